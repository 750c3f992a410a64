//! Output for the operator: lines of text, or one JSON object a line.

use super::heat::Heat;
use super::messages;
use super::screen::Screen;
use console::style;
use dynamics_core::safety::heat::HeatLevel;
use link::{Actuation, DriveFaultReport, Status};
use serde_json::{Value, json};
use std::cell::Cell;
use std::io;
use std::time::{Duration, Instant};

/// A status in the units of the arm.
#[derive(Clone, Debug)]
pub struct StatusView<'a> {
    /// The status.
    pub status: &'a Status,
    /// Positions, rad or m, if they were measured.
    pub q: Option<&'a [f64]>,
    /// Each joint's name and its units of position and force.
    pub joints: &'a [(String, &'static str, &'static str)],
    /// Control period, s.
    pub period: f64,
    /// External force (N) and moment (N m) at the tip, in base axes; `None` if they are not estimated or the arm is singular.
    pub wrench: Option<[f64; 6]>,
    /// Report of the first joint with a fault; only in the fault state.
    pub drive_fault: Option<DriveFaultReport>,
    /// The drives' error texts.
    pub words: Option<fn(u8) -> &'static str>,
    /// Heat of each joint's motor; empty for an arm without drives.
    pub heat: Vec<Heat>,
    /// Share of the limits of the first motion after homing, if these are in force.
    pub first_motion: Option<f64>,
}

/// A heat in per cent of the motor's continuous limit, highlighted from the warning threshold on.
#[must_use]
pub(super) fn heat_in_words(heat: &Heat) -> String {
    let Heat::Known(heat) = *heat else {
        return if *heat == Heat::Pending { "not reported yet" } else { "unknown" }.to_owned();
    };
    // Rounded down, so that the limit is not shown before it is reached.
    let percent = (100.0 * heat).floor();
    match HeatLevel::of(heat) {
        HeatLevel::Cool => format!("{percent:.0} %"),
        HeatLevel::Warm => style(format!("{percent:.0} % WARM")).red().bold().to_string(),
        HeatLevel::Overheated => style(format!("{percent:.0} % OVERHEATED")).red().bold().to_string(),
    }
}

impl StatusView<'_> {
    fn torque(&self) -> Option<&[f32]> {
        match &self.status.actuation {
            Some(Actuation::Drive { torque, .. }) => Some(torque),
            _ => None,
        }
    }

    /// State of the machine in words, with the report of a drive's fault.
    #[must_use]
    pub fn doing(&self) -> String {
        let said =
            self.drive_fault.map_or(String::new(), |said| format!("; {}", messages::drive_fault(&said, self.words)));
        let limited = self.first_motion.map_or(String::new(), |share| messages::in_first_motion(self.status, share));
        format!("{}{limited}{said}", messages::doing(self.status))
    }

    /// The status in one line.
    #[must_use]
    pub fn line(&self) -> String {
        let Status { tick, room, .. } = self.status;
        let mut line = format!("tick {tick}  {}", self.doing());
        if let Some(q) = self.q {
            line += "  q";
            q.iter().for_each(|q| line += &format!(" {q:.4}"));
        }
        if let Some(torque) = self.torque() {
            line += "  torque";
            torque.iter().for_each(|torque| line += &format!(" {torque:.2}"));
        }
        if let Some(external) = self.status.external() {
            line += "  external";
            external.iter().for_each(|torque| line += &format!(" {torque:.2}"));
        }
        let known = |(heat, (name, ..)): (&Heat, &'_ (String, &'static str, &'static str))| match heat {
            Heat::Known(value) => Some((*value, heat_in_words(heat), name.clone())),
            Heat::Unknown | Heat::Pending => None,
        };
        let hottest = self.heat.iter().zip(self.joints).filter_map(known).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, heat, name)) = hottest {
            line += &format!("  heat of {name} {heat}");
        }
        line + &format!("  room {room}")
    }

    /// The status in several lines.
    #[must_use]
    pub fn text(&self) -> String {
        let Status { tick, homed, room, .. } = self.status;
        let time = f64::from(*tick) * self.period;
        let homed = if *homed { "homed" } else { "not homed" };
        let mut text = format!("{}; {homed}, room for {room} points\ntick {tick}, {time:.3} s", self.doing());
        let limits = match &self.status.actuation {
            Some(Actuation::Drive { limits, .. }) => limits.as_slice(),
            _ => &[],
        };
        for (i, (name, place, force)) in self.joints.iter().enumerate() {
            let q = self.q.and_then(|q| q.get(i));
            let q = q.map_or_else(|| format!("{:>12}", "-"), |q| format!("{q:>12.5} {place}"));
            let torque = self.torque().and_then(|torque| torque.get(i));
            let torque = torque.map_or_else(|| "no torque".into(), |torque| format!("{torque:>10.3} {force}"));
            let acted = messages::limits(limits.get(i).copied().unwrap_or(0));
            let acted = if acted.is_empty() { acted } else { format!("  limited: {acted}") };
            let external = self.status.external().and_then(|external| external.get(i));
            let external = external.map_or_else(String::new, |torque| format!("  from outside {torque:.3} {force}"));
            let heat = self.heat.get(i).map_or_else(String::new, |heat| format!("  heat {}", heat_in_words(heat)));
            text += &format!("\n  {name:<12} {q}  {torque}{heat}{external}{acted}");
        }
        if let Some([x, y, z, a, b, c]) = self.wrench {
            text += &format!(
                "\nat the tip from outside: force {x:.2} {y:.2} {z:.2} N, moment {a:.3} {b:.3} {c:.3} N m, base axes"
            );
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
        let heat = |heat: &Heat| match heat {
            Heat::Known(heat) => json!(heat),
            Heat::Unknown | Heat::Pending => Value::Null,
        };
        json!({
            "tick": tick, "state": state.name(), "cause": cause, "joint": joint, "homed": homed,
            "room": room, "refused": refused, "q": self.q, "torque": self.torque(), "limits": limits,
            "external": self.status.external(), "wrench": self.wrench,
            "heat": self.heat.iter().map(heat).collect::<Vec<_>>(),
        })
    }
}

