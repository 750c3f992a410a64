//! USB by the crate `nusb`.

use super::plugged::{EndpointFacts, Endpoints, PRODUCTS, choose, endpoints};
use super::transport::Transport;
use core::task::{Context, Poll, Waker};
use nusb::descriptors::TransferType;
use nusb::transfer::{
    Buffer, Bulk, Completion, ControlIn, ControlOut, ControlType, EndpointDirection, In, Out, Recipient, TransferError,
};
use nusb::{DeviceInfo, Endpoint, ErrorKind, Interface, MaybeFuture as _};
use std::io;
use std::thread;
use std::time::Duration;

/// Number of the interface with this protocol.
const INTERFACE: u8 = 0;

/// Longest time of a control request. Linux allows the same.
const CONTROL_TIMEOUT: Duration = Duration::from_secs(1);

/// Transfers from the adapter that wait in the system. A tick has at most six echoes and as many replies; candleLight has 64 buffers.
const INPUTS: usize = 64;

/// Longest wait for the end of cancelled transfers, ms.
const CANCELLING_MAX_MS: u32 = 20;

/// Interface 0 of an adapter.
pub(super) struct Usb {
    interface: Interface,
    input: Endpoint<Bulk, In>,
    output: Endpoint<Bulk, Out>,
    /// Buffers of transfers to the adapter that have ended.
    free: Vec<Buffer>,
}

impl Usb {
    /// Takes the adapter with this serial number, or the only one.
    ///
    /// # Errors
    /// There is no such adapter, or several; it is in use, or may not be opened.
    pub(super) fn open(serial: Option<&str>) -> io::Result<Self> {
        let found: Vec<DeviceInfo> = nusb::list_devices().wait().map_err(no_usb)?.filter(is_ours).collect();
        let serials: Vec<Option<&str>> = found.iter().map(DeviceInfo::serial_number).collect();
        let at = choose(&serials, serial)?;
        let info = found.get(at).ok_or(io::ErrorKind::NotFound)?;
        #[cfg(target_os = "linux")]
        super::kernel_driver::check(info.sysfs_path())?;
        // Linux, macOS: the thread in which nusb completes transfers gets the priority of the one that opens the first device. On Windows it is one of
        // the system's, without priority.
        thread::scope(|scope| {
            let opening = scope.spawn(|| {
                crate::real_time::raise_priority().ok();
                Self::take(info)
            });
            opening.join().unwrap_or_else(|_| Err(io::Error::other("the thread that opens the adapter panicked")))
        })
    }

    fn take(info: &DeviceInfo) -> io::Result<Self> {
        let device = info.open().wait().map_err(|error| match error.kind() {
            ErrorKind::PermissionDenied => forbidden(info),
            _ => error.into(),
        })?;
        let interface = device.claim_interface(INTERFACE).wait().map_err(|error| match error.kind() {
            ErrorKind::Busy => {
                io::Error::new(io::ErrorKind::ResourceBusy, "another program or a driver of the system uses it")
            }
            _ => error.into(),
        })?;
        let facts: Vec<EndpointFacts> = interface
            .descriptor()
            .iter()
            .flat_map(nusb::descriptors::InterfaceDescriptor::endpoints)
            .map(|it| EndpointFacts {
                address: it.address(),
                is_bulk: it.transfer_type() == TransferType::Bulk,
                packet: it.max_packet_size(),
            })
            .collect();
        let Endpoints { input, input_bytes, output } = endpoints(&facts)?;
        let (mut input, output) = (interface.endpoint(input)?, interface.endpoint(output)?);
        for _ in 0..INPUTS {
            input.submit(Buffer::new(input_bytes));
        }
        Ok(Self { interface, input, output, free: Vec::new() })
    }

    /// Takes back the transfers to the adapter that have ended.
    fn reap(&mut self) -> io::Result<()> {
        while let Some(Completion { buffer, status, .. }) = ended(&mut self.output) {
            status.map_err(failed)?;
            self.free.push(buffer);
        }
        Ok(())
    }
}

fn no_usb(error: nusb::Error) -> io::Error {
    io::Error::new(io::ErrorKind::Unsupported, format!("this system lists no USB devices: {error}"))
}

fn is_ours(info: &DeviceInfo) -> bool {
    PRODUCTS.contains(&(info.vendor_id(), info.product_id()))
}

/// The next transfer that has ended; does not wait.
fn ended<D: EndpointDirection>(endpoint: &mut Endpoint<Bulk, D>) -> Option<Completion> {
    if endpoint.pending() == 0 {
        return None;
    }
    match endpoint.poll_next_complete(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(completion) => Some(completion),
        Poll::Pending => None,
    }
}

fn failed(error: TransferError) -> io::Error {
    match error {
        TransferError::Disconnected => io::Error::new(io::ErrorKind::NotConnected, error),
        _ => error.into(),
    }
}

/// The error of an adapter that this user may not open, with the rule that Linux needs.
fn forbidden(info: &DeviceInfo) -> io::Error {
    let (vendor, product) = (info.vendor_id(), info.product_id());
    let rule = if cfg!(target_os = "linux") { super::plugged::udev_rule(vendor, product) } else { String::new() };
    io::Error::new(io::ErrorKind::PermissionDenied, format!("this user may not open it{rule}"))
}

impl Transport for Usb {
    fn control_out(&mut self, request: u8, value: u16, data: &[u8]) -> io::Result<()> {
        let out = ControlOut {
            control_type: ControlType::Vendor,
            recipient: Recipient::Interface,
            request,
            value,
            index: INTERFACE.into(),
            data,
        };
        self.interface.control_out(out, CONTROL_TIMEOUT).wait().map_err(failed)
    }

    fn control_in(&mut self, request: u8, value: u16, length: u16) -> io::Result<Vec<u8>> {
        let input = ControlIn {
            control_type: ControlType::Vendor,
            recipient: Recipient::Interface,
            request,
            value,
            index: INTERFACE.into(),
            length,
        };
        self.interface.control_in(input, CONTROL_TIMEOUT).wait().map_err(failed)
    }

    fn submit(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.reap()?;
        let mut buffer = self.free.pop().unwrap_or_else(|| Buffer::new(64));
        buffer.clear();
        buffer.extend_from_slice(bytes);
        self.output.submit(buffer);
        Ok(())
    }

    fn receive(&mut self, bytes: &mut Vec<u8>) -> io::Result<bool> {
        self.reap()?;
        let Some(Completion { buffer, status, .. }) = ended(&mut self.input) else { return Ok(false) };
        status.map_err(failed)?;
        bytes.clear();
        bytes.extend_from_slice(&buffer);
        self.input.submit(buffer);
        Ok(true)
    }

    fn cancel(&mut self) {
        self.output.cancel_all();
        for _ in 0..CANCELLING_MAX_MS {
            while ended(&mut self.output).is_some() {}
            if self.output.pending() == 0 {
                return;
            }
            thread::sleep(Duration::from_millis(1));
        }
    }
}
