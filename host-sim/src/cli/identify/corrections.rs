//! Options that correct the columns of a log.

use clap::Args;
use identification::correction::Correction;
use sim::failure::Failure;

/// Signs, scales, order and delay of a log's columns. Joints are counted from 1, as in the robot file.
#[derive(Clone, Debug, Default, Args)]
pub struct CorrectionArgs {
    /// Joints whose torque has the opposite sign in the logs, or `all`.
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub negate_torque: Vec<String>,
    /// Joints whose position has the opposite sign in the logs, or `all`.
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub negate_position: Vec<String>,
    /// Factor of the torques, one for each joint or one for all: 0.001 for mN m.
    #[arg(long, value_name = "K1,K2,..", value_delimiter = ',')]
    pub torque_scale: Vec<f64>,
    /// Factor of the positions, one for each joint or one for all: 6.2832 for turns.
    #[arg(long, value_name = "K1,K2,..", value_delimiter = ',')]
    pub position_scale: Vec<f64>,
    /// For each joint, the number of the joint in whose columns its data is: 3,2,1 for the reversed order.
    #[arg(long, value_name = "JOINTS", value_delimiter = ',', conflicts_with_all = ["permute_torque", "permute_position"])]
    pub permute: Vec<usize>,
    /// The same, for torques only.
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub permute_torque: Vec<usize>,
    /// The same, for positions and velocities only.
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub permute_position: Vec<usize>,
    /// Delay of the torques relative to the positions, s, one for each joint or one for all. Without it, estimated.
    #[arg(long, value_name = "S1,S2,..", value_delimiter = ',', allow_hyphen_values = true)]
    pub delay: Vec<f64>,
}

impl CorrectionArgs {
    /// The correction for logs of this many joints.
    ///
    /// # Errors
    /// [`Failure::Input`]: a joint that does not exist, a list whose length is neither 1 nor the number of joints, or a factor of 0.
    pub fn correction(&self, joints: usize) -> Result<Correction, Failure> {
        let mut correction = Correction::none(joints);
        correction.torque = factors("--torque-scale", &self.torque_scale, joints, 1.0)?;
        correction.position = factors("--position-scale", &self.position_scale, joints, 1.0)?;
        for (name, factors) in [("--torque-scale", &correction.torque), ("--position-scale", &correction.position)] {
            if factors.contains(&0.0) {
                return Err(wrong(name, "0".to_owned(), "factors other than zero".to_owned()));
            }
        }
        correction.delay = factors("--delay", &self.delay, joints, 0.0)?;
        if let Some(long) = correction.delay.iter().find(|d| d.abs() > 1.0) {
            return Err(wrong("--delay", format!("{long} s"), "seconds, from -1 to 1 (milliseconds?)".to_owned()));
        }
        negate("--negate-torque", &self.negate_torque, &mut correction.torque)?;
        negate("--negate-position", &self.negate_position, &mut correction.position)?;
        let both = order("--permute", &self.permute, joints)?;
        correction.torques_from = order("--permute-torque", &self.permute_torque, joints)?
            .or_else(|| both.clone())
            .unwrap_or(correction.torques_from);
        correction.positions_from =
            order("--permute-position", &self.permute_position, joints)?.or(both).unwrap_or(correction.positions_from);
        Ok(correction)
    }
}

fn wrong(name: &str, found: String, expected: String) -> Failure {
    Failure::Input(miette::miette!(help = format!("expected {expected}"), "{name}: found {found}"))
}

fn factors(name: &str, given: &[f64], joints: usize, none: f64) -> Result<Vec<f64>, Failure> {
    if let Some(bad) = given.iter().find(|x| !x.is_finite()) {
        return Err(wrong(name, bad.to_string(), "finite numbers".to_owned()));
    }
    match given.len() {
        0 => Ok(vec![none; joints]),
        1 => Ok(vec![given[0]; joints]),
        count if count == joints => Ok(given.to_vec()),
        count => {
            let expected = format!("{joints} numbers, one for each joint, or one for all");
            Err(wrong(name, format!("{count} numbers"), expected))
        }
    }
}

fn negate(name: &str, joints: &[String], factors: &mut [f64]) -> Result<(), Failure> {
    let n = factors.len();
    for text in joints {
        if text == "all" {
            factors.iter_mut().for_each(|factor| *factor = -*factor);
            continue;
        }
        let joint = text.trim().parse::<usize>().ok().filter(|k| (1..=n).contains(k));
        let Some(joint) = joint else {
            return Err(wrong(name, format!("{text:?}"), format!("joints from 1 to {n}, or all")));
        };
        factors[joint - 1] = -factors[joint - 1];
    }
    Ok(())
}

fn order(name: &str, given: &[usize], joints: usize) -> Result<Option<Vec<usize>>, Failure> {
    if given.is_empty() {
        return Ok(None);
    }
    let mut sorted = given.to_vec();
    sorted.sort_unstable();
    if !sorted.iter().copied().eq(1..=joints) {
        let found = given.iter().map(usize::to_string).collect::<Vec<_>>().join(",");
        return Err(wrong(name, found, format!("each of 1 to {joints} once")));
    }
    Ok(Some(given.iter().map(|k| k - 1).collect()))
}
