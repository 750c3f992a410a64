//! Table of an arm at rest.

use super::{Answer, Minimised};
use sim::run::numbers::engineering;
use sim::table::table;

impl Answer {
    /// The table and the lines around it for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(
            [
                "joint".to_owned(),
                "position".to_owned(),
                "actuator".to_owned(),
                "of limit".to_owned(),
                "radial".to_owned(),
                "axial".to_owned(),
                "tilting".to_owned(),
                "twisting".to_owned(),
                format!("force / N ({} axes)", self.axes),
                format!("moment / N m ({} axes)", self.axes),
            ],
            1,
        );
        let three = |v: &[f64; 3]| v.map(|x| format!("{:.3}", x + 0.0)).join(" ");
        for (joint, q) in self.joints.iter().zip(&self.q) {
            let optional = |x: Option<f64>, unit| x.map_or("-".to_owned(), |x| engineering(x, unit));
            table.add_row([
                joint.name.clone(),
                format!("{q:.4} {}", joint.label.position_unit()),
                engineering(joint.actuator, joint.label.torque_unit()),
                joint.limit.map_or("-".to_owned(), |limit| format!("{:.0} %", 100.0 * joint.actuator.abs() / limit)),
                engineering(joint.radial, "N"),
                optional(joint.axial, "N"),
                engineering(joint.tilting, "N m"),
                optional(joint.twisting, "N m"),
                three(&joint.force),
                three(&joint.moment),
            ]);
        }
        let mut text =
            format!("{}: at rest\n{table}\n{:<20}{}", self.robot, "potential energy", engineering(self.potential, "J"));
        if let Some(Minimised { what, value, starts, postures }) = &self.minimised {
            text += &format!("\n{:<20}{what}: {value:.6e}, of {postures} postures from {starts} starts", "least");
        }
        text
    }
}
