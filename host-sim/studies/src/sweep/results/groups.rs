//! Tables of runs, grouped by the values of one key or of two.

use super::markdown::{Titled, share, short};
use super::{Distribution, Group, GroupCell};

impl Group {
    /// Table for one key: a row for each value.
    pub(super) fn list(&self, metric: Option<&Distribution>) -> Titled {
        let mut head = vec![self.keys[0].clone(), "runs".to_owned(), "failed (95 % interval)".to_owned()];
        head.extend(metric.map(|metric| format!("median {}, complete runs", metric.label())));
        let rows = self.cells.iter().map(|cell| {
            let median = metric.map(|_| cell.medians.first().copied().flatten().map_or("-".to_owned(), short));
            let counts = [cell.values[0].clone(), cell.failures.of.to_string(), share(&cell.failures)];
            counts.into_iter().chain(median).collect()
        });
        Titled { title: format!("Runs by {}", self.keys[0]), head, rows: rows.collect() }
    }

    /// Tables for two keys: the share of failures, and the median of the first figure.
    pub(super) fn matrices(&self, metric: Option<&Distribution>) -> Vec<Titled> {
        let values = |at: usize| {
            let mut list: Vec<&str> = self.cells.iter().map(|cell| cell.values[at].as_str()).collect();
            let number = |text: &str| text.parse::<f64>().unwrap_or(f64::INFINITY);
            list.sort_by(|a, b| number(a).total_cmp(&number(b)).then(a.cmp(b)));
            list.dedup();
            list
        };
        let (down, across) = (values(0), values(1));
        let matrix = |title: String, cell: &dyn Fn(&GroupCell) -> String| {
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
            matrix(format!("Median {} of the complete runs", metric.label()), &|cell| {
                cell.medians.first().copied().flatten().map_or("-".into(), short)
            })
        });
        core::iter::once(failed).chain(median).collect()
    }
}
