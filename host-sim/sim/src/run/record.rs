//! Record of a run: every joint in every tick.

use crate::run::joint_label::JointLabel;
use core::fmt::{self, Write as _};
use dynamics_core::Fault;
use dynamics_core::control::LimitFlags;
use std::io::{self, Write};

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
    /// Reference minus actual position, rad or m.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.q_reference - self.q
    }
}

/// One joint over all ticks, and the external torque on it, which is empty if it is not estimated.
#[derive(Clone, Debug, Default, PartialEq)]
struct JointRecord {
    samples: Vec<JointSample>,
    external: Vec<f64>,
}

/// A run: per tick the time, every joint, and the fault in force.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    joints: Vec<JointLabel>,
    time: Vec<f64>,
    faults: Vec<Option<Fault>>,
    /// Every joint, base first.
    records: Vec<JointRecord>,
    /// Wrenches at the tip that are equivalent to the external torques; empty if these are not estimated.
    wrenches: Vec<Option<[f64; 6]>>,
}

impl Record {
    /// Empty record with capacity for `ticks`.
    #[must_use]
    pub fn new(joints: Vec<JointLabel>, ticks: usize) -> Self {
        let room = ticks.min(1 << 20);
        let record = |_| JointRecord { samples: Vec::with_capacity(room), external: Vec::new() };
        let records = joints.iter().map(record).collect();
        let (time, faults) = (Vec::with_capacity(room), Vec::with_capacity(room));
        Self { joints, time, faults, records, wrenches: Vec::new() }
    }

    /// Adds a tick at time `t` (s).
    pub fn push<const N: usize>(&mut self, t: f64, samples: [JointSample; N], fault: Option<Fault>) {
        debug_assert_eq!(N, self.joints.len());
        self.time.push(t);
        self.faults.push(fault);
        for (record, sample) in self.records.iter_mut().zip(samples) {
            record.samples.push(sample);
        }
    }

    /// Adds to the last tick the external torque on each joint, N m or N, and the equivalent force (N) and moment (N m) at the tip, in base axes.
    pub fn push_external<const N: usize>(&mut self, external: [f64; N], wrench: Option<[f64; 6]>) {
        for (record, external) in self.records.iter_mut().zip(external) {
            record.external.push(external);
        }
        self.wrenches.push(wrench);
    }

    /// Estimate of the external torque on one joint over all ticks, N m or N; empty if it is not estimated.
    pub fn external(&self, joint: usize) -> impl Iterator<Item = f64> + Clone {
        self.records[joint].external.iter().copied()
    }

    /// Estimate of force (N) and moment (N m) at the tip in each tick, in base axes; `None` if the arm is singular. Empty if they are not estimated.
    #[must_use]
    pub fn wrenches(&self) -> &[Option<[f64; 6]>] {
        &self.wrenches
    }

    /// True if external torques are estimated.
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

    /// All joints in one tick; empty after the last tick.
    #[must_use]
    pub fn tick(&self, tick: usize) -> Vec<JointSample> {
        self.records.iter().filter_map(|record| record.samples.get(tick).copied()).collect()
    }

    /// External torques in one tick, N m or N, and the equivalent wrench at the tip; empty if they are not estimated.
    #[must_use]
    pub fn outside(&self, tick: usize) -> (Vec<f64>, Option<[f64; 6]>) {
        let torques = self.records.iter().filter_map(|record| record.external.get(tick).copied());
        (torques.collect(), self.wrenches.get(tick).copied().flatten())
    }

    /// One joint over all ticks.
    pub fn joint(&self, joint: usize) -> impl DoubleEndedIterator<Item = JointSample> + ExactSizeIterator + Clone {
        self.records[joint].samples.iter().copied()
    }

    /// Writes the run as CSV, a line per tick. Numbers have as many digits as are needed to read them back exactly.
    ///
    /// Columns: `t`, then per joint `k` (counted from 1) `qk_reference, qk, qdk_reference, qdk, tauk, limitsk`, then `fault` (0: none). SI units;
    /// `limits` is the sum of 1 position, 2 velocity, 4 torque, 8 torque rate, 16 collision. If external torques are estimated, `external1, ..` and
    /// the wrench at the tip in base axes, `tip_fx, .., tip_mz` (empty if the arm is singular), follow.
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
        // No value in a line needs quotes. All lines use the same buffer.
        let mut line = String::new();
        for tick in 0..self.ticks() {
            line.clear();
            self.write_line(tick, &mut line).map_err(io::Error::other)?;
            to.write_all(line.as_bytes())?;
        }
        to.flush()
    }

    fn write_line(&self, tick: usize, line: &mut String) -> fmt::Result {
        write!(line, "{}", self.time[tick])?;
        for s in self.records.iter().filter_map(|record| record.samples.get(tick)) {
            for number in [s.q_reference, s.q, s.qd_reference, s.qd, s.torque] {
                write!(line, ",{number}")?;
            }
            write!(line, ",{}", s.limits.bits())?;
        }
        write!(line, ",{}", self.faults[tick].map_or(0, |fault| fault.code()))?;
        if let Some(wrench) = self.wrenches.get(tick) {
            for torque in self.records.iter().filter_map(|record| record.external.get(tick)) {
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
