//! Replay of a dry run: its frames and their order determine every tick.

use super::difference::{Difference, Gap, Replay, ReplayError, bits, difference};
use crate::session::dry_run::{DryRun, OnDesk, without_cost};
use crate::session::frame_log::{Direction, Entry, LogError};
use dynamics_core::Model;
use link::Frame;
use robot_compiler::SceneFile;
use std::collections::VecDeque;

/// Answers still to be compared. The black box has its own queue, because other frames may come between its ticks.
#[derive(Debug, Default)]
struct Answers {
    ticks: VecDeque<Frame>,
    past: VecDeque<Frame>,
}

impl Answers {
    fn of(&mut self, frame: &Frame) -> &mut VecDeque<Frame> {
        if matches!(frame, Frame::Past(_)) { &mut self.past } else { &mut self.ticks }
    }
}

pub(super) fn replay<const N: usize>(
    scene: &SceneFile,
    model: &Model<f64, N>,
    entries: impl Iterator<Item = Result<Entry, LogError>>,
) -> Result<Replay, ReplayError> {
    let mut desk = OnDesk::<N>::start(scene, model);
    let mut expected = Answers::default();
    let (mut replay, mut tick) = (Replay::default(), 0);
    for entry in entries {
        let Entry { way, missed, frame, .. } = entry?;
        match (way, frame) {
            (Direction::Sent, Frame::Measurement(measurement)) => {
                tick = measurement.tick;
                // The desk session never fails.
                for answer in desk.tick(&measurement).unwrap_or_default() {
                    let answer = without_cost(answer);
                    expected.of(&answer).push_back(answer);
                }
            }
            (Direction::Sent, frame) => {
                let dumps = matches!(frame, Frame::Dump);
                desk.send(&frame).ok();
                // Read the black box before the next tick changes it.
                let past = if dumps { desk.dumped().unwrap_or_default() } else { Vec::new() };
                expected.past.extend(past.into_iter().map(without_cost));
            }
            (Direction::Received, Frame::Hello(_)) => {}
            (Direction::Received, _) if missed > 0 => {
                replay.end = Some(Gap { tick, why: format!("{missed} packets of the board were lost") });
                break;
            }
            (Direction::Received, frame) => {
                let frame = without_cost(frame);
                replay.ticks += u64::from(matches!(frame, Frame::Status(_)));
                let desk = expected.of(&frame).pop_front();
                if let Some(difference) = compare(tick, &frame, desk.as_ref()) {
                    replay.differs(difference);
                }
            }
        }
    }
    Ok(replay)
}

fn compare(tick: u32, recorded: &Frame, replayed: Option<&Frame>) -> Option<Difference> {
    match (recorded, replayed) {
        (recorded, Some(replayed)) if bits(recorded) == bits(replayed) => None,
        (Frame::Status(a), Some(Frame::Status(b))) | (Frame::Past(Some(a)), Some(Frame::Past(Some(b)))) => {
            difference(a, b)
        }
        (recorded, replayed) => Some(Difference {
            tick,
            field: "answer".into(),
            recorded: format!("{recorded:?}"),
            replayed: replayed.map_or_else(|| "none".into(), |replayed| format!("{replayed:?}")),
        }),
    }
}
