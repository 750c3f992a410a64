//! The program on the chip: the controllers, and the ticks that all of them run.

use core::fmt::{self, Write as _};
use core::hint::black_box;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprint;
use dynamics_core::control::{ArmBuild, Controller};
use dynamics_core::{Command, Fault, Measurement, Real, Reference, Sensed};
use generated::{INPUTS, N, all};
use heapless::String;
use probe::Counter;

/// Inputs of a tick: the reference, which equals the arm's state, and the encoder counts if there are any.
pub(crate) struct Row {
    pub(crate) q: [f64; N],
    pub(crate) qd: [f64; N],
    pub(crate) qdd: [f64; N],
    pub(crate) counts: Option<[i32; N]>,
}

/// Inputs of a tick, in the scalar of its controller.
pub(crate) struct Input<S> {
    pub(crate) reference: Reference<S, N>,
    pub(crate) measurement: Measurement<S, N>,
}

impl<S: Real> Input<S> {
    fn new(row: &Row) -> Self {
        let Reference { q, qd, qdd } = Reference { q: row.q, qd: row.qd, qdd: row.qdd }.cast::<S>();
        let sensed = row.counts.map_or(Sensed::State { q, qd }, Sensed::Counts);
        Self { reference: Reference { q, qd, qdd }, measurement: Measurement { sensed, age_ticks: 0 } }
    }
}

#[entry]
fn main() -> ! {
    probe::run(all)
}

/// Runs a controller over all ticks from rest, and prints the cost and the result of each.
///
/// The cost is that of the tick alone: the count of an empty function, called in the same way, is subtracted.
pub(crate) fn count<S: Real, A: ArmBuild<S, N>>(
    scene: u32,
    counter: &Counter,
    mut controller: Controller<S, N, A>,
    tick: fn(&Input<S>, &mut Controller<S, N, A>) -> Command<S, N>,
) {
    let bytes = size_of_val(&controller);
    say(|line| write!(line, "scene,{scene},{},{bytes}", tick as usize));
    for (at, row) in INPUTS.iter().enumerate() {
        let input = Input::new(row);
        // Hidden from the compiler: otherwise it would make a specialised copy of the function.
        let (empty, _) = counter.call(black_box(nothing), &input, &mut controller);
        let (called, command) = counter.call(black_box(tick), &input, &mut controller);
        let taken = called.wrapping_sub(empty);
        say(|line| {
            write!(line, "tick,{scene},{at},{taken}")?;
            outcome(line, &command)
        });
    }
}

/// Empty function with the result type of a tick; a fault is the shortest result.
#[inline(never)]
fn nothing<S: Real, A: ArmBuild<S, N>>(_: &Input<S>, _: &mut Controller<S, N, A>) -> Command<S, N> {
    Command::Brake(Fault::Overrun)
}

type Line = String<256>;

fn outcome<S: Real>(line: &mut Line, command: &Command<S, N>) -> fmt::Result {
    match command {
        Command::Drive { torque, limits } => {
            line.write_str(",drive")?;
            torque.iter().try_for_each(|torque| write!(line, ",{:016x}", torque.to_f64().to_bits()))?;
            limits.iter().try_for_each(|limits| write!(line, ",{}", limits.bits()))
        }
        Command::Brake(fault) => {
            write!(line, ",brake,{},", fault.code())?;
            fault.joint().map_or(Ok(()), |joint| write!(line, "{joint}"))
        }
    }
}

/// Prints a whole line at once, because each separate output to the emulator takes time.
fn say(what: impl FnOnce(&mut Line) -> fmt::Result) {
    let mut line = Line::new();
    if what(&mut line).and_then(|()| line.write_char('\n')).is_err() {
        probe::give_up();
    }
    hprint!("{}", line);
}

/// The controller of a scene, its tick as a function with a name, and the function that counts it.
macro_rules! scene {
    ($number:literal, $tick:ident, $scalar:ty) => {
        use crate::count::Input;
        use dynamics_core::Command;
        use dynamics_core::control::{Configuration, Controller, ControllerConfig, ControllerOf};

        /// The configuration, as constants of the program.
        #[derive(Clone, Copy)]
        pub(crate) struct Settings;

        impl Configuration<$scalar, { arm::N }> for Settings {
            #[inline]
            fn get(&self) -> &ControllerConfig<$scalar, { arm::N }> {
                const { &arm::config() }
            }
        }

        type SceneController = ControllerOf<$scalar, { arm::N }, dynamics::Arm, arm::Trig, Settings>;

        /// One tick, as in a firmware of this scene alone.
        #[allow(unsafe_code, reason = "whoever reads the program must find it by name")]
        // SAFETY: no other function has this name.
        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $tick(input: &Input<$scalar>, controller: &mut SceneController) -> Command<$scalar, { arm::N }> {
            controller.tick(&input.reference, &input.measurement)
        }

        pub(crate) fn count(counter: &probe::Counter) {
            let mut controller = Controller::new(Settings, dynamics::arm(), arm::TRIG);
            *controller.live_mut() = live();
            crate::count::count($number, counter, controller, $tick);
        }
    };
}

#[allow(
    unused_imports,
    unreachable_pub,
    dead_code,
    clippy::approx_constant,
    clippy::excessive_precision,
    reason = "generated: imports and holds what any scene may need"
)]
mod generated {
    use super::{Counter, Row};

    include!(concat!(env!("COST"), "/kernels.rs"));
}
