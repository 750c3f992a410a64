//! Results as tables, for the terminal and for a page.

use super::{Correlation, Distribution, Group, Refusal, Results, RunShare};
use crate::sweep::repeat::repeat_command;
use sim::table::{self, table};
use std::fmt::Write as _;
use std::path::Path;

/// A titled table.
pub(super) struct Titled {
    pub(super) title: String,
    pub(super) head: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Results {
    /// The results as Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n\n{}\n", self.study, self.sentence());
        self.tables(Titled::markdown, &mut text);
        text
    }

    /// The results as text for a terminal.
    #[must_use]
    pub fn text(&self, study: &Path) -> String {
        let mut text = format!("{}: {}\n", self.study, self.sentence());
        self.tables(Titled::text, &mut text);
        if let Some(index) = self.worst() {
            let _ = writeln!(text, "\none run in full      {}", repeat_command(study, index));
        }
        text
    }

    /// Markdown without a title, for the documentation.
    #[must_use]
    pub fn measured(&self) -> String {
        let mut text = format!("{}\n", self.sentence());
        self.tables(Titled::markdown, &mut text);
        text
    }

    /// Index of the run to inspect first.
    fn worst(&self) -> Option<u64> {
        let of_metrics = self.metrics.first().and_then(|metric| metric.worst.first()).map(|worst| worst.index);
        self.failing.first().copied().or(of_metrics)
    }

    pub(super) fn sentence(&self) -> String {
        let ends: Vec<String> = self.ends.iter().map(|(end, count)| format!("{end}: {}", runs(*count))).collect();
        let mut text = format!(
            "{} runs ({}); failed: {}, with 95 % confidence.",
            self.runs,
            ends.join(", "),
            share(&self.failures)
        );
        if self.refused > 0 {
            let _ = write!(text, " Refused, as their values make no possible scene: {}", runs(self.refused));
            let reason =
                |refusal: &Refusal| refusal.reason.as_ref().map_or(String::new(), |reason| format!(" ({reason})"));
            let first =
                self.refusal.as_ref().map(|refusal| format!(", first run {}{}", refusal.index, reason(refusal)));
            text += &(first.unwrap_or_default() + ".");
        }
        if !self.failing.is_empty() {
            let list: Vec<String> = self.failing.iter().map(u64::to_string).collect();
            let _ = write!(text, " First failing runs: {}.", list.join(", "));
        }
        if self.sample.stride > 1 {
            let (runs, stride) = (self.sample.runs, self.sample.stride);
            let _ = write!(
                text,
                " Quantiles, medians and correlations: of the {runs} runs whose index is a multiple of {stride}."
            );
        }
        text
    }

    fn tables(&self, one: fn(&Titled) -> String, text: &mut String) {
        for titled in self.titled() {
            let _ = write!(text, "\n{}", one(&titled));
        }
    }

    /// Every table.
    pub(super) fn titled(&self) -> Vec<Titled> {
        let mut all = Vec::new();
        if !self.metrics.is_empty() {
            all.push(self.distributions());
        }
        if !self.sensitivities.is_empty() {
            all.push(self.correlations());
        }
        // A table of two keys contains the information of each single key.
        let pairs: Vec<&Group> = self.groups.iter().filter(|group| group.keys.len() == 2).collect();
        let single = self
            .groups
            .iter()
            .filter(|group| group.keys.len() == 1 && !pairs.iter().any(|pair| pair.keys.contains(&group.keys[0])));
        let metric = self.metrics.first();
        all.extend(single.map(|group| group.list(metric)));
        all.extend(pairs.iter().flat_map(|group| group.matrices(metric)));
        all
    }

    fn distributions(&self) -> Titled {
        let head =
            ["figure", "fails", "failed (95 % interval)", "median", "5 to 95 %", "99 %", "greatest", "worst runs"];
        Titled {
            title: "Figures".to_owned(),
            head: head.map(str::to_owned).into(),
            rows: self.metrics.iter().map(Distribution::row).chain([self.broken_off()]).collect(),
        }
    }

    /// Row for runs that were not complete, which no figure's limit rejects.
    fn broken_off(&self) -> Vec<String> {
        let first: Vec<String> = self.broken_off.first.iter().map(u64::to_string).collect();
        let mut row = vec!["end".to_owned(), "in a fault, or diverged".to_owned(), share(&self.broken_off.share)];
        row.extend(["-"; 4].map(str::to_owned));
        row.push(if first.is_empty() { "-".to_owned() } else { first.join(", ") });
        row
    }

