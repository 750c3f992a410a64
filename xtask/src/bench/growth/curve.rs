//! Times over sizes: exponent of growth, tables, figures.

use crate::table::Table;
use anyhow::Result;
use report::{Figure, Point, Scale, Series, sheet};

/// Sizes.
pub(super) const JOINTS: &str = "joints";
pub(super) const STEPS: &str = "steps per tick";
pub(super) const RUNS: &str = "runs";
pub(super) const THREADS: &str = "threads";

/// Unit of the computing time of a run.
pub(super) const PACE: &str = "ms per simulated second";

/// Panels of the picture: caption, size, and unit of the ordinate.
const PANELS: [(&str, &str, &str); 4] = [
    ("Time over joints", JOINTS, PACE),
    ("Time over integration steps per tick of 1 ms", STEPS, PACE),
    ("Time over the number of runs of 0.05 s", RUNS, "s"),
    ("Speed over threads, against one thread", THREADS, "times"),
];

/// Two exponents that differ by less are reported as equal.
const TOLERANCE: f64 = 0.1;

/// A quantity at each of several sizes.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    size: &'static str,
    quantity: &'static str,
    unit: &'static str,
    pub(super) points: Vec<(f64, f64)>,
}

impl Curve {
    /// Creates the curve of these sizes and cases. `value` returns the quantity of a case.
    pub(super) fn of<C>(
        size: &'static str,
        quantity: &'static str,
        unit: &'static str,
        cases: impl Iterator<Item = (f64, C)>,
        value: impl Fn(C) -> Result<f64>,
    ) -> Result<Self> {
        let points = cases.map(|(at, case)| Ok((at, value(case)?))).collect::<Result<_>>()?;
        Ok(Self { size, quantity, unit, points })
    }

    /// Sentence about the growth.
    fn verdict(&self, exponent: Option<f64>) -> String {
        let Some(exponent) = exponent else {
            return "Not determined: this needs two sizes, and values above zero.".to_owned();
        };
        let grows = match exponent {
            x if x < -TOLERANCE => "falls with more",
            x if x < TOLERANCE => "hardly changes with",
            x if x < 1.0 - TOLERANCE => "grows slower than linearly with",
            x if x <= 1.0 + TOLERANCE => "grows linearly with",
            _ => "grows faster than linearly with",
        };
        format!("The {} {grows} {}.", self.quantity, self.size)
    }
}

/// Slope of the logarithm of the ordinates over that of the abscissas, by least squares. `None` without two different abscissas, or if a number is not
/// positive.
fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let usable = |x: f64| x.is_finite() && x > 0.0;
    if !points.iter().all(|(x, y)| usable(*x) && usable(*y)) {
        return None;
    }
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let (square, product) = (mean(&|p| (p.0 - x).powi(2)), mean(&|p| (p.0 - x) * (p.1 - y)));
    (square > 0.0).then(|| product / square)
}

/// Formats a number with three significant digits, and a missing one as `-`.
fn short(x: f64) -> String {
    if !x.is_finite() {
        return "-".to_owned();
    }
    let digits = if x.abs() >= 100.0 { 0 } else { (2.0 - x.abs().max(1e-3).log10().floor()) as usize };
    format!("{x:.digits$}")
}

/// Exponents: a row for each curve.
pub(super) fn growth(curves: &[Curve]) -> Table {
    let mut table = Table::new(&["over", "sizes", "quantity", "from", "to", "exponent", "of the last two", "growth"]);
    for curve in curves {
        let whole = exponent(&curve.points);
        let end = exponent(&curve.points[curve.points.len().saturating_sub(2)..]);
        let (from, to) = (curve.points.first().copied(), curve.points.last().copied());
        let power = |exponent: Option<f64>| exponent.map_or("-".to_owned(), |x| format!("{x:.2}"));
        let size = |point: Option<(f64, f64)>| point.map_or("-".to_owned(), |point| point.0.to_string());
        let cell = |point: Option<(f64, f64)>| {
            point.map_or("-".to_owned(), |point| format!("{} {}", short(point.1), curve.unit))
        };
        table.row(&[
            curve.size.into(),
            format!("{} to {}", size(from), size(to)),
            curve.quantity.into(),
            cell(from),
            cell(to),
            power(whole),
            power(end),
            curve.verdict(whole),
        ]);
    }
    table
}

