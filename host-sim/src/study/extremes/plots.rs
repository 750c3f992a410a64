//! The region of small error, and the stable region of the sampled loop, as SVG.

use super::inputs::regions;
use super::stability::{StableRegion, planar_region, puma_region};
use crate::failure::Failure;
use crate::run::plot::PlotError;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, Color, IntoDrawingArea, IntoFont, IntoLogRange, LineSeries, PathElement, RGBColor,
    SVGBackend, SeriesLabelPosition, WHITE,
};
use std::path::{Path, PathBuf};

const SIZE: (u32, u32) = (800, 500);
const COLOURS: [RGBColor; 6] = [
    RGBColor(0x1f, 0x4e, 0x9c),
    RGBColor(0xf0, 0x8c, 0x1e),
    RGBColor(0x2c, 0x8a, 0x4b),
    RGBColor(0xc0, 0x39, 0x2b),
    RGBColor(0x7d, 0x3c, 0x98),
    RGBColor(0x5d, 0x6d, 0x7e),
];

/// A curve, and the points that are to lie on it.
struct Curve {
    name: String,
    line: Vec<(f64, f64)>,
    dots: Vec<(f64, f64)>,
}

/// What a figure shows.
struct Figure<'a> {
    title: &'a str,
    axes: [&'a str; 2],
    legend: SeriesLabelPosition,
    curves: &'a [Curve],
}

impl Curve {
    fn stable((name, points): StableRegion) -> Self {
        Self {
            name,
            line: points.iter().map(|&(frequency, predicted, _)| (frequency, predicted)).collect(),
            dots: points.iter().map(|&(frequency, _, simulated)| (frequency, simulated)).collect(),
        }
    }
}

/// Draw them into the folder; returns the files.
///
/// # Errors
/// A shipped robot cannot be read, or a file cannot be written.
pub fn write_plots(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let above = |points: Vec<(f64, f64)>| points.into_iter().filter(|(_, rate)| *rate > 0.0).collect();
    let region: Vec<Curve> =
        regions()?.into_iter().map(|(name, points)| Curve { name, line: above(points), dots: vec![] }).collect();
    let planar: Vec<Curve> = planar_region()?.into_iter().map(Curve::stable).collect();
    let puma: Vec<Curve> = puma_region()?.into_iter().map(Curve::stable).collect();
    const STABLE: [&str; 2] = ["natural frequency / rad/s", "longest stable period / s"];
    let figures = [
        (
            "extremes_region.svg",
            Figure {
                title: "Error under 1e-4 of every torque limit below the line",
                axes: ["largest joint angle / rad", "largest joint rate / rad/s"],
                legend: SeriesLabelPosition::MiddleRight,
                curves: &region,
            },
        ),
        (
            "extremes_stability.svg",
            Figure {
                title: "Planar 2R: stable below the line (predicted), dots simulated",
                axes: STABLE,
                legend: SeriesLabelPosition::MiddleRight,
                curves: &planar,
            },
        ),
        (
            "extremes_stability_puma.svg",
            Figure {
                title: "Puma 560: stable below the line (predicted), dots simulated",
                axes: STABLE,
                legend: SeriesLabelPosition::UpperRight,
                curves: &puma,
            },
        ),
    ];
    let draw = |(file, figure): &(&str, Figure<'_>)| {
        let path = folder.join(file);
        draw(figure, &path)
            .map_err(|error| Failure::Output(std::io::Error::other(format!("{}: {error}", path.display()))))?;
        Ok(path)
    };
    figures.iter().map(draw).collect()
}

fn draw(figure: &Figure<'_>, path: &Path) -> Result<(), PlotError> {
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
    chart
        .configure_series_labels()
        .position(figure.legend.clone())
        .background_style(WHITE)
        .border_style(BLACK)
        .draw()?;
    area.present()?;
    Ok(())
}
