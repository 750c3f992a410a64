//! The socket of a session, and its connections.

use super::listener::listen;
use super::message::{Answer, Ask, Greeting};
use super::session_file::{Announced, SessionFile, folder};
use super::shared::{Shared, StopOutcome};
use super::targets::Over;
use crate::key;
use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Most connections at a time: so many that programs which forget to close theirs do not lock out a stop.
const CONNECTIONS: usize = 256;

/// Longest line, bytes.
const LINE: u64 = 4096;

/// Longest wait for the token.
const TOKEN_WAIT: Duration = Duration::from_secs(2);

/// Longest wait for the operator's message about a stop.
pub const STOP_WAIT: Duration = Duration::from_secs(3);

/// Bytes of a token.
const TOKEN: usize = 16;

/// The socket of a session. Its file is removed when this is dropped; connections end with the program.
#[derive(Debug)]
pub struct Service {
    _announced: Announced,
}

impl Service {
    /// Opens the socket and writes the session's file.
    ///
    /// # Errors
    /// No socket, no random numbers, or a file that cannot be written.
    pub fn start(scene: &Path, greeting: Greeting, shared: Arc<Shared>) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let token = new_token()?;
        let session = SessionFile::of_this_process(scene, listener.local_addr()?, token.clone());
        let announced = Announced::new(&session, &folder())?;
        listen(listener, CONNECTIONS, move |number, stream| {
            // A connection that breaks off is no event of the session, except for an arm that follows its targets.
            serve(stream, &token, &greeting, &shared, number).ok();
            shared.over(number, Over::Gone);
        })?;
        Ok(Self { _announced: announced })
    }
}

fn new_token() -> io::Result<String> {
    let bytes = key::random::<TOKEN>().map_err(io::Error::other)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Answers the lines of a connection until it is closed.
fn serve(stream: &TcpStream, token: &str, greeting: &Greeting, shared: &Shared, number: u64) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(TOKEN_WAIT))?;
    // A program that does not read its answers must not block this thread for ever.
    stream.set_write_timeout(Some(TOKEN_WAIT))?;
    let mut reader = BufReader::new(stream);
    // Without the token there is no answer: whoever knocks learns nothing.
    match next(&mut reader)? {
        Some(Ok(Ask::Token(given))) if is_same(&given, token) => send(stream, &Answer::Hello(greeting.clone()))?,
        _ => return Ok(()),
    }
    stream.set_read_timeout(None)?;
    while let Some(ask) = next(&mut reader)? {
        send(stream, &answer(ask, shared, number))?;
    }
    Ok(())
}

fn answer(ask: Result<Ask, String>, shared: &Shared, number: u64) -> Answer {
    match ask {
        Ok(Ask::State) => Answer::State(shared.snapshot()),
        Ok(Ask::Target(q)) => match shared.target(number, q) {
            Ok(()) => Answer::State(shared.snapshot()),
            Err(why) => Answer::Error(why),
        },
        Ok(Ask::Done) => {
            shared.over(number, Over::Done);
            Answer::State(shared.snapshot())
        }
        Ok(ask @ (Ask::Stop | Ask::EmergencyStop)) => {
            let wanted = shared.stop(ask == Ask::EmergencyStop);
            match shared.until_stopped(wanted, STOP_WAIT) {
                StopOutcome::Confirmed(text) => Answer::Stopped(text),
                StopOutcome::NotConfirmed(why) => Answer::Error(why.into()),
            }
        }
        Ok(Ask::Token(_)) => Answer::Error("the token was given already".into()),
        Err(why) => Answer::Error(why),
    }
}

/// The next line; `None` at the end, and after a line that is too long.
fn next(reader: &mut BufReader<&TcpStream>) -> io::Result<Option<Result<Ask, String>>> {
    let mut line = String::new();
    reader.by_ref().take(LINE).read_line(&mut line)?;
    if !line.ends_with('\n') {
        return Ok(None);
    }
    Ok(Some(serde_json::from_str(&line).map_err(|error| format!("{}: {error}", line.trim_end()))))
}

fn send(mut stream: &TcpStream, answer: &Answer) -> io::Result<()> {
    // In one packet: a reader that waits for the end of the line gets it at once.
    stream.write_all(format!("{}\n", serde_json::to_string(answer)?).as_bytes())
}

/// Compares in a time that does not depend on the place of the first difference.
fn is_same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}
