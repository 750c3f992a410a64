//! Rules about the numbers of an arm: checks of a robot file for impossible, placeholder and missing values.
//!
//! Each rule is a function with its equation, its threshold and the reason for it. A finding gives the value with its unit, and
//! what to measure or write instead. [`findings`] applies all rules to all links.
//!
//! | module | rules |
//! |---|---|
//! | `body` | masses, inertia tensors, mass centres |
//! | `limits` | limits that are impossible, placeholders, missing, or too wide |
//! | `load` | torque that holds the arm |
//! | `drives` | rotors, friction, resolution of torque and position |
//! | `heat` | continuous torque of the motors, and the pose in which the arm rests without torque |
//! | `units` | angles beyond a turn, lengths, masses and rotors that are a power of ten off |
//! | `remarks` | remarks of the reader: unknown names, held joints, open questions |
//! | `scene` | settings of a scene: the first motion, and the age of live inputs |

mod amount;
mod body;
mod drives;
mod finding;
mod heat;
mod limits;
mod load;
mod remarks;
mod scene;
mod units;

pub use crate::describe::draft::Draft;
pub use finding::{CheckRule, Finding, JointLoad, Severity};
pub use heat::on_stop_distance;
pub use scene::{gravity_finding, scene_findings};

/// All findings, the worst first, then by rule and position in the file.
///
/// `loads` has an entry for every joint. Without it, the rules that compare with a load find nothing.
#[must_use]
pub fn findings(draft: &Draft, loads: Option<&[JointLoad]>) -> Vec<Finding> {
    let mut all = body::findings(draft);
    all.extend(limits::findings(draft, loads));
    all.extend(drives::findings(draft, loads));
    all.extend(heat::findings(draft, loads));
    all.extend(loads.map(|loads| load::findings(draft, loads)).unwrap_or_default());
    all.extend(units::findings(draft, loads));
    all.extend(remarks::findings(draft));
    follow_from_a_unit(draft, &mut all);
    all.sort_by_key(|finding| (finding.severity, finding.rule, finding.place.line_column()));
    all
}

/// Removes the findings that follow from a wrong unit: advice about them would mislead.
///
/// With lengths in mm, every tensor is nearly a point and every torque too small; a mass centre or a mass in another unit has similar effects.
fn follow_from_a_unit(draft: &Draft, all: &mut Vec<Finding>) {
    let unit = |finding: &Finding| {
        finding.rule == CheckRule::Unit
            || (finding.rule == CheckRule::MassCentre && finding.severity == Severity::Wrong)
    };
    if !all.iter().any(unit) {
        return;
    }
    let far: Vec<String> = all
        .iter()
        .filter(|finding| finding.rule == CheckRule::MassCentre && finding.severity == Severity::Wrong)
        .map(|finding| link_of(finding).to_owned())
        .collect();
    let lengths = draft.length() > units::LONGEST;
    all.retain(|finding| match finding.rule {
        CheckRule::Holding | CheckRule::Heat | CheckRule::TorqueStep | CheckRule::PositionStep => {
            finding.severity == Severity::Note
        }
        CheckRule::Gyration if far.iter().any(|link| link == link_of(finding)) => finding.severity == Severity::Note,
        CheckRule::Gyration | CheckRule::InertiaAtJoint | CheckRule::MassCentre | CheckRule::SwappedAxes => {
            !lengths || finding.severity == Severity::Note
        }
        CheckRule::Placeholder => !finding.place.problem().contains("though gravity loads"),
        _ => true,
    });
}

/// The link or joint that a finding's field belongs to.
fn link_of(finding: &Finding) -> &str {
    let field = finding.place.field();
    field.rsplit_once('.').map_or(field, |(link, _)| link)
}
