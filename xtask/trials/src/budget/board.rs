//! A board on a serial port, in open-loop bench mode and lock step: cycles of each tick from the board's own counter, and torques that equal the
//! desk's to the last bit.
//!
//! In bench mode the controller runs alone, and no drive is active. A measurement starts the tick, and the host is silent until the answer, so no
//! byte of the link interrupts the counted code.
//!
//! | check, in this order | by |
//! |---|---|
//! | the port opens; the firmware answers, with the right protocol version, robot hash, joints and rate | [`::board::session::doctor`] |
//! | in every tick: cycles, and a plausible count | [`BadCounter`] |
//! | in every tick: the bits that the desk's own controller computes | [`Failure::Differ`] |

use crate::budget::failure::{BadCounter, Failure};
use crate::budget::random_motion::Tick;
use crate::budget::report::{OnBoard, Spread};
use crate::budget::ticks::hello;
use ::board::chip::ChipError;
use ::board::session::doctor::{self, State};
use ::board::session::serial::{BAUD, SerialError, SerialLink};
use dynamics_core::Fault;
use link::codec::{FrameTooLong, Received};
use link::{Cost, Encoder, Frame, Hello, Key, Pacing, Refusal};
use robot_compiler::SceneFile;
use sim::run::simulate;
use std::time::{Duration, Instant};

/// Timeout of an answer. A tick needs about 2 ms on the wire, and a USB adapter may buffer bytes for 16 ms more.
const ANSWER: Duration = Duration::from_secs(3);

/// Number of times that a hello is sent.
const TRIES: u32 = 3;

/// Measures the cycles of every tick of a motion.
///
/// `instructions` is the smallest count of the emulator for a tick, if it is known. No tick can take fewer cycles.
///
/// # Errors
/// [`Failure::Board`]: there is no such port, or it does not have this scene's firmware. [`Failure::Counter`]: the count is not cycles.
/// [`Failure::Differ`]: the board computes other torques. Also if the board brakes, rejects a frame, is silent, or is unplugged.
pub fn measure<const N: usize>(
    scene: &SceneFile,
    (port, key): (&str, Option<Key>),
    motion: &[Tick<N>],
    instructions: Option<u32>,
) -> Result<OnBoard, Failure> {
    let own = hello::<N>(scene)?;
    let checks = doctor::board_checks(port, Some(&own), key);
    if let Some(wrong) = checks.into_iter().find(|check| check.state == State::Problem) {
        return Err(Failure::Board { found: wrong.found, advice: wrong.advice.unwrap_or_default() });
    }
    let model = scene.robot.model::<N>().map_err(|error| Failure::Scene(error.to_string()))?;
    let live = simulate::live_inputs::<f32, N>(scene, &model);
    let mut desk = simulate::desk::<f32, N>(scene, &model);
    *desk.live_mut() = live;
    let mut board = BoardWire::start(port, key, own)?;
    board.send(&Frame::Live(link::Live::new(&live).map_err(ChipError::from)?))?;
    let (mut cycles, mut differ, mut first) = (Vec::with_capacity(motion.len()), 0, 0);
    for (number, (reference, measurement)) in (1..).zip(motion) {
        board.send(&Frame::Reference(link::Reference::new(reference)))?;
        board.send(&Frame::Measurement(link::Measurement::new(number, measurement)))?;
        let mut answer = board.answer(number)?;
        cycles.push(believed(number, cost_of(&mut answer), instructions)?);
        let expected = Frame::answer(number, &desk.tick(reference, measurement), None);
        if !same_bits(&answer, &expected).map_err(ChipError::from)? {
            differ += 1;
            first = if differ == 1 { number } else { first };
        }
    }
    let ticks = cycles.len() as u64;
    if differ > 0 {
        return Err(Failure::Differ { differ, ticks, first });
    }
    let cycles_per_tick = Spread::of(&cycles).ok_or_else(|| Failure::NotSeen("a tick: the motion has none".into()))?;
    let hash = format!("{:016x}", own.robot);
    Ok(OnBoard { hash, rate_hz: scene.control.rate, ticks, bits_differ: differ, cycles_per_tick })
}

/// Removes the cost from a command and returns it.
fn cost_of(answer: &mut Frame) -> Option<Cost> {
    if let Frame::Command(command) = answer { command.cost.take() } else { None }
}

/// Returns the cycles if the count is plausible.
fn believed(tick: u32, cost: Option<Cost>, instructions: Option<u32>) -> Result<u32, BadCounter> {
    match cost {
        None => Err(BadCounter::None { tick }),
        Some(Cost::Instructions(_)) => Err(BadCounter::Instructions { tick }),
        // The firmware subtracts the cost of reading the counter, so a stopped counter gives zero or less.
        Some(Cost::Cycles(count)) if count.cast_signed() <= 0 => Err(BadCounter::Stuck { tick, count }),
        Some(Cost::Cycles(count)) => match instructions.filter(|least| count < *least) {
            Some(instructions) => Err(BadCounter::TooFew { tick, count, instructions }),
            None => Ok(count),
        },
    }
}

/// Compares encoded packets, because `==` treats -0 and 0 as equal.
fn same_bits(a: &Frame, b: &Frame) -> Result<bool, FrameTooLong> {
    Ok(Encoder::new().encode(a)? == Encoder::new().encode(b)?)
}

/// A board with which robot, joints and rate are agreed.
struct BoardWire(SerialLink);

