//! Selection of the ticks of a run that its page keeps.
//!
//! Every tick is kept if the page has enough space. Otherwise the page keeps every `stride`-th tick. For error, torque and external torque it also
//! keeps the lowest and the highest value until the next kept tick, or until a fault, so that no peak is lost.

use crate::run::record::{JointSample, Record};
use report::column;
use serde_json::{Map, Value, json};

/// Space for all columns of a run in its page, bytes: with the scripts, a page stays below 2 MB.
const ROOM: usize = 1_150_000;
/// Columns per joint that are always present: `q, qd, error, qd_error, torque`.
const ALWAYS: usize = 5;
/// Columns per joint that also have a lowest and a highest value: error and torque.
const WITH_EXTREMES: usize = 2;

/// Selection of ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rows {
    /// Ticks from one row to the next.
    pub(super) stride: usize,
}

impl Rows {
    /// Chooses the smallest stride whose columns fit, with `more` further columns per joint.
    pub(super) fn new(record: &Record, more: usize) -> Self {
        let (joints, outside) = (record.joints().len(), usize::from(record.estimates()));
        let columns = |thinned: usize| {
            let extremes = 2 * (WITH_EXTREMES + outside) * thinned;
            joints * (ALWAYS + outside + more + extremes) + 6 * outside
        };
        let fits = |stride: &usize| {
            let rows = record.ticks().div_ceil(*stride);
            columns(usize::from(*stride > 1)) * column::length(rows) <= ROOM
        };
        let all = 1..=record.ticks().max(1);
        Self { stride: all.clone().find(fits).unwrap_or(*all.end()) }
    }

    /// The recorded quantities of every joint.
    pub(super) fn columns(self, record: &Record) -> Map<String, Value> {
        let plain = |value: fn(&JointSample) -> f64| -> Value {
            let each =
                (0..record.joints().len()).map(|joint| self.plain(record.joint(joint).map(|sample| value(&sample))));
            each.collect()
        };
        let thinned = |value: fn(&JointSample) -> f64| -> Value {
            let driven = |joint: usize| {
                let samples = record.joint(joint).zip(record.faults());
                samples.map(move |(sample, fault)| if fault.is_none() { value(&sample) } else { f64::NAN })
            };
            let all = |joint: usize| record.joint(joint).map(move |sample| value(&sample));
            (0..record.joints().len()).map(|joint| self.thinned(all(joint), driven(joint))).collect()
        };
        let mut columns = Map::new();
        columns.insert("q".to_owned(), plain(|s| s.q));
        columns.insert("qd".to_owned(), plain(|s| s.qd));
        columns.insert("qd_error".to_owned(), plain(|s| s.qd_reference - s.qd));
        columns.insert("error".to_owned(), thinned(JointSample::error));
        columns.insert("torque".to_owned(), thinned(|s| s.torque));
        if record.estimates() {
            let each =
                (0..record.joints().len()).map(|joint| self.thinned(record.external(joint), record.external(joint)));
            columns.insert("external".to_owned(), each.collect());
        }
        columns
    }

    /// The estimated wrench at the tip, as six columns; NaN if the arm is singular. `None` if it is not estimated.
    pub(super) fn wrenches(self, record: &Record) -> Option<Vec<String>> {
        let axis = |axis: usize| {
            let values = record.wrenches().iter().map(|wrench| wrench.map_or(f64::NAN, |wrench| wrench[axis]));
            column::encode(values.step_by(self.stride))
        };
        record.estimates().then(|| (0..6).map(axis).collect())
    }

    fn plain(self, values: impl Iterator<Item = f64>) -> Value {
        json!({ "at": column::encode(values.step_by(self.stride)) })
    }

    /// Every `stride`-th value, and the extremes of `between` from each of these to the next. NaN in `between` is ignored.
    fn thinned(self, values: impl Iterator<Item = f64>, between: impl Iterator<Item = f64>) -> Value {
        if self.stride == 1 {
            return self.plain(values);
        }
        let all: Vec<f64> = between.collect();
        let of = |pick: fn(f64, f64) -> f64| {
            column::encode(all.chunks(self.stride).map(|chunk| chunk.iter().copied().fold(f64::NAN, pick)))
        };
        let at = column::encode(values.step_by(self.stride));
        json!({ "at": at, "low": of(f64::min), "high": of(f64::max) })
    }
}

#[cfg(test)]
mod tests {
    use super::{ROOM, Rows};
    use crate::run::joint_label::JointLabel;
    use crate::run::record::{JointSample, Record};
    use dynamics_core::control::LimitFlags;
    use dynamics_core::{Fault, JointKind};

    /// A record with one peak torque, and a fault with larger torques from that tick on.
    fn record_with_fault(ticks: usize, peak: usize, fault: usize) -> Record {
        let label = JointLabel { name: "swing".to_owned(), kind: JointKind::Revolute };
        let mut record = Record::new(vec![label; 6], ticks);
        for tick in 0..ticks {
            let torque = if tick >= fault {
                9.0
            } else if tick == peak {
                7.0
            } else {
                0.0
            };
            let sample =
                JointSample { q_reference: 0.0, q: 0.0, qd_reference: 0.0, qd: 0.0, torque, limits: LimitFlags::NONE };
            record.push(tick as f64 * 1e-3, [sample; 6], (tick >= fault).then_some(Fault::TemperatureOutOfBounds));
        }
        record
    }

    fn record(ticks: usize, peak: usize) -> Record {
        record_with_fault(ticks, peak, ticks)
    }

    #[test]
    fn a_peak_in_the_row_of_a_fault_is_the_one_before_it() {
        let long = record_with_fault(60_000, 30_000, 30_001);
        let rows = Rows::new(&long, 6);
        let high = report::column::decode(rows.columns(&long)["torque"][0]["high"].as_str().unwrap()).unwrap();
        let row = 30_000 / rows.stride;
        assert!((high[row] - 7.0).abs() < 1e-9 && high[row - 1].abs() < 1e-9 && high[row + 1].is_nan());
    }

    #[test]
    fn a_short_run_is_kept_tick_by_tick_and_a_long_one_fits_with_every_peak() {
        assert_eq!(Rows::new(&record(2_100, 0), 6).stride, 1);
        let long = record(60_000, 54_321);
        let rows = Rows::new(&long, 6);
        assert!((20..40).contains(&rows.stride), "{}", rows.stride);
        let columns = rows.columns(&long);
        let text = serde_json::to_string(&columns).unwrap();
        assert!(text.len() < ROOM, "{}", text.len());
        // 7.0 is 00 00 e0 40. The row with the peak contains it as the highest value, although the row's own tick has 0.
        let high = columns["torque"][0]["high"].as_str().unwrap();
        let expected = report::column::encode(
            (0..60_000_usize.div_ceil(rows.stride)).map(|row| if row == 54_321 / rows.stride { 7.0 } else { 0.0 }),
        );
        assert_eq!(high, expected);
    }

    #[test]
    fn a_run_without_a_tick_has_a_page_too() {
        assert_eq!(Rows::new(&record(0, 0), 6).stride, 1);
    }
}
