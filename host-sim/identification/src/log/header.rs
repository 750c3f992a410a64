//! Which column is what.

use super::Reading;

/// Places of columns in a file.
pub(super) struct Places {
    /// Time, positions, velocities (or none), torques; the order of what is read.
    pub(super) all: Vec<usize>,
    /// Whether velocities are there.
    pub(super) velocities: bool,
    /// Whether the last ones are currents.
    pub(super) currents: bool,
    /// Whether time is counted in ticks.
    pub(super) ticks: bool,
}

const TIME: [&str; 6] = ["time", "t", "time_s", "times", "timestamp", "seconds"];
const POSITION: [&str; 7] = ["q", "position", "pos", "actual_q", "angle", "theta", "sensed"];
const VELOCITY: [&str; 8] = ["qd", "dq", "velocity", "vel", "actual_qd", "speed", "qdot", "v"];
const TORQUE: [&str; 6] = ["tau", "torque", "effort", "force", "moment", "trq"];
const CURRENT: [&str; 6] = ["current", "i", "actual_current", "cur", "motor_current", "amps"];

/// What was found, and what was expected.
type Problem = (String, String);

impl Places {
    fn joints(&self) -> usize {
        (self.all.len() - 1) / if self.velocities { 3 } else { 2 }
    }

    pub(super) fn positions(&self) -> &[usize] {
        &self.all[1..=self.joints()]
    }

    pub(super) fn speeds(&self) -> &[usize] {
        &self.all[1 + self.joints()..self.all.len() - self.joints()]
    }

    pub(super) fn torques(&self) -> &[usize] {
        &self.all[self.all.len() - self.joints()..]
    }

    pub(super) fn find(head: &[String], reading: &Reading) -> Result<Self, Problem> {
        let names: Vec<String> = head.iter().map(|name| plain(name)).collect();
        if let Some(twice) = (0..names.len()).find(|&k| !names[k].is_empty() && names[..k].contains(&names[k])) {
            return Err((format!("the column {:?} twice", head[twice]), "each column once".to_owned()));
        }
        let find = |name: &str| names.iter().position(|known| known == name);
        let time = TIME.iter().find_map(|name| find(name));
        let (time, ticks) = match (time, find("tick")) {
            (Some(time), _) => (time, false),
            (None, Some(tick)) if reading.tick_rate.is_some() => (tick, true),
            (None, Some(_)) => {
                return Err(("time in ticks".to_owned(), "a column `time` in s, or --tick-rate HZ".to_owned()));
            }
            (None, None) => return Err((listed(head), "a column `time` (or `t`), s".to_owned())),
        };
        let of_joint = |kinds: &[&str], joint: usize| {
            let name = plain(&reading.joints[joint]);
            let number = (joint + 1).to_string();
            let both = [number, name];
            kinds.iter().find_map(|kind| {
                both.iter().find_map(|id| {
                    let forms = [
                        format!("{kind}{id}"),
                        format!("{id}{kind}"),
                        format!("joint{id}{kind}"),
                        format!("{kind}joint{id}"),
                    ];
                    forms.iter().map(|form| plain(form)).find_map(|form| find(&form))
                })
            })
        };
        let n = reading.joints.len();
        let group = |kinds: &[&str]| -> Vec<Option<usize>> { (0..n).map(|joint| of_joint(kinds, joint)).collect() };
        let whole = |found: &[Option<usize>], name: &str, unit: &str| -> Result<Vec<usize>, Problem> {
            let missing = found.iter().position(Option::is_none);
            match missing {
                None => Ok(found.iter().flatten().copied().collect()),
                Some(joint) => Err((
                    listed(head),
                    format!(
                        "a column `{name}_{}` for joint {} ({}), {unit}",
                        joint + 1,
                        joint + 1,
                        reading.joints[joint]
                    ),
                )),
            }
        };
        let positions = whole(&group(&POSITION), "q", "rad or m")?;
        if let Some(extra) = find(&format!("q{}", n + 1)) {
            return Err((format!("the column {:?}", head[extra]), format!("the {n} joints of the robot")));
        }
        let speeds = group(&VELOCITY);
        let velocities = speeds.iter().all(Option::is_some);
        let torques = group(&TORQUE);
        let currents = torques.iter().all(Option::is_none);
        let drives = if currents { group(&CURRENT) } else { torques };
        let (name, unit) = if currents { ("current", "A (or `tau_1` .. in N m)") } else { ("tau", "N m or N") };
        let drives = whole(&drives, name, unit)?;
        if currents && reading.per_ampere.is_none() {
            let found = format!("currents ({:?} ..) and no torque per ampere", head[drives[0]]);
            return Err((found, format!("--torque-per-ampere K1,..,K{n} in N m/A, or columns `tau_1` ..")));
        }
        let speeds = if velocities { speeds.into_iter().flatten().collect() } else { Vec::new() };
        let all = [vec![time], positions, speeds, drives].concat();
        Ok(Self { all, velocities, currents, ticks })
    }
}

/// A name without case, blanks, units in brackets, and what stands between words.
fn plain(name: &str) -> String {
    let name = name.split(['[', '(']).next().unwrap_or("");
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn listed(head: &[String]) -> String {
    format!("the columns {}", head.join(", "))
}
