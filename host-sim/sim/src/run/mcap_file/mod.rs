//! Files for viewers: MCAP with JSON messages, under the schema names that Foxglove and PlotJuggler know.
//!
//! | topic | schema | holds |
//! |---|---|---|
//! | `/robot_description` | `std_msgs/String` | the arm's URDF, once |
//! | `/tf` | `foxglove.FrameTransforms` | every joint of the URDF, at most 100 times a second |
//! | `/joint_states` | `foxglove.JointStates` | position, velocity, torque of every joint, every tick |
//! | `/newtau/tick` | `newtau.Tick` | the loop: reference, torque, limits, terms, fault, every tick |
//! | `/newtau/frame` | `newtau.Frame` | in a record of a session: every frame of the link, bit for bit |
//!
//! The times are those of the arm, so a repeated run gives the same bytes. Chunks are not compressed, because the libraries for compression are
//! written in C. A chunk ends at a megabyte, and in a session every second: a file that is cut off keeps all complete chunks.
//!
//! | module | holds |
//! |---|---|
//! | [`writer`] | such a file with one typed channel per topic |
//! | [`reader`] | messages of such a file, also of one that was cut off |
//! | [`messages`] | the messages and their schemas |
//! | [`arm`] | an arm's URDF, frames and joints as messages |
//! | [`run`] | a finished run as such a file |

pub mod arm;
pub mod messages;
pub mod reader;
pub mod run;
pub mod writer;

mod schemas;

/// First bytes of an MCAP file.
pub const MAGIC: &[u8] = mcap::MAGIC;
