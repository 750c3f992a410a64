//! USB adapters with the protocol gs_usb: candleLight, CANable with its firmware, and others. No driver of the system is needed.
//!
//! Each classic frame is one USB transfer, in either direction. The adapter returns every sent frame as an echo. An echo means that the frame has left the
//! adapter's queue. In candleLight it has then only reached one of three transmit mailboxes: **an echo does not prove that a frame was sent**. So up to
//! three frames may wait on a bus without any acknowledgement and look sent; the next ones get no echo, and the adapter counts as off after
//! [`UNSENT_MAX`](super::adapter::UNSENT_MAX) ticks.
//!
//! **An adapter that is off is emptied**: at bus-off, after too many ticks with unsent frames, and after a USB error. A thread cancels the transfers that
//! have not begun and resets the channel. In most firmware a reset drops no frames, so the thread then starts the channel without the bus
//! ([`requests`]), and they come back. The same is done before a session. So no old torque follows when drives answer again. The adapter stays off until
//! it is opened again.
//!
//! **Linux** has a driver for these adapters, which makes a network interface of each channel. If it has the adapter, opening fails and names the interface.
//! The driver is not detached, for two reasons: another program may use the interface, and a program that is killed cannot attach the driver again.
//!
//! | module | holds |
//! |---|---|
//! | [`bit_timing`] | limits of an adapter's bit timing, and the timing for 1 Mbit/s |
//! | [`channel`] | a channel as an [`Adapter`](super::adapter::Adapter) |
//! | [`host_frame`] | frames, echoes and errors as the bytes of a transfer |
//! | `kernel_driver` | the check that Linux's driver does not have the adapter |
//! | [`plugged`] | choice of an adapter by its serial number, and of its endpoints |
//! | [`requests`] | control requests that start and reset a channel |
//! | [`transport`] | interface to USB |
//! | `usb` | USB by the crate `nusb` |
//!
//! Sources: `drivers/net/can/usb/gs_usb.c` of Linux; `candle-usb/candleLight_fw`, `include/gs_usb.h`, `src/usbd_gs_can.c` and `src/can_common.c`. Nothing was
//! tried on hardware. The CANtact Pro with its first firmware needs a byte more in each transfer without saying so; it is not supported.

mod bit_timing;
mod channel;
mod host_frame;
#[cfg(target_os = "linux")]
mod kernel_driver;
mod plugged;
mod requests;
mod transport;
#[cfg(any(target_os = "linux", target_os = "macos", target_os = "windows"))]
mod usb;

use super::adapter::Adapter;
use std::io;

/// Time of one bulk transaction with a frame on full-speed USB, ns: 20 bytes and 13 of the protocol (USB 2.0, table 5-9) at 12 Mbit/s, with a stuff bit
/// after every six bits. Computed, not measured. The time until a host controller begins it is unknown, and so is the firmware's.
pub(super) const TRANSACTION_NS: u64 = (20 + 13) * 8 * 7 * 1000 / (6 * 12);

/// Opens a channel of the adapter with this serial number, or of the only one, and joins the bus at 1 Mbit/s.
///
/// # Errors
/// No such adapter, or several; it is in use or may not be opened; its answers are wrong.
pub(super) fn open(serial: Option<&str>, channel: u8) -> io::Result<Box<dyn Adapter>> {
    #[cfg(any(target_os = "linux", target_os = "macos", target_os = "windows"))]
    return Ok(Box::new(channel::GsUsb::start(usb::Usb::open(serial)?, channel)?));
    #[cfg(not(any(target_os = "linux", target_os = "macos", target_os = "windows")))]
    {
        let _ = (serial, channel);
        Err(io::Error::new(io::ErrorKind::Unsupported, "gs_usb needs Linux, macOS or Windows; use slcan:PORT"))
    }
}

/// Advice for the person at the computer, by the kind of an error of [`open`].
pub(super) fn advice(kind: io::ErrorKind) -> &'static str {
    match kind {
        io::ErrorKind::PermissionDenied => {
            "`uaccess` admits the person at the computer, and the group also a login over the network; another group is as good"
        }
        io::ErrorKind::NotFound => {
            "is it plugged in, and does its firmware speak gs_usb? Adapters with slcan are serial ports: `--can slcan:PORT`"
        }
        io::ErrorKind::InvalidInput => "name one of them by its serial number",
        io::ErrorKind::ResourceBusy => {
            "a network interface of Linux starts with `sudo ip link set can0 up type can bitrate 1000000`; another program must end first"
        }
        io::ErrorKind::Unsupported => {
            "a container or a virtual machine must be given the USB device; on Windows the adapter needs the driver WinUSB, which Windows installs by itself for candleLight"
        }
        _ => "unplug it and plug it in again, and check that its firmware is up to date",
    }
}

#[cfg(test)]
mod earlier_program_tests;
#[cfg(test)]
mod protocol_tests;
#[cfg(test)]
mod session_tests;
#[cfg(test)]
mod simulated;
#[cfg(test)]
mod tests;
