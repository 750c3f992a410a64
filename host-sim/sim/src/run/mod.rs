//! A closed-loop run: from a scene to a record, a summary and a report.
//!
//! | module | holds |
//! |---|---|
//! | [`target`] | the targets that compute the torques: the desk, the chip, or both for comparison |
//! | [`world`] | everything in the loop but the controller: arm, sensors, drives, motion |
//! | [`sensing`] | the measurement of a tick, from sensors or drives |
//! | [`closed_loop`] | the loop itself, once per control period |
//! | [`batch`] | several runs together, with their arms' equations solved in lanes |
//! | [`scene_world`] | the simulated world of a scene |
//! | [`simulate`] | from a scene to a finished run |
//! | [`record`], [`joint_label`] | the record of every tick, and its CSV; names and units of joints |
//! | [`load`] | the nearest limit, the work of the torques |
//! | [`trial`] | does the arm become quiet when it is held? |
//! | [`quality`] | chatter, the error at rest, the distance from the reference |
//! | [`numbers`] | numbers of a series, and their text |
//! | [`summary`], [`summary_parts`] | a run in a few numbers |
//! | [`marks`] | waypoints and limits, for the charts of the report |
//! | [`mcap_file`] | a run, or a session, as a file for viewers |
//! | [`report`] | a run as a page |
//! | `wrench` | from joint torques to an equivalent wrench at the tip |
//! | `files` | log, summary and report as files |
//! | `one_run` | a controller in a world, from the first tick to the summary |
//! | `compiled` | the loop, compiled once for each number of joints |

pub mod batch;
pub mod closed_loop;
mod compiled;
pub mod files;
pub mod joint_label;
pub mod load;
pub mod marks;
pub mod mcap_file;
pub mod numbers;
mod one_run;
pub mod quality;
pub mod record;
pub mod report;
pub mod scene_world;
pub mod sensing;
pub mod simulate;
pub mod simulation;
pub mod summary;
pub mod summary_parts;
pub mod target;
pub mod trial;
pub mod world;
pub mod wrench;
