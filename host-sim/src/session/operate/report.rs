//! What an operator is told: lines for a person, or one JSON object a line.

use super::words;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use link::{Actuation, Status};
use serde_json::{Value, json};
use std::io::{self, IsTerminal, Write};

/// What a status says in the units of the arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen<'a> {
    /// The status.
    pub status: &'a Status,
    /// Positions, rad or m, where somebody measured them.
    pub q: Option<&'a [f64]>,
    /// Each joint's name and unit.
    pub joints: &'a [(String, &'static str, &'static str)],
    /// Control period, s.
    pub period: f64,
}

impl Seen<'_> {
    fn torque(&self) -> Option<&[f32]> {
        match &self.status.actuation {
            Some(Actuation::Drive { torque, .. }) => Some(torque),
            _ => None,
        }
    }

    /// In a line.
    #[must_use]
    pub fn line(&self) -> String {
        let Status { tick, room, .. } = self.status;
        let mut line = format!("tick {tick}  {}", words::doing(self.status));
        if let Some(q) = self.q {
            line += "  q";
            q.iter().for_each(|q| line += &format!(" {q:.4}"));
        }
        if let Some(torque) = self.torque() {
            line += "  torque";
            torque.iter().for_each(|torque| line += &format!(" {torque:.2}"));
        }
        line + &format!("  room {room}")
    }

    /// In a few lines.
    #[must_use]
    pub fn text(&self) -> String {
        let Status { tick, homed, room, .. } = self.status;
        let time = f64::from(*tick) * self.period;
        let homed = if *homed { "homed" } else { "not homed" };
        let mut text =
            format!("{}; {homed}, room for {room} points\ntick {tick}, {time:.3} s", words::doing(self.status));
        let limits = match &self.status.actuation {
            Some(Actuation::Drive { limits, .. }) => limits.as_slice(),
            _ => &[],
        };
        for (i, (name, place, force)) in self.joints.iter().enumerate() {
            let q = self.q.and_then(|q| q.get(i));
            let q = q.map_or_else(|| format!("{:>12}", "-"), |q| format!("{q:>12.5} {place}"));
            let torque = self.torque().and_then(|torque| torque.get(i));
            let torque = torque.map_or_else(|| "no torque".into(), |torque| format!("{torque:>10.3} {force}"));
            let acted = words::limits(limits.get(i).copied().unwrap_or(0));
            let acted = if acted.is_empty() { acted } else { format!("  limited: {acted}") };
            text += &format!("\n  {name:<12} {q}  {torque}{acted}");
        }
        text
    }

    fn json(&self) -> Value {
        let Status { tick, state, cause, joint, homed, room, refused, actuation, .. } = self.status;
        let refused = refused
            .as_ref()
            .map(|refused| json!({ "code": refused.code, "fault": refused.fault, "joint": refused.joint }));
        let limits = match actuation {
            Some(Actuation::Drive { limits, .. }) => json!(limits.as_slice()),
            _ => Value::Null,
        };
        json!({
            "tick": tick, "state": words::state(*state), "cause": cause, "joint": joint, "homed": homed, "room": room,
            "refused": refused, "q": self.q, "torque": self.torque(), "limits": limits,
        })
    }
}

/// Where it is told.
pub struct Report {
    json: bool,
    bar: ProgressBar,
}

impl Report {
    /// To standard output; the live line to standard error, where that is a terminal.
    #[must_use]
    pub fn new(json: bool) -> Self {
        let bar = if json || !io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
            // The template is ours: without it the line would only be plainer.
            ProgressStyle::with_template("{msg}").map_or(bar.clone(), |style| bar.with_style(style))
        };
        Self { json, bar }
    }

    /// What came of a command, or what happened.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn say(&self, about: &str, text: &str, seen: Option<&Seen<'_>>) -> io::Result<()> {
        let line = if self.json {
            json!({ "about": about, "text": text, "status": seen.map(Seen::json) }).to_string()
        } else {
            text.to_owned()
        };
        self.bar.suspend(|| {
            let mut out = io::stdout().lock();
            writeln!(out, "{line}")?;
            out.flush()
        })
    }

    /// The line that changes in its place.
    pub fn live(&self, seen: &Seen<'_>) {
        if !self.bar.is_hidden() {
            self.bar.set_message(seen.line());
            self.bar.tick();
        }
    }

    /// Take that line away: somebody is going to type.
    pub fn still(&self) {
        self.bar.finish_and_clear();
        self.bar.reset();
    }
}
