//! The properties, judged from the simulated drives and the motion, never from what the board believes.

use crate::scene::{AGE_MAX, INERTIA, PERIOD, Setup, WEIGHT};
use actuator_model::mit::Language;
use joint_io::can::WEAK_MAX;
use crate::world::World;
use dynamics_core::safety::{SafeAction, State};

/// A property of every period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Brakes open only if every drive was really on at the end of the period before.
    BrakesOpenOnlyWhenAllDrivesAreOn,
    /// Brakes close at the latest [`off_max`] periods after a drive has gone off.
    BrakesCloseWhenADriveIsOff,
    /// After a hold that was received the arm does not run; after a stop it is in the fault state.
    StopWinsWithinOnePeriod,
    /// An arm whose drive may have come back with another zero does not count as homed.
    HomingEndsWithTheZero,
    /// An arm runs only along points that were sent after the last fault, stop, disarming or homing.
    NoOldTrajectoryRuns,
    /// While torque is to act, no joint falls by more than [`fall_max`].
    NoJointFallsWhileArmed,
    /// In the period in which the brakes open every joint is carried: its drive's torque is within [`JUMP_MAX`] of its weight.
    TorqueCarriesTheArmWhenBrakesOpen,
}

impl Rule {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::BrakesOpenOnlyWhenAllDrivesAreOn,
        Self::BrakesCloseWhenADriveIsOff,
        Self::StopWinsWithinOnePeriod,
        Self::HomingEndsWithTheZero,
        Self::NoOldTrajectoryRuns,
        Self::NoJointFallsWhileArmed,
        Self::TorqueCarriesTheArmWhenBrakesOpen,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::BrakesOpenOnlyWhenAllDrivesAreOn => "brakes open only when all drives are on",
            Self::BrakesCloseWhenADriveIsOff => "brakes close when a drive is off",
            Self::StopWinsWithinOnePeriod => "stop wins within one period",
            Self::HomingEndsWithTheZero => "homing ends with the zero",
            Self::NoOldTrajectoryRuns => "no old trajectory runs",
            Self::NoJointFallsWhileArmed => "no joint falls while armed",
            Self::TorqueCarriesTheArmWhenBrakesOpen => "torque carries the arm when brakes open",
        }
    }

    const fn bit(self) -> u16 {
        1 << self as u16
    }
}

/// Periods that brakes may stay open over a drive that is off.
///
/// Replies may be missing for [`AGE_MAX`] periods, the next is late by one, and the brakes close in the period that sees it. A mini-cheetah's
/// replies carry no state: its torque has to be missing in more than [`WEAK_MAX`] of them.
#[must_use]
pub const fn off_max(setup: &Setup) -> u8 {
    let replies = if matches!(setup.language, Language::MiniCheetah) { WEAK_MAX + 1 } else { 0 };
    replies + AGE_MAX as u8 + 2
}

/// Greatest fall of a joint, rad, while torque is to act: free fall for [`off_max`] periods from the operator's greatest speed.
#[must_use]
pub fn fall_max(setup: &Setup) -> f64 {
    let time = PERIOD * f64::from(off_max(setup));
    time * (SPEED_MAX + 0.5 * time * WEIGHT / INERTIA)
}

/// Greatest speed of the operator's motion, rad/s.
const SPEED_MAX: f64 = 0.15;

/// Greatest distance of a drive's torque from the weight when brakes open, N m.
pub const JUMP_MAX: f64 = 1.0;

/// Periods with power after which a drive's other zero must have ended the homing: its first reply is one period old, and may be late or lost.
const SHIFTED_MAX: u8 = 4;

/// Memory of the judge.
#[derive(Clone, Copy, Debug)]
pub struct Judge<const N: usize> {
    /// Rules that were broken, as bits.
    broken: u16,
    /// A trajectory was sent after the last fault, stop, disarming or homing.
    pub fresh_points: bool,
    /// A hold was received since the last period.
    pub hold: bool,
    /// Drives that were on at the end of the period before.
    was_on: [bool; N],
    /// Periods that brakes are open over a drive that is off.
    off_for: [u8; N],
    /// Periods with power and a zero that has moved since the operator set it.
    shifted: [u8; N],
    /// Position from which a joint falls without torque that would carry it, rad.
    falls_from: [Option<f64>; N],
}

