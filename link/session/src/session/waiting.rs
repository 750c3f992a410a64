//! Changes of live inputs and parameters that wait for a tick, and its answers.

use crate::parameters;
use dynamics_core::control::{Configuration, Controller, Protection};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::scene::Live;
use dynamics_core::trig::Trig;
use link::{Frame, Refusal, Setting, Value};

/// A change that waits for its tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change<const N: usize> {
    Live(Live<f32, N>),
    Parameter(Setting),
}

/// Answer of a tick that has settled a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Changed {
    Value(Value),
    Refusal(Refusal),
}

impl Changed {
    pub(super) const fn frame(self) -> Frame {
        match self {
            Self::Value(value) => Frame::Value(value),
            Self::Refusal(refusal) => Frame::Refusal(refusal),
        }
    }
}

impl<const N: usize> Change<N> {
    pub(super) fn make<D, T, C, P>(&self, controller: &mut Controller<f32, N, D, T, C, P>)
    where
        D: InverseDynamics<f32, N>,
        T: Trig<f32>,
        C: Configuration<f32, N>,
        P: Protection<f32, N>,
    {
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
