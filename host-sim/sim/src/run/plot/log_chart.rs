//! Curves, and points that should lie on them, both axes logarithmic.

use super::PlotError;
use super::ticks::ticks;
use plotters::prelude::{
    BLACK, BindKeyPoints as _, ChartBuilder, Circle, Color, IntoDrawingArea, IntoFont, IntoLogRange, LineSeries,
    PathElement, RGBColor, SVGBackend, Text, WHITE,
};
use std::path::Path;

const SIZE: (u32, u32) = (1060, 500);
/// Width of the legend, to the right of the axes, where it covers no curve.
const LEGEND: u32 = 290;
const COLOURS: [RGBColor; 6] = [
    RGBColor(0x1f, 0x4e, 0x9c),
    RGBColor(0xf0, 0x8c, 0x1e),
    RGBColor(0x2c, 0x8a, 0x4b),
    RGBColor(0xc0, 0x39, 0x2b),
    RGBColor(0x7d, 0x3c, 0x98),
    RGBColor(0x5d, 0x6d, 0x7e),
];

/// Curves in one panel, both axes logarithmic.
pub struct LogChart<'a> {
    /// Title of the chart.
    pub title: &'a str,
    /// Abscissa and ordinate with their units.
    pub axes: [&'a str; 2],
    /// Up to six curves.
    pub curves: &'a [LogCurve],
}

/// A curve, and points that should lie on it.
pub struct LogCurve {
    /// Its name in the legend.
    pub name: String,
    /// Points of the curve; both coordinates above zero.
    pub line: Vec<(f64, f64)>,
    /// Points that should lie on the curve.
    pub dots: Vec<(f64, f64)>,
}

/// Draw a chart.
///
/// # Errors
/// The file cannot be written.
pub fn write_log_chart(figure: &LogChart<'_>, path: &Path) -> Result<(), PlotError> {
    let page = SVGBackend::new(path, SIZE).into_drawing_area();
    page.fill(&WHITE)?;
    let (area, beside) = page.split_horizontally(SIZE.0 - LEGEND);
    let points = || figure.curves.iter().flat_map(|curve| curve.line.iter().chain(&curve.dots));
    let span = |part: fn(&(f64, f64)) -> f64| {
        let (low, high) = points().map(part).fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        (0.8 * low, 1.25 * high)
    };
    let [x, y] = [span(|p| p.0), span(|p| p.1)];
    let mut chart = ChartBuilder::on(&area)
        .caption(figure.title, ("sans-serif", 19).into_font().color(&BLACK))
        .margin(15)
        .x_label_area_size(45)
        .y_label_area_size(80)
        .build_cartesian_2d(
            (x.0..x.1).log_scale().with_key_points(ticks(x.0, x.1)),
            (y.0..y.1).log_scale().with_key_points(ticks(y.0, y.1)),
        )?;
    chart
        .configure_mesh()
        .x_desc(figure.axes[0])
        .y_desc(figure.axes[1])
        .x_label_formatter(&|x| format!("{x:e}"))
        .y_label_formatter(&|y| format!("{y:e}"))
        .light_line_style(WHITE)
        .draw()?;
    for ((curve, colour), row) in figure.curves.iter().zip(COLOURS).zip((60..).step_by(24)) {
        chart.draw_series(LineSeries::new(curve.line.iter().copied(), colour.stroke_width(2)))?;
        beside.draw(&PathElement::new([(0, row), (20, row)], colour.stroke_width(2)))?;
        beside.draw(&Text::new(curve.name.clone(), (28, row - 6), ("sans-serif", 14)))?;
        chart.draw_series(curve.dots.iter().map(|&dot| Circle::new(dot, 4, colour.filled())))?;
    }
    page.present()?;
    Ok(())
}
