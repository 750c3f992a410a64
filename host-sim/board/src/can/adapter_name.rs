//! Adapters by name: opening one, and the line between it and the computer.

use super::adapter::Adapter;
use super::damiao_usb::DamiaoUsb;
use super::gs_usb;
use super::serial_adapter::SerialAdapter;
use super::slcan::Slcan;
use core::fmt;
use core::str::FromStr;
use dynamics_core::drive::bus_time::Identifier;
use std::io;

/// An adapter by its name on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AdapterName {
    /// A network interface of Linux, such as `can0`.
    Socket(String),
    /// An adapter with the text protocol of Lawicel on a serial port, at this baud rate; `None` if its USB is the port, at no rate.
    Slcan(String, Option<u32>),
    /// Damiao's USB adapter on a serial port, at this baud rate.
    Damiao(String, u32),
    /// A channel, counted from 0, of a USB adapter with the protocol gs_usb; `None` instead of its serial number if it is the only one.
    GsUsb(Option<String>, u8),
    /// A simulated arm in this program.
    Simulated,
}

/// Baud rate that is set where the number has no effect.
const ANY_BAUD: u32 = 115_200;

/// Baud rate of Damiao's USB adapter, from the maker's `DM_CAN.py`.
pub const DAMIAO_BAUD: u32 = 921_600;

const EXPECTED: &str = "expected an interface such as can0, slcan:/dev/ttyACM0, slcan:/dev/ttyUSB0@2000000, damiao:/dev/ttyACM0, gs_usb, \
                        gs_usb:SERIAL, gs_usb:SERIAL:CHANNEL, or simulated";

impl FromStr for AdapterName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((kind, port)) = text.split_once(':') else {
            return match text {
                "simulated" => Ok(Self::Simulated),
                "gs_usb" => Ok(Self::GsUsb(None, 0)),
                // IFNAMSIZ of Linux is 16, with the terminating zero.
                _ if !text.is_empty() && text.len() < 16 && !text.contains(['/', ' ', '@']) => {
                    Ok(Self::Socket(text.to_owned()))
                }
                _ => Err(EXPECTED.into()),
            };
        };
        if kind == "gs_usb" {
            return gs_usb_name(port);
        }
        let (path, baud) = match port.rsplit_once('@') {
            None => (port, None),
            Some((path, baud)) => {
                (path, Some(baud.parse().map_err(|_| format!("{baud} is no baud rate; {EXPECTED}"))?))
            }
        };
        if path.is_empty() || baud == Some(0) {
            return Err(EXPECTED.into());
        }
        match kind {
            // These are serial chips, which have a rate.
            "slcan" if baud.is_none() && path.contains("ttyUSB") => {
                Err(format!("{path} is a serial chip: give its baud rate, such as slcan:{path}@2000000"))
            }
            "slcan" => Ok(Self::Slcan(path.to_owned(), baud)),
            "damiao" => Ok(Self::Damiao(path.to_owned(), baud.unwrap_or(DAMIAO_BAUD))),
            _ => Err(format!("{kind} is no kind of adapter; {EXPECTED}")),
        }
    }
}

/// The adapter with this serial number, and a channel.
fn gs_usb_name(text: &str) -> Result<AdapterName, String> {
    let (serial, channel) = text.split_once(':').map_or((text, None), |(serial, channel)| (serial, Some(channel)));
    if serial.is_empty() || serial.contains(|c: char| !c.is_ascii_graphic() || c == '/') {
        return Err(format!("\"{serial}\" is no serial number of a USB adapter; {EXPECTED}"));
    }
    let channel = channel.map_or(Ok(0), str::parse);
    let channel =
        channel.map_err(|_| format!("gs_usb:{text}: expected a channel from 0 to 255 after the serial number"))?;
    Ok(AdapterName::GsUsb(Some(serial.to_owned()), channel))
}

impl fmt::Display for AdapterName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Socket(name) => f.write_str(name),
            Self::Slcan(port, _) => write!(f, "slcan:{port}"),
            Self::Damiao(port, _) => write!(f, "damiao:{port}"),
            Self::GsUsb(None, _) => f.write_str("gs_usb"),
            Self::GsUsb(Some(serial), 0) => write!(f, "gs_usb:{serial}"),
            Self::GsUsb(Some(serial), channel) => write!(f, "gs_usb:{serial}:{channel}"),
            Self::Simulated => f.write_str("simulated"),
        }
    }
}

/// Reason why an adapter cannot be opened.
#[derive(Debug, thiserror::Error)]
#[error("{name}: {source}")]
pub struct AdapterError {
    /// The adapter.
    pub name: AdapterName,
    /// Error of the system.
    pub source: io::Error,
}

impl AdapterError {
    /// Advice for the person at the computer.
    #[must_use]
    pub fn advice(&self) -> String {
        match &self.name {
            AdapterName::Socket(name) => format!(
                "is it there, and up? `ip -details link show {name}` shows it; `sudo ip link set {name} up type can bitrate 1000000` starts it"
            ),
            AdapterName::GsUsb(..) => gs_usb::advice(self.source.kind()).into(),
            _ => port_advice(self.source.kind() == io::ErrorKind::PermissionDenied).into(),
        }
    }
}

