//! Plots as SVG. Of a run: one file per quantity, one panel per joint. Of anything else: a [`Chart`].

use crate::run::record::{JointLabel, JointSample, Record};
use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, Color, DrawingArea, IntoDrawingArea, IntoFont, IntoLogRange, LineSeries, PathElement,
    RED, RGBColor, SVGBackend, ShapeStyle, Text, WHITE,
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
const GREEN: RGBColor = RGBColor(0x2e, 0x8b, 0x57);

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

/// A file of panels above one another, over one abscissa.
pub struct Chart {
    /// What stands on top.
    pub title: String,
    /// The abscissa and its unit, for example `time / s`.
    pub abscissa: &'static str,
    /// From top to bottom.
    pub panels: Vec<Panel>,
}

/// One panel of a chart.
pub struct Panel {
    /// What stands above it.
    pub caption: String,
    /// What it shows.
    pub quantity: &'static str,
    /// In which unit, without prefix.
    pub unit: &'static str,
    /// Up to three curves.
    pub lines: Vec<Line>,
}

/// One curve of a panel.
pub struct Line {
    /// Its name in the legend.
    pub name: &'static str,
    /// What it goes through.
    pub pieces: Pieces,
}

/// The points of a curve, in pieces without a gap.
pub type Pieces = Vec<Vec<(f64, f64)>>;

/// Draw a chart.
///
/// # Errors
/// The file cannot be written.
pub fn write_chart(chart: &Chart, path: &Path) -> Result<(), PlotError> {
    const COLOURS: [RGBColor; 3] = [BLUE, ORANGE, GREEN];
    let styled = |lines: &[Line]| -> Vec<(&'static str, ShapeStyle)> {
        lines.iter().zip(COLOURS.iter().cycle()).map(|(line, colour)| (line.name, colour.stroke_width(2))).collect()
    };
    // The legend is that of the panel with the most curves; the others' are among them.
    let legend =
        chart.panels.iter().max_by_key(|panel| panel.lines.len()).map_or(Vec::new(), |panel| styled(&panel.lines));
    let ends = |panel: &Panel| {
        panel.lines.iter().flat_map(|line| line.pieces.iter().flatten().map(|p| p.0)).collect::<Vec<_>>()
    };
    let all: Vec<f64> = chart.panels.iter().flat_map(ends).collect();
    let (from, to) = all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let range = if from < to { from..to } else { 0.0..1.0 };
    let title = chart.title.clone();
    on_page(path, &title, &legend, chart.panels.len(), |index, area| {
        let panel = &chart.panels[index];
        let curves = panel
            .lines
            .iter()
            .zip(styled(&panel.lines))
            .map(|(line, (_, style))| (style, line.pieces.iter().map(|piece| thinned(piece.clone())).collect()));
        draw_curves(
            area,
            &Axes {
                caption: &panel.caption,
                abscissa: chart.abscissa,
                range: range.clone(),
                quantity: panel.quantity,
                unit: panel.unit,
            },
            &curves.collect::<Vec<_>>(),
            None,
        )
    })
}

fn draw(record: &Record, figure: &Figure, name: &str, path: &Path) -> Result<(), PlotError> {
    let faulted = record.faults().iter().any(Option::is_some);
    let named = figure.curves.iter().map(|curve| (curve.name, curve.colour.stroke_width(curve.width)));
    let legend: Vec<_> = named.chain(faulted.then(|| ("fault", RED.stroke_width(2)))).collect();
    on_page(path, &format!("{}: {name}", figure.title), &legend, record.joints().len(), |joint, area| {
        let label = &record.joints()[joint];
        let curves: Vec<(ShapeStyle, Pieces)> = figure
            .curves
            .iter()
            .map(|curve| (curve.colour.stroke_width(curve.width), vec![points(record, joint, curve.value)]))
            .collect();
        let end = record.time().last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
        let fault = record.faults().iter().position(Option::is_some).map(|tick| record.time()[tick]);
        let axes = Axes {
            caption: &label.name,
            abscissa: "time / s",
            range: 0.0..end,
            quantity: (figure.axis)(label),
            unit: (figure.unit)(label),
        };
        draw_curves(area, &axes, &curves, fault)
    })
}

