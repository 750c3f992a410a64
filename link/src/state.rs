//! States of the safety state machine, as a status carries them.

use dynamics_core::safety::State;
use serde::Serialize;

/// State of the safety state machine, without its cause. On the wire it is one byte, [`State::code`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[cfg_attr(feature = "host", derive(serde::Deserialize))]
pub enum StateCode {
    /// No torque; requests are accepted.
    Idle,
    /// The joints' zeros are being found, without torque.
    Homing,
    /// Torque holds the arm in the pose in which it was armed.
    Armed,
    /// The arm follows its trajectory.
    Running,
    /// Torque brings the arm to rest and holds it there.
    Holding,
    /// The safe action acts until the fault is cleared.
    Fault,
    /// The drives switch on and take up the arm's weight, with engaged brakes.
    Arming,
    /// The host is lost: the arm moves slowly to its rest pose.
    Lowering,
    /// Torque holds the arm until its brakes have engaged.
    Disarming,
}

impl StateCode {
    /// All states, in the order of their numbers.
    pub const ALL: [Self; 9] = [
        Self::Idle,
        Self::Homing,
        Self::Armed,
        Self::Running,
        Self::Holding,
        Self::Fault,
        Self::Arming,
        Self::Lowering,
        Self::Disarming,
    ];

    /// Converts the machine's state and drops its cause.
    #[must_use]
    pub const fn new(state: State) -> Self {
        match state {
            State::Idle => Self::Idle,
            State::Homing => Self::Homing,
            State::Armed => Self::Armed,
            State::Running => Self::Running,
            State::Holding(_) => Self::Holding,
            State::Fault(_) => Self::Fault,
            State::Arming => Self::Arming,
            State::Lowering => Self::Lowering,
            State::Disarming => Self::Disarming,
        }
    }

    /// The number on the wire, [`State::code`].
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Its name, as shown to users: [`State::name`].
    #[must_use]
    pub const fn name(self) -> &'static str {
        State::NAMES[self as usize]
    }

    /// True if torque acts, with released or with engaged brakes, as [`State::has_torque`].
    #[must_use]
    pub const fn has_torque(self) -> bool {
        matches!(self, Self::Armed | Self::Running | Self::Holding | Self::Lowering | Self::Disarming)
    }
}

impl core::fmt::Display for StateCode {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::StateCode;
    use dynamics_core::control::Fault;
    use dynamics_core::safety::{HoldCause, State};

    #[test]
    fn the_numbers_are_the_machines() {
        let states = [
            State::Idle,
            State::Homing,
            State::Armed,
            State::Running,
            State::Holding(HoldCause::Requested),
            State::Fault(Fault::Overrun),
            State::Arming,
            State::Lowering,
            State::Disarming,
        ];
        assert_eq!(states.map(StateCode::new), StateCode::ALL);
        for (number, (state, code)) in states.into_iter().zip(StateCode::ALL).enumerate() {
            assert_eq!((state.code(), code.code()), (number as u8, number as u8));
            assert_eq!(state.has_torque(), code.has_torque(), "{state:?}");
        }
    }
}
