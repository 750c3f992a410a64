//! Points of several kinds.

use super::PlotError;
use super::page::{BLUE, GREEN, ORANGE, WIDTH, on_page};
use super::ticks::ticks;
use plotters::prelude::{
    BLACK, BindKeyPoints as _, ChartBuilder, Circle, Color, IntoLogRange, LineSeries, RGBColor, ShapeStyle, Text, WHITE,
};
use std::path::Path;

/// Points of several kinds, in panels above one another; both axes logarithmic.
pub struct Scatter<'a> {
    /// Title of the page.
    pub title: String,
    /// The abscissa and its unit.
    pub abscissa: String,
    /// Label of an abscissa.
    pub abscissa_label: &'a dyn Fn(f64) -> String,
    /// Names of the kinds, at most five. The legend has those that occur.
    pub kinds: Vec<String>,
    /// Panels, from top to bottom.
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
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Abscissa and ordinate.
    pub at: (f64, f64),
    /// Index of the point's kind.
    pub kind: usize,
    /// The point's name if it is on the drawn Pareto front: the front is numbered, and its names stand beside the panel.
    pub on_front: Option<String>,
    /// Whether the point has a ring around it.
    pub ringed: bool,
}

const KINDS: [RGBColor; 5] = [BLUE, GREEN, ORANGE, RGBColor(0x8b, 0x3a, 0x8b), RGBColor(0x80, 0x80, 0x80)];

/// Width of the names beside a panel.
const NAMES: u32 = 250;

/// Room of a point's number, pixels.
const LABEL: i32 = 13;

/// Meaning of the ring, in the list of names.
const RING: &str = "the scene's own choice";

/// Draw points of several kinds, and a stepped line through the numbered Pareto front.
///
/// # Errors
/// The file cannot be written.
pub fn write_scatter(scatter: &Scatter<'_>, path: &Path) -> Result<(), PlotError> {
    const TALLER: usize = 2;
    let spots = || scatter.panels.iter().flat_map(|panel| &panel.spots);
    let kinds = scatter.kinds.iter().zip(KINDS.iter().cycle()).enumerate();
    let legend: Vec<(&str, ShapeStyle)> = kinds
        .filter(|(kind, _)| spots().any(|spot| spot.kind == *kind))
        .map(|(_, (name, colour))| (name.as_str(), colour.stroke_width(6)))
        .collect();
    let (from, to) = decades(spots().map(|spot| spot.at.0));
    on_page(path, &scatter.title, &legend, scatter.panels.len(), TALLER, |index, area| {
        let panel = &scatter.panels[index];
        let (low, high) = decades(panel.spots.iter().map(|spot| spot.at.1));
        let (area, beside) = area.split_horizontally(WIDTH - NAMES);
        let mut chart = ChartBuilder::on(&area)
            .margin_right(20)
            .margin_left(10)
            .margin_top(10)
            .x_label_area_size(40)
            .y_label_area_size(80)
            .build_cartesian_2d(
                (from..to).log_scale().with_key_points(ticks(from, to)),
                (low..high).log_scale().with_key_points(ticks(low, high)),
            )?;
        chart
            .configure_mesh()
            .x_desc(scatter.abscissa.as_str())
            .y_desc(panel.quantity)
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_label_formatter(&|x| (scatter.abscissa_label)(*x))
            .y_label_formatter(&|y| format!("{y:e}"))
            .light_line_style(WHITE)
            .draw()?;
        let mut front: Vec<(&Spot, &str)> =
            panel.spots.iter().filter_map(|spot| Some((spot, spot.on_front.as_deref()?))).collect();
        front.sort_by(|(a, _), (b, _)| a.at.0.total_cmp(&b.at.0));
        let points = || front.iter().map(|(spot, _)| spot.at);
        // The line steps down only at the next point of the front; up to there the cheaper point is the best.
        let steps = points().zip(points().skip(1)).flat_map(|(a, b)| [a, (b.0, a.1)]);
        chart.draw_series(LineSeries::new(steps.chain(points().next_back()), BLACK.mix(0.5).stroke_width(1)))?;
        for spot in &panel.spots {
            let colour = KINDS[spot.kind % KINDS.len()];
            let (size, style) =
                if spot.on_front.is_some() { (5, colour.filled()) } else { (3, colour.mix(0.45).filled()) };
            chart.draw_series(core::iter::once(Circle::new(spot.at, size, style)))?;
            if spot.ringed {
                chart.draw_series(core::iter::once(Circle::new(spot.at, 9, BLACK.stroke_width(2))))?;
            }
        }
        let line = |row: i32, text: String| beside.draw(&Text::new(text, (0, 20 + 20 * row), ("sans-serif", 14)));
        let mut labels: Vec<(i32, i32)> = Vec::new();
        for (number, (spot, name)) in (1..).zip(&front) {
            // Below the front there is room, also for the numbers of points that lie close together.
            let (x, mut y) = chart.backend_coord(&spot.at);
            while labels.iter().any(|label| (label.0 - x).abs() < LABEL && (label.1 - y).abs() < LABEL) {
                y += LABEL;
            }
            labels.push((x, y));
            area.draw(&Text::new(format!("{number}"), (x - 12, y + 4), ("sans-serif", 13)))?;
            line(number, format!("{number}  {name}"))?;
        }
        if panel.spots.iter().any(|spot| spot.ringed) {
            line(0, format!("\u{25ef}  {RING}"))?;
        }
        Ok(())
    })
}

/// Range of the numbers with a margin, for a logarithmic axis; never empty.
fn decades(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers.fold((f64::INFINITY, 0.0), |(l, h), x| (f64::min(l, x), f64::max(h, x)));
    if low > high { (1.0, 10.0) } else { (low / 1.5, high * 1.5) }
}
