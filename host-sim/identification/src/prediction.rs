//! Torques that an identified model predicts along a log.

use crate::Series;
use crate::arm::Arm;
use crate::clock::repaired;
use crate::correction::shifted;
use crate::fit::FitProblem;
use crate::identify::Identified;
use crate::log::Log;
use crate::prepare::Prepared;
use crate::statistics;

/// Measured and predicted torque, both filtered.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Time of each sample, s.
    pub time: Vec<f64>,
    /// Measured torque, N m or N.
    pub measured: Series,
    /// Torque of the identified model, N m or N.
    pub model: Series,
    /// Filtered velocity of each joint, rad/s or m/s.
    pub qd: Series,
    /// True for samples in which friction holds the joint; no model predicts its torque there.
    pub held: Vec<Vec<bool>>,
}

impl Identified {
    /// Returns the log with an even clock if its stamps jitter, and with the torque delays removed.
    #[must_use]
    pub fn in_time(&self, log: &Log) -> Log {
        shifted(&repaired(log).0, &self.delay)
    }

    /// Predicts the torque along a log with the identified model and the filters of the identification.
    #[must_use]
    pub fn predict(&self, arm: &dyn Arm, log: &Log) -> Prediction {
        let prepared = Prepared::new(&self.in_time(log), arm, &self.base, self.filters);
        let loads = prepared.of_bodies(self.bodies.beta.as_slice());
        let problem = FitProblem { logs: std::slice::from_ref(&prepared), base: &self.base, laws: &self.laws };
        let mut model = loads.clone();
        for ((model, columns), coefficients) in
            model.iter_mut().zip(problem.friction(&prepared, &loads)).zip(&self.friction)
        {
            for (column, c) in columns.iter().zip(coefficients) {
                model.iter_mut().zip(column).for_each(|(sum, x)| *sum += c * x);
            }
        }
        Prediction { time: prepared.time, measured: prepared.tau, model, qd: prepared.qd, held: prepared.held }
    }

    /// Predicts the torque along a log with other parameters, for example a robot file's, and with a friction law `friction(joint, qd, load)`, N m or
    /// N. The load is the torque of the bodies.
    #[must_use]
    pub fn predict_by(
        &self,
        arm: &dyn Arm,
        log: &Log,
        parameters: &[f64],
        friction: &dyn Fn(usize, f64, f64) -> f64,
    ) -> Series {
        let prepared = Prepared::new(&self.in_time(log), arm, &self.base, self.filters);
        let mut model = prepared.of_bodies(self.base.of_parameters(parameters).as_slice());
        for (joint, model) in model.iter_mut().enumerate() {
            let friction: Vec<f64> =
                prepared.qd[joint].iter().zip(&*model).map(|(qd, load)| friction(joint, *qd, *load)).collect();
            model.iter_mut().zip(prepared.low_pass.apply(&friction)).for_each(|(sum, x)| *sum += x);
        }
        model
    }
}

impl Prediction {
    /// Measured torque minus a model's torque, N m or N; 0 where friction holds a joint.
    #[must_use]
    pub fn left(&self, model: &Series) -> Series {
        self.moving(&difference(&self.measured, model))
    }

    /// Sets a series to 0 where friction holds the joint.
    #[must_use]
    pub fn moving(&self, series: &Series) -> Series {
        let of = |(x, held): (&Vec<f64>, &Vec<bool>)| {
            x.iter().zip(held).map(|(x, held)| if *held { 0.0 } else { *x }).collect()
        };
        series.iter().zip(&self.held).map(of).collect()
    }

    /// Share of each joint's samples in which friction holds it.
    #[must_use]
    pub fn held_share(&self) -> Vec<f64> {
        let of = |held: &Vec<bool>| held.iter().filter(|held| **held).count() as f64 / held.len().max(1) as f64;
        self.held.iter().map(of).collect()
    }
}

/// Root mean square of each joint.
#[must_use]
pub fn rms(series: &Series) -> Vec<f64> {
    series.iter().map(|x| statistics::rms(x)).collect()
}

/// Difference of two series.
#[must_use]
pub fn difference(a: &Series, b: &Series) -> Series {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect()).collect()
}
