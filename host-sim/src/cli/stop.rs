//! `stop`: stops the arm of a session that runs in another terminal.

use board::session::local::client::Client;
use board::session::local::message::{Answer, Ask};
use board::session::local::session_file::{self, SessionFile};
use clap::Args;
use serde_json::json;
use sim::failure::{self, Failure};
use sim::terminal;

const EXAMPLE: &str = "Example:\n  newtau stop";

const EXAMPLES: &str = "\
Examples:
  newtau stop
  newtau stop --emergency

Stops every session of `newtau connect` and `newtau drive` that this user runs on this computer, as Esc does there: the arm stops along its path and
is held. `--emergency` is fault 9: the safe action of the scene, after which an arm without brakes may sink. Neither replaces an emergency stop that
cuts the drives' power.

Ends with 3 if there is no session, or if one of them did not confirm.";

/// Options of `stop`.
#[derive(Clone, Copy, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct StopArgs {
    /// Emergency stop (fault 9) instead of a stop along the path.
    #[arg(long)]
    pub emergency: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Outcome for one session: the session's message, or the reason why it did not confirm.
fn stopped(session: &SessionFile, ask: &Ask) -> Result<String, String> {
    let answer = Client::connect(session).and_then(|mut client| client.ask(ask)).map_err(|error| error.to_string())?;
    match answer {
        Answer::Stopped(text) => Ok(text),
        Answer::Error(why) => Err(why),
        other => Err(format!("unexpected answer: {other:?}")),
    }
}

/// Stops all sessions. Returns the exit code.
///
/// # Errors
/// The output is closed.
pub fn run(args: StopArgs) -> Result<u8, Failure> {
    let folders = session_file::folders();
    let (mut sessions, mut unread) = (Vec::new(), Vec::new());
    for folder in &folders {
        match session_file::running(folder) {
            Ok((found, bad)) => {
                sessions.extend(found);
                unread.extend(bad);
            }
            Err(error) => unread.push(format!("{}: {error}", folder.display())),
        }
    }
    let ask = if args.emergency { Ask::EmergencyStop } else { Ask::Stop };
    // All at the same time: none waits for another that does not answer.
    let outcomes: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = sessions.iter().map(|session| scope.spawn(|| stopped(session, &ask))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(|_| Err("no answer".into()))).collect()
    });
    let confirmed = !outcomes.is_empty() && unread.is_empty() && outcomes.iter().all(Result::is_ok);
    let text = match args.json {
        true => {
            let of = |(session, outcome): (&SessionFile, &Result<String, String>)| {
                json!({ "pid": session.pid, "scene": session.scene, "confirmed": outcome.is_ok(),
                    "text": outcome.as_ref().unwrap_or_else(|why| why) })
            };
            terminal::json(
                &json!({ "folders": folders, "sessions": sessions.iter().zip(&outcomes).map(of).collect::<Vec<_>>(), "unread": unread }),
            )?
        }
        false => {
            let of = |(session, outcome): (&SessionFile, &Result<String, String>)| match outcome {
                Ok(text) => format!("{} (process {}): confirmed: {text}\n", session.scene, session.pid),
                Err(why) => format!(
                    "{} (process {}): NOT CONFIRMED: {why}; use your emergency stop\n",
                    session.scene, session.pid
                ),
            };
            let mut text: String = sessions.iter().zip(&outcomes).map(of).collect();
            unread.iter().for_each(|why| text += &format!("{why}: this session was NOT STOPPED\n"));
            if text.is_empty() {
                let searched: Vec<_> = folders.iter().map(|folder| folder.display().to_string()).collect();
                text = format!(
                    "no session of this user was found: nothing was stopped. If an arm moves, use your emergency stop\nsearched: {}\n",
                    searched.join(", ")
                );
            }
            text
        }
    };
    terminal::print(&text)?;
    Ok(if confirmed { 0 } else { failure::FAULT })
}
