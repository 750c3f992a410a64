//! Who may talk: packets in and out, and the handshake before them.
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
//! A stranger's join gives him a challenge and disturbs nobody: the session goes on until a right proof begins another.

mod board;
mod host;

pub use board::{ANSWERS_MAX, Access, BoardChannel, NewNonce, Write};
pub use host::{Distrust, HostChannel};
