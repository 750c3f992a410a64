//! Input of the design of a motion.

use super::surroundings::Surroundings;
use clap::Args;
use sim::failure::Failure;

/// Number of motions that the search for postures tries.
const POSTURES: u64 = 14;

/// Kind of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A Fourier series per joint.
    Series,
    /// Slow sweeps at steady speeds.
    Friction,
    /// Postures with a rest in each.
    Static,
}

/// Input of the design of a motion.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct ExciteRequest {
    /// Instead, slow sweeps at constant speeds, to identify friction.
    #[arg(long, conflicts_with = "static")]
    pub friction: bool,
    /// Instead, postures in which the arm rests, to identify gravity.
    #[arg(long = "static")]
    pub r#static: bool,
    /// Position about which each joint swings, rad or m. Without it, the middle of its range.
    #[arg(long, value_name = "Q1,Q2,..", value_delimiter = ',', allow_hyphen_values = true)]
    pub centre: Option<Vec<f64>>,
    /// Widest swing to either side of a joint, rad or m.
    #[arg(long, value_name = "SWING", default_value_t = 1.5, allow_negative_numbers = true)]
    pub swing: f64,
    /// Share of the speed limits.
    #[arg(long, value_name = "SHARE", default_value_t = 0.6, allow_negative_numbers = true)]
    pub speed: f64,
    /// Greatest acceleration of every joint, rad/s^2 or m/s^2. Without it, each joint reaches its speed limit in 0.4 s.
    #[arg(long, value_name = "ACCELERATION", allow_negative_numbers = true)]
    pub acceleration: Option<f64>,
    /// Share of the torque limits.
    #[arg(long, value_name = "SHARE", default_value_t = 0.7, allow_negative_numbers = true)]
    pub torque: f64,
    /// Surroundings.
    #[command(flatten)]
    pub surroundings: Surroundings,
    /// Period of the first harmonic, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, allow_negative_numbers = true)]
    pub period: f64,
    /// Periods to record.
    #[arg(long, value_name = "NUMBER", default_value_t = 3)]
    pub periods: u32,
    /// Harmonics, 1 to 8.
    #[arg(long, value_name = "NUMBER", default_value_t = 5)]
    pub harmonics: usize,
    /// Expected standard deviation of the measured torque, as a share of each torque limit.
    #[arg(long, value_name = "SHARE", default_value_t = 0.005, allow_negative_numbers = true)]
    pub noise: f64,
    /// Motions to try.
    #[arg(long, value_name = "NUMBER", default_value_t = 1500)]
    pub tries: usize,
    /// Seed of the search.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
}

impl ExciteRequest {
    /// Checks the numbers that need no robot.
    ///
    /// # Errors
    /// [`Failure::Input`]: a number out of its range.
    pub fn check(&self) -> Result<(), Failure> {
        let wrong = |expected: &str, found: String| {
            Err(Failure::Input(miette::miette!(help = format!("expected {expected}"), "{found}")))
        };
        let numbers = [
            ("--swing", Some(self.swing), 100.0),
            ("--speed", Some(self.speed), 1.0),
            ("--acceleration", self.acceleration, 1e6),
            ("--torque", Some(self.torque), 1.0),
            ("--period", Some(self.period), 1000.0),
            ("--noise", Some(self.noise), 1.0),
        ];
        for (name, value, most) in numbers {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= most)) {
                return wrong(&format!("a number above zero, at most {most}"), format!("{name} {value}"));
            }
        }
        if !(1..=8).contains(&self.harmonics) || !(1..=100).contains(&self.periods) || self.tries == 0 {
            return wrong(
                "--harmonics 1 to 8, --periods 1 to 100, --tries above zero",
                "a number out of its range".to_owned(),
            );
        }
        self.surroundings.check()
    }

    /// Kind of motion.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match (self.friction, self.r#static) {
            (true, _) => Kind::Friction,
            (_, true) => Kind::Static,
            _ => Kind::Series,
        }
    }

    /// Number of motions to try.
    #[must_use]
    pub fn motions(&self) -> u64 {
        if self.kind() == Kind::Static { POSTURES } else { self.tries as u64 }
    }
}
