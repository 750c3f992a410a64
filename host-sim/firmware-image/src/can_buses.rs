//! Load of a scene's frames on its board's CAN buses, and a check that they fit.
//!
//! The board's compilation checks the same numbers ([`dynamics_core::drive::bus_time`]). Here, a scene that does not fit is rejected with the line of
//! the error, before the compiler starts.

use crate::board::Board;
use dynamics_core::drive::bus_time::{BusLoad, LEAD_US, TURNAROUND_US};
use robot_compiler::SceneFile;
use std::fmt;
use std::path::Path;
use toml_edit::{Document, Item};

/// Frames of a tick on one bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// Number of the bus as in a robot file, from 1.
    bus: u8,
    load: BusLoad,
    rate_hz: f64,
}

impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bus, load, rate_hz } = self;
        let actuators = if load.actuators == 1 { "actuator" } else { "actuators" };
        let mbit = |rate: u32| f64::from(rate) * 1e-6;
        let frames = match load.data_rate {
            None => format!("classic frames at {} Mbit/s", mbit(load.bit_rate)),
            Some(rate) => format!("FD frames at {} and {} Mbit/s", mbit(load.bit_rate), mbit(rate)),
        };
        // The rate is a whole number of hertz here: the cast saturates.
        let slack = load.slack_percent(rate_hz.ceil() as u32);
        write!(
            f,
            "bus {bus}: {} {actuators}, {frames}: at most {:.1} of {:.0} us a tick, {slack} % free; up to {} Hz",
            load.actuators,
            f64::from(load.frames_ns()) * 1e-3,
            1e6 / rate_hz,
            load.max_rate_hz(LEAD_US)
        )
    }
}

/// The schedule of each bus that has actuators; none for a board without CAN.
///
/// # Errors
/// For a line of the robot file: a bus or FD frames that the board does not have. For a line of the scene: a rate at which the frames do not fit.
pub fn schedules(file: &SceneFile, scene: &Path, board: Board) -> Result<Vec<Schedule>, String> {
    let (Some(buses), Some(protocol)) = (board.can_buses(), file.protocol()) else { return Ok(Vec::new()) };
    let drives = file.mit_drives();
    for (index, drive) in drives.iter().enumerate() {
        let wrong = |key: &str, found: u32, expected: String| {
            let at = place(&file.robot.path, |document| document.get("joint")?.get(index)?.get("drive")?.get(key));
            let name = file.robot.joints.get(index).map_or("", |joint| joint.name.as_str());
            Err(format!("{at}: joint {} ({name}).drive.{key}: found {found}, expected {expected}", index + 1))
        };
        if drive.bus >= buses.count {
            let expected = format!("a bus of {board}, 1 to {}", buses.count);
            return wrong("bus", u32::from(drive.bus) + 1, expected);
        }
        let before = drives.iter().take(index).filter(|other| other.bus == drive.bus).count();
        if let Some(most) = buses.actuators.filter(|&most| before >= most) {
            let expected = format!(
                "another bus: {board} sends to at most {most} actuators on a bus, and {before} are on this one"
            );
            return wrong("bus", u32::from(drive.bus) + 1, expected);
        }
        if let (Some(rate), false) = (drive.data_rate, buses.fd) {
            return wrong("data_rate", rate.bits_per_second(), format!("no such key: {board} has classic CAN alone"));
        }
    }
    let rate_hz = file.control.rate;
    let of_bus = |bus| Schedule { bus: bus + 1, load: BusLoad::of(&drives, bus, protocol.facts().identifier), rate_hz };
    let schedules: Vec<_> = (0..buses.count).map(of_bus).filter(|schedule| schedule.load.actuators > 0).collect();
    match schedules.iter().find(|schedule| rate_hz > f64::from(schedule.load.max_rate_hz(LEAD_US))) {
        None => Ok(schedules),
        Some(slow) => Err(format!(
            "{}: control.rate: found {rate_hz} Hz, expected at most {}, which bus {} holds on {board}: {:.1} us for frames, {TURNAROUND_US} us for the \
             last actuator's answer, {LEAD_US} us for the controller",
            place(scene, |document| document.get("control")?.get("rate")),
            slow.load.max_rate_hz(LEAD_US),
            slow.bus,
            f64::from(slow.load.frames_ns()) * 1e-3,
        )),
    }
}

