//! Comparison of a choice's errors with the quantisation steps of the drives' frames.

use super::{Trade, TradePoint};
use sim::run::numbers::engineering;
use std::fmt::Write as _;

impl Trade {
    /// Lines that compare a point's torque errors with the steps of the drives; empty if the drives have none.
    ///
    /// The error of a choice includes the terms that its model leaves out and the rounding of its scalar.
    pub(crate) fn beside_drives(&self, point: &TradePoint) -> String {
        let mut text = String::new();
        let mut finer = true;
        for (joint, (name, step)) in self.joints.iter().zip(&self.drives).enumerate() {
            let errors = point.courses.iter().filter_map(|course| course.torque.as_ref()?.max.get(joint));
            let choice = errors.fold(0.0, |most, error| f64::max(most, *error));
            let sources = [("torque step", step.torque), ("reading step", step.reading), ("choice", choice)];
            let largest = sources.iter().fold(sources[0], |most, it| if it.1 > most.1 { *it } else { most });
            finer &= choice <= step.torque;
            let shown = sources.map(|(source, torque)| format!("{source} {}", engineering(torque, "N m")));
            let _ = writeln!(text, "{:<20}{name}: {}; largest: {}", "drive", shown.join(", "), largest.0);
        }
        if !text.is_empty() && finer {
            let _ = writeln!(
                text,
                "{:<20}every joint's torque step is above this choice's error: no cycle is worth spending on less",
                "drive"
            );
        }
        text
    }
}
