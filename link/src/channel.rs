//! Authentication: packets in and out, and the handshake before them.
//!
//! ```text
//! host                                   board
//! join {nonce}                  ------>                                     open
//!                               <------  challenge {own, nonce, proof}      open; the host checks the proof
//! proof                         ------>                                     open; the board checks it
//! hello                         ------>                                     sealed from here on
//!                               <------  hello
//! ```
//!
//! A join from a stranger is answered with a challenge and does not disturb the session: that goes on until a correct proof begins another.

mod board;
mod host;

pub use board::{ANSWERS_MAX, Access, BoardChannel, NewNonce, Write};
pub use host::{Distrust, HostChannel};
