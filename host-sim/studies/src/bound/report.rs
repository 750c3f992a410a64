//! Tables of the torque errors.

use super::TorqueErrorBound;
use sim::run::numbers::engineering;
use sim::table::{self, table};

/// A share of the actuator's limit.
fn share(value: f64, limit: Option<f64>) -> String {
    limit.map_or_else(|| "-".to_owned(), |limit| format!("{:.1e}", value / limit))
}

fn ratio(a: f64, b: f64) -> String {
    if b > 0.0 { format!("{:.1}", a / b) } else { "-".to_owned() }
}

const HEADER: [&str; 8] =
    ["joint", "found", "one state", "proven", "proven / found", "limit", "found / limit", "proven / limit"];

impl TorqueErrorBound {
    fn rows(&self) -> impl Iterator<Item = [String; 8]> {
        self.joints.iter().map(|joint| {
            let number = |value| engineering(value, joint.unit);
            [
                joint.name.clone(),
                number(joint.found),
                number(joint.one_state),
                number(joint.proven),
                ratio(joint.proven, joint.found),
                joint.limit.map_or_else(|| "none".to_owned(), number),
                share(joint.found, joint.limit),
                share(joint.proven, joint.limit),
            ]
        })
    }

    /// Table for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(HEADER, 1);
        for row in self.rows() {
            table.add_row(row);
        }
        let scene = self.scene.as_ref().map_or_else(String::new, |scene| format!(" in {scene}"));
        let mut text = format!("{}{scene}: torque error of f32 at level {}\n{table}\n", self.robot, self.level);
        text += "Everywhere in the joint limits the worst error lies\n";
        for joint in &self.joints {
            let number = |value| engineering(value, joint.unit);
            text += &format!("  {:<12} between {} and {}\n", joint.name, number(joint.found), number(joint.proven));
        }
        text + &format!("{} random states, {} boxes for each joint, seed {}\n", self.samples, self.boxes, self.seed)
    }
}

/// Markdown for a document.
#[must_use]
pub fn markdown(answers: &[TorqueErrorBound]) -> String {
    let rows = answers.iter().flat_map(|answer| {
        let arm = answer.scene.as_ref().unwrap_or(&answer.robot);
        answer.rows().map(|row| [&[arm.clone()][..], &row].concat())
    });
    table::markdown(&[&["arm"][..], &HEADER].concat(), rows)
}
