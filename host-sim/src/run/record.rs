//! Record of a run, tick by tick.

use core::fmt::{self, Write as _};
use dynamics_core::control::LimitFlags;
use dynamics_core::{Fault, JointKind};
use std::io::{self, Write};

/// Name and kind of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointLabel {
    /// Its name in the robot file.
    pub name: String,
    /// Revolute or prismatic; decides the units.
    pub kind: JointKind,
}

impl JointLabel {
    /// Unit of its position.
    #[must_use]
    pub fn position_unit(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "rad",
            JointKind::Prismatic => "m",
        }
    }

    /// Unit of its velocity.
    #[must_use]
    pub fn velocity_unit(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "rad/s",
            JointKind::Prismatic => "m/s",
        }
    }

    /// Name of the actuator's output: torque or force.
    #[must_use]
    pub fn effort(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "torque",
            JointKind::Prismatic => "force",
        }
    }

    /// Unit of its torque or force.
    #[must_use]
    pub fn torque_unit(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "N m",
            JointKind::Prismatic => "N",
        }
    }
}

/// One joint in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSample {
    /// Reference position, rad or m.
    pub q_reference: f64,
    /// Position of the simulated arm, rad or m.
    pub q: f64,
    /// Reference velocity, rad/s or m/s.
    pub qd_reference: f64,
    /// Velocity of the simulated arm, rad/s or m/s.
    pub qd: f64,
    /// Commanded torque or force, N m or N; zero while braking.
    pub torque: f64,
    /// Limits that acted.
    pub limits: LimitFlags,
}

impl JointSample {
    /// Reference less actual position, rad or m.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.q_reference - self.q
    }
}

/// A run: per tick the time, every joint, and the fault in force.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    joints: Vec<JointLabel>,
    time: Vec<f64>,
    faults: Vec<Option<Fault>>,
    /// Tick by tick, all joints of a tick together.
    samples: Vec<JointSample>,
    /// Torque from outside on each joint, likewise, and what it stands for at the tip; empty where nobody estimates it.
    external: Vec<f64>,
    wrenches: Vec<Option<[f64; 6]>>,
}

impl Record {
    /// Empty record with room for `ticks`.
    #[must_use]
    pub fn new(joints: Vec<JointLabel>, ticks: usize) -> Self {
        let room = ticks.min(1 << 20);
        let samples = Vec::with_capacity(room * joints.len());
        let (external, wrenches) = (Vec::new(), Vec::new());
        Self { joints, time: Vec::with_capacity(room), faults: Vec::with_capacity(room), samples, external, wrenches }
    }

    /// Add a tick at time `t` (s).
    pub fn push<const N: usize>(&mut self, t: f64, samples: [JointSample; N], fault: Option<Fault>) {
        debug_assert_eq!(N, self.joints.len());
        self.time.push(t);
        self.faults.push(fault);
        self.samples.extend(samples);
    }

    /// Add to the last tick the torque from outside on each joint, N m or N, and force (N) and moment (N m) at the tip that it stands
    /// for, in base axes.
    pub fn push_external<const N: usize>(&mut self, external: [f64; N], wrench: Option<[f64; 6]>) {
        self.external.extend(external);
        self.wrenches.push(wrench);
    }

    /// Estimate of the torque from outside on one joint over all ticks, N m or N; empty where nobody estimates it.
    pub fn external(&self, joint: usize) -> impl Iterator<Item = f64> + Clone {
        self.external.iter().skip(joint).step_by(self.joints.len().max(1)).copied()
    }

    /// Estimate of force (N) and moment (N m) at the tip in each tick, in base axes; `None` where the arm is singular. Empty where
    /// nobody estimates it.
    #[must_use]
    pub fn wrenches(&self) -> &[Option<[f64; 6]>] {
        &self.wrenches
    }

    /// Whether torques from outside are estimated.
    #[must_use]
    pub fn estimates(&self) -> bool {
        !self.wrenches.is_empty()
    }

