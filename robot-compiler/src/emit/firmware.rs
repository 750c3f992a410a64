//! Source files of a firmware, written into a folder.

use super::arm::arm_module;
use super::changed::write_changed;
use super::drives::drives_module;
use super::dynamics::dynamics_module;
use super::protection::protection_module;
use crate::describe::diagnostics::Message;
use crate::describe::drive::Protocol;
use crate::describe::robot::Robot;
use crate::describe::scene::{SceneFile, UNREAD_MAX};
use crate::with_dof;
use std::path::Path;

/// Another law, or another sine and cosine method, than the scene file's, by their names in a scene file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Choices<'a> {
    /// The law.
    pub law: Option<&'a str>,
    /// Sine and cosine.
    pub trig: Option<&'a str>,
}

/// Slowest rate of the boards' timers, Hz: the emulated one has 16 bits at 1 MHz.
const RATE_MIN: f64 = 16.0;

/// Writes `arm.rs`, `dynamics.rs`, `drives.rs`, `protection.rs` and `tuning.rs` for a scene into a folder; `firmware/arm`
/// includes them.
///
/// # Errors
/// A scene that cannot be read, a rate that the boards' timers do not have, or a folder that cannot be written to.
pub fn write_firmware(scene: &Path, choices: Choices<'_>, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut file = SceneFile::load(scene)?;
    file.control.choose(choices.law, choices.trig).map_err(Message)?;
    let rate = file.control.rate;
    if rate.fract() != 0.0 || rate < RATE_MIN {
        let name = scene.display();
        let problem = format!("{name}: control.rate: {rate} Hz; expected whole hertz, {RATE_MIN} or more, for a chip");
        return Err(Message(problem).into());
    }
    if let Some((joint, jump)) = file.too_fast_for_its_encoder() {
        let (name, label) = (scene.display(), Robot::joint_label(joint, &file.robot.joints[joint].name));
        return Err(Message(format!(
            "{name}: control.rate: {rate} Hz, at which the encoder of {label} moves up to {jump} counts in a tick; \
             expected a rate at which it moves less than half a turn in {UNREAD_MAX} ticks, or a lower velocity limit"
        ))
        .into());
    }
    let (arm, dynamics, protection, drives) = with_dof!(file.robot.dof(), N => {
        let model = file.robot.model::<N>()?;
        (
            arm_module(&file, &model),
            dynamics_module(&file, &model),
            protection_module(&file, &model),
            drives_module(&file.drives::<N>()) + &frames(file.protocol()),
        )
    });
    // An included file cannot hold a module's own documentation.
    let modules = [("arm", arm), ("dynamics", dynamics), ("drives", drives), ("protection", protection)];
    for (name, text) in modules.into_iter().chain([("tuning", tuning_module(file.control.tunable, "f32"))]) {
        write_changed(&folder.join(format!("{name}.rs")), &text.replace("//!", "//"))?;
    }
    Ok(())
}

/// Type of the frames of the drives. A robot without drives on CAN gets one too, so that a board for such drives can report the error.
fn frames(protocol: Option<Protocol>) -> String {
    let kind = protocol.unwrap_or(Protocol::MiniCheetah).type_name();
    format!("\n/// Frames that the drives on CAN understand.\npub type Frames = dynamics_core::drive::{kind};\n")
}

/// Location of the controller's configuration: in RAM if it can be changed, otherwise in the program.
pub(super) fn tuning_module(tunable: bool, real: &str) -> String {
    let (kind, value) = if tunable {
        (format!("dynamics_core::control::ControllerConfig<{real}, {{ super::arm::N }}>"), "super::arm::config()")
    } else {
        ("super::Settings".to_owned(), "super::Settings")
    };
    format!(
        "/// Type of the controller's configuration.\npub type Tuning = {kind};\n\n/// Its value.\npub const fn tuning() -> Tuning {{\n    {value}\n}}\n"
    )
}
