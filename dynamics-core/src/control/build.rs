//! The parts of a controller, chosen when the program is compiled.

use super::collision::{Protection, Unprotected};
use super::config::{Configuration, ControllerConfig};
use crate::newton_euler::InverseDynamics;
use crate::safety::{self, Rules};
use crate::scalar::Real;
use crate::trig::Trig;
use core::marker::PhantomData;

/// The parts of an arm's controller and of the safety state machine around it, as one type.
///
/// A firmware implements it for a type without values. [`BuildOf`] puts parts together without such a type.
pub trait ArmBuild<S: Real, const N: usize> {
    /// Inverse dynamics: the recursion, or a kernel generated for the arm.
    type Dynamics: InverseDynamics<S, N> + Clone;
    /// Sine and cosine.
    type Trig: Trig<S>;
    /// Configuration of the controller: constants of the program, or numbers in RAM that a host may change.
    type Tuning: Configuration<S, N> + Clone;
    /// Collision observer, or none.
    type Protection: Protection<S, N> + Clone;
    /// Configuration and rules of the safety state machine.
    type Settings: safety::SafetyConfiguration<S, N> + Clone;
}

/// A build of these parts. The type has no values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOf<D, T, C, P = Unprotected, K = Unsupervised>(PhantomData<(D, T, C, P, K)>);

impl<S: Real, const N: usize, D, T, C, P, K> ArmBuild<S, N> for BuildOf<D, T, C, P, K>
where
    D: InverseDynamics<S, N> + Clone,
    T: Trig<S>,
    C: Configuration<S, N> + Clone,
    P: Protection<S, N> + Clone,
    K: safety::SafetyConfiguration<S, N> + Clone,
{
    type Dynamics = D;
    type Trig = T;
    type Tuning = C;
    type Protection = P;
    type Settings = K;
}

/// Settings of a controller without a safety state machine. The type has no values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsupervised {}

impl<S, const N: usize> Configuration<S, N> for Unsupervised {
    fn get(&self) -> &ControllerConfig<S, N> {
        match *self {}
    }
}

impl<S, const N: usize> safety::SafetyConfiguration<S, N> for Unsupervised {
    fn rules(&self) -> &Rules<S, N> {
        match *self {}
    }
}
