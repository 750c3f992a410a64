//! The choices of a trade-off as a CSV file.

use super::report::CHOICES;
use super::{Trade, TradePoint};
use sim::failure::{Failure, in_file};
use std::path::Path;

impl Trade {
    /// Writes every point with all its numbers.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<(), Failure> {
        let failed = |error: csv::Error| in_file(path, &error);
        let mut file = csv::Writer::from_path(path).map_err(failed)?;
        let mut head: Vec<String> = CHOICES.map(str::to_owned).to_vec();
        head.extend(
            [
                "instructions_mean",
                "instructions_max",
                "cycles_mean",
                "cycles_max",
                "interrupt_cycles_mean",
                "interrupt_cycles_max",
                "cpu_share_mean",
                "cpu_share_max",
                "flash",
                "ram",
                "matches_desk",
                "torque_of_limit",
            ]
            .map(str::to_owned),
        );
        for course in &self.courses {
            for joint in &self.joints {
                for what in ["torque_max", "torque_rms", "tracking_max", "tracking_rms"] {
                    head.push(format!("{}_{joint}_{what}", course.name));
                }
            }
            head.push(format!("{}_fault", course.name));
        }
        head.extend(["torque_front", "tracking_front", "command"].map(str::to_owned));
        file.write_record(&head).map_err(failed)?;
        for point in &self.points {
            let (cost, interrupt) = (&point.cost, &point.interrupt);
            let mut row = point.choice.cells().to_vec();
            row.extend([
                cost.instructions.to_string(),
                cost.instructions_max.to_string(),
                cost.cycles.to_string(),
                cost.cycles_max.to_string(),
                interrupt.cycles.to_string(),
                interrupt.cycles_max.to_string(),
                interrupt.cpu_share.to_string(),
                interrupt.cpu_share_max.to_string(),
                cost.flash.to_string(),
                cost.ram.to_string(),
                cost.matches_desk.to_string(),
                point.torque_of_limit.map_or_else(String::new, |x| x.to_string()),
            ]);
            for course in &point.courses {
                let torque = |joint: usize, pick: fn(&super::measure::Errors) -> &Vec<f64>| {
                    course.torque.as_ref().map_or_else(String::new, |errors| pick(errors)[joint].to_string())
                };
                for joint in 0..self.joints.len() {
                    row.extend([
                        torque(joint, |errors| &errors.max),
                        torque(joint, |errors| &errors.rms),
                        course.tracking.max[joint].to_string(),
                        course.tracking.rms[joint].to_string(),
                    ]);
                }
                row.push(course.fault.clone().unwrap_or_default());
            }
            row.extend([point.on_torque_front.to_string(), point.on_tracking_front.to_string(), point.command.clone()]);
            file.write_record(&row).map_err(failed)?;
        }
        file.flush().map_err(Failure::Output)
    }

    /// Name of a point in a figure: the columns in which it differs from the scene's own choice.
    pub(super) fn name_of(&self, point: &TradePoint) -> String {
        let [own, here] = [self.own.cells(), point.choice.cells()];
        let differ = own.iter().zip(&here).zip(CHOICES).filter(|((own, here), _)| own != here);
        let names: Vec<String> = differ
            .map(|((_, here), column)| match column {
                "friction" | "rotors" | "terms" => format!("{column} {here}"),
                _ => here.clone(),
            })
            .collect();
        if names.is_empty() { "as the scene has it".to_owned() } else { names.join(", ") }
    }
}
