//! One fault of drives, buses or host, with its random parameters.

use crate::campaign::fault::{FaultKind, Span};
use crate::campaign::host::Host;
use crate::campaign::random::Random;
use actuator_model::bus::{CommandFate, Disturbance, Fate};
use actuator_model::frame::Order;
use actuator_model::mit::error::OVERLOAD;
use link::Request;
use link::codec::FrameTooLong;
use sim::plant::State;
use sim::plant::drives::Drives;

/// Requests that make a board send frames of this kind.
const fn provoking(order: Order) -> &'static [Request] {
    match order {
        Order::Enable | Order::Setting => &[Request::Arm],
        Order::Disable => &[Request::Stop, Request::Disarm],
        Order::Clear => &[Request::Clear],
        Order::Torque => &[Request::Stop, Request::Disarm, Request::Hold, Request::Run, Request::Arm],
    }
}

/// A temporary fault.
#[derive(Clone, Copy, Debug)]
pub(super) struct DriveInjection {
    pub(super) kind: FaultKind,
    joint: usize,
    /// True if the fault affects all drives.
    all: bool,
    /// Share of the frames that are affected.
    share: f64,
    /// Requests to send: a pair, or one at the beginning.
    asks: [Option<Request>; 2],
}

/// Lines of the board, and lateness of a tick.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Board {
    pub(super) emergency_stop: bool,
    /// True if the tick is found late before its outputs, false if after them; `None` if it is on time.
    pub(super) late: Option<bool>,
}

impl DriveInjection {
    /// Draws the parameters of a fault; `pair` numbers the pairs of requests.
    pub(super) fn new<const N: usize>(kind: FaultKind, pair: u64, random: &mut Random) -> Self {
        let (joint, all) = (random.index(N), random.chance(0.3));
        let share = if random.chance(0.5) { 1.0 } else { 0.1 + 0.8 * random.unit() };
        let count = Request::OF_THE_MACHINE.len() as u64;
        let request = |number: u64| Request::OF_THE_MACHINE.get((number % count) as usize).copied();
        let asks = match kind {
            FaultKind::RequestPair => [request(pair), request(pair / count)],
            FaultKind::Command(order, _) => [random.pick(provoking(order)).filter(|_| random.chance(0.7)), None],
            FaultKind::EnableIgnored => [Some(Request::Arm), None],
            _ => [None; 2],
        };
        Self { kind, joint, all, share, asks }
    }

    /// Disturbs tick number `k`, counted from 0.
    pub(super) fn act<const N: usize>(
        &self,
        k: u32,
        (drives, state): (&mut Drives<N>, &State<N>),
        host: &mut Host<N>,
        random: &mut Random,
    ) -> Result<Board, FrameTooLong> {
        if k == 0 {
            self.asks.into_iter().flatten().try_for_each(|request| host.ask(request))?;
        }
        let Some((bus, id)) = drives.address(self.joint) else { return Ok(Board::default()) };
        let meets = random.chance(self.share);
        let mut board = Board::default();
        let everyone = |kind| matches!(kind, FaultKind::PowerOfAll(_) | FaultKind::PowerCut);
        let joints = if everyone(self.kind) { 0..N } else { self.joint..self.joint + 1 };
        match self.kind {
            FaultKind::Command(order, fate) => {
                let one = Disturbance { id: (!self.all).then_some(id), order: Some(order), fate };
                (0..3).filter(|other| self.all || *other == bus).for_each(|bus| {
                    drives.bus(bus).disturbance = meets.then_some(one);
                });
            }
            FaultKind::Burst => {
                let all = Disturbance { id: None, order: None, fate: CommandFate::Lost };
                (0..3).for_each(|bus| drives.bus(bus).disturbance = Some(all));
            }
            FaultKind::Unacknowledged => drives.bus(bus).stuck = true,
            FaultKind::BusOff => drives.bus(bus).off = true,
            FaultKind::Reply(fate) if meets => drives.bus(bus).fates = vec![(id, fate)],
            FaultKind::ReplyGap => drives.bus(bus).fates = vec![(id, Fate::Lost)],
            FaultKind::Power(_) | FaultKind::PowerOfAll(_) | FaultKind::PowerCut => {
                board.emergency_stop = self.kind == FaultKind::PowerCut;
                joints.for_each(|joint| {
                    drives.electronics(joint).into_iter().for_each(|it| it.powered = false);
                });
            }
            FaultKind::EnableIgnored => {
                drives.electronics(self.joint).into_iter().for_each(|it| it.ignores_enable = true)
            }
            FaultKind::Trip if k == 0 => drives.electronics(self.joint).into_iter().for_each(|it| it.trip()),
            FaultKind::Latched if k == 0 => {
                drives.electronics(self.joint).into_iter().for_each(|it| it.error = OVERLOAD);
            }
            FaultKind::Zero if k == 0 => {
                let shaft = drives.shaft(state, self.joint);
                drives.electronics(self.joint).into_iter().for_each(|it| it.set_zero(&shaft));
            }
            FaultKind::EmergencyStop => board.emergency_stop = true,
            FaultKind::Overrun => board.late = (k == 0 || meets).then_some(self.all),
            _ => {}
        }
        Ok(board)
    }

    /// Ends the fault: power returns, and frames arrive.
    pub(super) fn end<const N: usize>(&self, drives: &mut Drives<N>, state: &State<N>) {
        for bus in 0..3 {
            let bus = drives.bus(bus);
            (bus.disturbance, bus.stuck, bus.off) = (None, false, false);
            bus.fates.clear();
        }
        for joint in 0..N {
            let shaft = drives.shaft(state, joint);
            let Some(electronics) = drives.electronics(joint) else { continue };
            electronics.ignores_enable = false;
            if !electronics.powered {
                electronics.restart(&shaft);
            }
        }
    }

    /// Shortest and longest duration, ticks.
    pub(super) fn ticks(&self, age_max: u32, silence: u32, lowering: u32) -> (u32, u32) {
        match self.kind {
            FaultKind::Reply(Fate::Lost) => (1, age_max.max(1)),
            FaultKind::ReplyGap => (age_max + 1, age_max + 30),
            FaultKind::HostSilent => (1, silence + 100),
            FaultKind::HostGone => (silence + lowering, silence + lowering + 100),
            FaultKind::Power(Span::Short) | FaultKind::PowerOfAll(Span::Short) => (1, 9),
            kind => kind.ticks(),
        }
    }
}
