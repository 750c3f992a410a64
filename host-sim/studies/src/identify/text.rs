//! An outcome as text for the terminal.

use super::outcome::Outcome;
use super::subject::Subject;
use super::verdict as words;
use comfy_table::Cell;
use identification::audit::Audit;
use sim::table::table;

impl Outcome {
    /// Result as text for the terminal.
    #[must_use]
    pub fn text(&self, subject: &Subject) -> String {
        let found = &self.found;
        let mut table = table(["joint", "friction", "before", "identified", "robot file", "rms left"], 2);
        let percent = |x: f64| Cell::new(format!("{:.1} %", 100.0 * x));
        for (joint, error) in self.errors().iter().enumerate() {
            let terms: Vec<String> = found.laws[joint].terms.iter().skip(1).map(|term| term.name()).collect();
            table.add_row([
                Cell::new(&subject.robot.joints[joint].name),
                Cell::new(terms.join(", ")),
                percent(error.before),
                percent(error.relative),
                percent(error.file),
                Cell::new(format!("{:.3}", error.rms)),
            ]);
        }
        let logs: Vec<&str> = self.judged.iter().map(|judged| judged.file.as_str()).collect();
        let judged =
            if self.held_out { "held out" } else { "the logs themselves: give --validate for an honest number" };
        let unseen = self.numbers.unseen(subject);
        let masses = self.masses(subject);
        words::text(&self.verdict, subject)
            + &masses
            + &format!(
                "{}: relative error of torque on {} ({judged}), both behind {:.1} Hz\n{table}\n\
             base parameters     {} of {}, singular values {:.1e} and {:.1e} on both sides of the gap\n\
             condition           {:.0}\n\
             motion cut-off      {:.1} Hz: least error in blocks held out, of {}\n\
             bodies              possible, {:.1} deviations from least squares\n\
             mass matrix         {}\n\
             delay of torque     {}\n\
             held by friction    {}\n\
             not seen            {}\n",
                subject.robot.name,
                logs.join(", "),
                found.filters.torque,
                found.base.len(),
                found.base.regroup.ncols(),
                found.base.gap.0,
                found.base.gap.1,
                found.condition,
                found.filters.motion,
                found.cutoffs.iter().map(|(f, _)| format!("{f:.1}")).collect::<Vec<_>>().join(", "),
                (found.distance() / found.base.len() as f64).sqrt(),
                self.mass_matrix(subject),
                self.delay(subject),
                self.held_in_words(subject),
                if unseen.is_empty() {
                    "nothing".to_owned()
                } else {
                    format!("{} (the maker's numbers stay)", unseen.join(", "))
                },
            )
    }

    /// Description of the mass-matrix audit.
    fn mass_matrix(&self, subject: &Subject) -> String {
        let Audit { smallest, smallest_before, ratio } = &self.audit;
        let sign =
            if smallest.value > 0.0 { "positive in every posture searched" } else { "NOT POSITIVE in some posture" };
        let bare = if subject.maker.rotors.iter().all(|rotor| *rotor <= 0.0) { ", which has no rotors" } else { "" };
        let beside = ratio.as_ref().map_or_else(String::new, |(low, high)| {
            let times = |x: f64| if x < 100.0 { format!("{x:.2}") } else { format!("{x:.0}") };
            format!(
                "; relative to the maker's{bare}: {} in its lightest direction, {} in its heaviest",
                times(low.value),
                times(high.value)
            )
        });
        format!("{sign}, smallest eigenvalue {:.2e} (maker's {:.2e}){beside}", smallest.value, smallest_before.value)
    }

    /// Description of the shares of samples in which friction holds the joints.
    fn held_in_words(&self, subject: &Subject) -> String {
        let of = |(joint, share): (usize, &f64)| {
            (*share > 0.0005).then(|| format!("{} {:.1} %", subject.robot.joints[joint].name, 100.0 * share))
        };
        let held: Vec<String> = self.held().iter().enumerate().filter_map(of).collect();
        if held.is_empty() { "never".to_owned() } else { format!("{} of the samples, left out", held.join(", ")) }
    }

    /// Description of delay and jitter.
    fn delay(&self, subject: &Subject) -> String {
        let found = &self.found;
        let late = |(joint, delay): (usize, &f64)| {
            let name = &subject.robot.joints[joint].name;
            (*delay != 0.0).then(|| format!("{:.1} ms of joint {} ({name})", 1e3 * delay, joint + 1))
        };
        let common = found.delay.windows(2).all(|pair| (pair[0] - pair[1]).abs() < 1e-9);
        let milli = |x: f64| format!("{:.1}", 1e3 * x);
        let list = |x: &[f64]| x.iter().map(|x| milli(*x)).collect::<Vec<_>>().join(", ");
        let delay = if found.delay.iter().any(|d| *d != 0.0) {
            let each: Vec<String> = found.delay.iter().enumerate().filter_map(late).collect();
            let all = format!("{} ms of all joints", milli(found.delay[0]));
            format!("{}, compensated", if common { all } else { each.join(", ") })
        } else if found.delays.value.is_empty() {
            "as given".to_owned()
        } else {
            "none that lowers the error".to_owned()
        };
        let seen = match found.delays.value.is_empty() {
            true => String::new(),
            false => format!("; seen {} +- {} ms", list(&found.delays.value), list(&found.delays.deviation)),
        };
        let jitter = match found.jitter > 0.0 {
            true => format!("; time stamps jitter by {} ms, an even clock is used", milli(found.jitter)),
            false => String::new(),
        };
        delay + &seen + &jitter
    }

    /// Mass of every link before and after.
    fn masses(&self, subject: &Subject) -> String {
        let mut table = table(["link", "mass before", "mass after, kg", "moved", "rotor, kg m^2"], 1);
        for (link, numbers) in self.numbers.links.iter().enumerate() {
            let (before, (after, deviation)) = (subject.maker.links[link][0], numbers.mass);
            let moved = match (numbers.seen[0], before > 0.0) {
                (false, _) => "not seen".to_owned(),
                (true, false) => "was missing".to_owned(),
                (true, true) => format!("{:+.1} %", 100.0 * (after / before - 1.0)),
            };
            let rotor = self.numbers.rotors[link];
            table.add_row([
                Cell::new(&subject.robot.joints[link].name),
                Cell::new(format!("{before:.3}")),
                Cell::new(format!("{after:.3} +- {deviation:.3}")),
                Cell::new(moved),
                Cell::new(format!("{:.4} +- {:.4}", rotor.0, rotor.1)),
            ]);
        }
        format!("{table}\n")
    }
}
