//! Figures of a run: one sheet per quantity, one panel per joint.

use super::PlotError;
use super::chart::{Chart, Layout, Line, Panel, Pen, thinned, write_chart};
use super::marks::{Marks, limited};
use crate::run::record::{JointLabel, JointSample, Record};
use crate::run::summary::engineering;
use dynamics_core::Limits;
use std::path::{Path, PathBuf};

/// A curve of a panel: its name, its pen and its value at a sample.
struct Curve {
    name: &'static str,
    pen: Pen,
    value: fn(&JointSample) -> f64,
}

/// A figure: its file, its title, and per joint a panel with its limits, under a strip with the error.
struct Figure {
    file: &'static str,
    title: &'static str,
    axis: fn(&JointLabel) -> &'static str,
    unit: fn(&JointLabel) -> &'static str,
    curves: &'static [Curve],
    error: Option<Curve>,
    limits: fn(&Limits<f64>) -> [f64; 2],
}

const FIGURES: [Figure; 3] = [
    Figure {
        file: "position.svg",
        title: "Joint positions, and reference less actual on top",
        axis: |_| "position",
        unit: JointLabel::position_unit,
        curves: &[
            Curve { name: "reference", pen: Pen::BROAD, value: |s| s.q_reference },
            Curve { name: "actual", pen: Pen::BLUE, value: |s| s.q },
        ],
        error: Some(Curve { name: "error", pen: Pen::BLUE, value: |s| s.error() }),
        limits: |limits| [limits.position.0, limits.position.1],
    },
    Figure {
        file: "velocity.svg",
        title: "Joint velocities, and reference less actual on top",
        axis: |_| "velocity",
        unit: JointLabel::velocity_unit,
        curves: &[
            Curve { name: "reference", pen: Pen::BROAD, value: |s| s.qd_reference },
            Curve { name: "actual", pen: Pen::BLUE, value: |s| s.qd },
        ],
        error: Some(Curve { name: "error", pen: Pen::BLUE, value: |s| s.qd_reference - s.qd }),
        limits: |limits| [-limits.velocity, limits.velocity],
    },
    Figure {
        file: "torque.svg",
        title: "Commanded torques and forces",
        axis: JointLabel::effort,
        unit: JointLabel::torque_unit,
        curves: &[Curve { name: "torque", pen: Pen::BLUE, value: |s| s.torque }],
        error: None,
        limits: |limits| [-limits.torque, limits.torque],
    },
];

/// Figure that [`write_power`] draws.
const POWER: Figure = Figure {
    file: "power.svg",
    title: "Power of the commanded torques and forces",
    axis: |_| "power",
    unit: |_| "W",
    curves: &[Curve { name: "power", pen: Pen::BLUE, value: |s| s.torque * s.qd }],
    error: None,
    limits: |_| [f64::NEG_INFINITY, f64::INFINITY],
};

/// Draw the power of every joint into the folder; returns the file.
///
/// # Errors
/// The file cannot be written.
pub fn write_power(record: &Record, name: &str, folder: &Path) -> Result<PathBuf, PlotError> {
    write(record, &Marks::default(), &POWER, name, folder)
}

/// Draw every figure into the folder; returns the files.
///
/// # Errors
/// A file cannot be written.
pub fn write_all(record: &Record, marks: &Marks, name: &str, folder: &Path) -> Result<Vec<PathBuf>, PlotError> {
    FIGURES.iter().map(|figure| write(record, marks, figure, name, folder)).collect()
}

fn write(record: &Record, marks: &Marks, figure: &Figure, name: &str, folder: &Path) -> Result<PathBuf, PlotError> {
    let path = folder.join(figure.file);
    write_chart(&chart(record, marks, figure, name), &path)?;
    Ok(path)
}

fn chart(record: &Record, marks: &Marks, figure: &Figure, name: &str) -> Chart {
    let end = record.time().last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    let panels = |(joint, label): (usize, &JointLabel)| {
        let limits = marks.limits.get(joint).map_or([f64::NEG_INFINITY, f64::INFINITY], figure.limits);
        let bounds: Vec<f64> = limits.into_iter().filter(|limit| limit.is_finite()).collect();
        let panel = Panel {
            caption: caption(label, &bounds, (figure.unit)(label)),
            quantity: (figure.axis)(label),
            unit: (figure.unit)(label),
            lines: figure.curves.iter().map(|curve| line(record, joint, curve)).collect(),
            marks: marks.lines(record),
            bounds,
            limited: limited(record, joint),
        };
        let Some(error) = &figure.error else { return vec![panel] };
        let strip = Panel {
            caption: panel.caption.clone(),
            quantity: error.name,
            unit: panel.unit,
            lines: vec![Line {
                name: error.name,
                pen: Some(error.pen),
                pieces: vec![driven(record, joint, error.value)],
            }],
            marks: panel.marks.clone(),
            bounds: Vec::new(),
            limited: Vec::new(),
        };
        vec![strip, Panel { caption: String::new(), ..panel }]
    };
    Chart {
        title: format!("{}: {name}", figure.title),
        abscissa: "time / s",
        range: Some(0.0..end),
        layout: Layout::Landscape { strips: figure.error.is_some() },
        panels: record.joints().iter().enumerate().flat_map(panels).collect(),
    }
}

/// A joint's name and its limits.
fn caption(label: &JointLabel, bounds: &[f64], unit: &str) -> String {
    match bounds {
        [low, high] if (low + high).abs() <= 1e-9 * high.abs() => {
            format!("{}, limit {}", label.name, engineering(*high, unit))
        }
        [low, high] => format!("{}, limits {} and {}", label.name, engineering(*low, unit), engineering(*high, unit)),
        _ => label.name.clone(),
    }
}

/// A joint's error over time up to a fault: an arm that brakes follows no reference.
fn driven(record: &Record, joint: usize, value: fn(&JointSample) -> f64) -> Vec<(f64, f64)> {
    let end = record.faults().iter().take_while(|fault| fault.is_none()).count();
    let finite = record
        .time()
        .iter()
        .copied()
        .zip(record.joint(joint).map(|sample| value(&sample)))
        .take(end)
        .filter(|(_, y)| y.is_finite());
    thinned(finite.collect())
}

fn line(record: &Record, joint: usize, curve: &Curve) -> Line {
    Line { name: curve.name, pen: Some(curve.pen), pieces: vec![points(record, joint, curve.value)] }
}

/// Finite points of a joint's curve over time, thinned.
fn points(record: &Record, joint: usize, value: fn(&JointSample) -> f64) -> Vec<(f64, f64)> {
    let finite = record
        .time()
        .iter()
        .copied()
        .zip(record.joint(joint).map(|sample| value(&sample)))
        .filter(|(_, y)| y.is_finite());
    thinned(finite.collect())
}

#[cfg(test)]
mod tests {
    use super::points;
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
}
