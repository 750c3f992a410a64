//! The firmware's own functions that copy and clear memory, in the emulated chip.

use firmware_image::child_process::ChildProcess;
use firmware_image::toolchain;
use std::process::Command;
use std::time::Duration;

#[test]
fn every_length_address_and_overlap_is_copied_right_and_nothing_beside_it() {
    let mut cargo = toolchain::Toolchain::find_or_install().unwrap().cargo("build");
    cargo.args(["--quiet", "--locked", "--package", "probe", "--features", "copy"]);
    let elf = toolchain::build(&mut cargo, toolchain::product("probe-copy")).unwrap();
    let mut emulator = Command::new("qemu-system-arm");
    emulator.args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "null"]);
    emulator.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(elf);
    let output = ChildProcess::output(&emulator, Duration::from_secs(60), true).unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(said.trim(), "10854 calls are right");
}
