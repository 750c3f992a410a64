// Generated from a robot and a scene file. Do not edit: change the files instead.

use dynamics_core::drive::Drives;

/// Drives of the joints.
pub const fn drives() -> Drives<6> {
    Drives::Link
}

/// Frames that the drives on CAN understand.
pub type Frames = dynamics_core::drive::MiniCheetah;
