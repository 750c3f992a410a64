//! Record of a run: a column for every quantity of every joint, a row for every tick.

use core::fmt::{self, Write as _};
use dynamics_core::control::LimitFlags;
use dynamics_core::{Fault, JointKind};
use robot_compiler::RobotJoint;
use std::io::{self, Write};

/// Name and kind of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointLabel {
    /// Its name in the robot file.
    pub name: String,
    /// Revolute or prismatic; decides the units.
    pub kind: JointKind,
}

impl From<&RobotJoint> for JointLabel {
    fn from(joint: &RobotJoint) -> Self {
        Self { name: joint.name.clone(), kind: joint.spec.kind }
    }
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

/// One joint over all ticks: [`JointSample`]'s quantities, and the torque from outside, which is empty where nobody estimates it.
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
    /// Joint by joint.
    columns: Vec<Columns>,
    /// Wrenches at the tip equivalent to the torques from outside; empty if these are not estimated.
    wrenches: Vec<Option<[f64; 6]>>,
}

impl Record {
    /// Empty record with room for `ticks`.
    #[must_use]
    pub fn new(joints: Vec<JointLabel>, ticks: usize) -> Self {
        let room = ticks.min(1 << 20);
        let columns = joints.iter().map(|_| Columns::with_room(room)).collect();
        let (time, faults) = (Vec::with_capacity(room), Vec::with_capacity(room));
        Self { joints, time, faults, columns, wrenches: Vec::new() }
    }

    /// Add a tick at time `t` (s).
    pub fn push<const N: usize>(&mut self, t: f64, samples: [JointSample; N], fault: Option<Fault>) {
        debug_assert_eq!(N, self.joints.len());
        self.time.push(t);
        self.faults.push(fault);
        for (columns, sample) in self.columns.iter_mut().zip(samples) {
            columns.push(sample);
        }
    }

    /// Add to the last tick the torque from outside on each joint, N m or N, and force (N) and moment (N m) at the tip that it stands
    /// for, in base axes.
    pub fn push_external<const N: usize>(&mut self, external: [f64; N], wrench: Option<[f64; 6]>) {
        for (columns, external) in self.columns.iter_mut().zip(external) {
            columns.external.push(external);
        }
        self.wrenches.push(wrench);
    }

    /// Estimate of the torque from outside on one joint over all ticks, N m or N; empty where nobody estimates it.
    pub fn external(&self, joint: usize) -> impl Iterator<Item = f64> + Clone {
        self.columns[joint].external.iter().copied()
    }

    /// Estimate of force (N) and moment (N m) at the tip in each tick, in base axes; `None` where the arm is singular. Empty where
    /// nobody estimates it.
    #[must_use]
    pub fn wrenches(&self) -> &[Option<[f64; 6]>] {
        &self.wrenches
    }

    /// True if torques from outside are estimated.
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
    pub fn tick(&self, tick: usize) -> Vec<JointSample> {
        self.columns.iter().filter_map(|columns| columns.at(tick)).collect()
    }

    /// Torques from outside in one tick, N m or N, and what they stand for at the tip; empty where nobody estimates them.
    #[must_use]
    pub fn outside(&self, tick: usize) -> (Vec<f64>, Option<[f64; 6]>) {
        let torques = self.columns.iter().filter_map(|columns| columns.external.get(tick).copied());
        (torques.collect(), self.wrenches.get(tick).copied().flatten())
    }

    /// One joint over all ticks.
    pub fn joint(&self, joint: usize) -> impl DoubleEndedIterator<Item = JointSample> + ExactSizeIterator + Clone {
        self.columns[joint].samples()
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
