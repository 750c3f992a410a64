//! Checks of a robot file in which one mass is in grams: every finding names its line, the reason and the remedy.
//!
//! ```console
//! $ cargo run -p robot-compiler --example check_robot
//! ```

use robot_compiler::FileError;
use robot_compiler::check::{CheckRule, Draft, Finding, Severity, findings};

/// An arm of two links in SI units. The mass of the upper arm is wrong: it should be 2 kg.
const ROBOT: &str = r#"
name = "two links"
source = "made up for this example"

[[joint]]
name = "shoulder"
type = "revolute"
dh = { a = 0.4, alpha = 0.0, d = 0.0, theta = 0.0 }
mass = 2000.0
com = [-0.2, 0.0, 0.0]
inertia = { xx = 0.002, yy = 0.03, zz = 0.03 }
rotor = { inertia = 1e-4, gear = 30.0 }
friction = { viscous = 0.1, coulomb = 0.4 }
limits = { position = [-2.0, 2.0], velocity = 3.0, torque = 40.0 }

[[joint]]
name = "elbow"
type = "revolute"
dh = { a = 0.3, alpha = 0.0, d = 0.0, theta = 0.0 }
mass = 0.9
com = [-0.15, 0.0, 0.0]
inertia = { xx = 0.001, yy = 0.008, zz = 0.008 }
rotor = { inertia = 1e-4, gear = 20.0 }
friction = { viscous = 0.1, coulomb = 0.2 }
limits = { position = [-2.5, 2.5], velocity = 3.0, torque = 20.0 }
"#;

/// Prints and returns all findings, the worst first.
fn check(text: &str) -> Result<Vec<Finding>, FileError> {
    // A draft is the arm as its file describes it. `Robot` would stop at the first impossible value.
    let draft = Draft::from_toml_str(text, "two_links.toml")?;
    // `None`: the loads of the joints are not known, so no rule compares with the weight that they hold.
    let all = findings(&draft, None);
    println!("{} kg, {} m long: {} findings", draft.mass(), draft.length(), all.len());
    for finding in &all {
        println!("{}: [{}] {}", finding.severity.name(), finding.rule.name(), finding.place);
        if let Some(quote) = &finding.quote {
            println!("    found: {quote}");
        }
        println!("    do: {}", finding.place.expected());
    }
    Ok(all)
}

fn main() -> Result<(), FileError> {
    let wrong = check(ROBOT)?;
    // Line 9 of the file is the mass of the first joint's link.
    let named = |finding: &Finding| finding.rule == CheckRule::Unit && finding.place.line_column() == Some((9, 8));
    assert!(wrong.iter().any(named), "2000 kg on an arm of 0.7 m was not reported");

    let corrected = check(&ROBOT.replace("mass = 2000.0", "mass = 2.0"))?;
    assert!(corrected.iter().all(|finding| finding.severity == Severity::Note), "only notes remain");
    Ok(())
}
