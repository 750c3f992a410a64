// Nothing watches the arm.

use dynamics_core::control::Unprotected;

/// No protection.
pub type Protection = Unprotected;

/// No protection.
pub const fn protection() -> Protection {
    Unprotected
}
