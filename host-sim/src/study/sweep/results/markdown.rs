//! Results as tables, for the terminal and for a page.

use super::{Distribution, Group, Results, Share};
use crate::run::files::shell_word;
use crate::table::table;
use std::fmt::Write as _;
use std::path::Path;

/// A titled table.
pub(super) struct Titled {
    pub(super) title: String,
    pub(super) head: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Results {
    /// Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n\n{}\n", self.study, self.sentence());
        self.tables(Titled::markdown, &mut text);
        text
    }

    /// Text for a terminal; `study` as for [`Results::page`].
    #[must_use]
    pub fn text(&self, study: Option<&Path>) -> String {
        let mut text = format!("{}: {}\n", self.study, self.sentence());
        self.tables(Titled::text, &mut text);
        if let (Some(index), Some(study)) = (self.worst(), study.map(shell_word)) {
            let _ = writeln!(text, "\none run in full      host-sim sweep {study} --replay {index} --out FOLDER");
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

    /// The run that most deserves a look.
    fn worst(&self) -> Option<u64> {
        let of_metrics = self.metrics.first().and_then(|metric| metric.worst.first()).map(|worst| worst.index);
        self.failing.first().copied().or(of_metrics)
    }

    pub(super) fn sentence(&self) -> String {
        let ends: Vec<String> = self.ends.iter().map(|(end, count)| format!("{end} {count}")).collect();
        let mut text = format!("{} runs ({}); failed: {}.", self.runs, ends.join(", "), share(&self.failures));
        if self.refused > 0 {
            let _ = write!(text, " {} runs were refused: their values make no possible scene.", self.refused);
        }
        if !self.failing.is_empty() {
            let list: Vec<String> = self.failing.iter().map(u64::to_string).collect();
            let _ = write!(text, " First failing runs: {}.", list.join(", "));
        }
        if self.sample.stride > 1 {
            let (runs, stride) = (self.sample.runs, self.sample.stride);
            let _ = write!(text, " Quantiles, medians and correlations: every {stride}th run, {runs} in all.");
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
        // What two keys do together says what each does.
        let pairs: Vec<&Group> = self.groups.iter().filter(|group| group.keys.len() == 2).collect();
        let single = self
            .groups
            .iter()
            .filter(|group| group.keys.len() == 1 && !pairs.iter().any(|pair| pair.keys.contains(&group.keys[0])));
        let metric = self.metrics.first().map(|metric| metric.metric.clone());
        all.extend(single.map(|group| group.list(metric.as_deref())));
        all.extend(pairs.iter().flat_map(|group| group.matrices(metric.as_deref())));
        all
    }

    fn distributions(&self) -> Titled {
        let head = ["figure", "fails", "failed", "median", "5 to 95 %", "99 %", "greatest", "worst runs"];
        Titled {
            title: "Figures".to_owned(),
            head: head.map(str::to_owned).into(),
            rows: self.metrics.iter().map(Distribution::row).collect(),
        }
    }

    fn correlations(&self) -> Titled {
        let keys: Vec<&str> = self.sensitivities.iter().map(|found| found.key.as_str()).collect();
        let distinct: Vec<&str> =
            keys.iter().enumerate().filter(|(at, key)| !keys[..*at].contains(key)).map(|(_, key)| *key).collect();
        let row = |metric: &Distribution| {
            let of = |key: &&str| {
                let found = self.sensitivities.iter().find(|found| found.metric == metric.metric && found.key == **key);
                found.and_then(|found| found.correlation).map_or("-".to_owned(), |found| {
                    format!(
                        "{:+.2} ({:+.2} to {:+.2}), {:.0} %",
                        found.value,
                        found.low,
                        found.high,
                        100.0 * found.share
                    )
                })
            };
            core::iter::once(metric.metric.clone()).chain(distinct.iter().map(of)).collect()
        };
        Titled {
            title:
                "Rank correlation of figures with keys, and the share of a figure's variance that a key explains alone"
                    .to_owned(),
            head: core::iter::once("figure").chain(distinct.iter().copied()).map(str::to_owned).collect(),
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
        let at = |x: Option<Option<f64>>| x.map_or("-".to_owned(), |x| x.map_or("never".to_owned(), short));
        let quantiles = self.quantiles.as_ref();
        let worst: Vec<String> = self.worst.iter().map(|worst| worst.index.to_string()).collect();
        vec![
            self.metric.clone(),
            bound,
            failures,
            at(quantiles.map(|q| q.p50)),
            format!("{} to {}", at(quantiles.map(|q| q.p05)), at(quantiles.map(|q| q.p95))),
            at(quantiles.map(|q| q.p99)),
            if self.infinite > 0 { "never".to_owned() } else { at(self.max.map(Some)) },
            worst.join(", "),
        ]
    }
}

impl Group {
    /// One key: a row for each value.
    fn list(&self, metric: Option<&str>) -> Titled {
        let mut head = vec![self.keys[0].clone(), "runs".to_owned(), "failed".to_owned()];
        head.extend(metric.map(|metric| format!("median {metric}")));
        let rows = self.cells.iter().map(|cell| {
            let median = metric.map(|_| cell.medians.first().copied().flatten().map_or("-".to_owned(), short));
            let counts = [cell.values[0].clone(), cell.failures.of.to_string(), share(&cell.failures)];
            counts.into_iter().chain(median).collect()
        });
        Titled { title: format!("Runs by {}", self.keys[0]), head, rows: rows.collect() }
    }

    /// Two keys: the share of failures, and the median of the first figure.
    fn matrices(&self, metric: Option<&str>) -> Vec<Titled> {
        let values = |at: usize| {
            let mut list: Vec<&str> = self.cells.iter().map(|cell| cell.values[at].as_str()).collect();
            let number = |text: &str| text.parse::<f64>().unwrap_or(f64::INFINITY);
            list.sort_by(|a, b| number(a).total_cmp(&number(b)).then(a.cmp(b)));
            list.dedup();
            list
        };
        let (down, across) = (values(0), values(1));
        let matrix = |title: String, cell: &dyn Fn(&super::GroupCell) -> String| {
            let row = |first: &&str| {
                let of = |second: &&str| {
                    let found = self.cells.iter().find(|cell| cell.values == [*first, *second]);
                    found.map_or("-".to_owned(), cell)
                };
                core::iter::once((*first).to_owned()).chain(across.iter().map(of)).collect()
            };
            let corner = format!("{} \\ {}", self.keys[0], self.keys[1]);
            Titled {
                title,
                head: core::iter::once(corner).chain(across.iter().map(|value| (*value).to_owned())).collect(),
                rows: down.iter().map(row).collect(),
            }
        };
        let failed =
            matrix("Failed of runs".to_owned(), &|cell| format!("{}/{}", cell.failures.count, cell.failures.of));
        let median = metric.map(|metric| {
            matrix(format!("Median {metric}"), &|cell| {
                cell.medians.first().copied().flatten().map_or("-".into(), short)
            })
        });
        core::iter::once(failed).chain(median).collect()
    }
}

impl Titled {
    fn markdown(&self) -> String {
        let escaped = |cells: &[String]| cells.join(" | ").replace('\\', "\\\\");
        let mut text = format!("{}:\n\n| {} |\n|{}\n", self.title, escaped(&self.head), "---|".repeat(self.head.len()));
        for row in &self.rows {
            let _ = writeln!(text, "| {} |", escaped(row));
        }
        text
    }

    fn text(&self) -> String {
        let mut table = table(self.head.clone(), 1);
        self.rows.iter().for_each(|row| {
            table.add_row(row.clone());
        });
        format!("{}\n{table}\n", self.title)
    }
}

/// A share with its interval, in percent: `3 of 100 (0.62 to 8.5 %)`.
fn share(share: &Share) -> String {
    format!("{} of {} ({} to {} %)", share.count, share.of, percent(share.low), percent(share.high))
}

fn percent(x: f64) -> String {
    short(100.0 * x)
}

/// Three digits: `0.0123`, `4.56`, `789`, `1.2e-7`.
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
    use super::{Share, share, short};

    #[test]
    fn numbers_have_three_digits() {
        let found = [0.0, 0.012_345, 4.567, 789.4, 12_345.6, 1.23e-7, -0.5].map(short);
        assert_eq!(found, ["0", "0.0123", "4.57", "789", "12346", "1.23e-7", "-0.500"]);
        assert_eq!(share(&Share::new(3, 100)), "3 of 100 (0.623 to 8.52 %)");
    }
}
