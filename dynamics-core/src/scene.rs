//! Loads on the arm, the choice of terms to compute, and a model bound to both.

use crate::inertia::{Inertia, Wrench, cast_vector};
use crate::model::Model;
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// One effect of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term<T> {
    /// Absent: it adds no operation.
    Absent,
    /// Known when the scene is made.
    Constant(T),
    /// Known only in each tick: read from [`Live`].
    Live,
}

impl<T> Term<T> {
    /// The value in force, if there is one.
    #[inline]
    pub fn value<'a>(&'a self, live: &'a T) -> Option<&'a T> {
        match self {
            Self::Absent => None,
            Self::Constant(value) => Some(value),
            Self::Live => Some(live),
        }
    }

    /// The same term with its constant converted.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Term<U> {
        match self {
            Self::Absent => Term::Absent,
            Self::Constant(value) => Term::Constant(f(value)),
            Self::Live => Term::Live,
        }
    }
}

/// Effects that act on the arm. Every effect is absent, constant or live; an absent one costs no arithmetic.
///
/// Friction is no term here: it branches on the sign of the velocity, so the controller adds it per joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene<S, const N: usize> {
    /// Gravitational acceleration in the base frame, m/s^2: `(0, 0, -9.81)` on a floor, `(0, 0, 9.81)` under a ceiling.
    pub gravity: Term<Vector3<S>>,
    /// A body held by the tip. Constant: in the tip frame. Live: in the last link's frame, as
    /// [`Dynamics::payload_in_last_link`] returns it, so that it is transformed when it changes and not in every tick.
    pub payload: Term<Inertia<S>>,
    /// Wrench of the environment on the arm at the tip's origin, in tip axes.
    pub tip_wrench: Term<Wrench<S>>,
    /// Reflected rotor inertias, kg m^2 (kg for a prismatic joint).
    pub rotor: Term<[S; N]>,
    /// Centrifugal and Coriolis terms. Live: at the velocity passed to the recursion. Constant: at the velocity given here, for a
    /// motion about a steady speed.
    pub coriolis: Term<[S; N]>,
}

/// The live inputs of a scene, read only if its terms are [`Term::Live`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Live<S, const N: usize> {
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vector3<S>,
    /// The payload in the last link's frame.
    pub payload: Inertia<S>,
    /// Wrench of the environment on the arm at the tip's origin, in tip axes.
    pub tip_wrench: Wrench<S>,
    /// Reflected rotor inertias, kg m^2 (kg for a prismatic joint).
    pub rotor: [S; N],
}

impl<S: Scalar, const N: usize> Live<S, N> {
    /// Every live input zero.
    #[must_use]
    pub fn zero() -> Self {
        Self { gravity: Vector3::zeros(), payload: Inertia::zero(), tip_wrench: Wrench::zero(), rotor: [S::zero(); N] }
    }

    /// The same inputs in another scalar.
    #[must_use]
    pub fn cast<T: Scalar>(&self) -> Live<T, N>
    where
        S: Into<f64>,
    {
        Live {
            gravity: cast_vector(&self.gravity),
            payload: self.payload.cast(),
            tip_wrench: self.tip_wrench.cast(),
            rotor: self.rotor.map(|rotor| T::literal(rotor.into())),
        }
    }
}

impl<S: Scalar, const N: usize> Scene<S, N> {
    /// No gravity, no payload, no contact, no rotors; velocity terms live.
    #[must_use]
    pub fn free_space() -> Self {
        Self {
            gravity: Term::Absent,
            payload: Term::Absent,
            tip_wrench: Term::Absent,
            rotor: Term::Absent,
            coriolis: Term::Live,
        }
    }

    /// Gravity, rotors of the model and velocity terms, as most arms need them.
    #[must_use]
    pub fn with_gravity(gravity: Vector3<S>, model: &Model<S, N>) -> Self {
        Self {
            gravity: Term::Constant(gravity),
            rotor: Term::Constant(model.links().map(|link| link.rotor)),
            ..Self::free_space()
        }
    }

    /// The same scene in another scalar.
    #[must_use]
    pub fn cast<T: Scalar>(&self) -> Scene<T, N>
    where
        S: Into<f64>,
    {
        let joints = |term: Term<[S; N]>| term.map(|all| all.map(|x| T::literal(x.into())));
        Scene {
            gravity: self.gravity.map(|g| cast_vector(&g)),
            payload: self.payload.map(|p| p.cast()),
            tip_wrench: self.tip_wrench.map(|w| w.cast()),
            rotor: joints(self.rotor),
            coriolis: joints(self.coriolis),
        }
    }
}

/// A model bound to a scene: the input of the recursions.
///
/// Binding folds a constant payload into the last link once. The model itself is unchanged, so removing the payload
/// restores exactly the same bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics<S, const N: usize> {
    model: Model<S, N>,
    scene: Scene<S, N>,
    last_inertia: Inertia<S>,
}

impl<S: Scalar, const N: usize> Dynamics<S, N> {
    /// Binds a model to a scene.
    #[must_use]
    pub fn new(model: Model<S, N>, scene: Scene<S, N>) -> Self {
        let own = model.links()[N - 1].inertia;
        let last_inertia = match &scene.payload {
            Term::Constant(payload) => own + in_last_link(&model, payload),
            Term::Absent | Term::Live => own,
        };
        Self { model, scene, last_inertia }
    }

    /// Replaces the payload (in the tip frame), or removes it.
    pub fn set_payload(&mut self, payload: Option<Inertia<S>>) {
        self.scene.payload = payload.map_or(Term::Absent, Term::Constant);
        *self = Self::new(self.model, self.scene);
    }

    /// Moves a payload from the tip frame to the last link's frame, for [`Live::payload`].
    #[must_use]
    pub fn payload_in_last_link(&self, payload: &Inertia<S>) -> Inertia<S> {
        in_last_link(&self.model, payload)
    }

    /// The arm.
    #[must_use]
    pub const fn model(&self) -> &Model<S, N> {
        &self.model
    }

    /// The scene: effects that act on the arm.
    #[must_use]
    pub const fn scene(&self) -> &Scene<S, N> {
        &self.scene
    }

    /// The body that joint `i` moves: its link, and for the last joint the payload too.
    #[inline]
    pub(crate) fn inertia(&self, i: usize, live: &Live<S, N>) -> Inertia<S> {
        if i + 1 < N {
            self.model.links()[i].inertia
        } else if matches!(self.scene.payload, Term::Live) {
            self.last_inertia + live.payload
        } else {
            self.last_inertia
        }
    }
}

fn in_last_link<S: Scalar, const N: usize>(model: &Model<S, N>, payload: &Inertia<S>) -> Inertia<S> {
    payload.in_parent(&model.tip().rotation, &model.tip().translation)
}