/// The board before and after a period.
#[derive(Clone, Copy, Debug)]
pub struct Period {
    /// State before.
    pub before: State,
    /// State after.
    pub after: State,
    /// Brakes open before.
    pub opened: bool,
    /// Brakes open after.
    pub open: bool,
    /// The joints count as homed.
    pub homed: bool,
}

impl<const N: usize> Judge<N> {
    /// Nothing is broken.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            broken: 0,
            fresh_points: false,
            hold: false,
            was_on: [false; N],
            off_for: [0; N],
            shifted: [0; N],
            falls_from: [None; N],
        }
    }

    /// True if the rule holds.
    #[must_use]
    pub const fn holds(&self, rule: Rule) -> bool {
        self.broken & rule.bit() == 0
    }

    /// True if every rule holds.
    #[must_use]
    pub const fn all_hold(&self) -> bool {
        self.broken == 0
    }

    fn demand(&mut self, rule: Rule, holds: bool) {
        if !holds {
            self.broken |= rule.bit();
        }
    }

    /// The end of a period.
    pub fn judge(&mut self, setup: &Setup, world: &World<N>, period: &Period) {
        let Period { before, after, opened, open, homed } = *period;
        let brakes = setup.action == SafeAction::Brake;
        let opens = brakes && open && !opened;
        if opens {
            self.demand(Rule::BrakesOpenOnlyWhenAllDrivesAreOn, self.was_on.iter().all(|on| *on));
            let carried = world.axes.iter().all(|drive| {
                let over = drive.torque - WEIGHT;
                over <= JUMP_MAX && (over >= -JUMP_MAX || drive.q <= 0.0)
            });
            // A drive that goes off in this very period is another rule's.
            let all_on = world.axes.iter().all(|drive| drive.is_on());
            self.demand(Rule::TorqueCarriesTheArmWhenBrakesOpen, carried || !all_on);
        }
        if core::mem::take(&mut self.hold) {
            self.demand(Rule::StopWinsWithinOnePeriod, after != State::Running);
        }
        let runs = after == State::Running && before != State::Running;
        self.demand(Rule::NoOldTrajectoryRuns, !runs || self.fresh_points);
        let code = after.code();
        if code != before.code() && !after.drives() || matches!(after, State::Holding(_)) && before == State::Running {
            self.fresh_points = false;
        }
        let (free, off_max) = (open || !brakes, off_max(setup));
        for (i, drive) in world.axes.iter().enumerate() {
            self.was_on[i] = drive.is_on();
            let off = brakes && open && !drive.is_on();
            self.off_for[i] = if off { (self.off_for[i] + 1).min(off_max + 1) } else { 0 };
            self.demand(Rule::BrakesCloseWhenADriveIsOff, self.off_for[i] <= off_max);
            let shifted = drive.dark == 0 && drive.turns != 0;
            self.shifted[i] = if shifted { (self.shifted[i] + 1).min(SHIFTED_MAX + 1) } else { 0 };
            self.demand(Rule::HomingEndsWithTheZero, !homed || self.shifted[i] <= SHIFTED_MAX);
            let sinks = free && drive.qd < 0.0 && drive.torque < 0.5 * WEIGHT;
            self.falls_from[i] = if sinks { self.falls_from[i].or(Some(drive.q)) } else { None };
            let fallen = self.falls_from[i].map_or(0.0, |from| from - drive.q);
            self.demand(Rule::NoJointFallsWhileArmed, !after.drives() || fallen <= fall_max(setup));
        }
    }
}

impl<const N: usize> Default for Judge<N> {
    fn default() -> Self {
        Self::new()
    }
}
