//! Phrases of the emitted documentation.

use super::title::Title;
use crate::kernel::Function;
use dynamics_core::Term;

/// Name of the function in a sentence.
pub(super) const fn name(function: Function) -> &'static str {
    match function {
        Function::InverseDynamics => "Inverse dynamics",
        Function::Gravity => "Gravity torques",
        Function::Coriolis => "Velocity torques",
        Function::MassMatrix => "Mass matrix",
        Function::JointWrenches => "Joint wrenches",
        Function::Momentum => "Generalised momentum",
        Function::ForwardDynamics => "Forward dynamics",
        Function::Regressor => "Regressor",
        Function::ComputedTorque(_) => "Computed torque",
    }
}

/// Equation, order of the outputs and units.
pub(in crate::emit) fn documentation(function: Function, title: &Title<'_>) -> String {
    let meaning = match function {
        Function::InverseDynamics => "`tau = D(q) qdd + C(q, qd) qd + G(q) - J^T w`, one per joint, N m or N.",
        Function::Gravity => "`G(q)`, what holds the arm still: one per joint, N m or N.",
        Function::Coriolis => "`C(q, qd) qd`: one per joint, N m or N.",
        Function::MassMatrix => {
            "`D(q)`, the upper triangle row by row, `D[0][0], D[0][1], ..`: kg m^2, kg m or kg, with the rotors."
        }
        Function::JointWrenches => {
            "What each link exerts on the next, base first, `fx, fy, fz, mx, my, mz` in the frame of the next link, about its\n\
             /// joint's origin: N and N m."
        }
        Function::Momentum => {
            "`p = D(q) qd`, one per joint, kg m^2/s or kg m/s; then `C(q, qd)^T qd - G(q) + J^T w`, one per joint, N m or N."
        }
        Function::ForwardDynamics => {
            "`qdd = D(q)^-1 (tau - C(q, qd) qd - G(q) + J^T w)`, one per joint, rad/s^2 or m/s^2; then the inertia that each joint\n\
             /// feels with the joints beyond it free, kg m^2 or kg. One of these that is not above zero says that `D` cannot be\n\
             /// inverted: the accelerations, finite or not, then mean nothing."
        }
        Function::Regressor => {
            "`d tau / d pi`, joint by joint: for each link from the joint's own to the last, the torque per `m, m cx, m cy, m cz, Ixx,\n\
             /// Ixy, Ixz, Iyy, Iyz, Izz` of that link, about its origin and in its frame: N m or N per kg, kg m, kg m^2."
        }
        Function::ComputedTorque(_) => {
            "`tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`, before friction and limits: one per joint, N m or N."
        }
    };
    format!("/// {} of {} in the scene {}.\n///\n/// {meaning}\n", name(function), title.robot, title.scene)
}

pub(super) fn presence<T>(term: &Term<T>) -> &'static str {
    match term {
        Term::Absent => "absent",
        Term::Constant(_) => "constant",
        Term::Live => "live",
    }
}
