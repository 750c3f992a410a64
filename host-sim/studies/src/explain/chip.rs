//! Cost of each term on the chip.

use super::{ChipSaving, Explanation, OnChip, friction};
use crate::trade::baseline::Baseline;
use crate::trade::chip::{Chip, Cost, InterruptCost};
use robot_compiler::Ends;
use robot_compiler::scene::ModelTerm;
use sim::failure::{Failure, in_file};
use sim::output::Output;
use sim::run::files::file_name;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

impl Explanation {
    /// Measures the chip's tick with every term and without each of them.
    pub fn measure(&mut self, scene: &Path, chip: &dyn Chip, stop: &AtomicBool) -> Result<(), Failure> {
        let base = Baseline::load(scene, Ends::default())?;
        let folder = Path::new("out/explain").join(file_name(&self.scene));
        Output::new(false).folder(&folder, &[])?;
        let term = |name: &str| ModelTerm::ALL.into_iter().find(|term| term.name() == name);
        let mut sets: Vec<Vec<ModelTerm>> = vec![Vec::new()];
        sets.extend(
            self.terms
                .iter()
                .filter(|report| report.dropped.is_some())
                .map(|report| term(report.term).into_iter().collect()),
        );
        sets.push(self.fewest.given_up.iter().filter_map(|name| term(name)).collect());
        let paths = sets.iter().map(|terms| {
            let names: Vec<&str> = terms.iter().map(|term| term.key()).collect();
            let path = folder.join(format!(
                "without_{}.toml",
                if names.is_empty() { "nothing".to_owned() } else { names.join("_") }
            ));
            fs::write(&path, base.without(terms)).map_err(|error| in_file(&path, &error))?;
            Ok(path)
        });
        let mut paths: Vec<PathBuf> = paths.collect::<Result<_, Failure>>()?;
        for part in friction::parts(&base.file) {
            let [robot, path] =
                ["robot", "scene"].map(|what| folder.join(format!("{what}_without_{}.toml", part.name())));
            fs::write(&robot, friction::robot_without(&base.file.robot.path, part)?)
                .map_err(|error| in_file(&robot, &error))?;
            fs::write(&path, base.with_robot(&robot)).map_err(|error| in_file(&path, &error))?;
            paths.push(path);
        }
        let found = chip.controllers(&paths, stop)?;
        let Some((full, rest)) = found.split_first() else { return Ok(()) };
        let around = folder.join("interrupt.toml");
        fs::write(&around, base.with(&base.firmware())).map_err(|error| in_file(&around, &error))?;
        let known = (base.own() == base.firmware()).then_some(full);
        let surroundings = InterruptCost::measure(&around, known, chip, stop)?;
        let rate = base.file.control.rate;
        let saving = |cost: &Cost| ChipSaving {
            instructions: full.instructions - cost.instructions,
            cycles: full.cycles - cost.cycles,
            flash: full.flash as i64 - cost.flash as i64,
            interrupt: surroundings.around(cost, rate),
        };
        let each = self.terms.iter_mut().filter_map(|report| report.dropped.as_mut());
        let each = each.chain(core::iter::once(&mut self.fewest.dropped)).map(|dropped| &mut dropped.chip);
        for (chip, cost) in each.chain(self.friction.iter_mut().map(|report| &mut report.chip)).zip(rest) {
            *chip = Some(saving(cost));
        }
        self.chip = Some(OnChip { controller: *full, interrupt: surroundings.around(full, rate), rate });
        Ok(())
    }
}
