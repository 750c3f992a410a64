//! Conversion of a joint count known at run time to one known at compile time.

/// Evaluates an expression with the constant `N` set to a joint count that is known only at run time.
///
/// `with_dof!(robot.dof(), N => expression)` compiles the expression for `N` from 1 to 6 and runs the one for the given count. A count
/// below 1 runs 1, one above 6 runs 6; [`crate::Robot::model`] then returns an error, because the robot has another number of joints.
/// `?` and `return` inside the expression act on the surrounding function.
#[macro_export]
macro_rules! with_dof {
    ($count:expr, $N:ident => $body:expr) => {
        match $count {
            0 | 1 => {
                const $N: usize = 1;
                $body
            }
            2 => {
                const $N: usize = 2;
                $body
            }
            3 => {
                const $N: usize = 3;
                $body
            }
            4 => {
                const $N: usize = 4;
                $body
            }
            5 => {
                const $N: usize = 5;
                $body
            }
            _ => {
                const $N: usize = 6;
                $body
            }
        }
    };
}
