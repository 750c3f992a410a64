//! Plots of a run, as SVG: one file per quantity, one panel per joint.

use crate::record::{JointLabel, JointSample, Record};
use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, ChartBuilder, Color, DrawingArea, IntoDrawingArea, IntoFont, LineSeries, PathElement, RED, RGBColor,
    SVGBackend, Text, WHITE,
};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Something went wrong in drawing.
pub type PlotError = Box<dyn Error + Send + Sync>;

const WIDTH: u32 = 1000;
const PANEL: u32 = 240;
const TITLE: u32 = 40;
/// Width of an entry of the legend.
const LEGEND: i32 = 110;
const BLUE: RGBColor = RGBColor(0x1f, 0x4e, 0x9c);
const ORANGE: RGBColor = RGBColor(0xf0, 0x8c, 0x1e);

/// Points drawn per curve: two per pixel column hold every peak.
const COLUMNS: usize = WIDTH as usize;

/// A curve of a panel: its name, colour and width, and what it shows.
struct Curve {
    name: &'static str,
    colour: RGBColor,
    width: u32,
    value: fn(&JointSample) -> f64,
}

/// A file: what it shows of every joint.
struct Figure {
    file: &'static str,
    title: &'static str,
    axis: fn(&JointLabel) -> &'static str,
    unit: fn(&JointLabel) -> &'static str,
    curves: &'static [Curve],
}

const FIGURES: [Figure; 4] = [
    Figure {
        file: "position.svg",
        title: "Joint positions",
        axis: |_| "position",
        unit: JointLabel::position_unit,
        // The reference lies broad under the actual curve: where the two agree, both are seen.
        curves: &[
            Curve { name: "reference", colour: ORANGE, width: 5, value: |s| s.q_reference },
            Curve { name: "actual", colour: BLUE, width: 2, value: |s| s.q },
        ],
    },
    Figure {
        file: "velocity.svg",
        title: "Joint velocities",
        axis: |_| "velocity",
        unit: JointLabel::velocity_unit,
        curves: &[
            Curve { name: "reference", colour: ORANGE, width: 5, value: |s| s.qd_reference },
            Curve { name: "actual", colour: BLUE, width: 2, value: |s| s.qd },
        ],
    },
    Figure {
        file: "error.svg",
        title: "Tracking error: reference less actual position",
        axis: |_| "error",
        unit: JointLabel::position_unit,
        curves: &[Curve { name: "error", colour: BLUE, width: 2, value: |s| s.error() }],
    },
    Figure {
        file: "torque.svg",
        title: "Commanded torques and forces",
        axis: JointLabel::effort,
        unit: JointLabel::torque_unit,
        curves: &[Curve { name: "torque", colour: BLUE, width: 2, value: |s| s.torque }],
    },
];

/// What [`write_power`] draws.
const POWER: Figure = Figure {
    file: "power.svg",
    title: "Power of the commanded torques and forces",
    axis: |_| "power",
    unit: |_| "W",
    curves: &[Curve { name: "power", colour: BLUE, width: 2, value: |s| s.torque * s.qd }],
};

/// Draw the power of every joint into the folder; returns the file.
///
/// # Errors
/// The file cannot be written.
pub fn write_power(record: &Record, name: &str, folder: &Path) -> Result<PathBuf, PlotError> {
    write(record, &POWER, name, folder)
}

/// Draw every figure into the folder; returns the files.
///
/// # Errors
/// A file cannot be written.
pub fn write_all(record: &Record, name: &str, folder: &Path) -> Result<Vec<PathBuf>, PlotError> {
    FIGURES.iter().map(|figure| write(record, figure, name, folder)).collect()
}

fn write(record: &Record, figure: &Figure, name: &str, folder: &Path) -> Result<PathBuf, PlotError> {
    let path = folder.join(figure.file);
    draw(record, figure, name, &path)?;
    Ok(path)
}

fn draw(record: &Record, figure: &Figure, name: &str, path: &Path) -> Result<(), PlotError> {
    let joints = record.joints().len();
    let height = TITLE + PANEL * u32::try_from(joints)?;
    let area = SVGBackend::new(path, (WIDTH, height)).into_drawing_area();
    area.fill(&WHITE)?;
    let (head, body) = area.split_vertically(TITLE);
    let faulted = record.faults().iter().any(Option::is_some);
    draw_head(&head, &format!("{}: {name}", figure.title), figure.curves, faulted)?;
    for (joint, panel) in body.split_evenly((joints, 1)).iter().enumerate() {
        draw_panel(record, figure, joint, panel)?;
    }
    area.present()?;
    Ok(())
}

/// Title on the left, legend on the right: it holds for all panels, and covers no curve up here.
fn draw_head(
    head: &DrawingArea<SVGBackend<'_>, Shift>,
    title: &str,
    curves: &[Curve],
    faulted: bool,
) -> Result<(), PlotError> {
    head.draw(&Text::new(title.to_owned(), (12, 10), ("sans-serif", 22)))?;
    let named = curves.iter().map(|curve| (curve.name, curve.colour.stroke_width(curve.width)));
    let entries: Vec<_> = named.chain(faulted.then(|| ("fault", RED.stroke_width(2)))).collect();
    for (index, (name, style)) in entries.iter().rev().enumerate() {
        let x = i32::try_from(WIDTH)? - 20 - LEGEND * (1 + i32::try_from(index)?);
        head.draw(&PathElement::new([(x, 22), (x + 26, 22)], *style))?;
        head.draw(&Text::new((*name).to_owned(), (x + 34, 15), ("sans-serif", 15)))?;
    }
    Ok(())
}

