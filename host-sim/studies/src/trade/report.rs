//! Report of a trade-off as tables and Markdown.

use super::choice::Choice;
use super::{Trade, TradePoint};
use sim::run::files::shell_word;
use sim::run::numbers::engineering;
use sim::table::{markdown, table};
use std::fmt::Write as _;
use std::path::Path;

/// Command that measures one choice.
#[must_use]
pub fn command(scene: &Path, choice: &Choice) -> String {
    let options = CHOICES.iter().zip(choice.cells()).map(|(axis, value)| format!(" --{axis} {value}"));
    format!("newtau choose trade {}{} --alone", shell_word(scene), options.collect::<String>())
}

/// Column headers of the choices; the headers of the costs follow them.
pub(super) const CHOICES: [&str; 8] = ["scalar", "trig", "terms", "friction", "rotors", "every", "kernel", "rate"];

/// Shares below this are rounding errors.
const NOISE: f64 = 1e-12;

/// Formats a share in percent; below 1e-12 it is a rounding error: `< 1e-10 %`.
pub(crate) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if share != 0.0 && share.abs() < NOISE {
        format!("< {:e} %", 100.0 * NOISE)
    } else if percent == 0.0 || (0.01..1e4).contains(&percent) {
        format!("{percent:.3} %")
    } else {
        format!("{percent:.1e} %")
    }
}

fn or_fault(value: Option<f64>, show: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| "fault".to_owned(), show)
}

impl TradePoint {
    fn tracking_on(&self, course: usize) -> String {
        let of = &self.courses[course];
        let most = of.tracking.max.iter().fold(0.0, |most, x| f64::max(most, *x));
        or_fault(of.fault.is_none().then_some(most), |x| engineering(x, "rad"))
    }

    /// Greatest torque error of any joint on any test motion, N m or N.
    fn torque_max(&self) -> Option<f64> {
        let of = |course: &super::measure::OnMotion| {
            Some(course.torque.as_ref()?.max.iter().fold(0.0, |most, x| f64::max(most, *x)))
        };
        self.courses.iter().map(of).try_fold(0.0, |most, x| Some(f64::max(most, x?)))
    }

    fn cells(&self) -> Vec<String> {
        let (cost, interrupt) = (&self.cost, &self.interrupt);
        let mean_and_most = |mean: f64, most: f64| {
            if (most - mean).abs() < 0.5 { format!("{mean:.0}") } else { format!("{mean:.0} ({most:.0})") }
        };
        let mut cells = vec![
            mean_and_most(cost.instructions, cost.instructions_max as f64),
            mean_and_most(cost.cycles, cost.cycles_max),
            mean_and_most(interrupt.cycles, interrupt.cycles_max),
            mean_share(interrupt.cpu_share, interrupt.cpu_share_max),
            cost.flash.to_string(),
            cost.ram.to_string(),
            or_fault(self.torque_of_limit, percent),
            or_fault(self.torque_max(), |x| engineering(x, "N m")),
        ];
        cells.extend((0..self.courses.len()).map(|course| self.tracking_on(course)));
        cells
    }
}

const COSTS: [&str; 8] = [
    "controller: instructions",
    "controller: cycles, est.",
    "interrupt: cycles, est.",
    "share of 168 MHz, est.",
    "flash",
    "RAM",
    "torque error",
    "at most",
];

/// Formats the processor share of the mean tick, and that of the longest in brackets if they differ.
pub(crate) fn mean_share(mean: f64, most: f64) -> String {
    let [mean, most] = [mean, most].map(|share| format!("{:.1}", 100.0 * share));
    if mean == most { format!("{mean} %") } else { format!("{mean} ({most}) %") }
}

impl Trade {
    /// Indices of the choice columns in which the points differ.
    pub(super) fn varied(&self) -> Vec<usize> {
        let rows: Vec<[String; 8]> = self.points.iter().map(|point| point.choice.cells()).collect();
        let varies = |column: &usize| rows.iter().any(|row| row[*column] != rows[0][*column]);
        let varied: Vec<usize> = (0..CHOICES.len()).filter(varies).collect();
        if varied.is_empty() { (0..CHOICES.len()).collect() } else { varied }
    }

    pub(super) fn head(&self, varied: &[usize]) -> Vec<String> {
        let courses = self.courses.iter().map(|course| format!("tracking, {}", course.name));
        let named = varied.iter().map(|&column| CHOICES[column].to_owned()).chain(COSTS.map(str::to_owned));
        named.chain(courses).collect()
    }

    pub(super) fn row(point: &TradePoint, varied: &[usize]) -> Vec<String> {
        let chosen = point.choice.cells();
        varied.iter().map(|&column| chosen[column].clone()).chain(point.cells()).collect()
    }

    /// Points on the Pareto front of torque error or of tracking error.
    pub fn front(&self) -> impl Iterator<Item = &TradePoint> {
        self.points.iter().filter(|point| point.on_torque_front || point.on_tracking_front)
    }

