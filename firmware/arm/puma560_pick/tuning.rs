/// Where the controller finds its configuration.
pub type Tuning = crate::Settings;

/// Its value.
pub const fn tuning() -> Tuning {
    crate::Settings
}
