//! Names of the choices for a scene's controller.

use super::control::{ControlSpec, KernelChoice, ScalarChoice};
use crate::names::{Named, name, named};
use dynamics_core::control::{Between, ControlLaw};
use dynamics_core::trig::Method;

impl Named for ControlLaw {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &{
        let mut names = [("", "", Self::Pd); Self::ALL.len()];
        let mut i = 0;
        while i < names.len() {
            names[i] = (Self::ALL[i].name(), Self::ALL[i].about(), Self::ALL[i]);
            i += 1;
        }
        names
    };
}

impl Named for Method {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[
        ("polynomial", "", Self::Polynomial),
        ("polynomial-5", "", Self::Polynomial5),
        ("polynomial-3", "", Self::Polynomial3),
        ("table", "", Self::Table),
        ("libm", "", Self::Libm),
    ];
}

impl Named for ScalarChoice {
    const NAMES: &'static [(&'static str, &'static str, Self)] =
        &[("f32", "Single precision, as on the chip", Self::F32), ("f64", "Double precision", Self::F64)];
}

impl Named for Between {
    const NAMES: &'static [(&'static str, &'static str, Self)] =
        &[("hold", "", Self::Hold), ("extrapolate", "", Self::Extrapolate)];
}

impl Named for KernelChoice {
    const NAMES: &'static [(&'static str, &'static str, Self)] =
        &[("generic", "", Self::Generic), ("exact", "", Self::Exact), ("regrouped", "", Self::Regrouped)];
}

impl ControlSpec {
    /// Names of the law and of the sine and cosine, as in a scene file.
    #[must_use]
    pub fn names(&self) -> (&'static str, &'static str) {
        (name(self.law), name(self.trig))
    }

    /// Replaces the law, or the sine and cosine, by name.
    ///
    /// # Errors
    /// An unknown name.
    pub fn choose(&mut self, law: Option<&str>, trig: Option<&str>) -> Result<(), String> {
        if let Some(law) = law {
            self.law = named(law)?;
        }
        if let Some(trig) = trig {
            self.trig = named(trig)?;
        }
        Ok(())
    }
}
