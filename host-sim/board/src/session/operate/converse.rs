//! The operator's main loop: executes every line of a console.

use super::command::Command;
use super::command_parser::parse;
use super::console::{Console, Line};
use super::ending::{Consent, Released};
use super::{Operator, Stop};
use std::time::Duration;

/// A pending decision of the user: the command to complete although joints may sink, or the lifting of the first motion's limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pending {
    Disarm,
    Quit,
    FullRange,
}

/// Executes commands line by line, until the end. `docs/operate/README.md` describes the state in which it leaves the arm; see `Operator::release`.
pub fn converse(operator: &mut Operator, console: &mut Console) -> Result<(), Stop> {
    // In a dry run, simulated time does not pass while a pipe is silent: the result does not depend on the speed of the writer.
    const PATIENCE: Duration = Duration::from_millis(20);
    let person = console.is_a_person();
    let consent = if person { Consent::Ask } else { Consent::Rule };
    // True if Ctrl-C was pressed with no line typed since.
    let mut pressed = false;
    let mut pending = None;
    loop {
        let passes = operator.is_live() || (person && operator.is_moving());
        let wait = if passes { Duration::ZERO } else { PATIENCE };
        let done = match console.next(wait) {
            Line::End => return operator.end(),
            Line::None if passes => operator.idle().map(|()| None),
            Line::None => operator.unless_interrupted().map(|()| None),
            Line::Text(line) => {
                pressed = false;
                operator.report().still();
                let answered = pending.take();
                match (answered, line.trim()) {
                    (Some(Pending::FullRange), answer) if operator.lifts(answer) => {
                        operator.full_range().map(|()| None)
                    }
                    (Some(Pending::FullRange), "y" | "yes") => operator
                        .say(
                            "full-range",
                            "not every joint was seen moving: the limits of the first motion stay in force; `full-range`, then `unseen`, lifts them",
                        )
                        .map(|()| None),
                    (Some(Pending::FullRange), "n" | "no" | "") => {
                        operator.say("full-range", "the limits of the first motion stay in force").map(|()| None)
                    }
                    (Some(pending), "y" | "yes") => release(operator, pending, Consent::Given).map(Some),
                    (Some(pending), "p" | "park") if pending != Pending::FullRange && operator.can_park() => {
                        operator.park().and_then(|()| release(operator, pending, consent)).map(Some)
                    }
                    (Some(_), "n" | "no" | "") => operator.say("disarm", "the arm stays held").map(|()| None),
                    _ => parse(&line, &operator.joint_names()).map_err(Stop::Input).and_then(|command| match command {
                        Command::Disarm(now) => {
                            release(operator, Pending::Disarm, if now { Consent::Given } else { consent }).map(Some)
                        }
                        Command::Quit(now) => {
                            release(operator, Pending::Quit, if now { Consent::Given } else { consent }).map(Some)
                        }
                        Command::FullRange if person && operator.is_moving() => operator
                            .complain("full-range: rejected: the arm moves; `wait` or `hold` first")
                            .map(|()| None),
                        Command::FullRange if person && operator.is_limited() => {
                            pending = Some(Pending::FullRange);
                            operator.ask_for_full_range().map(|()| None)
                        }
                        Command::FullRange => operator.full_range().map(|()| None),
                        command => operator.obey(command).map(|()| None),
                    }),
                }
            }
        };
        match done {
            Ok(None) => {}
            Ok(Some((Pending::Quit, Released::Done))) => return Ok(()),
            Ok(Some((after, Released::Asked))) => pending = Some(after),
            // Nothing follows `quit` in a script.
            Ok(Some((Pending::Quit, Released::Held))) if !person => return operator.keep_holding(),
            Ok(Some(_)) => {}
            // A user at a terminal reads the error and goes on.
            Err(Stop::Input(problem)) if person => operator.complain(&problem)?,
            Err(Stop::Pressed) => {
                pending = None;
                operator.stop()?;
                discard(operator, console)?;
                if !person {
                    // The lines that follow would move the arm again.
                    return operator.keep_holding().and(Err(Stop::Interrupted));
                }
            }
            Err(Stop::Interrupted) if person && !pressed => {
                pressed = true;
                operator.interrupted();
                discard(operator, console)?;
                match release(operator, Pending::Disarm, Consent::Ask) {
                    Ok((after, Released::Asked)) => pending = Some(after),
                    Ok(_) => {}
                    Err(Stop::Pressed) => {
                        operator.stop()?;
                        discard(operator, console)?;
                    }
                    Err(stop) => return Err(stop),
                }
            }
            Err(stop) => return Err(stop),
        }
    }
}

/// Discards what was typed before a stop: nothing is resumed, and these lines would move the arm again.
fn discard(operator: &mut Operator, console: &mut Console) -> Result<(), Stop> {
    let discarded = console.discard();
    if discarded == 0 {
        return Ok(());
    }
    let lines = if discarded == 1 { "line" } else { "lines" };
    operator.say("stop", &format!("stop: {discarded} typed {lines} discarded"))
}

/// Removes the torque, as far as the consent allows.
fn release(operator: &mut Operator, pending: Pending, consent: Consent) -> Result<(Pending, Released), Stop> {
    Ok((pending, operator.release(consent, pending == Pending::Quit)?))
}

#[cfg(test)]
mod tests {
    use super::converse;
    use crate::session::dry_run::OnDesk;
    use crate::session::frame_log::Head;
    use crate::session::operate::console::Console;
    use crate::session::operate::device::Pace;
    use crate::session::operate::dry_run_device::DryRunDevice;
    use crate::session::operate::report::Report;
    use crate::session::operate::screen::Screen;
    use crate::session::operate::{Operator, Presses};
    use robot_compiler::SceneFile;
    use sim::run::scene_world;
    use std::path::Path;

    /// True if the limits of the first motion are in force after a user at a terminal has typed these lines.
    fn limited_after(lines: &[&str]) -> bool {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/yam_move.toml");
        let scene = SceneFile::load(&path).unwrap();
        let model = scene.robot.model::<6>().unwrap();
        let device =
            DryRunDevice::new(OnDesk::start(&scene, &model), scene_world::world::<6>(&scene).unwrap(), Pace::default());
        let head = Head { hash: scene.hash(&model), scene: path, text: String::new() };
        let report = Report::new(false, Screen::default());
        let mut operator = Operator::new(Box::new(device), (&scene, &scene), head, report, Presses::default()).unwrap();
        operator.begin().unwrap();
        converse(&mut operator, &mut Console::typed(lines)).unwrap();
        operator.is_limited()
    }

    #[test]
    fn a_user_at_a_terminal_is_asked_before_the_limits_of_the_first_motion_are_lifted() {
        let ready = ["home", "confirm"];
        let after = |more: &[&str]| limited_after(&[&ready, more].concat());
        assert!(!limited_after(&[]) && after(&[]), "homing begins the first motion");
        for kept in [
            &["full-range"][..],
            &["full-range", "n"],
            &["full-range", ""],
            &["full-range", "status", "unseen"],
            &["full-range", "y"],
            &["y"],
        ] {
            assert!(after(kept), "{kept:?}");
        }
        for lifted in [&["full-range", "unseen"][..], &["full-range", "p", "full-range", "unseen"]] {
            assert!(!after(lifted), "{lifted:?}");
        }
        assert!(after(&["full-range", "unseen", "home", "confirm"]), "another homing limits the arm again");
    }
}
