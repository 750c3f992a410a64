//! An actuator with a free shaft.

use super::{Electronics, Ranges, Shaft};
use crate::frame::Frame;

/// An actuator on a bus: electronics and the shaft that they measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Its electronics.
    pub electronics: Electronics,
    /// Its shaft, moved by [`Actuator::step`] or by a simulated arm.
    pub shaft: Shaft,
    /// Inertia at the shaft, kg m^2; used by [`Actuator::step`].
    pub inertia: f64,
}

impl Actuator {
    /// Creates an actuator that is off and at rest at 0, with a free shaft.
    #[must_use]
    pub fn new(id: u16, ranges: Ranges) -> Self {
        Self { electronics: Electronics::new(id, ranges), shaft: Shaft::default(), inertia: 0.01 }
    }

    /// Takes a command's data and returns the reply's data.
    pub fn receive(&mut self, data: &[u8]) -> Option<Vec<u8>> {
        self.electronics.receive(data, &self.shaft)
    }

    /// Takes a frame of the bus and returns the reply.
    pub fn answer(&mut self, frame: &Frame) -> Option<Frame> {
        self.electronics.answer(frame, &self.shaft)
    }

    /// Simulates a free shaft for `dt` seconds under an external torque `load`, N m.
    pub fn step(&mut self, dt: f64, load: f64) {
        self.electronics.pass(dt);
        let torque = self.electronics.drive(&self.shaft);
        self.shaft.velocity += dt * (torque + load) / self.inertia;
        self.shaft.position += dt * self.shaft.velocity;
    }
}
