//! Access to a running session for other programs of the same user on this computer: `newtau stop`, and programs that send targets.
//!
//! ```text
//! other program -> socket -> connection -> shared <-> operator -> board
//! ```
//!
//! The socket is on 127.0.0.1 and asks for a token. A file that only the user can read holds both. One JSON value a line goes each way;
//! `docs/reference/session-socket.md` lists them.
//!
//! | module | holds |
//! |---|---|
//! | [`session_file`] | the files by which other programs find the sessions that run |
//! | [`shared`] | state, targets and stops, between the operator and the connections |
//! | [`targets`] | targets of another program |
//! | [`message`] | the lines of a connection, the state of a session among them |
//! | [`listener`] | connections to a socket, each on a thread of its own |
//! | [`service`] | the socket and its connections |
//! | [`page`] | a page for a browser, and its server |
//! | [`client`] | the other end of a connection |

pub mod client;
pub mod listener;
pub mod message;
pub mod page;
pub mod service;
pub mod session_file;
pub mod shared;
pub mod targets;
