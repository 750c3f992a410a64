//! The board's own joint code, wired to simulated CAN buses and a brake line.

use actuator_model::bus::Bus;
use actuator_model::frame::Frame;
use core::convert::Infallible;
use dynamics_core::drive::MitDrive;
use dynamics_core::with_drive_kinds;
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use embedded_hal::digital::{ErrorType, OutputPin};
use joint_io::JointIo;
use joint_io::can::{BUSES, CanJoints};
use joint_io::can_bus::CanBus;
use joint_io::queued::Queued;
use robot_compiler::drive::Protocol;

/// The joints of an arm with drives of the kind `K`.
pub(super) type JointsOf<K, const N: usize> = CanJoints<K, Queued<Line>, Queued<Line>, Queued<Line>, BrakeLine, N>;

macro_rules! joints_of {
    ($($kind:ident)*) => {
        /// The board's access to the joints, for each kind of drive.
        #[derive(Clone, Debug)]
        pub(super) enum Joints<const N: usize> {
            $($kind(JointsOf<dynamics_core::drive::$kind, N>),)*
        }

        impl<const N: usize> Joints<N> {
            pub(super) fn new(protocol: Protocol, lines: [Line; BUSES], wires: [MitDrive; N]) -> Self {
                let buses = lines.map(Queued::new).into();
                match protocol {
                    $(Protocol::$kind => Self::$kind(CanJoints::new(buses, BrakeLine::default(), wires)),)*
                }
            }

            pub(super) fn io(&mut self) -> &mut dyn JointIo<N> {
                match self {
                    $(Self::$kind(joints) => joints,)*
                }
            }

            pub(super) fn buses(&mut self) -> (&mut Queued<Line>, &mut Queued<Line>, &mut Queued<Line>) {
                match self {
                    $(Self::$kind(joints) => joints.buses(),)*
                }
            }

            pub(super) fn brake(&self) -> &BrakeLine {
                match self {
                    $(Self::$kind(joints) => joints.brake(),)*
                }
            }
        }
    };
}

with_drive_kinds!(joints_of);

/// The line to the brakes: high opens them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BrakeLine {
    pub(super) open: bool,
}

impl ErrorType for BrakeLine {
    type Error = Infallible;
}

impl OutputPin for BrakeLine {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.open = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.open = true;
        Ok(())
    }
}

/// A bus, as the board's driver accesses it.
#[derive(Clone, Debug)]
pub(super) struct Line(pub(super) Bus);

impl Can for Line {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        Can::transmit(&mut self.0, frame)
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        Can::receive(&mut self.0)
    }
}

impl CanBus for Line {
    fn is_off(&mut self) -> bool {
        self.0.off
    }

    fn abandon(&mut self) {
        self.0.abandon();
    }
}
