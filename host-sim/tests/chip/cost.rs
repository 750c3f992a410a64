//! Cost of the tick on the chip for many scenes: compared with the desk's bits and the firmware's instruction count.

use crate::pinned;
use board::chip::cost::{Cost, measure};
use indicatif::ProgressBar;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A shipped scene with some lines of its `[control]` replaced.
fn variant(scene: &str, name: &str, control: &[(&str, &str)]) -> PathBuf {
    let mut text = std::fs::read_to_string(top().join(format!("scenes/{scene}.toml"))).unwrap();
    let robots = top().join("robots").canonicalize().unwrap();
    text = text.replace("../robots", robots.to_str().unwrap());
    for (key, value) in control {
        text = text
            .lines()
            .filter(|line| !line.starts_with(&format!("{key} =")))
            .map(|line| format!("{line}\n"))
            .collect();
        text = text.replace("[control]\n", &format!("[control]\n{key} = \"{value}\"\n"));
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cost_{scene}_{name}.toml"));
    std::fs::write(&path, text).unwrap();
    path
}

fn measured(scenes: &[PathBuf]) -> Vec<Cost> {
    let costs = measure(scenes, &AtomicBool::new(false), &ProgressBar::hidden());
    let costs = costs.map_err(|failure| format!("{:?}", failure.report())).unwrap();
    for (scene, cost) in scenes.iter().zip(&costs) {
        let name = scene.file_stem().unwrap_or_default().to_string_lossy();
        println!("{name}: {:?}, {} bytes of flash, {} of RAM", cost.instructions, cost.flash_bytes, cost.ram_bytes);
    }
    assert_eq!(costs.len(), scenes.len());
    costs
}

#[test]
fn ticks_give_the_desks_bits_and_cost_what_the_firmware_pins() {
    let puma = |name: &str, control: &[(&str, &str)]| variant("puma560_pick", name, control);
    let scenes = [
        puma("exact", &[]),
        puma("regrouped", &[("kernel", "regrouped")]),
        puma("generic", &[("kernel", "generic")]),
        puma("libm", &[("trig", "libm")]),
        puma("f64", &[("scalar", "f64")]),
        puma("sram", &[("kernel_memory", "sram")]),
    ];
    let mut costs = measured(&scenes);
    // Measured states instead of encoder counts.
    costs.extend(measured(&[top().join("scenes/planar2r_swing.toml")]));
    assert!(costs.iter().all(|cost| cost.matches_desk && cost.fault.is_none()));
    let [exact, regrouped, generic, libm, double, sram, planar] = costs.as_slice() else {
        unreachable!("seven scenes")
    };

    let Cost { instructions, .. } = exact;
    // A tick that is called alone, not by the session, is a little shorter than the firmware's.
    let [_, firmware] = pinned::instructions("puma560_pick");
    assert_eq!(instructions.min, instructions.max, "every tick takes the same");
    assert!(
        (firmware.start() * 95 / 100..=*firmware.end()).contains(&instructions.max),
        "{instructions:?}, {firmware:?}"
    );
    let most = |cost: &Cost| cost.instructions.max;
    assert!(most(regrouped) < most(exact) && most(exact) < most(generic));
    assert!(most(planar) < most(regrouped));
    // Software double precision: only in sine and cosine, and everywhere.
    assert!(most(libm) > 3 * most(exact), "{} instructions", most(libm));
    assert!(double.instructions.mean > 10.0 * exact.instructions.mean, "{:?}", double.instructions);

    assert!((12_000..14_000).contains(&exact.flash_bytes), "{exact:?}");
    assert!((370..430).contains(&exact.ram_bytes), "{exact:?}");
    // A kernel in RAM also occupies flash. Otherwise RAM holds only the controller.
    assert_eq!(regrouped.ram_bytes, exact.ram_bytes);
    assert!(sram.ram_bytes > exact.ram_bytes + 1_000);
    assert!(double.ram_bytes > exact.ram_bytes && generic.ram_bytes > exact.ram_bytes + 1_000);
    assert!(regrouped.flash_bytes < exact.flash_bytes && exact.flash_bytes < libm.flash_bytes);
    assert!(planar.flash_bytes < regrouped.flash_bytes && double.flash_bytes > 2 * exact.flash_bytes);
}

#[test]
fn a_scene_that_cannot_be_read_is_named_with_its_line() {
    let path = variant("puma560_pick", "bad", &[("law", "none")]);
    let failure = measure(std::slice::from_ref(&path), &AtomicBool::new(false), &ProgressBar::hidden()).unwrap_err();
    let said = failure.report().to_string();
    assert!(said.contains("cost_puma560_pick_bad.toml:") && said.contains("law"), "{said}");
}
