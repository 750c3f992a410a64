//! What can be chosen by name: in a scene file, on a command line, when a firmware is built.

use super::settings::ControlSpec;
use dynamics_core::control::Law;
use dynamics_core::trig::Method;

/// The laws by the names that files give them.
pub(crate) const LAWS: [(&str, Law); 4] = [
    ("computed-torque", Law::ComputedTorque),
    ("pd", Law::Pd),
    ("pd-gravity", Law::PdGravity),
    ("feedforward", Law::Feedforward),
];

/// The choices of sine and cosine by the names that files give them.
pub(crate) const METHODS: [(&str, Method); 6] = [
    ("polynomial", Method::Polynomial),
    ("polynomial-5", Method::Polynomial5),
    ("polynomial-3", Method::Polynomial3),
    ("table", Method::Table),
    ("rotation", Method::Rotation),
    ("libm", Method::Libm),
];

impl ControlSpec {
    /// The names that sine and cosine can be chosen by.
    #[must_use]
    pub fn trig_names() -> [&'static str; METHODS.len()] {
        METHODS.map(|(name, _)| name)
    }

    /// The names of law, and of sine and cosine, in a scene file.
    #[must_use]
    pub fn names(&self) -> (&'static str, &'static str) {
        let law = LAWS.iter().find(|(_, law)| *law == self.law).map_or("", |(name, _)| name);
        let trig = METHODS.iter().find(|(_, method)| *method == self.trig).map_or("", |(name, _)| name);
        (law, trig)
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

fn by_name<T: Copy>(table: &[(&str, T)], name: &str) -> Result<T, String> {
    table.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<&str> = table.iter().map(|(known, _)| *known).collect();
        format!("{name}: expected one of {}", known.join(", "))
    })
}
