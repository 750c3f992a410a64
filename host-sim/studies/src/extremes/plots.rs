//! SVG plots of the region of small error and of the sampled loop's stable region.

use super::inputs::regions;
use super::stability::{StableRegion, planar_region, puma_region};
use sim::failure::{Failure, in_file};
use sim::run::plot::{LogChart, LogCurve, write_log_chart};
use std::path::{Path, PathBuf};

/// Draw the plots into a folder; returns their paths.
///
/// # Errors
/// A shipped robot cannot be read, or a file cannot be written.
pub fn write_plots(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let above = |points: Vec<(f64, f64)>| points.into_iter().filter(|(_, rate)| *rate > 0.0).collect();
    let region: Vec<LogCurve> =
        regions()?.into_iter().map(|(name, points)| LogCurve { name, line: above(points), dots: vec![] }).collect();
    let planar: Vec<LogCurve> = planar_region()?.into_iter().map(stable).collect();
    let puma: Vec<LogCurve> = puma_region()?.into_iter().map(stable).collect();
    const STABLE: [&str; 2] = ["natural frequency / rad/s", "longest stable period / s"];
    let figures = [
        (
            "extremes_region.svg",
            LogChart {
                title: "Error under 1e-4 of every torque limit below the line",
                axes: ["largest joint angle / rad", "largest joint rate / rad/s"],
                curves: &region,
            },
        ),
        (
            "extremes_stability.svg",
            LogChart {
                title: "Planar 2R: stable below the line (predicted), dots simulated",
                axes: STABLE,
                curves: &planar,
            },
        ),
        (
            "extremes_stability_puma.svg",
            LogChart {
                title: "Puma 560: stable below the line (predicted), dots simulated",
                axes: STABLE,
                curves: &puma,
            },
        ),
    ];
    let draw = |(file, figure): &(&str, LogChart<'_>)| {
        let path = folder.join(file);
        write_log_chart(figure, &path).map_err(|error| in_file(&path, &error))?;
        Ok(path)
    };
    figures.iter().map(draw).collect()
}

fn stable((name, points): StableRegion) -> LogCurve {
    LogCurve {
        name,
        line: points.iter().map(|&(frequency, predicted, _)| (frequency, predicted)).collect(),
        dots: points.iter().map(|&(frequency, _, simulated)| (frequency, simulated)).collect(),
    }
}
