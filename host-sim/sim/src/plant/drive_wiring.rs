//! The board's own joint code, wired to simulated CAN buses and a brake line.

use crate::with_drive_type;
use actuator_model::bus::Bus;
use actuator_model::frame::Frame;
use core::convert::Infallible;
use core::fmt::Debug;
use dynamics_core::drive::MitDrive;
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use embedded_hal::digital::{ErrorType, OutputPin};
use joint_io::JointIo;
use joint_io::can::{BUSES, CanJoints};
use joint_io::can_bus::CanBus;
use joint_io::frames::Frames;
use joint_io::queued::Queued;
use robot_compiler::drive::Protocol;

/// The board's access to the joints, for drives of any kind.
pub(super) trait Joints<const N: usize>: Debug + Send + Sync {
    fn io(&mut self) -> &mut dyn JointIo<N>;

    fn bus(&mut self, bus: usize) -> &mut Bus;

    fn brake(&self) -> &BrakeLine;

    fn boxed(&self) -> Box<dyn Joints<N>>;
}

impl<K: Frames + Clone + Send + Sync + 'static, const N: usize> Joints<N>
    for CanJoints<K, Queued<Line>, Queued<Line>, Queued<Line>, BrakeLine, N>
{
    fn io(&mut self) -> &mut dyn JointIo<N> {
        self
    }

    fn bus(&mut self, bus: usize) -> &mut Bus {
        let (first, second, third) = self.buses();
        let queued = match bus {
            0 => first,
            1 => second,
            _ => third,
        };
        &mut queued.bus().0
    }

    fn brake(&self) -> &BrakeLine {
        CanJoints::brake(self)
    }

    fn boxed(&self) -> Box<dyn Joints<N>> {
        Box::new(self.clone())
    }
}

/// The board's access to the joints of an arm with drives of this kind.
pub(super) fn joints<const N: usize>(
    protocol: Protocol,
    lines: [Line; BUSES],
    wires: [MitDrive; N],
) -> Box<dyn Joints<N>> {
    let buses = lines.map(Queued::new);
    with_drive_type!(protocol, K => Box::new(CanJoints::<K, _, _, _, _, N>::new(buses.into(), BrakeLine::default(), wires)))
}

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