/// A file with a head and `count` panels, each drawn by `panel`.
fn on_page(
    path: &Path,
    title: &str,
    legend: &[(&str, ShapeStyle)],
    count: usize,
    panel: impl Fn(usize, &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), PlotError>,
) -> Result<(), PlotError> {
    on_tall_page(path, title, legend, count, 1, panel)
}

/// As [`on_page`], with panels `taller` times as high.
fn on_tall_page(
    path: &Path,
    title: &str,
    legend: &[(&str, ShapeStyle)],
    count: usize,
    taller: usize,
    panel: impl Fn(usize, &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), PlotError>,
) -> Result<(), PlotError> {
    let height = TITLE + PANEL * u32::try_from(count * taller)?;
    let area = SVGBackend::new(path, (WIDTH, height)).into_drawing_area();
    area.fill(&WHITE)?;
    let (head, body) = area.split_vertically(TITLE);
    draw_head(&head, title, legend)?;
    for (index, area) in body.split_evenly((count, 1)).iter().enumerate() {
        panel(index, area)?;
    }
    area.present()?;
    Ok(())
}

/// Title on the left, legend on the right: it holds for all panels, and covers no curve up here.
fn draw_head(
    head: &DrawingArea<SVGBackend<'_>, Shift>,
    title: &str,
    legend: &[(&str, ShapeStyle)],
) -> Result<(), PlotError> {
    head.draw(&Text::new(title.to_owned(), (12, 10), ("sans-serif", 22)))?;
    for (index, (name, style)) in legend.iter().rev().enumerate() {
        let x = i32::try_from(WIDTH)? - 20 - LEGEND * (1 + i32::try_from(index)?);
        head.draw(&PathElement::new([(x, 22), (x + 26, 22)], *style))?;
        head.draw(&Text::new((*name).to_owned(), (x + 34, 15), ("sans-serif", 15)))?;
    }
    Ok(())
}

/// What a panel's axes say.
struct Axes<'a> {
    caption: &'a str,
    abscissa: &'a str,
    range: std::ops::Range<f64>,
    quantity: &'a str,
    unit: &'a str,
}

/// Axes and curves, each of pieces; `mark` is where a red line stands across.
fn draw_curves(
    panel: &DrawingArea<SVGBackend<'_>, Shift>,
    axes: &Axes<'_>,
    curves: &[(ShapeStyle, Pieces)],
    mark: Option<f64>,
) -> Result<(), PlotError> {
    let all = || curves.iter().flat_map(|(_, pieces)| pieces.iter().flatten());
    let (scale, prefix) = prefix(all());
    let (low, high) = span(all());
    let mut chart = ChartBuilder::on(panel)
        .caption(axes.caption, ("sans-serif", 17).into_font().color(&BLACK))
        .margin_right(20)
        .margin_left(10)
        .x_label_area_size(40)
        .y_label_area_size(80)
        .build_cartesian_2d(axes.range.clone(), low / scale..high / scale)?;
    chart
        .configure_mesh()
        .x_desc(axes.abscissa)
        .y_desc(format!("{} / {prefix}{}", axes.quantity, axes.unit))
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .y_labels(5)
        .y_label_formatter(&|y| tick_label(*y))
        .light_line_style(WHITE)
        .draw()?;
    for (style, pieces) in curves {
        for piece in pieces {
            let scaled = piece.iter().map(|(x, y)| (*x, y / scale));
            chart.draw_series(LineSeries::new(scaled, *style))?;
        }
    }
    if let Some(x) = mark {
        chart.draw_series(LineSeries::new([(x, low / scale), (x, high / scale)], RED.stroke_width(2)))?;
    }
    Ok(())
}

