//! Comparison of the frames that chip and desk send in one tick.
//!
//! Two machines agree if they send the same frames in the same order, apart from the answers to requests. Each answer contains the number of its
//! request, so the order of answers carries no meaning. The order depends on timing: when one task reads a request, another may already have sent its
//! first answers. The answers of a tick are therefore compared as a set, sorted by number. Each request is answered once. All answers of a tick come
//! before its status: a later answer belongs to the next tick, and is a difference.

use link::{Answer, Frame};

/// Describes the difference between the frames of one tick; `None` if the machines agree.
pub(super) fn difference(chip: &[Frame], desk: &[Frame]) -> Option<String> {
    let (chip, desk) = (Sorted::new(chip), Sorted::new(desk));
    if let Some(number) = chip.answered_twice().or(desk.answered_twice()) {
        return Some(format!("request {number} is answered twice\n  chip {chip:?}\n  desk {desk:?}"));
    }
    (chip != desk).then(|| format!("\n  chip {chip:?}\n  desk {desk:?}"))
}

/// Frames of a tick. They are compared as printed text, which has every digit, because NaN differs from itself.
#[derive(Debug, PartialEq)]
struct Sorted {
    /// All frames but answers, in their order.
    frames: Vec<String>,
    /// Answers by number.
    answers: Vec<(u8, String)>,
}

impl Sorted {
    fn new(all: &[Frame]) -> Self {
        let (mut frames, mut answers) = (Vec::new(), Vec::new());
        for frame in all {
            match frame {
                Frame::Answer(Answer { number, verdict }) => answers.push((*number, format!("{verdict:?}"))),
                other => frames.push(format!("{other:?}")),
            }
        }
        answers.sort();
        Self { frames, answers }
    }

    /// Number of a request that has more than one answer.
    fn answered_twice(&self) -> Option<u8> {
        self.answers.windows(2).find(|pair| pair[0].0 == pair[1].0).map(|pair| pair[0].0)
    }
}

#[cfg(test)]
mod tests {
    use super::difference;
    use link::{Answer, Denial, Frame, Refusal, Verdict};

    const NOT_HOMED: Denial = Denial { code: 3, fault: 0, joint: None, input: 0 };

    const fn answer(number: u8, verdict: Verdict) -> Frame {
        Frame::Answer(Answer { number, verdict })
    }

    /// A tick with colliding requests: two refusals, three answers, and one frame in place of its status.
    fn desk() -> Vec<Frame> {
        vec![
            Frame::Refusal(Refusal::Lost { missed: 1 }),
            answer(7, Verdict::Superseded),
            Frame::Refusal(Refusal::NonFiniteLive),
            answer(6, Verdict::Superseded),
            answer(8, Verdict::Accepted),
            Frame::Alive,
        ]
    }

    /// Difference between the desk's frames and the same frames after `change`.
    fn changed(change: impl Fn(&mut Vec<Frame>)) -> Option<String> {
        let mut chip = desk();
        change(&mut chip);
        difference(&chip, &desk())
    }

    #[test]
    fn answers_in_another_order_are_no_difference() {
        assert_eq!(difference(&desk(), &desk()), None);
        assert_eq!(changed(|chip| chip.swap(1, 3)), None);
        assert_eq!(changed(|chip| chip.swap(3, 4)), None);
        // Sent before a refusal, not after it.
        assert_eq!(changed(|chip| chip.swap(0, 1)), None);
    }

    #[test]
    fn a_changed_a_missing_and_a_doubled_answer_are_differences() {
        assert!(changed(|chip| chip[1] = answer(7, Verdict::Accepted)).is_some(), "another verdict");
        assert!(changed(|chip| chip[4] = answer(8, Verdict::Rejected(NOT_HOMED))).is_some(), "another verdict");
        assert!(changed(|chip| chip[1] = answer(9, Verdict::Superseded)).is_some(), "another number");
        // The same numbers and verdicts, but assigned to other requests.
        let swapped_verdicts = |chip: &mut Vec<Frame>| {
            chip[3] = answer(6, Verdict::Accepted);
            chip[4] = answer(8, Verdict::Superseded);
        };
        assert!(changed(swapped_verdicts).is_some(), "verdicts of each other's requests");
        assert!(changed(|chip| drop(chip.remove(4))).is_some(), "a missing answer");
        assert!(changed(|chip| chip.insert(4, answer(7, Verdict::Superseded))).is_some(), "a doubled answer");
        // Two answers to one request are an error even if both machines send them.
        let twice = [desk(), vec![answer(8, Verdict::Accepted)]].concat();
        assert!(difference(&twice, &twice).unwrap().contains("request 8 is answered twice"));
    }

    #[test]
    fn other_frames_that_change_their_places_are_a_difference() {
        assert!(changed(|chip| chip.swap(0, 2)).is_some(), "swapped refusals");
        assert!(changed(|chip| chip.swap(2, 5)).is_some(), "a refusal after the last frame");
        assert!(changed(|chip| drop(chip.remove(0))).is_some(), "a missing refusal");
        assert!(changed(|chip| chip[5] = Frame::Dump).is_some(), "another frame");
    }
}
