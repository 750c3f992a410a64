//! Record of a run: a column for every quantity of every joint, a row for every tick.

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

/// One joint over all ticks: [`JointSample`]'s quantities, and the external torque, which is empty if it is not estimated.
#[derive(Clone, Debug, Default, PartialEq)]
struct Columns {
    q_reference: Vec<f64>,
    q: Vec<f64>,
    qd_reference: Vec<f64>,
    qd: Vec<f64>,
    torque: Vec<f64>,
    limits: Vec<LimitFlags>,
    external: Vec<f64>,
}

impl Columns {
    fn with_room(ticks: usize) -> Self {
        let numbers = || Vec::with_capacity(ticks);
        Self {
            q_reference: numbers(),
            q: numbers(),
            qd_reference: numbers(),
            qd: numbers(),
            torque: numbers(),
            limits: Vec::with_capacity(ticks),
            external: Vec::new(),
        }
    }

    fn push(&mut self, sample: JointSample) {
        let JointSample { q_reference, q, qd_reference, qd, torque, limits } = sample;
        self.q_reference.push(q_reference);
        self.q.push(q);
        self.qd_reference.push(qd_reference);
        self.qd.push(qd);
        self.torque.push(torque);
        self.limits.push(limits);
    }

    fn samples(&self) -> impl DoubleEndedIterator<Item = JointSample> + ExactSizeIterator + Clone {
        let reference = self.q_reference.iter().zip(&self.qd_reference);
        let actual = self.q.iter().zip(&self.qd);
        let output = self.torque.iter().zip(&self.limits);
        reference.zip(actual).zip(output).map(|(((q_reference, qd_reference), (q, qd)), (torque, limits))| {
            JointSample {
                q_reference: *q_reference,
                q: *q,
                qd_reference: *qd_reference,
                qd: *qd,
                torque: *torque,
                limits: *limits,
            }
        })
    }

    fn at(&self, tick: usize) -> Option<JointSample> {
        Some(JointSample {
            q_reference: *self.q_reference.get(tick)?,
            q: *self.q.get(tick)?,
            qd_reference: *self.qd_reference.get(tick)?,
            qd: *self.qd.get(tick)?,
            torque: *self.torque.get(tick)?,
            limits: *self.limits.get(tick)?,
        })
    }
}

/// A run: per tick the time, every joint, and the fault in force.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    joints: Vec<JointLabel>,
    time: Vec<f64>,
    faults: Vec<Option<Fault>>,
    /// Columns of each joint.
    columns: Vec<Columns>,
    /// Wrenches at the tip that are equivalent to the external torques; empty if these are not estimated.
    wrenches: Vec<Option<[f64; 6]>>,
}

impl Record {
    /// Empty record with capacity for `ticks`.
    #[must_use]
    pub fn new(joints: Vec<JointLabel>, ticks: usize) -> Self {
        let room = ticks.min(1 << 20);
        let columns = joints.iter().map(|_| Columns::with_room(room)).collect();
        let (time, faults) = (Vec::with_capacity(room), Vec::with_capacity(room));
        Self { joints, time, faults, columns, wrenches: Vec::new() }
    }

    /// Adds a tick at time `t` (s).
    pub fn push<const N: usize>(&mut self, t: f64, samples: [JointSample; N], fault: Option<Fault>) {
        debug_assert_eq!(N, self.joints.len());
        self.time.push(t);
        self.faults.push(fault);
        for (columns, sample) in self.columns.iter_mut().zip(samples) {
            columns.push(sample);
        }
    }

    /// Adds to the last tick the external torque on each joint, N m or N, and the equivalent force (N) and moment (N m) at the tip, in base axes.
    pub fn push_external<const N: usize>(&mut self, external: [f64; N], wrench: Option<[f64; 6]>) {
        for (columns, external) in self.columns.iter_mut().zip(external) {
            columns.external.push(external);
        }
        self.wrenches.push(wrench);
    }

    /// Estimate of the external torque on one joint over all ticks, N m or N; empty if it is not estimated.
    pub fn external(&self, joint: usize) -> impl Iterator<Item = f64> + Clone {
        self.columns[joint].external.iter().copied()
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
        self.columns.iter().filter_map(|columns| columns.at(tick)).collect()
    }

    /// External torques in one tick, N m or N, and the equivalent wrench at the tip; empty if they are not estimated.
    #[must_use]
    pub fn outside(&self, tick: usize) -> (Vec<f64>, Option<[f64; 6]>) {
        let torques = self.columns.iter().filter_map(|columns| columns.external.get(tick).copied());
        (torques.collect(), self.wrenches.get(tick).copied().flatten())
    }

    /// One joint over all ticks.
    pub fn joint(&self, joint: usize) -> impl DoubleEndedIterator<Item = JointSample> + ExactSizeIterator + Clone {
        self.columns[joint].samples()
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
        for s in self.columns.iter().filter_map(|columns| columns.at(tick)) {
            for number in [s.q_reference, s.q, s.qd_reference, s.qd, s.torque] {
                write!(line, ",{number}")?;
            }
            write!(line, ",{}", s.limits.bits())?;
        }
        write!(line, ",{}", self.faults[tick].map_or(0, |fault| fault.code()))?;
        if let Some(wrench) = self.wrenches.get(tick) {
            for torque in self.columns.iter().filter_map(|columns| columns.external.get(tick)) {
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
