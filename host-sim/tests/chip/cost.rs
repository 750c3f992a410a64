//! Cost of the tick on the chip for many scenes: compared with the desk's bits and the firmware's instruction count.

use crate::pinned;
use indicatif::ProgressBar;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::trade::chip::cost::{Cost, MeasuredCost, measure};

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

fn measured(scenes: &[PathBuf]) -> Vec<MeasuredCost> {
    let costs = measure(scenes, &AtomicBool::new(false), &ProgressBar::hidden());
    let costs = costs.map_err(|failure| format!("{:?}", failure.report())).unwrap();
    for (scene, MeasuredCost { cost, .. }) in scenes.iter().zip(&costs) {
        let name = scene.file_stem().unwrap_or_default().to_string_lossy();
        println!("{name}: {} instructions, {} bytes of flash, {} of RAM", cost.instructions, cost.flash, cost.ram);
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
    ];
    let mut costs = measured(&scenes);
    // Measured states instead of encoder counts.
    costs.extend(measured(&[top().join("scenes/planar2r_swing.toml")]));
    assert!(costs.iter().all(|found| found.cost.matches_desk && found.fault.is_none()));
    let fewest = costs[0].instructions_min;
    let costs: Vec<_> = costs.into_iter().map(|found| found.cost).collect();
    let [exact, regrouped, generic, libm, double, planar] = costs.as_slice() else { unreachable!("six scenes") };

    // A tick that is called alone, not by the session, is a little shorter than the firmware's.
    let [_, firmware] = pinned::instructions("puma560_pick");
    assert_eq!(fewest, exact.instructions_max, "every tick takes the same");
    assert!(
        (firmware.start() * 95 / 100..=*firmware.end()).contains(&exact.instructions_max),
        "{exact:?}, {firmware:?}"
    );
    let most = |cost: &Cost| cost.instructions_max;
    assert!(most(regrouped) < most(exact) && most(exact) < most(generic));
    assert!(most(planar) < most(regrouped));
    // Software double precision: only in sine and cosine, and everywhere.
    assert!(most(libm) > 3 * most(exact), "{} instructions", most(libm));
    assert!(double.instructions > 10.0 * exact.instructions, "{double:?}");

    assert!((12_000..14_000).contains(&exact.flash), "{exact:?}");
    assert!((370..430).contains(&exact.ram), "{exact:?}");
    // RAM holds only the controller.
    assert_eq!(regrouped.ram, exact.ram);
    assert!(double.ram > exact.ram && generic.ram > exact.ram + 1_000);
    assert!(regrouped.flash < exact.flash && exact.flash < libm.flash);
    assert!(planar.flash < regrouped.flash && double.flash > 2 * exact.flash);
}

#[test]
fn a_scene_that_cannot_be_read_is_named_with_its_line() {
    let path = variant("puma560_pick", "bad", &[("law", "none")]);
    let failure = measure(std::slice::from_ref(&path), &AtomicBool::new(false), &ProgressBar::hidden()).unwrap_err();
    let said = failure.report().to_string();
    assert!(said.contains("cost_puma560_pick_bad.toml:") && said.contains("law"), "{said}");
}
