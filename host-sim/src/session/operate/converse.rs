//! The operator's main loop: executes every line of a console.

use super::command::parse;
use super::console::{Console, Line};
use super::{Operator, Stop};
use std::time::Duration;

/// Execute commands line by line, until the end.
pub(crate) fn converse(operator: &mut Operator, console: &mut Console) -> Result<(), Stop> {
    // In a drill, time stands still while a pipe is silent: the result does not depend on the speed of the writer.
    const PATIENCE: Duration = Duration::from_millis(20);
    // Whether Ctrl-C was pressed with no line typed since.
    let mut pressed = false;
    loop {
        let person = console.is_a_person();
        let passes = operator.is_live() || (person && operator.is_moving());
        let wait = if passes { Duration::ZERO } else { PATIENCE };
        let done = match console.next(wait) {
            Line::End => return Ok(()),
            Line::None if passes => operator.idle().map(|()| false),
            Line::None => operator.unless_interrupted().map(|()| false),
            Line::Text(line) => {
                pressed = false;
                operator.report().still();
                parse(&line, &operator.joint_names()).map_err(Stop::Input).and_then(|command| operator.obey(command))
            }
        };
        match done {
            Ok(false) => {}
            Ok(true) => return Ok(()),
            // A user at a terminal reads the error and goes on.
            Err(Stop::Input(problem)) if person => operator.complain(&problem)?,
            Err(Stop::Interrupted) if person && !pressed => {
                pressed = true;
                operator.end()?;
            }
            Err(stop) => return Err(stop),
        }
    }
}