/// Advice for a serial port that cannot be opened or does not answer; `forbidden` if it exists, but this user may not open it.
pub(crate) fn port_advice(forbidden: bool) -> &'static str {
    match forbidden {
        true => {
            "give this user the right to it: on most Linux systems `sudo usermod -aG dialout $USER`, then log in again"
        }
        false => "is it plugged in, and not open in another program? `newtau doctor` lists the ports that there are",
    }
}

impl AdapterName {
    /// Opens the adapter and joins the bus at 1 Mbit/s. Sends no frame.
    ///
    /// # Errors
    /// [`AdapterError`]: the adapter does not exist, is in use or may not be opened. [`AdapterName::Simulated`] is opened by its arm.
    pub fn open(&self) -> Result<Box<dyn Adapter>, AdapterError> {
        let opened: io::Result<Box<dyn Adapter>> = match self {
            Self::Slcan(port, baud) => boxed(SerialAdapter::<Slcan>::open(port, baud.unwrap_or(ANY_BAUD))),
            Self::Damiao(port, baud) => boxed(SerialAdapter::<DamiaoUsb>::open(port, *baud)),
            Self::GsUsb(serial, channel) => gs_usb::open(serial.as_deref(), *channel),
            #[cfg(target_os = "linux")]
            Self::Socket(name) => boxed(super::socket::Socket::open(name)),
            #[cfg(not(target_os = "linux"))]
            Self::Socket(_) => {
                Err(io::Error::new(io::ErrorKind::Unsupported, "only Linux has SocketCAN; use gs_usb or slcan:PORT"))
            }
            Self::Simulated => Err(io::Error::new(
                io::ErrorKind::Unsupported,
                "the simulated arm is that of a scene, in `newtau drive SCENE --can simulated`; expected the adapter of real motors",
            )),
        };
        opened.map_err(|source| AdapterError { name: self.clone(), source })
    }

    /// True if both names are channels of one adapter. A program can use one of its channels.
    #[must_use]
    pub fn is_same_adapter(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::GsUsb(serial, _), Self::GsUsb(other, _)) => match (serial, other) {
                (Some(serial), Some(other)) => serial.eq_ignore_ascii_case(other),
                // The only one.
                _ => true,
            },
            _ => self == other,
        }
    }

    /// The line between computer and adapter, if it takes time. A serial port that is named without a baud rate is USB's own, which is faster than the
    /// bus.
    #[must_use]
    pub fn line(&self, identifier: Identifier) -> Option<AdapterLine> {
        match *self {
            Self::Slcan(_, Some(baud)) => {
                let bytes = super::slcan::line_max(identifier);
                // An answer to the command, `z` and its end, comes back too.
                Some(AdapterLine::serial(bytes, bytes + 2, baud))
            }
            Self::Damiao(_, baud) => {
                let (command, reply) =
                    (super::damiao_usb::COMMAND_BYTES as u32, super::damiao_usb::RECEIVED_BYTES as u32);
                Some(AdapterLine::serial(command, reply, baud))
            }
            // A command comes back as an echo.
            Self::GsUsb(..) => {
                let transaction = gs_usb::TRANSACTION_NS;
                Some(AdapterLine { command_ns: 2 * transaction, reply_ns: transaction, is_usb: true })
            }
            _ => None,
        }
    }
}

/// A line between computer and adapter: time of a command and of a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdapterLine {
    command_ns: u64,
    reply_ns: u64,
    is_usb: bool,
}

impl AdapterLine {
    /// A serial line with these bytes at this rate, bit/s. A byte is a start bit, eight bits and a stop bit.
    fn serial(command: u32, reply: u32, baud: u32) -> Self {
        let ns = |bytes: u32| (u64::from(bytes) * 10 * 1_000_000_000).div_ceil(u64::from(baud.max(1)));
        Self { command_ns: ns(command), reply_ns: ns(reply), is_usb: false }
    }

    /// Time of this many commands, ns.
    #[must_use]
    pub fn commands_ns(&self, count: u32) -> u64 {
        u64::from(count) * self.command_ns
    }

    /// Time of a reply, ns.
    #[must_use]
    pub fn reply_ns(&self) -> u64 {
        self.reply_ns
    }

    /// Its name in a message.
    #[must_use]
    pub fn text(&self) -> &'static str {
        if self.is_usb { "on full-speed USB, echoes included" } else { "on the adapter's serial line" }
    }

    /// Delays that its times do not include, for a message.
    #[must_use]
    pub fn unknown(&self) -> &'static str {
        if self.is_usb {
            "; delays of the USB host controller and of the adapter's firmware are not included: they were not measured"
        } else {
            ""
        }
    }
}

fn boxed<A: Adapter + 'static>(adapter: io::Result<A>) -> io::Result<Box<dyn Adapter>> {
    adapter.map(|adapter| Box::new(adapter) as Box<dyn Adapter>)
}