/// A file and the line, counted from 1, of a value in it. The file alone if it does not contain the value.
fn place(path: &Path, value: impl FnOnce(&Item) -> Option<&Item>) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let document = Document::parse(text.as_str()).ok();
    let start = document.as_ref().and_then(|document| Some(value(document.as_item())?.span()?.start));
    let line = start.and_then(|start| Some(1 + text.get(..start)?.matches('\n').count()));
    line.map_or_else(|| path.display().to_string(), |line| format!("{}:{line}", path.display()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{Schedule, schedules};
    use crate::board::Board;
    use dynamics_core::drive::DataRate;
    use robot_compiler::SceneFile;
    use robot_compiler::drive::{JointDrive, MitSpec};
    use std::path::PathBuf;

    const CLASSIC: &str = "scenes/examples/mit6_wave.toml";
    const FD: &str = "scenes/examples/mit6_fd_wave.toml";

    fn path(scene: &str) -> PathBuf {
        crate::process::root().join(scene)
    }

    fn of(scene: &str, board: Board, change: impl Fn(usize, &mut MitSpec)) -> Result<Vec<Schedule>, String> {
        let mut file = SceneFile::load(&path(scene)).unwrap();
        for (index, joint) in file.robot.joints.iter_mut().enumerate() {
            if let Some(JointDrive::Mit(spec)) = &mut joint.drive {
                change(index, spec);
            }
        }
        schedules(&file, &path(scene), board)
    }

    fn lines(scene: &str, board: Board, change: impl Fn(usize, &mut MitSpec)) -> Vec<String> {
        of(scene, board, change).unwrap().iter().map(ToString::to_string).collect()
    }

    #[test]
    fn every_bus_with_actuators_is_reported_with_its_slack() {
        let bus = |bus: u8| {
            format!(
                "bus {bus}: 3 actuators, classic frames at 1 Mbit/s: at most 750.0 of 1000 us a tick, 25 % free; up to 1098 Hz"
            )
        };
        assert_eq!(lines(CLASSIC, Board::F405Can, |_, _| ()), [bus(1), bus(2)]);
        assert_eq!(lines(CLASSIC, Board::G474Fdcan, |_, _| ()), [bus(1), bus(2)]);
        assert_eq!(
            lines(FD, Board::G474Fdcan, |_, _| ()),
            [
                "bus 1: 6 actuators, FD frames at 1 and 5 Mbit/s: at most 643.2 of 1000 us a tick, 35 % free; up to 1243 Hz"
            ]
        );
        assert!(lines(CLASSIC, Board::OdriveV3, |_, _| ()).is_empty());
    }

    /// The longest possible replies, at 1 kHz.
    #[test]
    fn six_joints_leave_30_percent_free_on_three_classic_buses_and_on_one_of_fd() {
        let three = of(CLASSIC, Board::G474Fdcan, |index, spec| {
            (spec.bus, spec.reply_bytes) = (index as u8 / 2 + 1, 8);
        });
        let slacks: Vec<u32> = three.unwrap().iter().map(|schedule| schedule.load.slack_percent(1000)).collect();
        assert_eq!(slacks, [46; 3]);
        let fd = of(FD, Board::G474Fdcan, |_, spec| spec.reply_bytes = 8).unwrap();
        assert_eq!(fd.iter().map(|schedule| schedule.load.slack_percent(1000)).collect::<Vec<_>>(), [33]);
    }

    #[test]
    fn a_bus_that_the_board_does_not_have_is_refused_in_the_robots_line() {
        let third = |_: usize, spec: &mut MitSpec| spec.bus = 3;
        let why = of(CLASSIC, Board::F405Can, third).unwrap_err();
        let expected = "mit6.toml:23: joint 1 (base).drive.bus: found 3, expected a bus of f405-can, 1 to 2";
        assert!(why.ends_with(expected), "{why}");
        let why = of(FD, Board::F405Can, |_, _| ()).unwrap_err();
        let expected =
            "joint 1 (base).drive.data_rate: found 5000000, expected no such key: f405-can has classic CAN alone";
        assert!(why.contains("mit6_fd.toml:") && why.ends_with(expected), "{why}");
    }

    #[test]
    fn six_actuators_on_a_classic_bus_are_for_a_board_with_queues_and_a_rate_that_the_bus_holds() {
        let mut file = SceneFile::load(&path(CLASSIC)).unwrap();
        for joint in &mut file.robot.joints {
            if let Some(JointDrive::Mit(spec)) = &mut joint.drive {
                spec.bus = 1;
            }
        }
        file.control.rate = 500.0;
        assert!(schedules(&file, &path(CLASSIC), Board::G474Fdcan).is_ok());
        let why = schedules(&file, &path(CLASSIC), Board::F405Can).unwrap_err();
        let expected =
            "found 1, expected another bus: f405-can sends to at most 3 actuators on a bus, and 3 are on this one";
        assert!(why.ends_with(expected), "{why}");
        file.control.rate = 1000.0;
        assert!(
            schedules(&file, &path(CLASSIC), Board::G474Fdcan).unwrap_err().contains("control.rate: found 1000 Hz")
        );
    }

    #[test]
    fn a_rate_that_a_bus_does_not_hold_is_refused_in_the_scenes_line() {
        let mut file = SceneFile::load(&path(FD)).unwrap();
        file.control.rate = 1243.0;
        assert!(schedules(&file, &path(FD), Board::G474Fdcan).is_ok());
        file.control.rate = 1244.0;
        let why = schedules(&file, &path(FD), Board::G474Fdcan).unwrap_err();
        assert!(
            why.contains("mit6_fd_wave.toml:6: control.rate: found 1244 Hz, expected at most 1243, which bus 1 holds"),
            "{why}"
        );
        // At the lower data rate, the frames do not fit at 1 kHz.
        let why = of(FD, Board::G474Fdcan, |_, spec| spec.data_rate = Some(DataRate::Mbit2)).unwrap_err();
        assert!(
            why.contains(
                ": found 1000 Hz, expected at most 851, which bus 1 holds on g474-fdcan: 1014.0 us for frames"
            ),
            "{why}"
        );
    }
}
