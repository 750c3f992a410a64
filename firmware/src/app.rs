//! The tasks and who owns what.
//!
//! | task | interrupt | priority | owns |
//! |---|---|---|---|
//! | `byte` | the link's receiver | 3 | the receiving half of the link |
//! | `tick` | the control timer | 2 | timer, counter, lines, joints |
//! | `serve` | a vector that no peripheral uses | 1 | decoder, encoder, the sending half of the link |
//!
//! `serve` is pended, not spawned: pending it while it runs makes it run again, so every received frame is handled.

use crate::boards;
use firmware::board::Board;
use link::{Hello, Pacing};

#[cfg(any(feature = "odrive-v3", feature = "f405-can", feature = "f405-pwm"))]
use defmt_rtt as _;
#[cfg(feature = "netduinoplus2")]
use defmt_semihosting as _;

// Two boards define one name twice, and the compiler reports it: `--no-default-features --features odrive-v3`.
#[cfg(feature = "f405-can")]
pub(crate) use boards::f405_can::F405Can as ThisBoard;
#[cfg(feature = "f405-pwm")]
pub(crate) use boards::f405_pwm::F405Pwm as ThisBoard;
#[cfg(feature = "netduinoplus2")]
pub(crate) use boards::netduinoplus2::NetduinoPlus2 as ThisBoard;
#[cfg(feature = "odrive-v3")]
pub(crate) use boards::odrive_v3::OdriveV3 as ThisBoard;

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
    use firmware::board::{BoardLines, LinkInput, LinkOutput, Nonces, Parts, Ticker};
    use firmware::joint_io::{JointIo, higher};
    use heapless::spsc::{Consumer, Queue};
    use link::{Access, Arrival, BoardChannel, DecodeError, Frame, Inlet, Pacing, Received};
    use session::black_box::Report;
    use session::meter::Meter;
    use session::{Buffers, Drives, Reaction, Session};

    /// Bytes between `byte` and `serve`: three whole packets, the most that a host sends before it waits for an answer
    /// (live inputs, reference, measurement). A queue holds one less than its size.
    const BYTES: usize = 3 * link::PACKET_MAX + 1;

    const BOARD: &str = <ThisBoard as Board<{ arm::N }>>::NAME;

    type ArmBuffers = Buffers<{ arm::N }>;
    type ArmSession =
        Session<{ arm::N }, arm::Arm, arm::Trig, arm::Settings, arm::Tuning, arm::Protection, &'static mut ArmBuffers>;

    #[shared]
    struct Shared {
        session: ArmSession,
        ticker: <ThisBoard as Board<{ arm::N }>>::Ticker,
        joints: <ThisBoard as Board<{ arm::N }>>::Joints,
        overflow: bool,
    }

    #[local]
    struct Local {
        input: <ThisBoard as Board<{ arm::N }>>::Input,
        inlet: Inlet,
        pending: Consumer<'static, u8>,
        output: <ThisBoard as Board<{ arm::N }>>::Output,
        channel: BoardChannel,
        nonces: <ThisBoard as Board<{ arm::N }>>::Nonces,
        meter: Meter<<ThisBoard as Board<{ arm::N }>>::Counter>,
        lines: <ThisBoard as Board<{ arm::N }>>::Lines,
    }

    #[init(local = [bytes: Queue<u8, BYTES> = Queue::new(), buffers: ArmBuffers = Buffers::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let Parts { input, output, ticker, counter, lines, joints, nonces } =
            <ThisBoard as Board<{ arm::N }>>::start(boards::Chip { device: cx.device, core: cx.core }, arm::RATE_HZ);
        let meter = Meter::new(counter);
        let (bytes, pending) = cx.local.bytes.split();
        defmt::info!("{} on {}: {} joints, {} Hz", arm::NAME, BOARD, arm::N, arm::RATE_HZ);
        if !meter.is_exact() {
            defmt::warn!("no exact counter: the cost of a tick is not reported");
        }
        // Its first run sends the hello. Frames sent by a host earlier may meet a receiver that is still off.
        rtic::pend(Interrupt::EXTI0);
        let session = Session::with_buffers(super::hello(), arm::controller(), arm::Settings, cx.local.buffers);
        let access = crate::key::access();
        match access {
            Access::Key(_) => {}
            Access::NoKey => defmt::warn!("no link key: the bench alone; `cargo xtask firmware key`"),
            Access::Insecure => defmt::warn!("built without a link key: anybody on the wire can drive"),
        }
        let (inlet, channel) = (Inlet::new(bytes), BoardChannel::new(access));
        (
            Shared { session, ticker, joints, overflow: false },
            Local { input, inlet, pending, output, channel, nonces, meter, lines },
        )
    }

    /// One byte from the link.
    #[task(binds = USART2, priority = 3, shared = [overflow], local = [input, inlet])]
    fn byte(mut cx: byte::Context) {
        let Some(byte) = cx.local.input.read() else { return };
        let arrival = cx.local.inlet.push(byte);
        if arrival == Arrival::Lost {
            cx.shared.overflow.lock(|overflow| *overflow = true);
        }
        if arrival != Arrival::Waits {
            rtic::pend(Interrupt::EXTI0);
        }
    }

    /// The control tick.
    #[task(binds = TIM3, priority = 2, shared = [session, ticker, joints], local = [meter, lines])]
    fn tick(cx: tick::Context) {
        let tick::SharedResources { session, ticker, joints, .. } = cx.shared;
        let tick::LocalResources { meter, lines, .. } = cx.local;
        (session, ticker, joints).lock(|session, ticker, joints| {
            ticker.acknowledge();
            let readings = joints.measure();
            let mut lines_now = lines.read();
            lines_now.temperature = higher(lines_now.temperature, joints.temperature());
            session.sense(readings.as_ref(), &lines_now);
            let drives = session.tick(meter);
            let late = ticker.is_due();
            if late {
                session.overrun();
            }
            match drives {
                Drives::Drive(torque) if !late => joints.drive(&torque),
                Drives::Drive(_) => joints.safe(session.safe_action()),
                Drives::Safe(action) => joints.safe(action),
            }
            if session.is_live() && !late {
                lines.feed();
            }
        });
        rtic::pend(Interrupt::EXTI0);
    }

    /// Read the received frames and send the reports.
    #[task(
        binds = EXTI0, priority = 1, shared = [session, ticker, joints, overflow],
        local = [
            pending, output, channel, nonces, announced: bool = false
        ]
    )]
    fn serve(mut cx: serve::Context) {
        let serve::LocalResources { pending, output, channel, nonces, announced, .. } = cx.local;
        let own = super::hello();
        if !core::mem::replace(announced, true) {
            send(channel, output, &Frame::Hello(own));
        }
        report(&mut cx.shared.session, channel, output);
        if cx.shared.overflow.lock(core::mem::take) {
            defmt::warn!("bytes lost: the link is faster than they are read");
        }
        while let Some(byte) = pending.dequeue() {
            let received = channel.push(byte, &own, &mut || nonces.next(), &mut |bytes| output.write(bytes));
            let Some(received) = received else { continue };
            let shared = (&mut cx.shared.session, &mut cx.shared.ticker, &mut cx.shared.joints);
            react(shared, received, channel, output);
        }
        if cx.shared.session.lock(|session| session.dumps()) {
            rtic::pend(Interrupt::EXTI0);
        }
    }

    /// Send the session's reports.
    #[inline(never)]
    fn report(
        session: &mut impl rtic::Mutex<T = ArmSession>,
        channel: &mut BoardChannel,
        output: &mut <ThisBoard as Board<{ arm::N }>>::Output,
    ) {
        while let Some(report) = session.lock(|session| session.say()) {
            // The rest of a black box waits until the frames that came meanwhile are handled.
            let past = matches!(report, Report::Past(_));
            let frame = report.frame();
            if let Frame::Fault(fault) = &frame {
                defmt::warn!("fault {} in tick {}", fault.code, fault.tick);
            }
            send(channel, output, &frame);
            if past {
                break;
            }
        }
    }

    /// Take a frame, and do what it asks for.
    #[inline(never)]
    fn react(
        (session, ticker, joints): (
            &mut impl rtic::Mutex<T = ArmSession>,
            &mut impl rtic::Mutex<T = <ThisBoard as Board<{ arm::N }>>::Ticker>,
            &mut impl rtic::Mutex<T = <ThisBoard as Board<{ arm::N }>>::Joints>,
        ),
        received: Result<Received, DecodeError>,
        channel: &mut BoardChannel,
        output: &mut <ThisBoard as Board<{ arm::N }>>::Output,
    ) {
        if let Err(error) = &received {
            defmt::warn!("not decoded: {}", error);
        }
        match session.lock(|session| session.receive(received)) {
            Reaction::None => {}
            Reaction::Tick => ticker.lock(Ticker::trigger),
            Reaction::Reply(frame) => send(channel, output, &frame),
            Reaction::Start(pacing, hello) => {
                ticker.lock(|ticker| match pacing {
                    Pacing::Timer | Pacing::Live => ticker.run(),
                    Pacing::LockStep | Pacing::Drill => ticker.hold(),
                });
                stop(session, joints);
                send(channel, output, &hello);
            }
            Reaction::Stop(hello, refusal) => {
                ticker.lock(Ticker::hold);
                stop(session, joints);
                send(channel, output, &hello);
                send(channel, output, &refusal);
            }
        }
    }

    /// One copy of it, not one at each place that sends.
    #[inline(never)]
    fn send(channel: &mut BoardChannel, output: &mut <ThisBoard as Board<{ arm::N }>>::Output, frame: &Frame) {
        channel.send(frame, &mut |bytes| output.write(bytes));
    }

    /// The drives do the safe action now.
    fn stop(
        session: &mut impl rtic::Mutex<T = ArmSession>,
        joints: &mut impl rtic::Mutex<T = <ThisBoard as Board<{ arm::N }>>::Joints>,
    ) {
        let action = session.lock(|session| session.safe_action());
        joints.lock(|joints| joints.safe(action));
    }
}
