//! The tasks and who owns what.
//!
//! | task | interrupt | priority | owns |
//! |---|---|---|---|
//! | `receive` | the link's receiver: a byte, or the idle line behind what a DMA has stored | 3 | the receiving half of the link |
//! | `half_filled` | the DMA that stores the link's bytes | 3 | the same |
//! | `tick` | the control timer | 2 | timer, counter, lines, joints |
//! | `on_first_bus` to `on_third_bus` | a CAN controller with less room than a tick has frames | 2 | joints |
//! | `serve` | a vector that no peripheral uses | 1 | decoder, encoder, the sending half of the link |
//! | `sent` | the DMA that sends the link's bytes | 1 | the sending half of the link |
//!
//! Tasks are bound to the vectors of an STM32F405; another chip's file says which of its own these are.
//!
//! `serve` is pended, not spawned: pending it while it runs makes it run again, so every received frame is handled. Tasks of one priority
//! share without a lock.

use crate::boards;
use firmware::board::Board;
use link::{Hello, Pacing};

#[cfg(any(feature = "odrive-v3", feature = "f405-can", feature = "f405-pwm", feature = "g474-fdcan"))]
use defmt_rtt as _;
#[cfg(feature = "netduinoplus2")]
use defmt_semihosting as _;

// Two boards define one name twice, and the compiler reports it: `--no-default-features --features odrive-v3`.
pub(crate) use boards::ThisBoard;

/// After a panic the only safe state is braked and silent.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| {
        // The place only: the message would bring 3 KiB of formatting to the chip.
        if let Some(place) = info.location() {
            defmt::error!("panic at {=str}:{=u32}", place.file(), place.line());
        }
    })
}

#[defmt::panic_handler]
fn defmt_panic() -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| {})
}

/// The hello of this firmware.
fn hello() -> Hello {
    Hello { robot: arm::HASH, joints: arm::N as u8, rate_hz: arm::RATE_HZ, pacing: Pacing::LockStep }
}

#[rtic::app(device = crate::boards::pac, peripherals = true)]
mod rtos {
    use super::{Board, ThisBoard, boards};
    use boards::pac::Interrupt;
    use core::mem::MaybeUninit;
    #[cfg(feature = "dma")]
    use firmware::board::LinkOutput;
    use firmware::board::{BoardLines, Incoming, LinkInput, Nonces, Parts, Ticker};
    use firmware::joint_io::{JointIo, run_tick};
    use firmware::serve::{self as service, Served};
    use link::{Access, BoardChannel, Frame, Pacing, Received};
    use session::black_box::Report;
    use session::meter::Meter;
    use session::{Buffers, Message, Outcome, Reaction, Session};

    const BOARD: &str = <ThisBoard as Board<{ arm::N }>>::NAME;

    type ArmBuffers = Buffers<{ arm::N }>;
    type ArmOutput = <ThisBoard as Board<{ arm::N }>>::Output;
    type ArmJoints = <ThisBoard as Board<{ arm::N }>>::Joints;
    type ArmSession = Session<{ arm::N }, arm::Build, &'static mut ArmBuffers>;

    /// State that tick and link share. One resource: each lock of its own costs the tick a dozen instructions.
    #[allow(unreachable_pub, reason = "the application hands it to its tasks in types that are public")]
    pub struct Control {
        session: &'static mut ArmSession,
        ticker: <ThisBoard as Board<{ arm::N }>>::Ticker,
        joints: &'static mut ArmJoints,
    }

    #[shared]
    struct Shared {
        control: Control,
        #[lock_free]
        input: <ThisBoard as Board<{ arm::N }>>::Input,
        #[lock_free]
        output: <ThisBoard as Board<{ arm::N }>>::Output,
    }

    #[local]
    struct Local {
        incoming: <ThisBoard as Board<{ arm::N }>>::Incoming,
        channel: &'static mut BoardChannel,
        nonces: <ThisBoard as Board<{ arm::N }>>::Nonces,
        meter: Meter<<ThisBoard as Board<{ arm::N }>>::Counter>,
        lines: <ThisBoard as Board<{ arm::N }>>::Lines,
    }

