//! The test of a library: torques of states along the scene's motion, as the desk computes them.

use super::arm::{Arm, finite};
use crate::emit::arm_crate::golden_states;
use crate::emit::expression::Float;
use crate::kernel::Level;
use dynamics_core::trig::Method;
use dynamics_core::{Live, Model, Trig};

/// `test/golden.c`.
pub(super) fn golden<S: Float + Into<f64>, const N: usize>(
    arm: &Arm<'_>,
    model: &Model<f64, N>,
) -> Result<String, Box<dyn std::error::Error>>
where
    Method: Trig<S>,
{
    let (prefix, real, joints, capitals) = (&arm.prefix, arm.real(), arm.joints, arm.capitals());
    // A regrouped kernel rounds otherwise than the recursion.
    let program = (arm.file.control.kernel.level() == Some(Level::Regrouped)).then_some(&arm.kernels[0].1);
    let states = golden_states::<S, N>(arm.file, model, arm.live, program)?;
    let literal = |x: &S| finite((*x).into(), arm.precision);
    let row = |row: &[S; N]| format!("{{{}}}", row.iter().map(literal).collect::<Vec<_>>().join(", "));
    let table: String = states
        .iter()
        .map(|state| format!("    {{{}}},\n", state.iter().map(row).collect::<Vec<_>>().join(",\n     ")))
        .collect();
    let (live, pass) = if arm.live {
        (format!("    const {prefix}_live_t live = {};\n", live_value(&arm.file.live(model), arm)), ", &live")
    } else {
        (String::new(), "")
    };
    Ok(format!(
        "/* Torques of {count} states, as the desk computed them when this library was written. Returns the number of states that differ. */\n\
         #include \"{prefix}.h\"\n#include <stdio.h>\n\n\
         /* Position, velocity, acceleration, and the torque that they need. */\n\
         static const {real} states[{count}][4][{capitals}_JOINTS] = {{\n{table}}};\n\n\
         int main(void)\n{{\n    int wrong = 0;\n{live}    if ({prefix}_conditions() != 0) {{\n        \
         printf(\"compiler or processor change results: %d, see {prefix}_conditions in {prefix}.h\\n\", {prefix}_conditions());\n    }}\n    for (int i = 0; i < {count}; i++) {{\n        {real} tau[{joints}];\n        \
         {prefix}_inverse_dynamics(states[i][0], states[i][1], states[i][2]{pass}, tau);\n        \
         for (int joint = 0; joint < {joints}; joint++) {{\n            if (!(tau[joint] == states[i][3][joint])) {{\n                \
         printf(\"state %d, joint %d: %.17g instead of %.17g\\n\", i, joint, (double)tau[joint], (double)states[i][3][joint]);\n                \
         wrong++;\n                break;\n            }}\n        }}\n    }}\n    \
         printf(\"%d of {count} states differ\\n\", wrong);\n    return wrong;\n}}\n",
        count = states.len(),
    ))
}

/// The scene's live inputs as a C initialiser.
fn live_value<const N: usize>(live: &Live<f64, N>, arm: &Arm<'_>) -> String {
    let Live { gravity, payload, tip_wrench, rotor } = live;
    let number = |x: &f64| finite(*x, arm.precision);
    let list = |all: &[f64]| format!("{{{}}}", all.iter().map(number).collect::<Vec<_>>().join(", "));
    let j = &payload.about_origin;
    format!(
        "{{{}, {{{}, {}}}, {{{}, {}, {}}}, {}}}",
        list(gravity.as_slice()),
        list(tip_wrench.force.as_slice()),
        list(tip_wrench.moment.as_slice()),
        number(&payload.mass),
        list(payload.first_moment.as_slice()),
        list(&[j.m11, j.m22, j.m33, j.m12, j.m13, j.m23]),
        list(rotor)
    )
}
