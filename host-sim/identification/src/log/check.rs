//! Plausibility checks of the numbers in a log.

use super::header::Places;
use super::{BadLog, Log, Reading};
use crate::Series;
use crate::filter::derivative;

/// Smallest number of samples.
const FEWEST: usize = 100;
/// Shortest log, s.
const SHORTEST: f64 = 1.0;
/// Longest gap, in mean steps. Gaps up to 0.1 s are always accepted.
const GAP: f64 = 50.0;
/// A joint that moves less than this, rad or m, counts as not moved.
const STILL: f64 = 2e-3;
/// Largest position beyond a limit, rad or m.
const BEYOND: f64 = 0.2;
/// Largest number of turns of a joint without limits.
const TURNS: f64 = 40.0;
/// Largest plausible torque, in multiples of the limit.
const TOO_MUCH: f64 = 20.0;
/// Samples at exactly the same extreme that count as clipped: in a row, and in total.
const CLIPPED: (usize, usize) = (8, 24);

/// Ratios of recorded velocity to the derivative of the position, and the unit error that each suggests.
const UNITS: [(f64, &str); 6] = [
    (57.295_78, "velocity in deg/s and position in rad"),
    (0.017_453_29, "velocity in rad/s and position in deg"),
    (9.549_297, "velocity in rpm and position in rad"),
    (0.159_154_9, "velocity in rev/s and position in rad"),
    (1e-3, "time in ms"),
    (1e3, "velocity in mm/s, or in 1/ms"),
];

pub(super) struct Table<'a> {
    pub(super) file: &'a str,
    pub(super) head: &'a [String],
    pub(super) places: &'a Places,
    pub(super) lines: &'a [u64],
}

