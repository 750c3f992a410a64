/// Type of the controller's configuration.
pub type Tuning = super::Settings;

/// Its value.
pub const fn tuning() -> Tuning {
    super::Settings
}
