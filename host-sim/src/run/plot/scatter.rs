//! Points of several kinds.

use super::PlotError;
use super::page::{BLUE, GREEN, ORANGE, on_page};
use plotters::prelude::{BLACK, ChartBuilder, Circle, Color, IntoLogRange, LineSeries, RGBColor, ShapeStyle, WHITE};
use std::path::Path;

/// Points of several kinds, in panels above one another; both axes logarithmic.
pub struct Scatter {
    /// Title of the page.
    pub title: String,
    /// The abscissa and its unit.
    pub abscissa: &'static str,
    /// Names of the kinds, at most five.
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Abscissa and ordinate.
    pub at: (f64, f64),
    /// Index of the point's kind.
    pub kind: usize,
    /// Whether the point is on the drawn Pareto front.
    pub on_front: bool,
}

const KINDS: [RGBColor; 5] = [BLUE, GREEN, ORANGE, RGBColor(0x8b, 0x3a, 0x8b), RGBColor(0x80, 0x80, 0x80)];

/// Draw points of several kinds, and a stepped line through the Pareto front.
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
    on_page(path, &scatter.title, &legend, scatter.panels.len(), TALLER, |index, area| {
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
        // The line steps down only at the next point of the front; up to there the cheaper point is the best.
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

/// Range of the numbers with a margin, for a logarithmic axis; never empty.
fn decades(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers.fold((f64::INFINITY, 0.0), |(l, h), x| (f64::min(l, x), f64::max(h, x)));
    if low > high { (1.0, 10.0) } else { (low / 1.5, high * 1.5) }
}