impl Table<'_> {
    fn wrong(&self, place: String, found: String, expected: &str) -> BadLog {
        BadLog { file: self.file.to_owned(), place, found, expected: expected.to_owned() }
    }

    /// Heading of a column, by its index among the columns that were read.
    fn name(&self, column: usize) -> &str {
        &self.head[self.places.all[column]]
    }

    fn at(&self, row: usize, column: usize) -> String {
        format!("line {}, {}", self.lines[row], self.name(column))
    }

    pub(super) fn checked(&self, columns: Vec<Vec<f64>>, reading: &Reading) -> Result<Log, BadLog> {
        let n = reading.joints.len();
        let mut columns = columns.into_iter();
        let time = columns.next().unwrap_or_default();
        let q: Series = columns.by_ref().take(n).collect();
        let qd: Option<Series> = self.places.velocities.then(|| columns.by_ref().take(n).collect());
        let qd = qd.filter(|qd| qd.iter().flatten().all(|x| x.is_finite()));
        let mut tau: Series = columns.collect();
        self.time(&time)?;
        self.positions(&q, reading)?;
        if let Some(qd) = &qd {
            self.velocities(&time, &q, qd, reading)?;
        }
        self.clipped(&q, &tau)?;
        if let (true, Some(constants)) = (self.places.currents, &reading.per_ampere) {
            for (tau, constant) in tau.iter_mut().zip(constants) {
                tau.iter_mut().for_each(|x| *x *= constant);
            }
        }
        self.torques(&tau, reading)?;
        Ok(Log { file: self.file.to_owned(), time, q, qd, tau, from_current: self.places.currents })
    }

    fn time(&self, time: &[f64]) -> Result<(), BadLog> {
        if time.len() < FEWEST {
            let found = format!("{} samples", time.len());
            return Err(self.wrong("the whole file".to_owned(), found, "100 samples or more, over a second at least"));
        }
        if let Some(k) = time.windows(2).position(|t| t[1] <= t[0]) {
            let found = format!("{} after {}", time[k + 1], time[k]);
            return Err(self.wrong(self.at(k + 1, 0), found, "time that rises from row to row"));
        }
        let duration = time[time.len() - 1] - time[0];
        let step = duration / (time.len() - 1) as f64;
        if step > 0.2 {
            let found = format!("a step of {step:.3} s on average");
            return Err(self.wrong(self.at(0, 0), found, "time in s, five samples a second at least (milliseconds?)"));
        }
        if duration < SHORTEST || step < 1e-5 {
            let found = format!("{duration:.6} s in {} samples", time.len());
            return Err(self.wrong(self.at(0, 0), found, "time in s, over a second at least"));
        }
        if let Some(k) = time.windows(2).position(|t| t[1] - t[0] > (GAP * step).max(0.1)) {
            let found = format!("a gap of {:.3} s", time[k + 1] - time[k]);
            return Err(self.wrong(
                self.at(k + 1, 0),
                found,
                "one stretch of time: cut the log there, and give both parts",
            ));
        }
        Ok(())
    }

    fn positions(&self, q: &Series, reading: &Reading) -> Result<(), BadLog> {
        for (joint, q) in q.iter().enumerate() {
            let column = 1 + joint;
            let (lo, hi) = reading.limits[joint];
            let far = if reading.turns[joint] { TURNS } else { 10.0 };
            let (lo, hi) = ((lo - BEYOND).max(-far), (hi + BEYOND).min(far));
            if let Some(k) = q.iter().position(|x| !(lo..=hi).contains(x)) {
                let unit = if reading.turns[joint] { "rad (degrees? --degrees)" } else { "m" };
                let found = format!("{:.4}, outside of what {} can reach", q[k], reading.joints[joint]);
                let expected = format!("a position from {lo:.3} to {hi:.3} {unit}");
                return Err(self.wrong(self.at(k, column), found, &expected));
            }
            let range = q.iter().fold(f64::MIN, |a, b| a.max(*b)) - q.iter().fold(f64::MAX, |a, b| a.min(*b));
            if range < STILL && !reading.may_rest {
                let found = format!("a joint that never moves: {range:.2e} in all");
                let place = format!("lines {} to {}, {}", self.lines[0], self.lines[q.len() - 1], self.name(column));
                return Err(self.wrong(place, found, "a motion of every joint (`newtau identify excite` designs one)"));
            }
        }
        Ok(())
    }

    /// Compares velocity columns with the derivatives of the positions: their scale, and their order.
    fn velocities(&self, time: &[f64], q: &Series, qd: &Series, reading: &Reading) -> Result<(), BadLog> {
        let n = q.len();
        let rate = (time.len() - 1) as f64 / (time[time.len() - 1] - time[0]);
        let change: Series = q.iter().map(|q| derivative(q, rate)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let size = |a: &[f64]| dot(a, a).sqrt().max(1e-12);
        let alike = |i: usize, j: usize| dot(&change[i], &qd[j]) / (size(&change[i]) * size(&qd[j]));
        for i in 0..n {
            let moving = size(&change[i]) / (time.len() as f64).sqrt() > 0.02;
            if !moving {
                continue;
            }
            let own = alike(i, i);
            if let Some(j) = (0..n).find(|&j| j != i && own < 0.5 && alike(i, j) > 0.9) {
                let found = format!("the velocity of joint {} ({})", i + 1, reading.joints[i]);
                let expected = format!("that of joint {}: columns exchanged", j + 1);
                return Err(self.wrong(self.at(0, 1 + n + j), found, &expected));
            }
            if own < -0.5 {
                let found = "the opposite of the position's change".to_owned();
                return Err(self.wrong(self.at(0, 1 + n + i), found, "position and velocity with one sign"));
            }
            let ratio = dot(&change[i], &qd[i]) / dot(&change[i], &change[i]);
            if own > 0.7 && !(0.5..2.0).contains(&ratio) {
                let found = format!("{ratio:.4} times the position's change per second");
                let cause = UNITS.iter().find(|(factor, _)| (ratio / factor - 1.0).abs() < 0.1);
                let cause = cause.map_or(String::new(), |(_, unit)| format!(": {unit}?"));
                let expected = format!("position, velocity and time in one set of units{cause}");
                return Err(self.wrong(self.at(0, 1 + n + i), found, &expected));
            }
        }
        Ok(())
    }

    /// Rejects torques that stay at their extreme while the arm moves.
    fn clipped(&self, q: &Series, tau: &Series) -> Result<(), BadLog> {
        for (joint, tau) in tau.iter().enumerate() {
            for extreme in [tau.iter().copied().fold(f64::MIN, f64::max), tau.iter().copied().fold(f64::MAX, f64::min)]
            {
                let near = |x: &f64| (x - extreme).abs() <= 1e-9 * extreme.abs();
                let (mut all, mut first, mut k) = (0, None, 0);
                while k < tau.len() {
                    let run = tau[k..].iter().take_while(|x| near(x)).count();
                    let moved = |q: &Vec<f64>| (q[k + run.max(1) - 1] - q[k]).abs() > 1e-3;
                    if run >= CLIPPED.0 && extreme != 0.0 && q.iter().any(moved) {
                        all += run;
                        first = first.or(Some((k, run)));
                    }
                    k += run.max(1);
                }
                if let (Some((k, run)), true) = (first, all >= CLIPPED.1) {
                    let found = format!("{extreme} in {run} rows on end, {all} in all: a clipped value");
                    let column = self.places.all.len() - q.len() + joint;
                    return Err(self.wrong(self.at(k, column), found, "a motion that leaves the drive room"));
                }
            }
        }
        Ok(())
    }

    fn torques(&self, tau: &Series, reading: &Reading) -> Result<(), BadLog> {
        for (joint, tau) in tau.iter().enumerate() {
            let column = self.places.all.len() - reading.joints.len() + joint;
            let most = TOO_MUCH * reading.torque[joint];
            if let Some(k) = tau.iter().position(|x| x.abs() > most.min(1e6)) {
                let found = format!("{:.1} N m, {TOO_MUCH} times the torque limit or more", tau[k]);
                return Err(self.wrong(
                    self.at(k, column),
                    found,
                    "torque in N m (N), or currents with --torque-per-ampere",
                ));
            }
            if tau.iter().all(|x| x.abs() < 1e-9) {
                let place = format!("lines {} on, {}", self.lines[0], self.name(column));
                return Err(self.wrong(place, "zero in every row".to_owned(), "measured torques or currents"));
            }
        }
        Ok(())
    }
}
