//! Check that Linux's own driver does not have an adapter.

use std::fs;
use std::io;
use std::path::Path;

/// Checks that an adapter has no network interface. `device` is its folder in `/sys`.
///
/// # Errors
/// The kernel's driver has it; the error names its interfaces.
pub(super) fn check(device: &Path) -> io::Result<()> {
    let found = interfaces(device);
    if found.is_empty() {
        return Ok(());
    }
    let options: Vec<_> = found.iter().map(|name| format!("`--can {name}`")).collect();
    Err(io::Error::new(
        io::ErrorKind::ResourceBusy,
        format!("the kernel's driver gs_usb has this adapter: use {} instead", options.join(" or ")),
    ))
}

/// Network interfaces of a USB device: `DEVICE/*:1.0/net/*`.
fn interfaces(device: &Path) -> Vec<String> {
    let entries = |path: &Path| fs::read_dir(path).into_iter().flatten().flatten();
    let mut found: Vec<String> = entries(device)
        .filter(|entry| entry.file_name().to_string_lossy().contains(':'))
        .flat_map(|entry| entries(&entry.path().join("net")))
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    found.sort_unstable();
    found
}
