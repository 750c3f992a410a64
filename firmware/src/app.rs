//! The tasks of the firmware and the resources that they own.
//!
//! | task | interrupt | priority | owns |
//! |---|---|---|---|
//! | `receive` | the link's receiver: a byte, or with a DMA the idle line after a packet | 3 | the receiving half of the link |
//! | `half_filled` | the DMA that stores the link's bytes | 3 | the same |
//! | `tick` | the control timer | 2 | timer, counter, lines, joints |
//! | `on_first_bus` to `on_third_bus` | a CAN controller that holds fewer frames than a tick has | 2 | joints |
//! | `serve` | a vector that no peripheral uses | 1 | decoder, encoder, the sending half of the link |
//! | `sent` | the DMA that sends the link's bytes | 1 | the sending half of the link |
//!
//! Tasks are bound to the vectors of an STM32F405; the file of another chip maps these names to its own vectors.
//!
//! `serve` is pended, not spawned: if it is pended while it runs, it runs again, so every received frame is handled. Tasks of the same priority
//! share resources without a lock.

use crate::boards;
use firmware::board::Board;
use link::{Hello, Pacing};

#[cfg(any(feature = "odrive-v3", feature = "f405-can", feature = "f405-pwm", feature = "g474-fdcan"))]
use defmt_rtt as _;
#[cfg(feature = "netduinoplus2")]
use defmt_semihosting as _;

// With the features of two boards this name is defined twice and the compiler reports an error. Select one board, for example with
// `--no-default-features --features odrive-v3`.
pub(crate) use boards::ThisBoard;

