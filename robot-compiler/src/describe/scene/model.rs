//! Terms of the controller's inverse dynamics: the table `[model]`.

use super::lists::joints;
use crate::describe::robot::Robot;
use dynamics_core::safety::LiveInput;
use dynamics_core::{Body, Inertia, Model, Scene, Term, Wrench};
use nalgebra::Vector3;

/// Terms of the controller's inverse dynamics.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelSpec {
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Term<Vector3<f64>>,
    /// A body held by the tip, in the tip frame.
    pub payload: Term<Body>,
    /// Wrench of the environment on the arm at the tip's origin, in tip axes.
    pub tip_wrench: Term<Wrench<f64>>,
    /// Rotor inertias, at the values of the robot file.
    pub rotor: Term<()>,
    /// Velocity terms: live, or at one constant joint velocity.
    pub coriolis: Term<Vec<f64>>,
    /// True if friction is fed forward.
    pub friction: bool,
    /// Speed at which the whole Coulomb torque acts, rad/s or m/s.
    pub friction_smoothing: f64,
    /// The full model from which these terms were chosen, if the file has `terms = "auto"`. The terms above are the
    /// remaining ones, and desk, firmware and hash use only those.
    pub auto: Option<AutoTerms>,
}

/// Request of a scene for the fewest terms (`terms = "auto"`).
#[derive(Clone, Debug, PartialEq)]
pub struct AutoTerms {
    /// Greatest torque error, as a share of each joint's torque limit.
    pub tolerance: f64,
    /// Every term that acts in the simulated world.
    pub full: Box<ModelSpec>,
}
/// A term of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ModelTerm {
    /// The weight of all bodies.
    Gravity,
    /// The body held by the tip.
    Payload,
    /// The wrench of the environment on the tip.
    TipWrench,
    /// Reflected rotor inertias.
    Rotors,
    /// Centrifugal and Coriolis torques.
    VelocityTerms,
    /// Friction feedforward.
    Friction,
}

impl ModelTerm {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Gravity, Self::Payload, Self::TipWrench, Self::Rotors, Self::VelocityTerms, Self::Friction];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gravity => LiveInput::Gravity.name(),
            Self::Payload => LiveInput::Payload.name(),
            Self::TipWrench => LiveInput::TipWrench.name(),
            Self::Rotors => LiveInput::Rotors.name(),
            Self::VelocityTerms => "velocity terms",
            Self::Friction => "friction",
        }
    }

    /// True if the term adds to the arm's inertia in the model.
    #[must_use]
    pub const fn is_inertia(self) -> bool {
        matches!(self, Self::Payload | Self::Rotors)
    }

    /// Its key in a scene's `[model]`.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Gravity => "gravity",
            Self::Payload => "payload",
            Self::TipWrench => "tip_wrench",
            Self::Rotors => "rotor",
            Self::VelocityTerms => "coriolis",
            Self::Friction => "friction",
        }
    }
}

impl ModelSpec {
    /// Gravity of a floor-mounted arm, no payload, and the rotors and friction of the robot file.
    pub(crate) fn default_for(robot: &Robot) -> Self {
        let rotors = robot.joints.iter().any(|joint| joint.spec.rotor.reflected() > 0.0);
        Self {
            gravity: Term::Constant(robot.gravity()),
            payload: Term::Absent,
            tip_wrench: Term::Absent,
            rotor: if rotors { Term::Constant(()) } else { Term::Absent },
            coriolis: Term::Live,
            friction: robot.joints.iter().any(|joint| joint.friction.is_some()),
            friction_smoothing: 0.05,
            auto: None,
        }
    }

    /// State of a term: absent, constant or live. Friction feedforward counts as constant, because its coefficients are.
    #[must_use]
    pub fn state(&self, term: ModelTerm) -> Term<()> {
        fn state<T>(term: &Term<T>) -> Term<()> {
            match term {
                Term::Absent => Term::Absent,
                Term::Constant(_) => Term::Constant(()),
                Term::Live => Term::Live,
            }
        }
        match term {
            ModelTerm::Gravity => state(&self.gravity),
            ModelTerm::Payload => state(&self.payload),
            ModelTerm::TipWrench => state(&self.tip_wrench),
            ModelTerm::Rotors => self.rotor,
            ModelTerm::VelocityTerms => state(&self.coriolis),
            ModelTerm::Friction if self.friction => Term::Constant(()),
            ModelTerm::Friction => Term::Absent,
        }
    }

    /// Live inputs that the model needs, as bits of [`LiveInput::bit`].
    #[must_use]
    pub fn live_inputs(&self) -> u32 {
        let of_input = |input| match input {
            LiveInput::Gravity => ModelTerm::Gravity,
            LiveInput::Payload => ModelTerm::Payload,
            LiveInput::TipWrench => ModelTerm::TipWrench,
            LiveInput::Rotors => ModelTerm::Rotors,
        };
        let needed = LiveInput::ALL.into_iter().filter(|&input| self.state(of_input(input)) == Term::Live);
        needed.fold(0, |bits, input| bits | input.bit())
    }

    /// The terms that are not absent.
    #[must_use]
    pub fn terms(&self) -> Vec<ModelTerm> {
        ModelTerm::ALL.into_iter().filter(|&term| self.state(term) != Term::Absent).collect()
    }

    /// The same model without some of its terms.
    #[must_use]
    pub fn without(&self, terms: &[ModelTerm]) -> Self {
        let mut model = self.clone();
        for term in terms {
            match term {
                ModelTerm::Gravity => model.gravity = Term::Absent,
                ModelTerm::Payload => model.payload = Term::Absent,
                ModelTerm::TipWrench => model.tip_wrench = Term::Absent,
                ModelTerm::Rotors => model.rotor = Term::Absent,
                ModelTerm::VelocityTerms => model.coriolis = Term::Absent,
                ModelTerm::Friction => model.friction = false,
            }
        }
        model
    }

    /// The model with all terms that `terms = "auto"` removed; unchanged in other scenes.
    #[must_use]
    pub fn full(&self) -> &Self {
        self.auto.as_ref().map_or(self, |auto| &auto.full)
    }

    /// The terms that `terms = "auto"` removed.
    #[must_use]
    pub fn given_up(&self) -> Vec<ModelTerm> {
        self.full().terms().into_iter().filter(|&term| self.state(term) == Term::Absent).collect()
    }

    /// Scene of the recursion for this model of an arm.
    #[must_use]
    pub fn scene<const N: usize>(&self, model: &Model<f64, N>) -> Scene<f64, N> {
        let rotors = model.links().map(|link| link.rotor);
        Scene {
            gravity: self.gravity,
            payload: self.payload.map(|body| inertia(&body)),
            tip_wrench: self.tip_wrench,
            rotor: self.rotor.map(|()| rotors),
            coriolis: self.coriolis.clone().map(|speeds| joints(&speeds)),
        }
    }
}

/// A body as the core stores it.
pub(super) fn inertia(body: &Body) -> Inertia<f64> {
    Inertia::from_mass_centre(body.mass, &body.com, &body.inertia)
}
