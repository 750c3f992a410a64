//! Curves in panels above one another.

use super::PlotError;
use super::page::{BLUE, GREEN, GREY, ORANGE, WIDTH, on_page, on_sheet};
use plotters::coord::Shift;
use plotters::prelude::{
    AsRelative, BLACK, ChartBuilder, Color, DrawingArea, IntoFont, LineSeries, RED, RGBColor, SVGBackend, ShapeStyle,
    WHITE,
};
use std::ops::Range;
use std::path::Path;

/// Number of pixel columns. Two points per column, the lowest and the highest, keep every peak of a curve.
const COLUMNS: usize = WIDTH as usize;

/// A chart: panels above one another with a common abscissa.
pub struct Chart {
    /// Title of the page.
    pub title: String,
    /// The abscissa and its unit, for example `time / s`.
    pub abscissa: &'static str,
    /// Ends of the abscissa; `None`: the ends of the curves.
    pub range: Option<Range<f64>>,
    /// Where the panels stand.
    pub layout: Layout,
    /// Panels, in order.
    pub panels: Vec<Panel>,
}

/// Where the panels of a chart stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Above one another.
    #[default]
    Stacked,
    /// On one sheet that is wider than high, in rows and columns on one abscissa, which the lowest panels name.
    Landscape {
        /// Whether panels come in pairs: a low one on top of a high one.
        strips: bool,
    },
}

/// Height of the low panel of a pair, percent.
const STRIP: u32 = 36;

/// One panel of a chart.
pub struct Panel {
    /// Caption above the panel.
    pub caption: String,
    /// Quantity on the ordinate.
    pub quantity: &'static str,
    /// Unit of the ordinate, without prefix.
    pub unit: &'static str,
    /// Curves, each drawn over those before it.
    pub lines: Vec<Line>,
    /// Vertical lines across the curves.
    pub marks: Vec<Mark>,
    /// Ordinates of limits, each drawn as a line.
    pub bounds: Vec<f64>,
    /// Stretches of the abscissa in which a limit acts, drawn as bars at the foot of the panel.
    pub limited: Vec<(f64, f64)>,
}

/// One curve of a panel.
pub struct Line {
    /// Its name in the legend.
    pub name: &'static str,
    /// Pen of the curve; `None`: a pen by the curve's place in the panel.
    pub pen: Option<Pen>,
    /// Points of the curve.
    pub pieces: Pieces,
}

/// Colour and width of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    colour: RGBColor,
    width: u32,
}

impl Pen {
    /// Pen of the first curve.
    pub const BLUE: Self = Self { colour: BLUE, width: 2 };
    /// Broad pen for a curve under another one: both can be seen where they agree.
    pub const BROAD: Self = Self { colour: ORANGE, width: 5 };
    /// Pens for curves without a pen of their own, in turn.
    const TURNS: [Self; 3] = [Self::BLUE, Self { colour: ORANGE, width: 2 }, Self { colour: GREEN, width: 2 }];

    fn style(self) -> ShapeStyle {
        self.colour.stroke_width(self.width)
    }
}

/// Kind and place of a vertical line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// What it marks.
    pub kind: MarkKind,
    /// Its abscissa.
    pub at: f64,
}

/// What a vertical line marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// The reference reaches a point: thin and grey, under the curves.
    Waypoint,
    /// A fault: red, over the curves.
    Fault,
}

impl MarkKind {
    fn entry(self) -> (&'static str, ShapeStyle) {
        match self {
            Self::Waypoint => ("waypoint", GREY.stroke_width(1)),
            Self::Fault => ("fault", RED.stroke_width(2)),
        }
    }
}

