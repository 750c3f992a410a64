//! Waypoints and limits, which the charts of a run show in addition to its curves.

use crate::run::closed_loop::World;
use dynamics_core::{Limits, Model};

/// Limits and times of waypoints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Marks {
    /// Times at which the reference reaches a point, s.
    pub waypoints: Vec<f64>,
    /// Limits of each joint; infinite if there is none.
    pub limits: Vec<Limits<f64>>,
}

impl Marks {
    /// Marks of a run of `ticks` control periods.
    pub(crate) fn of<const N: usize>(world: &World<N>, model: &Model<f64, N>, ticks: usize) -> Self {
        let end = ticks as f64 * world.period;
        let lap = world.motion.duration();
        let points: Vec<f64> = (0..).map_while(|index| world.motion.arrival(index)).collect();
        let laps = if world.repeat && lap > 0.0 { (end / lap).ceil() as usize } else { 1 };
        let starts = (0..laps.max(1)).map(|n| n as f64 * lap);
        let mut waypoints: Vec<f64> = starts.flat_map(|start| points.iter().map(move |at| start + at)).collect();
        // The end of a lap is the start of the next one.
        waypoints.dedup_by(|a, b| (*a - *b).abs() < 0.5 * world.period);
        waypoints.retain(|at| *at <= end);
        Self { waypoints, limits: model.links().iter().map(|link| link.limits).collect() }
    }
}