/// A joint's curve over time, as far as it is finite, thinned.
fn points(record: &Record, joint: usize, value: fn(&JointSample) -> f64) -> Vec<(f64, f64)> {
    let finite = record.time().iter().copied().zip(record.joint(joint).map(value)).filter(|(_, y)| y.is_finite());
    thinned(finite.collect())
}

/// Where there are many points, the lowest and the highest of each pixel column.
fn thinned(all: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
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

/// Points of several kinds, in panels above one another; both axes logarithmic.
pub struct Scatter {
    /// What stands on top.
    pub title: String,
    /// The abscissa and its unit.
    pub abscissa: &'static str,
    /// Names of the kinds, at most five.
    pub kinds: Vec<String>,
    /// From top to bottom.
    pub panels: Vec<ScatterPanel>,
}

/// One panel of points.
pub struct ScatterPanel {
    /// The ordinate and its unit.
    pub quantity: &'static str,
    /// The points.
    pub spots: Vec<Spot>,
}

/// A point; both coordinates above zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Abscissa and ordinate.
    pub at: (f64, f64),
    /// Which of the kinds.
    pub kind: usize,
    /// Whether it lies on the line that is drawn.
    pub on_front: bool,
}

const KINDS: [RGBColor; 5] = [BLUE, GREEN, ORANGE, RGBColor(0x8b, 0x3a, 0x8b), RGBColor(0x80, 0x80, 0x80)];

/// Draw points of several kinds, and a line through those on the front.
///
/// # Errors
/// The file cannot be written.
pub fn write_scatter(scatter: &Scatter, path: &Path) -> Result<(), PlotError> {
    const TALLER: usize = 2;
    let legend: Vec<(&str, ShapeStyle)> = scatter
        .kinds
        .iter()
        .zip(KINDS.iter().cycle())
        .map(|(kind, colour)| (kind.as_str(), colour.stroke_width(6)))
        .collect();
    let all = scatter.panels.iter().flat_map(|panel| panel.spots.iter().map(|spot| spot.at.0));
    let (from, to) = decades(all);
    on_tall_page(path, &scatter.title, &legend, scatter.panels.len(), TALLER, |index, area| {
        let panel = &scatter.panels[index];
        let (low, high) = decades(panel.spots.iter().map(|spot| spot.at.1));
        let mut chart = ChartBuilder::on(area)
            .margin_right(20)
            .margin_left(10)
            .margin_top(10)
            .x_label_area_size(40)
            .y_label_area_size(80)
            .build_cartesian_2d((from..to).log_scale(), (low..high).log_scale())?;
        chart
            .configure_mesh()
            .x_desc(scatter.abscissa)
            .y_desc(panel.quantity)
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .light_line_style(WHITE)
            .draw()?;
        let mut front: Vec<(f64, f64)> = panel.spots.iter().filter(|spot| spot.on_front).map(|spot| spot.at).collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        // A step down only where the next point lies: what is between costs what the cheaper one does.
        let steps = front.iter().zip(front.iter().skip(1)).flat_map(|(a, b)| [*a, (b.0, a.1)]);
        chart.draw_series(LineSeries::new(steps.chain(front.last().copied()), BLACK.mix(0.5).stroke_width(1)))?;
        for spot in &panel.spots {
            let colour = KINDS[spot.kind % KINDS.len()];
            let (size, style) = if spot.on_front { (5, colour.filled()) } else { (3, colour.mix(0.45).filled()) };
            chart.draw_series(core::iter::once(Circle::new(spot.at, size, style)))?;
        }
        Ok(())
    })
}

/// Numbers with some room, for a logarithmic axis; never empty.
fn decades(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers.fold((f64::INFINITY, 0.0), |(l, h), x| (f64::min(l, x), f64::max(h, x)));
    if low > high { (1.0, 10.0) } else { (low / 1.5, high * 1.5) }
}

#[cfg(test)]
mod tests {
    use super::{points, prefix, span};
    use crate::run::record::{JointLabel, JointSample, Record};
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