    /// Places of what is too large for the stack.
    #[allow(unreachable_pub, reason = "the application hands it to its tasks in types that are public")]
    pub struct Places {
        buffers: ArmBuffers,
        session: MaybeUninit<ArmSession>,
        joints: MaybeUninit<ArmJoints>,
        channel: MaybeUninit<BoardChannel>,
    }

    impl Places {
        const EMPTY: Self = Self {
            buffers: Buffers::new(),
            session: MaybeUninit::uninit(),
            joints: MaybeUninit::uninit(),
            channel: MaybeUninit::uninit(),
        };
    }

    #[init(local = [places: Places = Places::EMPTY])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let all = set_up(cx.local.places, boards::Chip { device: cx.device, core: cx.core });
        // Its first run sends the hello. Frames sent by a host earlier may meet a receiver that is still off.
        rtic::pend(Interrupt::EXTI0);
        all
    }

    /// Start the board, and put everything in its place. Interrupts begin at the end of `init`, above its frame: the frame of this
    /// function has left the stack by then.
    #[inline(never)]
    fn set_up(places: &'static mut Places, chip: boards::Chip) -> (Shared, Local) {
        let Places { buffers, session, joints: joints_place, channel } = places;
        let Parts { input, incoming, output, ticker, counter, lines, joints, nonces } =
            <ThisBoard as Board<{ arm::N }>>::start(chip, arm::RATE_HZ);
        let meter = Meter::new(counter);
        defmt::info!("{} on {}: {} joints, {} Hz", arm::NAME, BOARD, arm::N, arm::RATE_HZ);
        if !meter.is_exact() {
            defmt::warn!("no exact counter: the cost of a tick is not reported");
        }
        let access = crate::key::access();
        match access {
            Access::Key(_) => {}
            Access::NoKey => {
                defmt::warn!("no link key: the bench alone; `cargo newtau firmware key write FILE --board BOARD`")
            }
            Access::Insecure => defmt::warn!("built without a link key: anybody on the wire can drive"),
        }
        let session = session.write(Session::with_buffers(super::hello(), arm::controller(), arm::Settings, buffers));
        let joints = joints_place.write(joints);
        // A reset may have left drives on. Their first frame waits in the controllers until these have joined their buses.
        joints.safe(session.safe_action());
        let control = Control { session, ticker, joints };
        let channel = channel.write(BoardChannel::new(access));
        (Shared { control, input, output }, Local { incoming, channel, nonces, meter, lines })
    }

    /// A byte from the link, or the idle line behind a packet that a DMA has stored.
    #[task(binds = USART2, priority = 3, shared = [input])]
    fn receive(cx: receive::Context) {
        if cx.shared.input.received() {
            rtic::pend(Interrupt::EXTI0);
        }
    }

    /// Another half of the buffer of received bytes is full.
    #[cfg(feature = "dma")]
    #[task(binds = DMA1_STREAM5, priority = 3, shared = [input])]
    fn half_filled(cx: half_filled::Context) {
        cx.shared.input.half_filled();
        rtic::pend(Interrupt::EXTI0);
    }

    /// The control tick.
    #[task(binds = TIM3, priority = 2, shared = [control], local = [meter, lines])]
    fn tick(mut cx: tick::Context) {
        let tick::LocalResources { meter, lines, .. } = cx.local;
        cx.shared.control.lock(|Control { session, ticker, joints }| {
            ticker.acknowledge();
            let in_time = run_tick(*session, *joints, meter, || lines.read(), || ticker.is_due());
            if session.is_live() && in_time {
                lines.feed();
            }
        });
        rtic::pend(Interrupt::EXTI0);
    }

    /// A frame has come on a CAN bus, or one is sent.
    #[cfg(feature = "g474-fdcan")]
    #[task(binds = CAN1_RX0, priority = 2, shared = [control])]
    fn on_first_bus(mut cx: on_first_bus::Context) {
        cx.shared.control.lock(|control| control.joints.interrupt());
    }

    /// The same on the second one.
    #[cfg(feature = "g474-fdcan")]
    #[task(binds = CAN1_RX1, priority = 2, shared = [control])]
    fn on_second_bus(mut cx: on_second_bus::Context) {
        cx.shared.control.lock(|control| control.joints.interrupt());
    }

    /// The same on the third one.
    #[cfg(feature = "g474-fdcan")]
    #[task(binds = CAN2_RX0, priority = 2, shared = [control])]
    fn on_third_bus(mut cx: on_third_bus::Context) {
        cx.shared.control.lock(|control| control.joints.interrupt());
    }

    /// A piece is sent: the next one, and what found no room.
    #[cfg(feature = "dma")]
    #[task(binds = DMA1_STREAM6, priority = 1, shared = [output])]
    fn sent(cx: sent::Context) {
        cx.shared.output.sent();
        rtic::pend(Interrupt::EXTI0);
    }

    /// Read the received frames and send the reports: [`firmware::serve`].
    #[task(
        binds = EXTI0, priority = 1, shared = [control, output],
        local = [incoming, channel, nonces, announced: bool = false]
    )]
    fn serve(mut cx: serve::Context) {
        let serve::LocalResources { incoming, channel, nonces, announced, .. } = cx.local;
        let output = cx.shared.output;
        if !core::mem::replace(announced, true) {
            greet(channel, output);
        }
        if incoming.has_lost() {
            defmt::warn!("bytes lost: the link is faster than they are read");
        }
        let mut served = ServedSession(&mut cx.shared.control);
        if service::run(incoming, channel, output, &super::hello(), &mut || nonces.next(), &mut served) {
            rtic::pend(Interrupt::EXTI0);
        }
    }

    /// The session behind its lock.
    struct ServedSession<'a, M>(&'a mut M);

    impl<M: rtic::Mutex<T = Control>> Served<ArmOutput> for ServedSession<'_, M> {
        fn take(&mut self, received: Received, channel: &mut BoardChannel, output: &mut ArmOutput) {
            let outcome = take(self.0, received);
            react(self.0, outcome, channel, output);
        }

        fn say(&mut self) -> Option<(Frame, bool)> {
            let report = self.0.lock(|control| control.session.say())?;
            let past = matches!(report, Report::Past(_));
            let frame = report.frame();
            if let Frame::Fault(fault) = &frame {
                defmt::warn!("fault {} in tick {}", fault.code, fault.tick);
            }
            Some((frame, past))
        }

        fn dumps(&mut self) -> bool {
            self.0.lock(|control| control.session.dumps())
        }
    }

    /// Send the board's hello.
    #[inline(never)]
    fn greet(channel: &mut BoardChannel, output: &mut ArmOutput) {
        service::send(channel, output, &Frame::Hello(super::hello()));
    }

    /// Take a frame.
    #[inline(never)]
    fn take(control: &mut impl rtic::Mutex<T = Control>, received: Received) -> Outcome {
        // Whatever does not need the session is done before it is locked: a tick waits for the lock.
        let mut message = Message::new(Ok(received));
        if message.goes_on() {
            message.find_way(control.lock(|control| control.session.way_from()));
        }
        let outcome = control.lock(|control| control.session.take(&message));
        let Outcome::Hello(theirs) = &outcome else { return outcome };
        // In parts, each under a lock of its own: a tick in between finds no session, and does the safe action.
        control.lock(|control| control.session.forget_controller());
        control.lock(|control| control.session.forget_arm());
        control.lock(|control| control.session.begin(theirs))
    }

    /// Do what a frame asks for.
    #[inline(never)]
    fn react(
        control: &mut impl rtic::Mutex<T = Control>,
        outcome: Outcome,
        channel: &mut BoardChannel,
        output: &mut ArmOutput,
    ) {
        match outcome.reaction() {
            Reaction::None => {}
            Reaction::Tick => control.lock(|control| control.ticker.trigger()),
            Reaction::Reply(frame) => service::reply(channel, output, &frame),
            Reaction::Start(pacing, hello) => {
                control.lock(|control| {
                    match pacing {
                        Pacing::Timer | Pacing::Live => control.ticker.run(),
                        Pacing::LockStep | Pacing::DryRun => control.ticker.hold(),
                    }
                    control.joints.safe(control.session.safe_action());
                });
                service::send(channel, output, &hello);
            }
            // Not as a reply, which may be dropped: the host waits for it.
            Reaction::Resume(hello) => service::send(channel, output, &hello),
            Reaction::Stop(hello, refusal) => {
                control.lock(|control| {
                    control.ticker.hold();
                    control.joints.safe(control.session.safe_action());
                });
                service::send(channel, output, &hello);
                service::send(channel, output, &refusal);
            }
        }
    }
}
