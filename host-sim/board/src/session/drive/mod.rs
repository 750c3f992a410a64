//! The firmware's session in this program, with the arm's drives at CAN adapters of this computer.
//!
//! ```text
//! operator -> frames -> control thread: session -> joint-io -> adapter -> drives
//!          <- frames <-                         <-          <-         <-
//! ```
//!
//! Session, safety state machine and driver of the joints are the board's own code. The control thread is what the timer's interrupt is on a board.
//! If this program dies, the drives' own timeouts act.
//!
//! | module | holds |
//! |---|---|
//! | [`arm`] | session and drives of a scene, for any number of joints |
//! | [`bus_rates`] | the check that buses and adapters carry the scene's rate |
//! | `control` | the control thread |
//! | [`device`] | the thread as a device of the operator |
//! | [`lateness`] | lateness and duration of ticks |
//! | [`timing_check`] | the rate that this computer holds, without an arm |

pub mod arm;
pub mod bus_rates;
mod control;
pub mod device;
pub mod lateness;
pub mod timing_check;
