//! The other end of a connection to a session.

use super::message::{Answer, Ask, Greeting};
use super::service::STOP_WAIT;
use super::session_file::SessionFile;
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::net::TcpStream;
use std::time::Duration;

/// Longest wait for a connection, and for an answer beyond the time that the session takes for it.
const WAIT: Duration = Duration::from_secs(2);

/// A connection to a session.
#[derive(Debug)]
pub struct Client {
    reader: BufReader<TcpStream>,
    greeting: Greeting,
}

impl Client {
    /// Connects to a session.
    ///
    /// # Errors
    /// The session does not answer, or does not accept the token.
    pub fn connect(session: &SessionFile) -> io::Result<Self> {
        let stream = TcpStream::connect_timeout(&session.address, WAIT)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(STOP_WAIT + WAIT))?;
        let mut reader = BufReader::new(stream);
        match exchange(&mut reader, &Ask::Token(session.token.clone()))? {
            Answer::Hello(greeting) => Ok(Self { reader, greeting }),
            other => Err(unexpected(&other)),
        }
    }

    /// The session's introduction.
    #[must_use]
    pub fn greeting(&self) -> &Greeting {
        &self.greeting
    }

    /// Sends a line, and returns the answer.
    ///
    /// # Errors
    /// The connection is broken.
    pub fn ask(&mut self, ask: &Ask) -> io::Result<Answer> {
        exchange(&mut self.reader, ask)
    }
}

fn exchange(reader: &mut BufReader<TcpStream>, ask: &Ask) -> io::Result<Answer> {
    reader.get_mut().write_all(format!("{}\n", serde_json::to_string(ask)?).as_bytes())?;
    let mut line = String::new();
    if reader.read_line(&mut line)? == 0 {
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the session closed the connection"));
    }
    Ok(serde_json::from_str(&line)?)
}

fn unexpected(answer: &Answer) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("unexpected answer: {answer:?}"))
}