impl Panel {
    /// Lines of a limit, and bars where one acts.
    const BOUND: (&'static str, RGBColor, u32) = ("limit", RED, 1);
    const LIMITED: (&'static str, RGBColor, u32) = ("limit acts", ORANGE, 6);

    /// Limits that lie near enough to be drawn: the axis then goes that far.
    fn bounds_shown(&self) -> Vec<f64> {
        let most = self.lines.iter().flat_map(|line| line.pieces.iter().flatten()).map(|point| point.1.abs());
        let most = most.fold(0.0, f64::max);
        self.bounds.iter().copied().filter(|bound| bound.is_finite() && bound.abs() <= BOUND_RATIO * most).collect()
    }
}

/// Greatest ratio of a limit to the largest value at which the limit is drawn: beyond, the curve would be flat.
const BOUND_RATIO: f64 = 5.0;

/// The points of a curve, as pieces without gaps.
pub type Pieces = Vec<Vec<(f64, f64)>>;

/// Draw a chart.
///
/// # Errors
/// The file cannot be written.
pub fn write_chart(chart: &Chart, path: &Path) -> Result<(), PlotError> {
    // The legend comes from the panel with the most curves; it includes the curves of the other panels.
    let mut entries = chart.panels.iter().max_by_key(|panel| panel.lines.len()).map_or(Vec::new(), curves);
    entries.extend(extras(&chart.panels));
    let range = chart.range.clone().unwrap_or_else(|| range(chart));
    let draw = |index: usize, area: &DrawingArea<SVGBackend<'_>, Shift>, labelled: bool| {
        draw_panel(area, &chart.panels[index], labelled.then_some(chart.abscissa), &range)
    };
    match chart.layout {
        Layout::Stacked => {
            on_page(path, &chart.title, &entries, chart.panels.len(), 1, |index, area| draw(index, area, true))
        }
        Layout::Landscape { strips } => {
            let cells = chart.panels.len() / if strips { 2 } else { 1 };
            on_sheet(path, &chart.title, &entries, cells, |cell, area, lowest| {
                if !strips {
                    return draw(cell, area, lowest);
                }
                let (strip, panel) = area.split_vertically(STRIP.percent_height());
                draw(2 * cell, &strip, false)?;
                draw(2 * cell + 1, &panel, lowest)
            })
        }
    }
}

/// Names and styles of a panel's curves.
fn curves(panel: &Panel) -> Vec<(&'static str, ShapeStyle)> {
    panel.lines.iter().zip(styles(panel)).map(|(line, style)| (line.name, style)).collect()
}

/// Names and styles of what any panel shows beside its curves.
fn extras(panels: &[Panel]) -> Vec<(&'static str, ShapeStyle)> {
    let entry = |(name, colour, width): (&'static str, RGBColor, u32)| (name, colour.stroke_width(width));
    let mut found = Vec::new();
    if panels.iter().any(|panel| !panel.bounds_shown().is_empty()) {
        found.push(entry(Panel::BOUND));
    }
    if panels.iter().any(|panel| !panel.limited.is_empty()) {
        found.push(entry(Panel::LIMITED));
    }
    for kind in [MarkKind::Waypoint, MarkKind::Fault] {
        if panels.iter().any(|panel| panel.marks.iter().any(|mark| mark.kind == kind)) {
            found.push(kind.entry());
        }
    }
    found
}

fn styles(panel: &Panel) -> impl Iterator<Item = ShapeStyle> {
    let turns = Pen::TURNS.into_iter().cycle();
    panel.lines.iter().zip(turns).map(|(line, turn)| line.pen.unwrap_or(turn).style())
}

/// Range from the first to the last abscissa of all curves.
fn range(chart: &Chart) -> Range<f64> {
    let lines = chart.panels.iter().flat_map(|panel| &panel.lines);
    let all = lines.flat_map(|line| line.pieces.iter().flatten().map(|point| point.0));
    let (from, to) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    if from < to { from..to } else { 0.0..1.0 }
}

/// Draw axes, curves and the mark; without a named abscissa, no numbers either.
fn draw_panel(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    panel: &Panel,
    abscissa: Option<&str>,
    range: &Range<f64>,
) -> Result<(), PlotError> {
    let curves: Vec<(ShapeStyle, Pieces)> = styles(panel)
        .zip(&panel.lines)
        .map(|(style, line)| (style, line.pieces.iter().map(|piece| thinned(piece.clone())).collect()))
        .collect();
    let all = || curves.iter().flat_map(|(_, pieces)| pieces.iter().flatten());
    let (scale, prefix) = prefix(all());
    let bounds = panel.bounds_shown();
    let ends: Vec<(f64, f64)> = bounds.iter().map(|bound| (0.0, *bound)).collect();
    let (low, high) = span(all().chain(&ends));
    let mut chart = ChartBuilder::on(area)
        .caption(panel.caption.as_str(), ("sans-serif", 17).into_font().color(&BLACK))
        .margin_right(20)
        .margin_left(10)
        .x_label_area_size(if abscissa.is_some() { 40 } else { 8 })
        .y_label_area_size(80)
        .build_cartesian_2d(range.clone(), low / scale..high / scale)?;
    chart
        .configure_mesh()
        .x_desc(abscissa.unwrap_or_default())
        .x_labels(if abscissa.is_some() { 9 } else { 0 })
        .y_desc(format!("{} / {prefix}{}", panel.quantity, panel.unit))
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .y_labels(5)
        .y_label_formatter(&|y| tick_label(*y))
        .light_line_style(WHITE)
        .draw()?;
    let mut line = |from: (f64, f64), to: (f64, f64), style: ShapeStyle| -> Result<(), PlotError> {
        let scaled = [from, to].map(|(x, y)| (x, y / scale));
        chart.draw_series(LineSeries::new(scaled, style))?;
        Ok(())
    };
    for mark in panel.marks.iter().filter(|mark| mark.kind == MarkKind::Waypoint) {
        line((mark.at, low), (mark.at, high), mark.kind.entry().1)?;
    }
    for y in bounds {
        line((range.start, y), (range.end, y), Panel::BOUND.1.stroke_width(Panel::BOUND.2))?;
    }
    // A stretch of one tick is as wide as a pixel.
    let least = (range.end - range.start) / f64::from(WIDTH);
    for (from, to) in &panel.limited {
        line((*from, low), (to.max(from + least), low), Panel::LIMITED.1.stroke_width(Panel::LIMITED.2))?;
    }
    for (style, pieces) in &curves {
        for piece in pieces {
            let scaled = piece.iter().map(|(x, y)| (*x, y / scale));
            chart.draw_series(LineSeries::new(scaled, *style))?;
        }
    }
    for mark in panel.marks.iter().filter(|mark| mark.kind == MarkKind::Fault) {
        let ends = [(mark.at, low / scale), (mark.at, high / scale)];
        chart.draw_series(LineSeries::new(ends, mark.kind.entry().1))?;
    }
    Ok(())
}

/// The lowest and the highest point of each pixel column, if there are many points; otherwise all points.
pub(super) fn thinned(all: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
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

/// Lowest and highest value with a margin; never an empty span.
fn span<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> (f64, f64) {
    let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.1), h.max(p.1)));
    if low > high {
        return (-1.0, 1.0);
    }
    // A constant gets a span in proportion to its size, so that rounding does not fill the height of the panel.
    let room = (0.08 * (high - low)).max(1e-6 * low.abs().max(high.abs())).max(1e-12);
    (low - room, high + room)
}

/// Power of a thousand and its prefix, from pico to one, such that the largest value lies between 1 and 1000.
fn prefix<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> (f64, &'static str) {
    let most = points.fold(0.0, |most, p| f64::max(most, p.1.abs()));
    let scales = [(1.0, ""), (1e-3, "m"), (1e-6, "\u{b5}"), (1e-9, "n"), (1e-12, "p")];
    // 0.5 of a unit reads better than 500 thousandths.
    scales.into_iter().find(|(scale, _)| most >= 0.1 * scale).unwrap_or((1.0, ""))
}

/// Label of a number beside an axis. Ticks are sums of steps: the one at zero can be a rounding error of either sign.
fn tick_label(value: f64) -> String {
    const STEPS: f64 = 1e6;
    format!("{}", (value * STEPS).round() / STEPS + 0.0)
}

#[cfg(test)]
mod tests {
    use super::{prefix, span};

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
