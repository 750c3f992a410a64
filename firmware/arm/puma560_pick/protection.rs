// Nothing watches the arm.

use dynamics_core::control::Unprotected;

/// Nothing.
pub type Protection = Unprotected;

/// Nothing.
pub const fn protection() -> Protection {
    Unprotected
}
