//! `terms = "auto"`: the fewest terms that keep the scene's tolerance.

use crate::choose::Along;
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::{AutoTerms, ModelTerm, SceneFile};
use crate::read::table::{Table, Value};
use crate::with_dof;

const TOLERANCE: &str = "a share of each joint's torque limit, 0 to 0.5, such as 0.002";

/// The request of the table, and its location.
pub(super) struct Auto<'a> {
    terms: Value<'a>,
    tolerance: f64,
}

/// `terms` and `tolerance` of the table `[model]`, if present.
pub(super) fn read<'a>(table: &Table<'a>, robot: &Robot) -> Result<Option<Auto<'a>>, FileError> {
    let (terms, tolerance) = match (table.get("terms"), table.get("tolerance")) {
        (None, None) => return Ok(None),
        (None, Some(tolerance)) => {
            return Err(tolerance.error("given without `terms`", "a tolerance only beside `terms = \"auto\"`"));
        }
        (Some(terms), tolerance) => (terms, tolerance),
    };
    terms.choice(&[("auto", ())])?;
    let Some(tolerance) = tolerance else {
        return Err(terms.error("given without `tolerance`", format!("`tolerance`, {TOLERANCE}")));
    };
    let tolerance = tolerance.within(0.0, 0.5, TOLERANCE)?;
    if let Some(said) = ModelTerm::ALL.into_iter().find_map(|term| table.get(term.key())) {
        let expected = "either `terms = \"auto\"`, with what acts in [plant], or terms one by one";
        return Err(said.error("given beside `terms = \"auto\"`", expected));
    }
    if let Some(index) = robot.joints.iter().position(|joint| !joint.spec.limits.torque.is_finite()) {
        let label = Robot::joint_label(index, &robot.joints[index].name);
        let problem = format!("{label} has no torque limit, of which the tolerance is a share");
        return Err(terms.error(problem, "a torque limit on every joint of the robot, or terms one by one"));
    }
    Ok(Some(Auto { terms, tolerance }))
}

impl Auto<'_> {
    /// Gives the model every term that acts in the simulated world.
    pub(super) fn know(&self, scene: &mut SceneFile) {
        let friction_smoothing = scene.model.friction_smoothing;
        scene.model = scene.plant.known(&scene.robot);
        scene.model.friction_smoothing = friction_smoothing;
    }

    /// Leaves only the fewest terms.
    pub(super) fn choose(&self, scene: &mut SceneFile) -> Result<(), FileError> {
        let fewest = with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>()?;
            let along = Along::new(scene, &model);
            along.map(|along| along.fewest_terms(self.tolerance))
        });
        // The motion has been made before, so this cannot fail.
        let fewest = fewest.map_err(|error| self.terms.error(error.to_string(), "a motion that can be"))?;
        let full = scene.model.clone();
        scene.model = full.without(&fewest.given_up);
        scene.model.auto = Some(AutoTerms { tolerance: self.tolerance, full: Box::new(full) });
        Ok(())
    }
}
