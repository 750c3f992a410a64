//! What can be chosen by name: in a scene file, on a command line, when a firmware is built.

use super::control::{ControlSpec, ScalarChoice};
use dynamics_core::control::{Between, Law};
use dynamics_core::trig::Method;

/// The laws by the names that files give them.
pub(crate) const LAWS: [(&str, Law); 5] = [
    ("computed-torque", Law::ComputedTorque),
    ("pd", Law::Pd),
    ("pd-gravity", Law::PdGravity),
    ("diagonal-inertia", Law::DiagonalInertia),
    ("feedforward", Law::Feedforward),
];

/// The choices of sine and cosine by the names that files give them.
pub(crate) const METHODS: [(&str, Method); 5] = [
    ("polynomial", Method::Polynomial),
    ("polynomial-5", Method::Polynomial5),
    ("polynomial-3", Method::Polynomial3),
    ("table", Method::Table),
    ("libm", Method::Libm),
];

/// The floating-point types by the names that files give them.
pub(crate) const SCALARS: [(&str, ScalarChoice); 2] = [("f32", ScalarChoice::F32), ("f64", ScalarChoice::F64)];

/// What the model's torque does between two evaluations, by the names that files give it.
pub(crate) const BETWEENS: [(&str, Between); 2] = [("hold", Between::Hold), ("extrapolate", Between::Extrapolate)];

impl ScalarChoice {
    /// Its name in a scene file.
    #[must_use]
    pub fn name(self) -> &'static str {
        name_in(&SCALARS, self)
    }
}

impl ControlSpec {
    /// The names that sine and cosine can be chosen by.
    #[must_use]
    pub fn trig_names() -> [&'static str; METHODS.len()] {
        METHODS.map(|(name, _)| name)
    }

    /// The sine and cosine of a name.
    #[must_use]
    pub fn trig_named(name: &str) -> Option<Method> {
        METHODS.iter().find(|(known, _)| *known == name).map(|(_, method)| *method)
    }

    /// The name of a sine and cosine.
    #[must_use]
    pub fn trig_name(method: Method) -> &'static str {
        name_in(&METHODS, method)
    }

    /// The names of law, and of sine and cosine, in a scene file.
    #[must_use]
    pub fn names(&self) -> (&'static str, &'static str) {
        (name_in(&LAWS, self.law), name_in(&METHODS, self.trig))
    }

    /// The name, in a scene file, of what the model's torque does between two evaluations.
    #[must_use]
    pub fn between_name(&self) -> &'static str {
        name_in(&BETWEENS, self.model_between)
    }

    /// Take another law, or another sine and cosine, by name.
    ///
    /// # Errors
    /// A name that is none.
    pub fn choose(&mut self, law: Option<&str>, trig: Option<&str>) -> Result<(), String> {
        if let Some(name) = law {
            self.law = by_name(&LAWS, name)?;
        }
        if let Some(name) = trig {
            self.trig = by_name(&METHODS, name)?;
        }
        Ok(())
    }
}

fn name_in<T: Copy + PartialEq>(table: &[(&'static str, T)], wanted: T) -> &'static str {
    table.iter().find(|(_, value)| *value == wanted).map_or("", |(name, _)| name)
}

fn by_name<T: Copy>(table: &[(&str, T)], name: &str) -> Result<T, String> {
    table.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<&str> = table.iter().map(|(known, _)| *known).collect();
        format!("{name}: expected one of {}", known.join(", "))
    })
}
