//! Motion of a scene.

use super::SceneFile;
use super::lists::joints;
use super::motion::MotionSpec;
use dynamics_core::control::trajectory::{
    Bounds, FourierSpec, Motion, MotionError, SweepSpec, Timing, TorqueLimits, Waypoint,
};
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Model};

impl SceneFile {
    /// The reference motion, checked against the joint limits, and slowed down if necessary and allowed.
    ///
    /// # Errors
    /// A motion that is not possible: outside the position limits, too fast, or of a shape that does not exist.
    pub fn trajectory<const N: usize>(&self, model: &Model<f64, N>) -> Result<Motion<f64, N>, MotionError> {
        let bounds = Bounds::from_limits(&model.links().map(|link| link.limits));
        match &self.motion {
            MotionSpec::Hold { q, duration } => Motion::hold(joints(q), *duration, &bounds),
            MotionSpec::Quintic { points, acceleration, .. } => {
                let waypoints: Vec<Waypoint<f64, N>> =
                    points.iter().map(|point| Waypoint { q: joints(&point.q), dwell: point.dwell }).collect();
                let durations: Option<Vec<f64>> = points.iter().skip(1).map(|point| point.duration).collect();
                match durations {
                    Some(durations) => Motion::quintic(&waypoints, Timing::Durations(&durations), &bounds),
                    None => {
                        let bounds = with_acceleration(bounds, acceleration.as_deref());
                        self.within_torque(model, Motion::quintic(&waypoints, Timing::Fastest, &bounds)?)
                    }
                }
            }
            MotionSpec::Trapezoid { start, goal, acceleration, duration, ramp_share } => {
                let (start, goal) = (joints(start), joints(goal));
                match duration {
                    Some(duration) => Motion::trapezoid_in(start, goal, *duration, *ramp_share, &bounds),
                    None => {
                        let bounds = with_acceleration(bounds, acceleration.as_deref());
                        self.within_torque(model, Motion::trapezoid(start, goal, &bounds)?)
                    }
                }
            }
            MotionSpec::Sine { centre, amplitude, frequency_start, frequency_end, duration, ramp } => {
                let spec = SweepSpec {
                    centre: joints(centre),
                    amplitude: joints(amplitude),
                    from: *frequency_start,
                    to: *frequency_end,
                    duration: *duration,
                    ramp: *ramp,
                };
                Motion::sweep(&spec, &bounds)
            }
            MotionSpec::Fourier { centre, sine, cosine, period, duration, ramp } => {
                let harmonics =
                    |list: &[Vec<f64>]| core::array::from_fn(|k| list.get(k).map_or([0.0; N], |a| joints(a)));
                let spec = FourierSpec {
                    centre: joints(centre),
                    sine: harmonics(sine),
                    cosine: harmonics(cosine),
                    period: *period,
                    duration: *duration,
                    ramp: *ramp,
                };
                Motion::fourier(&spec, &bounds)
            }
        }
    }

    /// Slows a motion without a stated duration until a tenth of the torque limit is left for friction and feedback.
    fn within_torque<const N: usize>(
        &self,
        model: &Model<f64, N>,
        motion: Motion<f64, N>,
    ) -> Result<Motion<f64, N>, MotionError> {
        const SHARE: f64 = 0.9;
        const STEPS: u32 = 500;
        // The full model, including terms that `terms = "auto"` dropped: the terms are chosen along the motion, so the
        // motion must not depend on them.
        let dynamics = Dynamics::new(*model, self.model.full().scene(model));
        let torque = std::array::from_fn(|i| {
            let coulomb =
                self.robot.joints.get(i).and_then(|joint| joint.friction).map_or(0.0, |friction| friction.starting());
            let limit = model.links()[i].limits.torque;
            // If friction alone needs the whole torque of a drive, that is a problem of the plant, and no reason to reject the
            // motion.
            (SHARE * limit - coulomb).max(0.1 * limit)
        });
        motion.scale_to_torque(&dynamics, &Libm, &self.live(model), &TorqueLimits { torque, steps: STEPS })
    }
}

fn with_acceleration<const N: usize>(bounds: Bounds<f64, N>, acceleration: Option<&[f64]>) -> Bounds<f64, N> {
    match acceleration {
        Some(acceleration) => bounds.with_acceleration(joints(acceleration)),
        None => bounds,
    }
}
