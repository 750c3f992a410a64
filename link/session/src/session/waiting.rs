//! Changes of live inputs and parameters that wait for a tick.

use crate::parameters;
use dynamics_core::control::{ArmBuild, Controller};
use dynamics_core::scene::Live;
use link::Setting;

/// A change that waits for its tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change<const N: usize> {
    Live(Live<f32, N>),
    Parameter(Setting),
}

impl<const N: usize> Change<N> {
    pub(super) fn make<A: ArmBuild<f32, N>>(&self, controller: &mut Controller<f32, N, A>) {
        match self {
            Self::Live(live) => *controller.live_mut() = *live,
            Self::Parameter(setting) => {
                if let Some(config) = controller.config_mut() {
                    parameters::set(*setting, config);
                }
            }
        }
    }
}