/// Every value: a row for each point.
pub(super) fn values(curves: &[Curve]) -> Table {
    let mut table = Table::new(&["over", "size", "quantity", "value", "unit"]);
    for curve in curves {
        for (size, value) in &curve.points {
            table.put(&[&curve.size, size, &curve.quantity, &short(*value), &curve.unit]);
        }
    }
    table
}

/// The panels, each with a dashed line of linear growth from its first point.
pub(super) fn drawing(curves: &[Curve]) -> String {
    let panel = |(caption, size, unit): (&str, &str, &str)| {
        let mut figure = Figure::new(caption, size, unit).scaled(Scale::Log, Scale::Log);
        let shown: Vec<&Curve> = curves.iter().filter(|curve| curve.size == size && curve.unit == unit).collect();
        for curve in &shown {
            let points = curve.points.iter().map(|(x, y)| Point::at(*x, *y)).collect();
            figure = figure.with(Series::points(curve.quantity, points));
        }
        let ends = shown.first().and_then(|curve| Some((*curve.points.first()?, *curve.points.last()?)));
        let Some((from, to)) = ends else { return figure };
        figure.with(Series::limit("linear", from, (to.0, from.1 * to.0 / from.0)))
    };
    sheet("Growth of the simulator's computing time", 2, &PANELS.map(panel))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::{Curve, JOINTS, PACE, drawing, exponent, growth, short, values};

    fn curve(power: f64) -> Curve {
        let cases = (1..=6).map(|n| (f64::from(n), f64::from(n)));
        Curve::of(JOINTS, "time of one run alone", PACE, cases, |n: f64| Ok(3.0 * n.powf(power))).unwrap()
    }

    #[test]
    fn the_exponent_of_a_power_is_found() {
        for power in [-1.0, 0.0, 0.5, 1.0, 3.0] {
            let found = exponent(&curve(power).points).unwrap();
            assert!((found - power).abs() < 1e-12, "{power}: {found}");
        }
        // By hand: logarithms to base 2 are (0, 0), (1, 2), (2, 1); their slope is 1/2.
        assert!((exponent(&[(1.0, 1.0), (2.0, 4.0), (4.0, 2.0)]).unwrap() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn an_exponent_needs_two_sizes_and_positive_values() {
        for points in [&[][..], &[(1.0, 2.0)], &[(2.0, 1.0), (2.0, 3.0)], &[(1.0, 2.0), (2.0, 0.0)], &[(1.0, f64::NAN)]]
        {
            assert_eq!(exponent(points), None, "{points:?}");
        }
    }

    #[test]
    fn each_exponent_has_its_sentence() {
        for (power, said) in [
            (-1.0, "falls with more joints"),
            (0.0, "hardly changes with joints"),
            (0.5, "grows slower than linearly with joints"),
            (1.05, "grows linearly with joints"),
            (1.5, "grows faster than linearly with joints"),
        ] {
            let table = growth(&[curve(power)]).0;
            assert!(table.contains(&format!("The time of one run alone {said}.")), "{table}");
        }
        let bent = Curve { points: vec![(1.0, 1.0), (2.0, 1.0), (4.0, 4.0)], ..curve(1.0) };
        assert!(growth(&[bent]).0.contains("| 1.00 | 2.00 |"));
        let none = Curve { points: vec![(1.0, 1.0)], ..curve(1.0) };
        assert!(growth(&[none]).0.contains("| - | - | Not determined"));
    }

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!([12345.6, 123.4, 12.34, 1.234, 0.01234].map(short), ["12346", "123", "12.3", "1.23", "0.0123"]);
        assert_eq!(short(f64::NAN), "-");
        assert_eq!(
            values(&[curve(1.0)]).0.lines().nth(3).unwrap(),
            "| joints | 2 | time of one run alone | 6.00 | ms per simulated second |"
        );
    }

    #[test]
    fn every_panel_is_drawn_and_curves_are_in_theirs() {
        let svg = drawing(&[curve(1.0), curve(0.5)]);
        assert_eq!(svg.matches("class=\"title\"").count(), 4);
        assert_eq!(svg.matches("<circle").count(), 2 * (6 + 1), "points, and a key for each curve");
        assert_eq!(svg.matches(">linear</text>").count(), 1);
    }
}
