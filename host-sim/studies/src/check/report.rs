//! Findings in text and JSON.

use super::{CLASS_I, CheckResult, Hazard};
use robot_compiler::check::{Finding, Severity};
use serde::Serialize;

/// Severities of the robot or of the scene, the worst first, with their meaning.
const MEANINGS: [(Severity, bool, &str); 5] = [
    (Severity::Wrong, false, "no physics allows it, the arm cannot hold itself, or a name is misspelt"),
    (Severity::Wrong, true, "the scene's controller cannot hold the arm"),
    (Severity::Doubt, false, "improbable"),
    (Severity::Note, false, "missing: measure it"),
    (Severity::Note, true, "settings of the scene: think about them before the arm is armed"),
];

/// The findings as JSON.
#[derive(Debug, Serialize)]
struct Report<'a> {
    robot: &'a str,
    gravity: [f64; 3],
    wrong: usize,
    doubts: usize,
    notes: usize,
    findings: Vec<FindingRow<'a>>,
    hazard: Option<&'a Hazard>,
    class_i: ClassI,
}

/// Limits of class I of ISO 10218-1:2025 as JSON: kg, N, m/s.
#[derive(Debug, Serialize)]
struct ClassI {
    mass: f64,
    force: f64,
    speed: f64,
}

/// A finding as JSON.
#[derive(Debug, Serialize)]
struct FindingRow<'a> {
    severity: &'static str,
    rule: &'static str,
    file: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<usize>,
    field: &'a str,
    problem: &'a str,
    advice: &'a str,
}

impl CheckResult {
    /// The findings, grouped by severity, and their count.
    #[must_use]
    pub fn text(&self) -> String {
        let [x, y, z] = <[f64; 3]>::from(self.gravity).map(|g| (g * 1e4).round() / 1e4 + 0.0);
        let robot = &self.draft.robot;
        let mut text = format!(
            "{}: {}, {:.3} kg that move, {:.3} m from the first joint to the tip, gravity {x},{y},{z}\n",
            robot.name,
            counted(robot.dof(), "joint"),
            self.draft.mass(),
            self.draft.length()
        );
        let mounting = robot.mounting_note();
        if !mounting.is_empty() {
            text += &format!("{mounting}\n");
        }
        if self.loads.is_none() {
            text += "not put into postures, so that no load is compared: correct the masses first\n";
        }
        for (severity, of_scene, meaning) in MEANINGS {
            let belongs = |finding: &&Finding| finding.severity == severity && finding.rule.is_of_scene() == of_scene;
            let found: Vec<&Finding> = self.findings.iter().filter(belongs).collect();
            if !found.is_empty() {
                text += &format!("\n{}: {meaning}\n", severity.name());
            }
            for (index, finding) in found.iter().enumerate() {
                let next = found.get(index + 1).map(|next| next.place.expected());
                // If several findings in a row have the same advice, print it after the last one.
                text += &described(finding, next != Some(finding.place.expected()));
            }
        }
        text += &self.hazard.as_ref().map_or(String::new(), Hazard::text);
        text + &format!("\n{}\n", self.counts())
    }

    /// "1 wrong, 3 doubts, 2 notes".
    fn counts(&self) -> String {
        let of = |severity| self.count(severity);
        let (doubts, notes) = (counted(of(Severity::Doubt), "doubt"), counted(of(Severity::Note), "note"));
        format!("{} wrong, {doubts}, {notes}", of(Severity::Wrong))
    }

    /// The findings in machine-readable form.
    #[must_use]
    pub fn json(&self) -> impl Serialize + '_ {
        let rows = self.findings.iter().map(|finding| {
            let place = finding.place.line_column();
            FindingRow {
                severity: finding.severity.name(),
                rule: finding.rule.name(),
                file: finding.place.file(),
                line: place.map(|(line, _)| line),
                column: place.map(|(_, column)| column),
                field: finding.place.field(),
                problem: finding.place.problem(),
                advice: finding.place.expected(),
            }
        });
        Report {
            robot: &self.draft.robot.name,
            gravity: self.gravity.into(),
            wrong: self.count(Severity::Wrong),
            doubts: self.count(Severity::Doubt),
            notes: self.count(Severity::Note),
            findings: rows.collect(),
            hazard: self.hazard.as_ref(),
            class_i: ClassI { mass: CLASS_I.0, force: CLASS_I.1, speed: CLASS_I.2 },
        }
    }
}

/// Location, text of the file, problem and, if `advise`, the remedy.
fn described(finding: &Finding, advise: bool) -> String {
    let place = &finding.place;
    let at = place.line_column().map_or(String::new(), |(line, column)| format!(":{line}:{column}"));
    let mut text = format!("\n  {}{at}: {}\n", place.file(), place.field());
    if let Some(quote) = &finding.quote {
        text += &format!("    \u{2502} {quote}\n");
    }
    text += &format!("    {}\n", place.problem());
    if advise {
        text += &format!("    \u{2192} {}\n", place.expected());
    }
    text
}

/// "1 note", "2 notes".
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
