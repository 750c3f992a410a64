//! Choice of an adapter by its serial number, and of its endpoints.

use std::io;

/// Vendor and product of adapters with this protocol (Linux, table of identifiers in `gs_usb.c`).
pub(super) const PRODUCTS: [(u16, u16); 4] = [(0x1D50, 0x606F), (0x1209, 0x2323), (0x1CD2, 0x606F), (0x16D0, 0x10B8)];

/// Chooses the adapter with this serial number, or the only one, from the serial numbers of all that are plugged in. Returns its index.
///
/// # Errors
/// There is none, or more than one.
pub(super) fn choose(serials: &[Option<&str>], wanted: Option<&str>) -> io::Result<usize> {
    // Systems differ in the case of letters.
    let is_wanted = |serial: &Option<&str>| match wanted {
        Some(wanted) => serial.is_some_and(|serial| serial.eq_ignore_ascii_case(wanted)),
        None => true,
    };
    let mut found = serials.iter().enumerate().filter(|(_, serial)| is_wanted(serial)).map(|(at, _)| at);
    let names = || {
        let name =
            |serial: &Option<&str>| serial.map_or("one without a serial number".into(), |it| format!("gs_usb:{it}"));
        serials.iter().map(name).collect::<Vec<_>>().join(", ")
    };
    match (found.next(), found.next(), wanted) {
        (Some(at), None, _) => Ok(at),
        (Some(_), Some(_), None) => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("{} such adapters are plugged in, expected the name of one: {}", serials.len(), names()),
        )),
        (Some(_), Some(_), Some(_)) => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "several adapters with this serial number are plugged in, expected one",
        )),
        (None, ..) if serials.is_empty() => {
            Err(io::Error::new(io::ErrorKind::NotFound, "no adapter with the protocol gs_usb is plugged in"))
        }
        (None, ..) => Err(io::Error::new(
            io::ErrorKind::NotFound,
            format!("no adapter with this serial number is plugged in, but {}", names()),
        )),
    }
}

/// Text with the rule by which Linux lets users open an adapter of this vendor and product.
pub(super) fn udev_rule(vendor: u16, product: u16) -> String {
    format!(
        ": write the line `SUBSYSTEM==\"usb\", ATTR{{idVendor}}==\"{vendor:04x}\", ATTR{{idProduct}}==\"{product:04x}\", MODE=\"0660\", \
         GROUP=\"dialout\", TAG+=\"uaccess\"` into /etc/udev/rules.d/70-gs_usb.rules, then `sudo udevadm control --reload`, and plug it in again"
    )
}

/// An endpoint, from its descriptor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct EndpointFacts {
    /// Address; bit 7 is set if the adapter sends.
    pub(super) address: u8,
    /// True for a bulk endpoint.
    pub(super) is_bulk: bool,
    /// Largest packet, bytes.
    pub(super) packet: usize,
}

/// Endpoints of an adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Endpoints {
    /// Address of the endpoint that the adapter sends from.
    pub(super) input: u8,
    /// Bytes to request there: whole packets that hold any classic frame, padded or not.
    pub(super) input_bytes: usize,
    /// Address of the endpoint that the adapter receives at.
    pub(super) output: u8,
}

/// Smallest number of requested bytes.
const INPUT_MIN: usize = 64;

/// Chooses the first bulk endpoint of either direction. Firmwares differ in the addresses.
///
/// # Errors
/// One is missing, or its packets have no bytes.
pub(super) fn endpoints(all: &[EndpointFacts]) -> io::Result<Endpoints> {
    let first = |sends: bool| all.iter().find(|it| it.is_bulk && it.packet > 0 && (it.address & 0x80 != 0) == sends);
    match (first(true), first(false)) {
        (Some(input), Some(output)) => Ok(Endpoints {
            input: input.address,
            input_bytes: INPUT_MIN.div_ceil(input.packet) * input.packet,
            output: output.address,
        }),
        _ => Err(io::Error::new(
            io::ErrorKind::InvalidData,
            format!("interface 0 lacks a bulk endpoint, expected one in each direction: found {all:?}"),
        )),
    }
}
