//! Fields that a refusal of the core concerns, and remedies that a TOML file offers.

use dynamics_core::model::Impossible;

/// A remedy that a TOML file allows.
pub(super) fn remedy(what: &Impossible) -> &'static str {
    match what {
        Impossible::NegativeMass(_)
        | Impossible::InertiaWithoutMass(_)
        | Impossible::NegativePrincipalMoment(_)
        | Impossible::TriangleInequality(_) => ", or `allow_unphysical = \"reason\"` for a published set of numbers",
        Impossible::LimitNotPositive(..) => "; without the key there is none",
        _ => "",
    }
}

/// The key, and the key inside it, that an error concerns.
pub(super) fn field_of(what: &Impossible) -> (&'static str, Option<&'static str>) {
    match what {
        Impossible::NegativeMass(_) | Impossible::InertiaWithoutMass(_) => ("mass", None),
        Impossible::AsymmetricInertia(_)
        | Impossible::NegativePrincipalMoment(_)
        | Impossible::TriangleInequality(_) => ("inertia", None),
        Impossible::NonUnitAxis(_) => ("axis", None),
        Impossible::NotARotation(_) => ("placement", None),
        Impossible::PositionLimitsReversed(..) => ("limits", Some("position")),
        Impossible::LimitNotPositive("velocity", _) => ("limits", Some("velocity")),
        Impossible::LimitNotPositive("torque", _) => ("limits", Some("torque")),
        Impossible::LimitNotPositive(..) => ("limits", Some("torque_rate")),
        Impossible::NegativeRotorInertia(_) => ("rotor", Some("inertia")),
        // The reader rejects NaN and infinity, but a product of two numbers may still overflow.
        Impossible::NotFinite(_) => ("mass", None),
    }
}
