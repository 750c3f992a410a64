//! Curves, and points that should lie on them, both axes logarithmic.

use super::PlotError;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, Color, IntoDrawingArea, IntoFont, IntoLogRange, LineSeries, PathElement, RGBColor,
    SVGBackend, SeriesLabelPosition, WHITE,
};
use std::path::Path;

const SIZE: (u32, u32) = (800, 500);
const COLOURS: [RGBColor; 6] = [
    RGBColor(0x1f, 0x4e, 0x9c),
    RGBColor(0xf0, 0x8c, 0x1e),
    RGBColor(0x2c, 0x8a, 0x4b),
    RGBColor(0xc0, 0x39, 0x2b),
    RGBColor(0x7d, 0x3c, 0x98),
    RGBColor(0x5d, 0x6d, 0x7e),
];

/// Curves in one panel, both axes logarithmic.
pub(crate) struct LogChart<'a> {
    /// Title of the chart.
    pub(crate) title: &'a str,
    /// Abscissa and ordinate with their units.
    pub(crate) axes: [&'a str; 2],
    /// Whether the legend is in the upper right corner; otherwise it is halfway down.
    pub(crate) legend_on_top: bool,
    /// Up to six curves.
    pub(crate) curves: &'a [LogCurve],
}

/// A curve, and points that should lie on it.
pub(crate) struct LogCurve {
    /// Its name in the legend.
    pub(crate) name: String,
    /// Points of the curve; both coordinates above zero.
    pub(crate) line: Vec<(f64, f64)>,
    /// Points that should lie on the curve.
    pub(crate) dots: Vec<(f64, f64)>,
}

/// Draw a chart.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_log_chart(figure: &LogChart<'_>, path: &Path) -> Result<(), PlotError> {
    let legend = if figure.legend_on_top { SeriesLabelPosition::UpperRight } else { SeriesLabelPosition::MiddleRight };
    let area = SVGBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let points = || figure.curves.iter().flat_map(|curve| curve.line.iter().chain(&curve.dots));
    let span = |part: fn(&(f64, f64)) -> f64| {
        let (low, high) = points().map(part).fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        (0.8 * low)..(1.25 * high)
    };
    let mut chart = ChartBuilder::on(&area)
        .caption(figure.title, ("sans-serif", 19).into_font().color(&BLACK))
        .margin(15)
        .x_label_area_size(45)
        .y_label_area_size(80)
        .build_cartesian_2d(span(|p| p.0).log_scale(), span(|p| p.1).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(figure.axes[0])
        .y_desc(figure.axes[1])
        .x_label_formatter(&|x| format!("{x:e}"))
        .y_label_formatter(&|y| format!("{y:e}"))
        .light_line_style(WHITE)
        .draw()?;
    for (curve, colour) in figure.curves.iter().zip(COLOURS) {
        let line = LineSeries::new(curve.line.iter().copied(), colour.stroke_width(2));
        chart
            .draw_series(line)?
            .label(curve.name.clone())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
        chart.draw_series(curve.dots.iter().map(|&dot| Circle::new(dot, 4, colour.filled())))?;
    }
    chart.configure_series_labels().position(legend).background_style(WHITE).border_style(BLACK).draw()?;
    area.present()?;
    Ok(())
}
