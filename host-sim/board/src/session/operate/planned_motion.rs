//! A motion of an arm with any number of joints.

use dynamics_core::control::trajectory::{Bounds, Motion};
use std::fmt;
use std::rc::Rc;

/// A motion of an arm with any number of joints.
pub trait PlannedMotion: fmt::Debug {
    /// Duration, s.
    fn duration(&self) -> f64;

    /// Reference at `t` (s) after the start.
    fn at(&self, t: f64) -> link::Reference;

    /// Reference at the end, bit for bit.
    fn end(&self) -> link::Reference;

    /// Positions at the start and at the end, rad or m.
    fn ends(&self) -> [Vec<f64>; 2];

    /// Greatest speed of each joint, rad/s or m/s.
    fn peak_velocity(&self) -> Vec<f64>;

    /// The same path, slower by this factor. Speeds are divided by it, accelerations by its square. `None` unless the factor is finite and above 1.
    fn slowed(&self, factor: f64) -> Option<Rc<dyn PlannedMotion>>;
}

impl<const N: usize> PlannedMotion for Motion<f64, N> {
    fn duration(&self) -> f64 {
        Motion::duration(self)
    }

    fn at(&self, t: f64) -> link::Reference {
        link::Reference::new(&self.sample(t).cast::<f32>())
    }

    fn end(&self) -> link::Reference {
        link::Reference::new(&Motion::end(self).cast::<f32>())
    }

    fn ends(&self) -> [Vec<f64>; 2] {
        [self.start().q.to_vec(), Motion::end(self).q.to_vec()]
    }

    fn peak_velocity(&self) -> Vec<f64> {
        self.peaks().velocity.to_vec()
    }

    fn slowed(&self, factor: f64) -> Option<Rc<dyn PlannedMotion>> {
        let slower = (factor > 1.0).then(|| self.stretched(factor * (1.0 + Bounds::<f64, N>::MARGIN)))?;
        slower.ok().map(|motion| Rc::new(motion) as Rc<dyn PlannedMotion>)
    }
}