fn draw_panel(
    record: &Record,
    figure: &Figure,
    joint: usize,
    panel: &DrawingArea<SVGBackend<'_>, Shift>,
) -> Result<(), PlotError> {
    let label = &record.joints()[joint];
    let curves: Vec<(&Curve, Vec<(f64, f64)>)> =
        figure.curves.iter().map(|curve| (curve, points(record, joint, curve.value))).collect();
    let (scale, prefix) = prefix(curves.iter().flat_map(|(_, points)| points));
    let (low, high) = span(curves.iter().flat_map(|(_, points)| points));
    let end = record.time().last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    let mut chart = ChartBuilder::on(panel)
        .caption(&label.name, ("sans-serif", 17).into_font().color(&BLACK))
        .margin_right(20)
        .margin_left(10)
        .x_label_area_size(40)
        .y_label_area_size(80)
        .build_cartesian_2d(0.0..end, low / scale..high / scale)?;
    chart
        .configure_mesh()
        .x_desc("time / s")
        .y_desc(format!("{} / {prefix}{}", (figure.axis)(label), (figure.unit)(label)))
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .y_labels(5)
        .y_label_formatter(&|y| tick_label(*y))
        .light_line_style(WHITE)
        .draw()?;
    for (curve, points) in curves {
        let scaled = points.into_iter().map(|(t, y)| (t, y / scale));
        chart.draw_series(LineSeries::new(scaled, curve.colour.stroke_width(curve.width)))?;
    }
    if let Some(tick) = record.faults().iter().position(Option::is_some) {
        let t = record.time()[tick];
        chart.draw_series(LineSeries::new([(t, low / scale), (t, high / scale)], RED.stroke_width(2)))?;
    }
    Ok(())
}

/// A joint's curve over time; where there are many ticks, the lowest and the highest of each pixel column.
fn points(record: &Record, joint: usize, value: fn(&JointSample) -> f64) -> Vec<(f64, f64)> {
    let finite = record.time().iter().copied().zip(record.joint(joint).map(value)).filter(|(_, y)| y.is_finite());
    let all: Vec<(f64, f64)> = finite.collect();
    let per_column = all.len().div_ceil(COLUMNS).max(1);
    if per_column <= 2 {
        return all;
    }
    let extremes = |column: &[(f64, f64)]| {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let mut ends = [column.iter().min_by(by_value), column.iter().max_by(by_value)];
        ends.sort_by(|a, b| a.map(|p| p.0).partial_cmp(&b.map(|p| p.0)).unwrap_or(std::cmp::Ordering::Equal));
        ends.into_iter().flatten().copied().collect::<Vec<_>>()
    };
    all.chunks(per_column).flat_map(extremes).collect()
}

/// Lowest and highest value with some room; never empty.
fn span<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> (f64, f64) {
    let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.1), h.max(p.1)));
    if low > high {
        return (-1.0, 1.0);
    }
    // A constant gets a span of its own size, so that rounding is not blown up to the height of the panel.
    let room = (0.08 * (high - low)).max(1e-6 * low.abs().max(high.abs())).max(1e-12);
    (low - room, high + room)
}

/// The power of a thousand that leaves the largest value between 1 and 1000, from pico to one, and its name.
fn prefix<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> (f64, &'static str) {
    let most = points.fold(0.0, |most, p| f64::max(most, p.1.abs()));
    let scales = [(1.0, ""), (1e-3, "m"), (1e-6, "\u{b5}"), (1e-9, "n"), (1e-12, "p")];
    // Half a unit still reads better as 0.5 than as 500 thousandths.
    scales.into_iter().find(|(scale, _)| most >= 0.1 * scale).unwrap_or((1.0, ""))
}

/// A number beside an axis. Ticks are sums of steps, so the one at zero may be a rest of rounding, below zero as likely as not.
fn tick_label(value: f64) -> String {
    const STEPS: f64 = 1e6;
    format!("{}", (value * STEPS).round() / STEPS + 0.0)
}

#[cfg(test)]
mod tests {
    use super::{points, prefix, span};
    use crate::record::{JointLabel, JointSample, Record};
    use dynamics_core::JointKind;
    use dynamics_core::control::LimitFlags;

    #[test]
    fn thinning_keeps_every_peak() {
        let label = JointLabel { name: "swing".to_owned(), kind: JointKind::Revolute };
        let mut record = Record::new(vec![label], 100_000);
        for tick in 0..100_000_u32 {
            let torque = if tick == 54_321 { 7.0 } else { 0.0 };
            let limits = LimitFlags::NONE;
            let sample = JointSample { q_reference: 0.0, q: 0.0, qd_reference: 0.0, qd: 0.0, torque, limits };
            record.push(f64::from(tick), [sample], None);
        }
        let thinned = points(&record, 0, |s| s.torque);
        assert!(thinned.len() <= 2000);
        assert!(thinned.contains(&(54_321.0, 7.0)));
        assert!(thinned.is_sorted_by(|a, b| a.0 <= b.0));
    }

    #[test]
    fn axes_are_never_empty_and_read_well() {
        assert_eq!(span([].iter()), (-1.0, 1.0));
        let (low, high) = span([(0.0, 3.0), (1.0, 3.0)].iter());
        assert!(low < 3.0 && high > 3.0);
        assert_eq!(prefix([(0.0, -2e-5)].iter()).1, "\u{b5}");
        assert_eq!(prefix([(0.0, 0.3)].iter()).1, "");
        assert_eq!(prefix([(0.0, 0.0)].iter()).1, "");
        assert_eq!([-1e-17, 0.55, -0.4].map(super::tick_label), ["0", "0.55", "-0.4"]);
    }
}