    /// Keys with sensitivities, each once.
    pub(super) fn keys(&self) -> Vec<&str> {
        let mut keys: Vec<&str> = Vec::new();
        for found in &self.sensitivities {
            if !keys.contains(&found.key.as_str()) {
                keys.push(&found.key);
            }
        }
        keys
    }

    /// Rank correlation of a figure with a key.
    pub(super) fn correlation(&self, metric: &Distribution, key: &str) -> Option<Correlation> {
        let found = self.sensitivities.iter().find(|found| found.metric == metric.metric && found.key == key);
        found.and_then(|found| found.correlation)
    }

    fn correlations(&self) -> Titled {
        let keys = self.keys();
        let row = |metric: &Distribution| {
            let of = |key: &&str| {
                self.correlation(metric, key).map_or("-".to_owned(), |found| {
                    format!(
                        "{:+.2} ({:+.2} to {:+.2}), {:.0} %",
                        found.value,
                        found.low,
                        found.high,
                        100.0 * found.share
                    )
                })
            };
            core::iter::once(metric.metric.clone()).chain(keys.iter().map(of)).collect()
        };
        Titled {
            title:
                "Rank correlation of figures with keys (95 % interval), and the share of a figure's variance that a key explains alone"
                    .to_owned(),
            head: core::iter::once("figure").chain(keys.iter().copied()).map(str::to_owned).collect(),
            rows: self.metrics.iter().map(row).collect(),
        }
    }
}

impl Distribution {
    fn row(&self) -> Vec<String> {
        let bound = match (self.limit, self.least) {
            (None, None) => "-".to_owned(),
            (Some(limit), None) => format!("above {}", short(limit)),
            (None, Some(least)) => format!("below {}", short(least)),
            (Some(limit), Some(least)) => format!("above {}, below {}", short(limit), short(least)),
        };
        let failures = if bound == "-" { "-".to_owned() } else { share(&self.failures) };
        let at = |x: Option<Option<f64>>| x.map_or("-".to_owned(), |x| x.map_or("unsettled".to_owned(), short));
        let quantiles = self.quantiles.as_ref();
        let worst: Vec<String> = self.worst.iter().map(|worst| worst.index.to_string()).collect();
        vec![
            self.label(),
            bound,
            failures,
            at(quantiles.map(|q| q.p50)),
            format!("{} to {}", at(quantiles.map(|q| q.p05)), at(quantiles.map(|q| q.p95))),
            at(quantiles.map(|q| q.p99)),
            if self.infinite > 0 { "unsettled".to_owned() } else { at(self.max.map(Some)) },
            worst.join(", "),
        ]
    }
}

impl Titled {
    fn markdown(&self) -> String {
        let escaped = |cells: &Vec<String>| cells.iter().map(|cell| cell.replace('\\', "\\\\")).collect::<Vec<_>>();
        format!("{}:\n\n{}", self.title, table::markdown(&escaped(&self.head), self.rows.iter().map(escaped)))
    }

    fn text(&self) -> String {
        let mut table = table(self.head.clone(), 1);
        self.rows.iter().for_each(|row| {
            table.add_row(row.clone());
        });
        format!("{}\n{table}\n", self.title)
    }
}

/// "1 run", "2 runs".
fn runs(count: u64) -> String {
    if count == 1 { "1 run".to_owned() } else { format!("{count} runs") }
}

/// A share with its interval, in percent: `3 of 100 (0.62 to 8.5 %)`.
pub(super) fn share(share: &RunShare) -> String {
    format!("{} of {} ({} to {} %)", share.count, share.of, percent(share.low), percent(share.high))
}

fn percent(x: f64) -> String {
    short(100.0 * x)
}

/// Formats with three digits: `0.0123`, `4.56`, `789`, `1.2e-7`.
pub(super) fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let size = x.abs();
    if !(1e-4..1e6).contains(&size) {
        return format!("{x:.2e}");
    }
    let magnitude = libm::floor(libm::log10(size)) as i32;
    format!("{x:.*}", usize::try_from(2 - magnitude).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::{RunShare, share, short};

    #[test]
    fn numbers_have_three_digits() {
        let found = [0.0, 0.012_345, 4.567, 789.4, 12_345.6, 1.23e-7, -0.5].map(short);
        assert_eq!(found, ["0", "0.0123", "4.57", "789", "12346", "1.23e-7", "-0.500"]);
        assert_eq!(share(&RunShare::new(3, 100)), "3 of 100 (0.623 to 8.52 %)");
    }
}
