//! Conversion of a drive's kind known at run time to a type.

/// Evaluates an expression with the type of a kind of drive on CAN: in `with_drive_type!(protocol, K => ..)`, `K` is the type of `protocol`.
#[macro_export]
macro_rules! with_drive_type {
    (@($d:tt) $protocol:expr, $Kind:ident => $body:expr) => {{
        macro_rules! of_kinds {
            ($d($d kind:ident)*) => {
                match $protocol {
                    $d(dynamics_core::drive::Protocol::$d kind => {
                        type $Kind = dynamics_core::drive::$d kind;
                        $body
                    })*
                }
            };
        }
        dynamics_core::with_drive_kinds!(of_kinds)
    }};
    ($protocol:expr, $Kind:ident => $body:expr) => { $crate::with_drive_type!(@($) $protocol, $Kind => $body) };
}
