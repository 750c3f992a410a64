//! Numbered reasons to stop: 1 to 7 are the controller's own, and from 8 on those of the state machine around it.

use core::fmt;

/// The one list of faults: number, name, the joint if it concerns one joint, its text, the condition that raises it, and things to check. The
/// enum, the numbers, the texts, the advice on the operator's screen and the table of `docs/operate/faults.md` are made from it.
macro_rules! faults {
    ($($code:literal $name:ident $({ $joint:ident })? $text:literal, raised: $raised:literal, check: $check:literal;)*) => {
        /// Reason why the controller stopped. Numbers are stable: telemetry carries them.
        ///
        /// | code | fault | raised when |
        /// |---|---|---|
        $(#[doc = concat!("| ", $code, " | ", $text, " | ", $raised, " |")])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Fault {
            $(#[doc = concat!("Raised when ", $raised, ".")]
            $name $({
                /// Joint, counted from 0.
                $joint: u8,
            })?,)*
        }

        impl Fault {
            /// All faults in the order of their numbers; those that concern one joint appear with joint 0.
            pub const ALL: &[Self] = &[$(Self::$name $({ $joint: 0 })?),*];

            /// The stable number.
            #[must_use]
            pub const fn code(&self) -> u8 {
                match self {
                    $(Self::$name $({ $joint: _ })? => $code,)*
                }
            }

            /// The joint at fault, counted from 0, if the fault concerns one joint.
            #[must_use]
            pub const fn joint(&self) -> Option<u8> {
                match *self {
                    $(Self::$name $({ $joint })? => faults!(@joint $($joint)?),)*
                }
            }

            /// The fault with this number, on this joint if it concerns one joint. The inverse of [`Fault::code`] and [`Fault::joint`].
            #[must_use]
            pub const fn from_code(code: u8, joint: u8) -> Option<Self> {
                Some(match code {
                    $($code => Self::$name $({ $joint: joint })?,)*
                    _ => return None,
                })
            }

            /// The fault in words.
            #[must_use]
            pub const fn text(&self) -> &'static str {
                match self {
                    $(Self::$name $({ $joint: _ })? => $text,)*
                }
            }

            /// Condition that raises the fault.
            #[must_use]
            pub const fn raised(&self) -> &'static str {
                match self {
                    $(Self::$name $({ $joint: _ })? => $raised,)*
                }
            }

            /// Things to check after the fault, most likely causes first.
            #[must_use]
            pub const fn check(&self) -> &'static str {
                match self {
                    $(Self::$name $({ $joint: _ })? => $check,)*
                }
            }
        }
    };
    (@joint) => { None };
    (@joint $joint:ident) => { Some($joint) };
}

faults! {
    1 NonFiniteMeasurement { joint }
        "measurement is not a finite number",
        raised: "a position or velocity is NaN or infinite",
        check: "the sensor of this joint and its cable";
    2 NonFiniteReference { joint }
        "reference is not a finite number",
        raised: "a reference position, velocity or acceleration is NaN or infinite",
        check: "the program that sends the reference";
    3 StaleMeasurement
        "measurement is stale",
        raised: "the measurement is older than `age_max` ticks: it came late, or none has come since",
        check: "the sensor's rate, the link";
    4 PositionOutOfBounds { joint }
        "position out of bounds",
        raised: "a joint is beyond its limit by more than `guard.position_margin`",
        check: "the reference and the zero of this joint; move the joint back inside by hand, then `clear`";
    5 VelocityOutOfBounds { joint }
        "velocity out of bounds",
        raised: "a joint is faster than `guard.velocity_factor` times its limit",
        check: "the gains, the payload, the encoder's scale";
    6 Overrun
        "control tick overran",
        raised: "a tick had not ended when the next was due",
        check: "the control rate, other interrupts of the board";
    7 NonFiniteTorque { joint }
        "computed torque is not a finite number",
        raised: "the computed torque is NaN or infinite",
        check: "the numbers of the model, the size of the reference";
    8 ImpossibleJump { joint }
        "measured position jumped farther than the joint can move",
        raised: "a joint is farther from its last reading than it can have moved",
        check: "the encoder and its cable; home the arm again";
    9 EmergencyStop
        "emergency stop",
        raised: "the line is pressed or broken",
        check: "the emergency stop; release it, then `clear`";
    10 HeartbeatLost
        "the host was silent for too long",
        raised: "the host has been silent for longer than the arm holds",
        check: "the host and the link";
    11 DriveFault { joint }
        "the drive reports a fault",
        raised: "a joint's drive says so",
        check: "the drive's error text";
    12 SupplyOutOfBounds
        "supply voltage out of bounds",
        raised: "the board's voltage is NaN or outside `safety.supply`",
        check: "the supply voltage, the brake resistor";
    13 TemperatureOutOfBounds
        "temperature out of bounds",
        raised: "the highest temperature of board and drives is NaN or outside `safety.temperature`",
        check: "the cooling, the load";
    14 Collision { joint }
        "collision",
        raised: "a joint's external torque was above its threshold, in a scene whose `[collision]` says stop",
        check: "the arm's surroundings; then payload, friction and thresholds of the scene";
    15 FollowingError { joint }
        "the joint is out of reach of where the arm holds",
        raised: "a joint is farther than its `reach` from where it was armed, also on engaged brakes while it is armed, or than 1.5 times that from the way of its stop or \
         of its lowering, but not while it gives way to a collision; or, also then, lowering waited for it for `hold_ms`, \
         at most 0.5 s, in all",
        check: "most likely first: 1. the payload (`payload` or `weigh` declares it); 2. a person or an obstacle that pushes the \
         arm; 3. the drive's torque (`check-torque`); 4. live wrench and rotors; 5. the model of the arm (`newtau \
         identify`)";
    16 Overload { joint }
        "the joint cannot hold what the arm carries",
        raised: "the arm was to be armed, and a joint would need more than its torque limit to hold it there: by the model, and \
         the payload, wrench and gravity that were told",
        check: "payload, wrench and gravity as declared, and the posture; `clear`, correct them, and arm again";
    17 DriveNotOn { joint }
        "the drive did not come on",
        raised: "the arm was to be armed, and a joint's drive did not show within 1 s that it is on",
        check: "the drive's power, its bus and its error text; then `clear` and arm again";
    18 DriveOff { joint }
        "the drive went off while torque acted",
        raised: "a joint's drive went off while torque acted",
        check: "the drive's power and its protection against current, voltage and heat: the drive switched itself off";
    19 ZeroLost
        "a drive may have lost its zero while torque acted",
        raised: "a drive may have lost its zero while torque acted",
        check: "the drives' power: a drive may have lost its zero; home the arm again";
    20 Overheated { joint }
        "the joint is too hot",
        raised: "torque acts or is about to, and a joint's motor is above 1.05 of its continuous limit by the board's heat model; \
         only where the robot file knows the motor",
        check: "the load and the posture; let the joint cool down";
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fault {}: {}", self.code(), self.text())?;
        match self.joint() {
            Some(joint) => write!(f, " (joint {})", u32::from(joint) + 1),
            None => Ok(()),
        }
    }
}