    /// The point of the scene's own choice.
    fn own_point(&self) -> Option<&TradePoint> {
        self.points.iter().find(|point| point.choice == self.own)
    }

    /// Head and rows of the choices on the front.
    fn front_table(&self, varied: &[usize]) -> (Vec<String>, Vec<Vec<String>>) {
        let row = |point| [Self::row(point, varied), vec![front_name(point).to_owned()]].concat();
        ([self.head(varied), vec!["front".to_owned()]].concat(), self.front().map(row).collect())
    }

    /// Table for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let varied = self.varied();
        let (head, rows) = self.front_table(&varied);
        let mut table = table(head, varied.len());
        table.add_rows(rows);
        let mut text = format!(
            "{}: {}, {} choices; those that nothing beats:\n{table}\n",
            self.scene,
            self.robot,
            self.points.len()
        );
        for course in &self.courses {
            let _ = writeln!(
                text,
                "{:<10}{:.2} s, speed to {:.0} % of a limit, least eigenvalue of the scaled mass matrix {:.3}",
                course.name,
                course.duration,
                100.0 * course.speed,
                course.least_eigenvalue
            );
        }
        let _ = writeln!(text, "{}", self.around());
        text + &self.own_point().map_or_else(String::new, |own| self.beside_drives(own))
    }

    /// Description of the processor share, and of the part that no choice changes.
    fn around(&self) -> String {
        format!(
            "share: mean cycles of the whole interrupt (the longest in brackets) times the rate over 168 MHz; around the controller the \
             interrupt takes {:.0} instructions, {:.0} cycles (estimate)",
            self.surroundings.instructions, self.surroundings.cycles
        )
    }

    /// Markdown: the test motions, the Pareto front, and the effect of each axis alone.
    #[must_use]
    pub fn markdown(&self) -> String {
        let courses = self.courses.iter().map(|course| {
            vec![
                course.name.to_owned(),
                format!("{:.2} s", course.duration),
                format!("{:.0} %", 100.0 * course.speed),
                format!("{:.3}", course.least_eigenvalue),
            ]
        });
        let head = ["course", "length", "speed, of a limit", "least eigenvalue of the scaled mass matrix"];
        let mut text = markdown(&head, courses);
        let (head, rows) = self.front_table(&self.varied());
        let _ = write!(
            text,
            "\n{} choices. S{}.\n\nThose that nothing beats:\n\n{}",
            self.points.len(),
            &self.around()[1..],
            markdown(&head, rows)
        );
        if let Some(own) = self.own_point() {
            let _ = write!(
                text,
                "\nThe scene's own choice ({}), and each that differs from it in one thing:\n\n{}",
                own.choice.cells().join(", "),
                self.variations(own)
            );
        }
        text + &self.simulator_markdown()
    }

    /// Table of a point, and of each point that differs from it in one axis.
    fn variations(&self, own: &TradePoint) -> String {
        let here = own.choice.cells();
        let row = |label: String, point: &TradePoint| [vec![label], point.cells()].concat();
        let mut rows = vec![row("(own)".to_owned(), own)];
        for column in 0..CHOICES.len() {
            for point in &self.points {
                let there = point.choice.cells();
                if (0..CHOICES.len()).all(|k| (here[k] != there[k]) == (k == column)) {
                    rows.push(row(format!("{} {}", CHOICES[column], there[column]), point));
                }
            }
        }
        markdown(&[vec!["instead".to_owned()], self.head(&[])].concat(), rows)
    }

    /// Table of the errors of the simulator's own integrator.
    fn simulator_markdown(&self) -> String {
        let rows = self.simulator.iter().map(|method| {
            let steps = match (method.steps_per_tick, method.tolerance) {
                (Some(steps), _) => steps.to_string(),
                (None, Some(tolerance)) => format!("its own, tolerance {tolerance:.0e}"),
                (None, None) => "its own".to_owned(),
            };
            let solved = method.off_by.map_or("-".to_owned(), |_| format!("{:.1}", method.accelerations_per_tick));
            let shown = |x: Option<f64>| x.map_or("refused".to_owned(), |x| engineering(x, "rad"));
            vec![method.integrator.to_owned(), steps, solved, shown(method.off_by), shown(method.tracking)]
        });
        let head = ["integrator", "steps a tick", "accelerations a tick", "off by", "greatest tracking error"];
        format!(
            "\nThe simulator, on the scene's own motion: how far a joint is at most from where the adaptive pair has it at a tolerance of 1e-12.\n\n{}",
            markdown(&head, rows)
        )
    }
}

pub(super) fn front_name(point: &TradePoint) -> &'static str {
    match (point.on_torque_front, point.on_tracking_front) {
        (true, true) => "both",
        (true, false) => "torque",
        (false, true) => "tracking",
        (false, false) => "",
    }
}
