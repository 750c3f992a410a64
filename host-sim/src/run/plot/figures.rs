//! Figures of a run: one file per quantity, one panel per joint.

use super::PlotError;
use super::chart::{Chart, Line, Panel, Pen, thinned, write_chart};
use super::marks::{Marks, limited};
use crate::run::record::{JointLabel, JointSample, Record};
use crate::run::summary::engineering;
use std::path::{Path, PathBuf};

/// A curve of a panel: its name, its pen and its value at a sample.
struct Curve {
    name: &'static str,
    pen: Pen,
    value: fn(&JointSample) -> f64,
}

/// A figure: its file, its title, its axis and the curves of every joint.
struct Figure {
    file: &'static str,
    title: &'static str,
    axis: fn(&JointLabel) -> &'static str,
    unit: fn(&JointLabel) -> &'static str,
    curves: &'static [Curve],
    /// Whether the torque limits belong into it.
    torque: bool,
}

const FIGURES: [Figure; 4] = [
    Figure {
        file: "position.svg",
        title: "Joint positions",
        axis: |_| "position",
        unit: JointLabel::position_unit,
        curves: &[
            Curve { name: "reference", pen: Pen::BROAD, value: |s| s.q_reference },
            Curve { name: "actual", pen: Pen::BLUE, value: |s| s.q },
        ],
        torque: false,
    },
    Figure {
        file: "velocity.svg",
        title: "Joint velocities",
        axis: |_| "velocity",
        unit: JointLabel::velocity_unit,
        curves: &[
            Curve { name: "reference", pen: Pen::BROAD, value: |s| s.qd_reference },
            Curve { name: "actual", pen: Pen::BLUE, value: |s| s.qd },
        ],
        torque: false,
    },
    Figure {
        file: "error.svg",
        title: "Tracking error: reference less actual position",
        axis: |_| "error",
        unit: JointLabel::position_unit,
        curves: &[Curve { name: "error", pen: Pen::BLUE, value: |s| s.error() }],
        torque: false,
    },
    Figure {
        file: "torque.svg",
        title: "Commanded torques and forces",
        axis: JointLabel::effort,
        unit: JointLabel::torque_unit,
        curves: &[Curve { name: "torque", pen: Pen::BLUE, value: |s| s.torque }],
        torque: true,
    },
];

/// Figure that [`write_power`] draws.
const POWER: Figure = Figure {
    file: "power.svg",
    title: "Power of the commanded torques and forces",
    axis: |_| "power",
    unit: |_| "W",
    curves: &[Curve { name: "power", pen: Pen::BLUE, value: |s| s.torque * s.qd }],
    torque: false,
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
    let bound =
        |joint: usize| marks.torque_limits.get(joint).copied().filter(|limit| figure.torque && limit.is_finite());
    let panel = |(joint, label): (usize, &JointLabel)| Panel {
        caption: match bound(joint) {
            Some(limit) => format!("{}, limit {}", label.name, engineering(limit, label.torque_unit())),
            None => label.name.clone(),
        },
        quantity: (figure.axis)(label),
        unit: (figure.unit)(label),
        lines: figure.curves.iter().map(|curve| line(record, joint, curve)).collect(),
        marks: marks.lines(record),
        bound: bound(joint),
        limited: limited(record, joint),
    };
    Chart {
        title: format!("{}: {name}", figure.title),
        abscissa: "time / s",
        range: Some(0.0..end),
        panels: record.joints().iter().enumerate().map(panel).collect(),
    }
}

fn line(record: &Record, joint: usize, curve: &Curve) -> Line {
    Line { name: curve.name, pen: Some(curve.pen), pieces: vec![points(record, joint, curve.value)] }
}

/// Finite points of a joint's curve over time, thinned.
fn points(record: &Record, joint: usize, value: fn(&JointSample) -> f64) -> Vec<(f64, f64)> {
    let finite = record.time().iter().copied().zip(record.joint(joint).map(value)).filter(|(_, y)| y.is_finite());
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
