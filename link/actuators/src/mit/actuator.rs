//! An actuator with a shaft of its own.

use super::{Electronics, Ranges, Shaft};
use crate::frame::Frame;

/// An actuator at a bus: electronics and the shaft that they measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Frames, loop, errors.
    pub electronics: Electronics,
    /// The shaft: moved by [`Actuator::step`], or by an arm that carries it.
    pub shaft: Shaft,
    /// Inertia at the shaft, kg m^2, where [`Actuator::step`] moves it.
    pub inertia: f64,
}

impl Actuator {
    /// An actuator at rest at 0, off, with a free shaft.
    #[must_use]
    pub fn new(id: u16, ranges: Ranges) -> Self {
        Self { electronics: Electronics::new(id, ranges), shaft: Shaft::default(), inertia: 0.01 }
    }

    /// Take a command; the reply's data.
    pub fn receive(&mut self, data: &[u8]) -> Option<Vec<u8>> {
        self.electronics.receive(data, &self.shaft)
    }

    /// Take a frame of the bus; the reply.
    pub fn answer(&mut self, frame: &Frame) -> Option<Frame> {
        self.electronics.answer(frame, &self.shaft)
    }

    /// Time goes by for a free shaft, under a torque from outside, N m.
    pub fn step(&mut self, dt: f64, load: f64) {
        self.electronics.pass(dt);
        let torque = self.electronics.drive(&self.shaft);
        self.shaft.velocity += dt * (torque + load) / self.inertia;
        self.shaft.position += dt * self.shaft.velocity;
    }
}