/// After a panic the only safe state is with drives off, brakes engaged and no communication.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| {
        // Only the location: formatting the message would need 3 KiB of flash.
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
    use crate::tick_code::Guard;
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
    use session::parameters::LiveBounds;
    use session::{Buffers, Message, Outcome, Reaction, Session};

    const BOARD: &str = <ThisBoard as Board<{ arm::N }>>::NAME;

    type ArmBounds = LiveBounds<{ arm::N }>;
    type ArmBuffers = Buffers<{ arm::N }>;
    type ArmOutput = <ThisBoard as Board<{ arm::N }>>::Output;
    type ArmJoints = <ThisBoard as Board<{ arm::N }>>::Joints;
    type ArmSession = Session<{ arm::N }, arm::Build, &'static mut ArmBuffers>;

    /// State that tick and link share. It is one resource, because every further lock takes a dozen instructions of the tick.
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
        guard: Guard,
        live_bounds: ArmBounds,
    }

    /// Static memory for values that are too large for the stack. `coupled.x` finds it by its name, and puts it into memory that the start-up
    /// code does not clear; `set_up` writes it.
    #[allow(unreachable_pub, reason = "the application hands it to its tasks in types that are public")]
    pub struct Places {
        buffers: MaybeUninit<ArmBuffers>,
        session: MaybeUninit<ArmSession>,
        joints: MaybeUninit<ArmJoints>,
        channel: MaybeUninit<BoardChannel>,
    }

    impl Places {
        const EMPTY: Self = Self {
            buffers: MaybeUninit::uninit(),
            session: MaybeUninit::uninit(),
            joints: MaybeUninit::uninit(),
            channel: MaybeUninit::uninit(),
        };
    }

    #[init(local = [places: Places = Places::EMPTY])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let all = set_up(cx.local.places, boards::Chip { device: cx.device, core: cx.core });
        // The first run of `serve` sends the hello. Frames that a host sends before it may be lost, because the receiver may still be off.
        rtic::pend(Interrupt::EXTI0);
        all
    }

    /// Starts the board and initialises all static memory. Not inlined, so that its stack frame is gone when interrupts begin at the end of
    /// `init`.
    #[inline(never)]
    fn set_up(places: &'static mut Places, chip: boards::Chip) -> (Shared, Local) {
        let rounds_as_the_desk = chip.rounds_as_the_desk();
        let Places { buffers, session, joints: joints_place, channel } = places;
        let Parts { input, incoming, output, ticker, counter, lines, joints, nonces } =
            <ThisBoard as Board<{ arm::N }>>::start(chip, arm::RATE_HZ);
        if !rounds_as_the_desk {
            // After the start, which has set the lines: its torques would not be those that were tested, and the check of the arm's hash would not see it.
            <ThisBoard as Board<{ arm::N }>>::halt(|| {
                defmt::error!(
                    "floating-point mode changed before the start: FPSCR or FPDSCR has FZ, DN, RMode or AHP set"
                )
            })
        }
        // Not before the start, which has set the lines.
        let guard = Guard::start();
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
        let buffers = buffers.write(const { Buffers::new() });
        let session = session.write(Session::with_buffers(super::hello(), arm::controller(), arm::Settings, buffers));
        let joints = joints_place.write(joints);
        // A reset may have left drives on. The first frame to them waits in the CAN controllers until these have joined their buses.
        joints.safe(session.safe_action());
        let live_bounds = session.live_bounds();
        let control = Control { session, ticker, joints };
        let channel = channel.write(BoardChannel::new(access));
        (Shared { control, input, output }, Local { incoming, channel, nonces, meter, lines, guard, live_bounds })
    }

    /// Handles a byte from the link, or the idle line after a packet that a DMA has stored.
    #[task(binds = USART2, priority = 3, shared = [input])]
    fn receive(cx: receive::Context) {
        if cx.shared.input.received() {
            rtic::pend(Interrupt::EXTI0);
        }
    }

    /// Counts a full half of the buffer of received bytes.
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

    /// Handles a received or sent frame on the first CAN bus.
    #[cfg(feature = "g474-fdcan")]
    #[task(binds = CAN1_RX0, priority = 2, shared = [control])]
    fn on_first_bus(mut cx: on_first_bus::Context) {
        cx.shared.control.lock(|control| control.joints.interrupt());
    }

    /// Handles a received or sent frame on the second CAN bus.
    #[cfg(feature = "g474-fdcan")]
    #[task(binds = CAN1_RX1, priority = 2, shared = [control])]
    fn on_second_bus(mut cx: on_second_bus::Context) {
        cx.shared.control.lock(|control| control.joints.interrupt());
    }

    /// Handles a received or sent frame on the third CAN bus.
    #[cfg(feature = "g474-fdcan")]
    #[task(binds = CAN2_RX0, priority = 2, shared = [control])]
    fn on_third_bus(mut cx: on_third_bus::Context) {
        cx.shared.control.lock(|control| control.joints.interrupt());
    }

    /// Starts to send the next piece, and runs `serve` for frames that did not fit into the queue.
    #[cfg(feature = "dma")]
    #[task(binds = DMA1_STREAM6, priority = 1, shared = [output])]
    fn sent(cx: sent::Context) {
        cx.shared.output.sent();
        rtic::pend(Interrupt::EXTI0);
    }

    /// Reads the received frames and sends the reports: [`firmware::serve`].
    #[task(
        binds = EXTI0, priority = 1, shared = [control, output],
        local = [incoming, channel, nonces, announced: bool = false, guard, live_bounds]
    )]
    fn serve(mut cx: serve::Context) {
        let serve::LocalResources { incoming, channel, nonces, announced, guard, live_bounds, .. } = cx.local;
        guard.check_some();
        let output = cx.shared.output;
        if !core::mem::replace(announced, true) {
            greet(channel, output);
        }
        if Incoming::has_lost(incoming) {
            defmt::warn!("bytes lost: the link is faster than they are read");
        }
        let mut served = ServedSession { control: &mut cx.shared.control, guard, live_bounds };
        if service::run(incoming, channel, output, &super::hello(), &mut || nonces.next(), &mut served) {
            rtic::pend(Interrupt::EXTI0);
        }
    }

    /// Locked access to the session.
    struct ServedSession<'a, M> {
        control: &'a mut M,
        guard: &'a Guard,
        live_bounds: &'a ArmBounds,
    }

    impl<M: rtic::Mutex<T = Control>> Served<ArmOutput> for ServedSession<'_, M> {
        fn take(&mut self, received: Received, channel: &mut BoardChannel, output: &mut ArmOutput) {
            let outcome = take(self, received);
            react(self.control, outcome, channel, output);
        }

        fn say(&mut self) -> Option<(Frame, bool)> {
            let report = self.control.lock(|control| control.session.say())?;
            let past = matches!(report, Report::Past(_) | Report::End);
            let frame = report.frame();
            if let Frame::Fault(fault) = &frame {
                defmt::warn!("fault {} in tick {}", fault.code, fault.tick);
            }
            Some((frame, past))
        }

        fn dumps(&mut self) -> bool {
            self.control.lock(|control| control.session.dumps())
        }
    }

    /// Sends the board's hello.
    #[inline(never)]
    fn greet(channel: &mut BoardChannel, output: &mut ArmOutput) {
        service::send(channel, output, &Frame::Hello(super::hello()));
    }

    /// Passes a frame to the session.
    #[inline(never)]
    fn take(served: &mut ServedSession<'_, impl rtic::Mutex<T = Control>>, received: Received) -> Outcome {
        let ServedSession { control, guard, live_bounds } = served;
        // All work that does not need the session is done before the lock, because a tick waits for the lock.
        let mut message = Message::new(Ok(received));
        if message.goes_on() {
            message.find_way(control.lock(|control| control.session.way_from()));
        }
        message.check(live_bounds);
        let outcome = control.lock(|control| control.session.take(&message));
        let Outcome::Hello(theirs) = &outcome else { return outcome };
        guard.check();
        // In parts, each under a separate lock: a tick in between finds no session and performs the safe action.
        control.lock(|control| control.session.forget_controller());
        control.lock(|control| control.session.forget_arm());
        control.lock(|control| control.session.begin(theirs))
    }

    /// Carries out the session's reaction to a frame.
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
            // Not sent as a reply, which may be dropped, because the host waits for it.
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
