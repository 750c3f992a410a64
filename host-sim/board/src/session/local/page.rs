//! A page that shows a session in a browser of this computer, and its server.
//!
//! The page can do one thing: stop the arm. Pages of other origins can neither read the state nor stop the arm. The server answers only requests whose
//! `Host` is its own address, so that a foreign name which leads to 127.0.0.1 is refused (DNS rebinding), and refuses a foreign `Origin`. A stop needs the
//! page's own `Origin`, which no other page can send.

use super::listener::listen;
use super::service::STOP_WAIT;
use super::shared::{Shared, StopOutcome};
use std::io::{self, Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// Most connections at a time.
const CONNECTIONS: usize = 64;

/// Longest head of a request, bytes, and most headers.
const HEAD: usize = 16 * 1024;
const HEADERS: usize = 64;

/// Longest wait for a request, and for a browser that does not read.
const WAIT: Duration = Duration::from_secs(2);

/// Interval between two states, and between two signs of life without a new state.
const INTERVAL: Duration = Duration::from_millis(33);
const ALIVE: Duration = Duration::from_secs(1);

/// Starts the server at this port of 127.0.0.1; 0 lets the system choose one. Returns the address. The server ends with the program.
///
/// # Errors
/// The port is in use, or there is no thread.
pub fn start(port: u16, html: String, shared: Arc<Shared>) -> io::Result<SocketAddr> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
    let address = listener.local_addr()?;
    listen(listener, CONNECTIONS, move |_, stream| {
        // A browser that goes away is no event of the session.
        serve(stream, address.port(), &html, &shared).ok();
    })?;
    Ok(address)
}

/// A request, as far as it matters.
#[derive(Debug, Default, PartialEq, Eq)]
struct Asked {
    method: String,
    path: String,
    host: Vec<String>,
    origin: Vec<String>,
}

/// Response to a request.
#[derive(Debug, PartialEq, Eq)]
enum Response {
    Page,
    States,
    Stop,
    Refused(&'static str, &'static str),
}

impl Asked {
    /// Reads a whole head; `None` if it is none.
    fn parse(head: &[u8]) -> Option<Self> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        if !request.parse(head).ok()?.is_complete() {
            return None;
        }
        let (method, path) = (request.method?.to_owned(), request.path?.to_owned());
        let all = |name: &str| {
            let named = request.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
            named.map(|header| String::from_utf8_lossy(header.value).into_owned()).collect()
        };
        Some(Self { method, path, host: all("host"), origin: all("origin") })
    }

    fn response(&self, port: u16) -> Response {
        let own = |text: &str| [format!("127.0.0.1:{port}"), format!("localhost:{port}")].iter().any(|own| own == text);
        let own_origin = |text: &String| text.strip_prefix("http://").is_some_and(own);
        if !matches!(self.host.as_slice(), [host] if own(host)) {
            return Response::Refused("421 Misdirected Request", "another host is asked for");
        }
        if !self.origin.iter().all(own_origin) {
            return Response::Refused("403 Forbidden", "a page of another origin asks");
        }
        match (self.method.as_str(), self.path.as_str()) {
            ("GET", "/") => Response::Page,
            ("GET", "/state") => Response::States,
            ("POST", "/stop") if self.origin.is_empty() => Response::Refused("403 Forbidden", "no page asks"),
            ("POST", "/stop") => Response::Stop,
            (_, "/" | "/state" | "/stop") => Response::Refused("405 Method Not Allowed", "no such method"),
            _ => Response::Refused("404 Not Found", "no such page"),
        }
    }
}

fn serve(mut stream: &TcpStream, port: u16, html: &str, shared: &Shared) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(WAIT))?;
    stream.set_write_timeout(Some(WAIT))?;
    let (mut head, mut part) = (Vec::new(), [0; 2048]);
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let count = stream.read(&mut part)?;
        head.extend_from_slice(part.get(..count).unwrap_or_default());
        if count == 0 || head.len() > HEAD {
            return Ok(());
        }
    }
    let Some(asked) = Asked::parse(&head) else {
        return respond(stream, "400 Bad Request", "text/plain", "no request\n");
    };
    match asked.response(port) {
        Response::Page => respond(stream, "200 OK", "text/html; charset=utf-8", html),
        Response::States => states(stream, shared),
        Response::Stop => {
            let wanted = shared.stop(false);
            match shared.until_stopped(wanted, STOP_WAIT) {
                StopOutcome::Confirmed(text) => {
                    respond(stream, "200 OK", "text/plain; charset=utf-8", &format!("confirmed: {text}\n"))
                }
                StopOutcome::NotConfirmed(why) => {
                    let text = format!("NOT CONFIRMED: {why}. Use the emergency stop.\n");
                    respond(stream, "504 Gateway Timeout", "text/plain; charset=utf-8", &text)
                }
            }
        }
        Response::Refused(status, why) => respond(stream, status, "text/plain", &format!("{why}\n")),
    }
}

/// Headers of every response: no frame of another page, no cache, nothing for other origins.
const HEADER: &str = "X-Frame-Options: DENY\r\nContent-Security-Policy: frame-ancestors 'none'\r\nCross-Origin-Resource-Policy: same-origin\r\nX-Content-Type-Options: nosniff\r\n\
                      Referrer-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n";

