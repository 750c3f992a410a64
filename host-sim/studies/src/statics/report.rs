//! Table of an arm at rest.

use super::{Minimised, StaticLoads};
use sim::run::numbers::engineering;
use sim::table::table;

impl StaticLoads {
    /// The table and the lines around it for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let words = ["joint", "position", "actuator", "of limit", "radial", "axial", "tilting", "twisting"];
        let wrenches = ["force / N", "moment / N m"].map(|what| format!("{what} ({} axes)", self.axes));
        let head = words.map(str::to_owned).into_iter().chain(wrenches);
        let mut table = table(head.collect::<Vec<_>>(), 1);
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