    /// The joints, base first.
    #[must_use]
    pub fn joints(&self) -> &[JointLabel] {
        &self.joints
    }

    /// Number of ticks.
    #[must_use]
    pub fn ticks(&self) -> usize {
        self.time.len()
    }

    /// Time of each tick, s.
    #[must_use]
    pub fn time(&self) -> &[f64] {
        &self.time
    }

    /// Fault in force in each tick.
    #[must_use]
    pub fn faults(&self) -> &[Option<Fault>] {
        &self.faults
    }

    /// All joints in one tick; empty beyond the last one.
    #[must_use]
    pub fn tick(&self, tick: usize) -> &[JointSample] {
        let joints = self.joints.len();
        self.samples.get(tick * joints..(tick + 1) * joints).unwrap_or_default()
    }

    /// Torques from outside in one tick, N m or N, and what they stand for at the tip; empty where nobody estimates them.
    #[must_use]
    pub fn outside(&self, tick: usize) -> (&[f64], Option<[f64; 6]>) {
        let joints = self.joints.len();
        let torques = self.external.get(tick * joints..(tick + 1) * joints).unwrap_or_default();
        (torques, self.wrenches.get(tick).copied().flatten())
    }

    /// One joint over all ticks.
    pub fn joint(&self, joint: usize) -> impl Iterator<Item = &JointSample> + Clone {
        self.samples.iter().skip(joint).step_by(self.joints.len().max(1))
    }

    /// Write the run as CSV: one line per tick, numbers with as many digits as they need to be read back exactly.
    ///
    /// Columns: `t`, then per joint `k` (counted from 1) `qk_reference, qk, qdk_reference, qdk, tauk, limitsk`, then
    /// `fault` (0: none). SI units; `limits` is the sum of 1 position, 2 velocity, 4 torque, 8 torque rate,
    /// 16 collision. Where torques from outside are estimated, `external1, ..` and the wrench at the tip in base axes, `tip_fx, .., tip_mz`
    /// (empty where the arm is singular), stand behind them.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_csv(&self, mut to: impl Write) -> io::Result<()> {
        let names = (1..=self.joints.len()).flat_map(|k| {
            ["q?_reference", "q?", "qd?_reference", "qd?", "tau?", "limits?"].map(|s| s.replace('?', &k.to_string()))
        });
        let external = (1..=self.joints.len()).map(|k| format!("external{k}"));
        let tip = ["tip_fx", "tip_fy", "tip_fz", "tip_mx", "tip_my", "tip_mz"].map(str::to_owned);
        let outside = external.chain(tip).filter(|_| self.estimates());
        let names: Vec<String> =
            std::iter::once("t".to_owned()).chain(names).chain(["fault".to_owned()]).chain(outside).collect();
        writeln!(to, "{}", names.join(","))?;
        // Nothing in a line needs quotes. It is made in memory that every line uses again.
        let mut line = String::new();
        for (tick, samples) in self.samples.chunks_exact(self.joints.len().max(1)).enumerate() {
            line.clear();
            self.write_line(tick, samples, &mut line).map_err(io::Error::other)?;
            to.write_all(line.as_bytes())?;
        }
        to.flush()
    }

    fn write_line(&self, tick: usize, samples: &[JointSample], line: &mut String) -> fmt::Result {
        write!(line, "{}", self.time[tick])?;
        for s in samples {
            for number in [s.q_reference, s.q, s.qd_reference, s.qd, s.torque] {
                write!(line, ",{number}")?;
            }
            write!(line, ",{}", s.limits.bits())?;
        }
        write!(line, ",{}", self.faults[tick].map_or(0, |fault| fault.code()))?;
        if let Some(wrench) = self.wrenches.get(tick) {
            let joints = self.joints.len();
            for torque in self.external.iter().skip(tick * joints).take(joints) {
                write!(line, ",{torque}")?;
            }
            for axis in 0..6 {
                line.push(',');
                if let Some(wrench) = wrench {
                    write!(line, "{}", wrench[axis])?;
                }
            }
        }
        line.push('\n');
        Ok(())
    }
}