/// Time between two drawings of the live line.
const REFRESH: Duration = Duration::from_millis(100);

/// Writer of the output.
pub struct Report {
    json: bool,
    screen: Screen,
    /// Time at which the live line was last sent; `None` if it is not shown.
    drawn: Cell<Option<Instant>>,
}

impl Report {
    /// A writer to standard output, above the lowest lines of the terminal.
    #[must_use]
    pub const fn new(json: bool, screen: Screen) -> Self {
        Self { json, screen, drawn: Cell::new(None) }
    }

    /// Prints the result of a command, or an event.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn say(&self, about: &str, text: &str, seen: Option<&StatusView<'_>>) -> io::Result<()> {
        let line = if self.json {
            json!({ "about": about, "text": text, "status": seen.map(StatusView::json) }).to_string()
        } else {
            text.to_owned()
        };
        self.screen.above(&line)
    }

    /// Updates the live line.
    pub fn live(&self, seen: &StatusView<'_>) {
        let is_due = self.drawn.get().is_none_or(|at| at.elapsed() >= REFRESH);
        if !self.json && self.screen.is_drawn() && is_due {
            self.drawn.set(Some(Instant::now()));
            self.screen.live(Some(seen.line()));
        }
    }

    /// Removes the live line, because it is out of date. It stays away until [`Report::live`].
    pub fn still(&self) {
        if self.drawn.take().is_some() {
            self.screen.live(None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Heat, StatusView, heat_in_words};
    use console::strip_ansi_codes;
    use link::{Actuation, ExtraFields, StateCode, Status, convert::joints};

    #[test]
    fn the_screen_shows_the_heat_of_each_motor_that_is_known_and_marks_a_warm_one() {
        let status = Status {
            tick: 7,
            taken: 0,
            state: StateCode::Armed,
            cause: 0,
            joint: None,
            homed: true,
            refused: None,
            kept: false,
            room: 16,
            actuation: Some(Actuation::Drive { torque: joints(&[1.0; 5]), limits: joints(&[0; 5]) }),
            sensed: None,
            extra: ExtraFields::Nothing,
            cost: None,
        };
        let names = ["a", "b", "c", "d", "e"].map(|name| (name.to_owned(), "rad", "N m"));
        let heat = vec![Heat::Unknown, Heat::Pending, Heat::Known(0.75), Heat::Known(0.8125), Heat::Known(1.0625)];
        let q = [0.0; 5];
        let driven = StatusView {
            status: &status,
            q: Some(&q),
            joints: &names,
            period: 0.001,
            wrench: None,
            drive_fault: None,
            words: None,
            heat,
            first_motion: None,
        };
        let text = driven.text();
        let ends: Vec<_> = strip_ansi_codes(&text)
            .lines()
            .skip(2)
            .map(|line| line.split("N m").nth(1))
            .map(|end| end.map(str::to_owned))
            .collect();
        let expected =
            ["heat unknown", "heat not reported yet", "heat 75 %", "heat 81 % WARM", "heat 106 % OVERHEATED"];
        assert_eq!(ends, expected.map(|end| Some(format!("  {end}"))), "{text}");
        let line = driven.line();
        assert!(strip_ansi_codes(&line).contains("  heat of e 106 % OVERHEATED  "), "{line}");
        assert_eq!(driven.json()["heat"].to_string(), "[null,null,0.75,0.8125,1.0625]");
        // Exactly from the warning threshold on.
        let words = [0.799_999, 0.8].map(|heat| strip_ansi_codes(&heat_in_words(&Heat::Known(heat))).into_owned());
        assert_eq!(words, ["79 %", "80 % WARM"]);
        // A fault that the limits of the first motion explain.
        let fault = |cause: u8, first_motion| {
            let status = Status { state: StateCode::Fault, cause, ..status.clone() };
            StatusView { status: &status, first_motion, ..driven.clone() }.doing()
        };
        for cause in [5, 15] {
            assert!(fault(cause, Some(0.2)).contains("; in the first motion after homing"), "{cause}");
            assert!(
                fault(cause, Some(0.2)).contains("20 %") && !fault(cause, None).contains("first motion"),
                "{cause}"
            );
        }
        assert_eq!(fault(9, Some(0.2)), fault(9, None));
        // An arm without drives has no motors to report.
        let simulated = StatusView { heat: Vec::new(), ..driven };
        assert!(!simulated.text().contains("heat") && !simulated.line().contains("heat"));
    }
}
