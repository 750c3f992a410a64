//! The controllers, and the ticks that all of them get.

use crate::count::Row;
use probe::Counter;

/// The controller of a scene, its tick as a function with a name, and the function that counts it.
macro_rules! scene {
    ($number:literal, $tick:ident, $scalar:ty) => {
        use crate::count::Input;
        use dynamics_core::Command;
        use dynamics_core::control::{Configuration, Controller, ControllerConfig};

        /// The configuration, as constants of the program.
        #[derive(Clone, Copy)]
        pub(crate) struct Settings;

        impl Configuration<$scalar, { arm::N }> for Settings {
            #[inline]
            fn get(&self) -> &ControllerConfig<$scalar, { arm::N }> {
                const { &arm::config() }
            }
        }

        type SceneController = Controller<$scalar, { arm::N }, dynamics::Arm, arm::Trig, Settings>;

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

pub(crate) use generated::{INPUTS, N, all};
