//! Kernels as modules of a crate, in files that the crate includes.

use super::changed::write_changed;
use super::kernel::{Title, generic_module, module};
use crate::describe::scene::SceneFile;
use crate::kernel::{Function, Level, Precision};
use crate::with_dof;
use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Kernels in files of a folder, and their module declarations.
#[derive(Clone, Debug)]
pub struct Modules {
    folder: PathBuf,
    declarations: String,
}

impl Modules {
    /// An empty list; files go to `folder`.
    #[must_use]
    pub fn new(folder: PathBuf) -> Self {
        Self { folder, declarations: String::new() }
    }

    /// Writes a kernel of the scene's arm, and returns the name of its module: scene, function, level and precision.
    ///
    /// # Errors
    /// An impossible arm, or a folder that cannot be written to.
    pub fn kernel(
        &mut self,
        scene: &SceneFile,
        function: Function,
        level: Level,
        precision: Precision,
    ) -> Result<String, Box<dyn Error>> {
        let text = with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>()?;
            let title = Title { robot: &scene.robot.name, scene: &scene.name, hash: scene.hash(&model) };
            module(function, &model, &scene.scene(&model), level, precision, &title)
        });
        self.named(scene, function, level, precision.name(), &text)
    }

    /// As [`Modules::kernel`], for every scalar; the name ends in `any` instead of the precision, which is f64.
    ///
    /// # Errors
    /// As [`Modules::kernel`].
    pub fn generic_kernel(
        &mut self,
        scene: &SceneFile,
        function: Function,
        level: Level,
    ) -> Result<String, Box<dyn Error>> {
        let text = with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>()?;
            let title = Title { robot: &scene.robot.name, scene: &scene.name, hash: scene.hash(&model) };
            generic_module(function, &model, &scene.scene(&model), level, Precision::Double, &title)
        });
        self.named(scene, function, level, "any", &text)
    }

    fn named(
        &mut self,
        scene: &SceneFile,
        function: Function,
        level: Level,
        scalar: &str,
        text: &str,
    ) -> Result<String, Box<dyn Error>> {
        let function = function.name().replace('-', "_");
        let name = format!("{}_{function}_{}_{scalar}", scene.name, level.name());
        self.module(&name, text)?;
        Ok(name)
    }

    /// Writes another module with this name.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn module(&mut self, name: &str, text: &str) -> Result<(), Box<dyn Error>> {
        let path = self.file(name, text)?;
        writeln!(self.declarations, "#[path = {path:?}]\npub mod {name};")?;
        Ok(())
    }

    /// Writes a module of this name and returns its path; the caller makes the declaration.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn file(&self, name: &str, text: &str) -> Result<PathBuf, Box<dyn Error>> {
        let path = self.folder.join(format!("{name}.rs"));
        write_changed(&path, text)?;
        Ok(path)
    }

    /// Writes `kernels.rs`, for the crate to include: the declarations of the modules, and then `rest`.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn finish(self, rest: &str) -> Result<(), Box<dyn Error>> {
        Ok(write_changed(&self.folder.join("kernels.rs"), &(self.declarations + "\n" + rest))?)
    }
}