impl BoardWire {
    fn start(port: &str, key: Option<Key>, own: Hello) -> Result<Self, Failure> {
        let mut wire = Self(SerialLink::open(port, BAUD)?);
        wire.0.join(key)?;
        // Answers to an earlier user of the port may still arrive, and could be mistaken for ours. No other program requests bench mode with timer
        // pacing, so every answer after this one is for us.
        wire.agree(Hello { pacing: Pacing::Timer, ..own })?;
        wire.agree(own)?;
        Ok(wire)
    }

    fn agree(&mut self, hello: Hello) -> Result<(), Failure> {
        for _ in 0..TRIES {
            self.send(&Frame::Hello(hello))?;
            let end = Instant::now() + ANSWER;
            while Instant::now() < end {
                match self.0.receive(end.saturating_duration_since(Instant::now())) {
                    Ok(Some(Received { frame: Frame::Hello(theirs), .. })) if theirs == hello => return Ok(()),
                    // The board still counts an earlier user's packets. The number is right from the next packet on.
                    Ok(Some(Received { frame: Frame::Refusal(Refusal::Lost { .. }), .. })) => break,
                    // An old answer, or a packet that was cut when the port was opened.
                    Ok(_) | Err(SerialError::Undecodable(_)) => {}
                    Err(error) => return Err(error.into()),
                }
            }
        }
        Err(ChipError::Silent { waiting_for: "the answer to a hello", timeout: ANSWER * TRIES }.into())
    }

    fn send(&mut self, frame: &Frame) -> Result<(), Failure> {
        Ok(self.0.send(frame)?)
    }

    /// The command of a tick.
    fn answer(&mut self, tick: u32) -> Result<Frame, Failure> {
        let received = self.0.receive(ANSWER)?;
        match received {
            None => Err(ChipError::Silent { waiting_for: "the answer to a measurement", timeout: ANSWER }.into()),
            Some(Received { missed: missed @ 1.., .. }) => Err(ChipError::Lost { missed }.into()),
            Some(Received { frame: Frame::Command(command), .. }) if command.tick == tick => {
                Ok(Frame::Command(command))
            }
            Some(Received { frame: Frame::Command(command), .. }) => {
                Err(ChipError::OtherTick { expected: tick, found: command.tick }.into())
            }
            Some(Received { frame: Frame::Fault(fault), .. }) => {
                let why =
                    fault.to_core().map_or_else(|| format!("fault {}", fault.code), |fault: Fault| fault.to_string());
                Err(Failure::NotSeen(format!("a torque in tick {tick}: the board brakes, {why}")))
            }
            Some(Received { frame: Frame::Refusal(refusal), .. }) => Err(ChipError::Refused(refusal).into()),
            Some(Received { frame, .. }) => {
                Err(ChipError::Unexpected { expected: "a command", found: Box::new(frame) }.into())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BadCounter, Cost, Frame, believed, same_bits};
    use dynamics_core::Command;
    use dynamics_core::control::LimitFlags;

    #[test]
    fn only_cycles_that_can_be_are_believed() {
        let cycles = |count| Some(Cost::Cycles(count));
        let stuck = |count| Err(BadCounter::Stuck { tick: 7, count });
        // Reported count, the emulator's instructions, expected result. A stopped counter gives zero minus the cost of reading it.
        for (cost, instructions, expected) in [
            (cycles(2_805), Some(1_338), Ok(2_805)),
            (cycles(1_338), Some(1_338), Ok(1_338)),
            (cycles(1), None, Ok(1)),
            (cycles(0x7fff_ffff), None, Ok(0x7fff_ffff)),
            (cycles(0), None, stuck(0)),
            (cycles(u32::MAX - 1), Some(1_338), stuck(u32::MAX - 1)),
            (cycles(0x8000_0000), None, stuck(0x8000_0000)),
            (cycles(1_337), Some(1_338), Err(BadCounter::TooFew { tick: 7, count: 1_337, instructions: 1_338 })),
            (Some(Cost::Instructions(1_365)), None, Err(BadCounter::Instructions { tick: 7 })),
            (None, None, Err(BadCounter::None { tick: 7 })),
        ] {
            assert_eq!(believed(7, cost, instructions), expected, "{cost:?}");
        }
    }

    #[test]
    fn a_counter_that_is_not_believed_says_what_to_look_for() {
        let stuck = BadCounter::Stuck { tick: 1, count: u32::MAX - 1 }.to_string();
        assert!(
            stuck.starts_with("tick 1 took -2 cycles: the counter stands still. CYCCNT counts while TRCENA"),
            "{stuck}"
        );
        for bad in [BadCounter::None { tick: 1 }, BadCounter::TooFew { tick: 1, count: 3, instructions: 1_338 }] {
            let said = bad.to_string();
            assert!(said.contains("TRCENA is set in DEMCR") && said.contains("NOCYCCNT"), "{said}");
        }
        let emulator = BadCounter::Instructions { tick: 1 }.to_string();
        assert!(emulator.contains("without --port") && !emulator.contains("CYCCNT"), "{emulator}");
    }

    #[test]
    fn any_bit_of_an_answer_counts() {
        let answer = |torque: f32, limits, tick| {
            let limits = [LimitFlags::from_bits(limits)];
            Frame::answer(tick, &Command::Drive { torque: [torque], limits }, None)
        };
        assert_eq!(same_bits(&answer(0.0, 0, 1), &answer(0.0, 0, 1)), Ok(true));
        for other in [answer(-0.0, 0, 1), answer(f32::from_bits(1), 0, 1), answer(0.0, 1, 1), answer(0.0, 0, 2)] {
            assert_eq!(same_bits(&answer(0.0, 0, 1), &other), Ok(false), "{other:?}");
        }
    }
}
