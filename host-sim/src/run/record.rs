//! Record of a run, tick by tick.

use dynamics_core::control::LimitFlags;
use dynamics_core::{Fault, JointKind};
use std::io::Write;

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
}

impl Record {
    /// Empty record with room for `ticks`.
    #[must_use]
    pub fn new(joints: Vec<JointLabel>, ticks: usize) -> Self {
        let room = ticks.min(1 << 20);
        let samples = Vec::with_capacity(room * joints.len());
        Self { joints, time: Vec::with_capacity(room), faults: Vec::with_capacity(room), samples }
    }

    /// Add a tick at time `t` (s).
    pub fn push<const N: usize>(&mut self, t: f64, samples: [JointSample; N], fault: Option<Fault>) {
        debug_assert_eq!(N, self.joints.len());
        self.time.push(t);
        self.faults.push(fault);
        self.samples.extend(samples);
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

    /// One joint over all ticks.
    pub fn joint(&self, joint: usize) -> impl Iterator<Item = &JointSample> + Clone {
        self.samples.iter().skip(joint).step_by(self.joints.len().max(1))
    }

    /// Write the run as CSV: one line per tick, numbers with as many digits as they need to be read back exactly.
    ///
    /// Columns: `t`, then per joint `k` (counted from 1) `qk_reference, qk, qdk_reference, qdk, tauk, limitsk`, then
    /// `fault` (0: none). SI units; `limits` is the sum of 1 position, 2 velocity, 4 torque, 8 torque rate,
    /// 16 collision.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_csv(&self, to: impl Write) -> csv::Result<()> {
        let mut out = csv::Writer::from_writer(to);
        let names = (1..=self.joints.len()).flat_map(|k| {
            ["q?_reference", "q?", "qd?_reference", "qd?", "tau?", "limits?"].map(|s| s.replace('?', &k.to_string()))
        });
        out.write_record(std::iter::once("t".to_owned()).chain(names).chain(["fault".to_owned()]))?;
        for (tick, samples) in self.samples.chunks_exact(self.joints.len().max(1)).enumerate() {
            out.write_field(self.time[tick].to_string())?;
            for s in samples {
                for number in [s.q_reference, s.q, s.qd_reference, s.qd, s.torque] {
                    out.write_field(number.to_string())?;
                }
                out.write_field(s.limits.bits().to_string())?;
            }
            out.write_field(self.faults[tick].map_or(0, |fault| fault.code()).to_string())?;
            out.write_record(None::<&[u8]>)?;
        }
        out.flush()?;
        Ok(())
    }
}
