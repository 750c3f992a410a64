//! The tools on this machine: compiler, emulator, probe, ports.

use super::program::{Answer, ask, first_line};
use super::{Check, State, Use};
use std::path::{Path, PathBuf};

/// Compiler target of the chip: Cortex-M4 with a single-precision unit.
const TARGET: &str = "thumbv7em-none-eabihf";

/// Oldest supported compiler, `1.95`, from the workspace's manifest.
const RUST_MIN: &str = env!("CARGO_PKG_RUST_VERSION");

/// Debian's compiler and, in its sysroot, a source file of its core library: the fallback of `cargo xtask`.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const CORE_SOURCE: &str = "lib/rustlib/src/rust/library/core/src/lib.rs";

/// Checks of every tool, needed for these uses or not.
#[must_use]
pub fn checks(uses: &[Use]) -> Vec<Check> {
    let chip = uses.contains(&Use::Emulator) || uses.contains(&Use::Flash);
    let flash = uses.contains(&Use::Flash);
    let mut checks = vec![
        rust(),
        chip_target(chip),
        tool("emulator", "qemu-system-arm", uses.contains(&Use::Emulator), "`cargo xtask setup` installs it"),
        tool("probe-rs", "probe-rs", flash, "`cargo install probe-rs-tools --locked`"),
    ];
    checks.extend(probe(flash));
    checks.push(serial_ports());
    checks
}

/// Check of a program by its version.
fn tool(name: &'static str, program: &str, needed: bool, advice: &str) -> Check {
    match ask(program, &["--version"]) {
        Answer::Said(text) => Check::ok(name, first_line(&text)),
        Answer::Failed(why) => Check::wrong(name, needed, format!("{program} {why}"), advice),
        Answer::Missing => Check::wrong(name, needed, format!("no {program} on the path"), advice),
    }
}

fn rust() -> Check {
    const ADVICE: &str = "install a newer Rust: https://rustup.rs, or `rustup update`";
    match tool("rust", "rustc", true, ADVICE) {
        Check { state: State::Ok, found, .. } if !is_new_enough(&found) => {
            Check::wrong("rust", true, format!("{found}, expected {RUST_MIN} or newer"), ADVICE)
        }
        check => check,
    }
}

/// True if `rustc 1.95.0 (...)` is as new as the workspace requires.
fn is_new_enough(text: &str) -> bool {
    let number = |version: &str| {
        let mut parts = version.split('.').map(str::parse::<u32>);
        Some((parts.next()?.ok()?, parts.next()?.ok()?))
    };
    let found = text.split(' ').nth(1).and_then(number);
    found.is_some_and(|found| number(RUST_MIN).is_some_and(|oldest| found >= oldest))
}

/// Searches for the target in the same two locations, in the same order, as the builds in host-sim/firmware-image/src/toolchain.rs.
fn chip_target(needed: bool) -> Check {
    let sysroot = |rustc| ask(rustc, &["--print", "sysroot"]).said().map(PathBuf::from);
    if sysroot("rustc").is_some_and(|root| root.join("lib/rustlib").join(TARGET).join("lib").is_dir()) {
        return Check::ok("chip target", format!("{TARGET}, installed in rustup's tool chain"));
    }
    let with_source = || {
        let version = ask(DEBIAN_RUSTC, &["--version"]).said().filter(|text| is_new_enough(text))?;
        let sources = [Some(PathBuf::from("/usr")), sysroot(DEBIAN_RUSTC)];
        let source = sources.iter().flatten().any(|root| root.join(CORE_SOURCE).is_file());
        (source && Path::new("/usr/bin/cargo").is_file())
            .then(|| version.split(' ').take(2).collect::<Vec<_>>().join(" "))
    };
    match with_source() {
        Some(version) => Check::ok("chip target", format!("{TARGET}, core built from source by Debian's {version}")),
        None => Check::wrong(
            "chip target",
            needed,
            format!("no {TARGET}"),
            format!("`rustup target add {TARGET}`, or let `cargo xtask setup` find a way"),
        ),
    }
}

/// Check of the connected probes; `None` without the tool, because the tool's own check reports that.
fn probe(needed: bool) -> Option<Check> {
    let text = match ask("probe-rs", &["list"]) {
        Answer::Missing => return None,
        Answer::Failed(why) => {
            return Some(Check::wrong(
                "probe",
                needed,
                format!("probe-rs list {why}"),
                "run `probe-rs list` to see more",
            ));
        }
        Answer::Said(text) => text,
    };
    // `[0]: STLink V3 -- 0483:374e:0030004A3432511630343838 (ST-LINK)`
    let probes: Vec<&str> = text.lines().filter(|line| line.starts_with('[')).collect();
    Some(if probes.is_empty() {
        Check::wrong(
            "probe",
            needed,
            "none connected",
            "connect an ST-LINK, J-Link or CMSIS-DAP probe to the board and this machine",
        )
    } else if probes.iter().all(|probe| probe.ends_with("(inaccessible)")) {
        Check::wrong(
            "probe",
            needed,
            probes.join("; "),
            "give this user the right to it: https://probe.rs/docs/getting-started/probe-setup",
        )
    } else {
        Check::ok("probe", probes.join("; "))
    })
}

/// Checks the serial ports. Finding none is no problem: a named port is opened even if it is not in this list.
fn serial_ports() -> Check {
    const ADVICE: &str = "connect a USB-to-serial adapter (3.3 V) to the board's link pins: docs/flash.md";
    match serialport::available_ports() {
        Ok(ports) if ports.is_empty() => Check::wrong("serial ports", false, "none", ADVICE),
        Ok(ports) => {
            Check::ok("serial ports", ports.into_iter().map(|port| port.port_name).collect::<Vec<_>>().join(", "))
        }
        Err(error) => Check::wrong("serial ports", false, format!("cannot be listed: {error}"), "name one by --port"),
    }
}

#[cfg(test)]
mod tests {
    use super::is_new_enough;

    #[test]
    fn versions_compare_as_numbers_and_from_the_workspace_s_on() {
        for (text, expected) in [
            ("rustc 1.95.0 (59807616e 2026-04-14)", true),
            ("rustc 1.100.0", true),
            ("rustc 2.0.0", true),
            ("rustc 1.94.9", false),
            ("rustc 1.9.0", false),
            ("rustc one", false),
            ("", false),
        ] {
            assert_eq!(is_new_enough(text), expected, "{text}");
        }
    }
}