fn respond(mut stream: &TcpStream, status: &str, kind: &str, body: &str) -> io::Result<()> {
    let length = body.len();
    let head = format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{HEADER}\r\n");
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())
}

/// Sends the state as server-sent events until the browser goes away.
fn states(mut stream: &TcpStream, shared: &Shared) -> io::Result<()> {
    stream.write_all(format!("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{HEADER}\r\n").as_bytes())?;
    let (mut last, mut sent) = (String::new(), Instant::now());
    loop {
        let state = serde_json::to_string(&shared.snapshot())?;
        if state != last || sent.elapsed() >= ALIVE {
            stream.write_all(format!("data: {state}\n\n").as_bytes())?;
            (last, sent) = (state, Instant::now());
        }
        thread::sleep(INTERVAL);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    use super::{Asked, Response, start};
    use crate::session::local::shared::{Demanded, Shared};
    use std::io::{Read as _, Write as _};
    use std::net::{SocketAddr, TcpStream};
    use std::sync::Arc;

    /// Status line and the rest of the response to these lines, in which PORT stands for the port.
    fn answer(address: SocketAddr, lines: &str) -> (String, String) {
        let mut stream = TcpStream::connect(address).unwrap();
        let text = lines.replace("PORT", &address.port().to_string()).replace('\n', "\r\n");
        stream.write_all(format!("{text}\r\n\r\n").as_bytes()).unwrap();
        let mut response = String::new();
        stream.read_to_string(&mut response).unwrap();
        let (status, rest) = response.split_once("\r\n").unwrap();
        (status.to_owned(), rest.to_owned())
    }

    #[test]
    fn only_the_own_page_is_answered_and_only_it_may_stop_the_arm() {
        let shared = Arc::new(Shared::new(None));
        let address = start(0, "<p>the arm".into(), Arc::clone(&shared)).unwrap();
        for (lines, status) in [
            ("GET / HTTP/1.1\nHost: 127.0.0.1:PORT", "200 OK"),
            ("GET / HTTP/1.1\nhost: localhost:PORT", "200 OK"),
            ("GET / HTTP/1.1", "421 Misdirected Request"),
            ("GET / HTTP/1.1\nHost: arm.example:PORT", "421 Misdirected Request"),
            ("GET / HTTP/1.1\nHost: 127.0.0.1", "421 Misdirected Request"),
            ("GET / HTTP/1.1\nHost: 127.0.0.1:PORT\nHost: arm.example", "421 Misdirected Request"),
            ("GET /state HTTP/1.1\nHost: 127.0.0.1:PORT\nOrigin: http://arm.example", "403 Forbidden"),
            ("POST /stop HTTP/1.1\nHost: 127.0.0.1:PORT", "403 Forbidden"),
            ("POST /stop HTTP/1.1\nHost: 127.0.0.1:PORT\nOrigin: null", "403 Forbidden"),
            ("POST /stop HTTP/1.1\nHost: 127.0.0.1:PORT\nOrigin: https://127.0.0.1:PORT", "403 Forbidden"),
            ("POST /stop HTTP/1.1\nHost: 127.0.0.1:PORT\nOrigin: http://127.0.0.1:1", "403 Forbidden"),
            ("POST /stop HTTP/1.1\nHost: arm.example:PORT\nOrigin: http://arm.example:PORT", "421 Misdirected Request"),
            ("GET /stop HTTP/1.1\nHost: 127.0.0.1:PORT\nOrigin: http://127.0.0.1:PORT", "405 Method Not Allowed"),
            ("GET /../etc/passwd HTTP/1.1\nHost: 127.0.0.1:PORT", "404 Not Found"),
            ("nonsense", "400 Bad Request"),
        ] {
            let (found, rest) = answer(address, lines);
            assert_eq!(found, format!("HTTP/1.1 {status}"), "{lines}");
            assert!(rest.contains("X-Frame-Options: DENY") && !rest.contains("Access-Control-Allow"), "{rest}");
        }
        assert_eq!(shared.demanded(), Demanded::default(), "nothing of this stops the arm");
        // Confirmed before it is asked for, as it were.
        shared.stopped(Demanded { calm: 1, emergency: 0 }, Some("holding".into()));
        let (status, rest) =
            answer(address, "POST /stop HTTP/1.1\nHost: localhost:PORT\nOrigin: http://localhost:PORT");
        assert!(status.ends_with("200 OK") && rest.ends_with("confirmed: holding\n"), "{status}: {rest}");
        assert_eq!(shared.demanded(), Demanded { calm: 1, emergency: 0 });
    }

    #[test]
    fn a_request_that_is_cut_off_is_none() {
        assert_eq!(Asked::parse(b"GET / HTTP/1.1\r\nHost: x\r\n"), None);
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(200));
        assert_eq!(Asked::parse(many.as_bytes()), None);
        let asked = Asked::parse(b"GET / HTTP/1.1\r\nHost: localhost:80\r\n\r\n").unwrap();
        assert_eq!(asked.response(80), Response::Page);
    }
}
