//! Properties of the followed reference, and of rest after a stop.

use super::law::{SafetyProperty, Unsafe, broken};
use super::observation::{ReadingFaults, beyond};
use super::{Judge, Trust};
use dynamics_core::control::LimitFlags;
use link::StateCode;
use link::{Actuation, Status};

impl<const N: usize> Judge<N> {
    /// Checks the followed reference.
    pub(super) fn reference(&self, seen: &ReadingFaults<N>, status: &Status) -> Result<(), Unsafe> {
        if status.state != StateCode::Running {
            return Ok(());
        }
        let (Some(reference), Some(Actuation::Drive { limits, .. })) = (status.reference(), &status.actuation) else {
            return broken(SafetyProperty::Reference, "it runs without a reference");
        };
        for i in 0..N {
            let at = |list: &link::Joints<f32>| list.get(i).map_or(f64::NAN, |x| f64::from(*x));
            let (q, qd, qdd) = (at(&reference.q), at(&reference.qd), at(&reference.qdd));
            if !(q.is_finite() && qd.is_finite() && qdd.is_finite()) {
                return broken(SafetyProperty::Reference, format!("joint {}: reference {q}, {qd}, {qdd}", i + 1));
            }
            let joint = &self.rules.joints[i];
            let place = seen.position[i];
            if self.is_astray(seen, i, q) {
                return broken(
                    SafetyProperty::Reference,
                    format!("joint {}: reference {q}, the arm at {place}", i + 1),
                );
            }
            let (low, high) = self.config.limits[i].position;
            let room = if qd > 0.0 { high - q } else { q - low };
            let way = qd.abs() * self.rules.latency + qd * qd / (2.0 * joint.deceleration);
            if qd.abs() > 1e-4 && beyond(way, room) {
                return broken(SafetyProperty::Reference, format!("joint {}: needs {way} to stop, has {room}", i + 1));
            }
            let flags = limits.get(i).copied().unwrap_or(0);
            let outside = beyond(q, high) || beyond(low, q);
            let fast = beyond(qd.abs(), self.config.limits[i].velocity);
            if (outside && flags & 1 == 0) || (fast && flags & 2 == 0) {
                return broken(
                    SafetyProperty::Held,
                    format!("joint {}: reference {q}, {qd} is followed, flags {flags}", i + 1),
                );
            }
        }
        Ok(())
    }

    /// Checks that a holding arm comes to rest.
    pub(super) fn rest(&mut self, status: &Status) -> Result<(), Unsafe> {
        self.held = if status.state == StateCode::Holding { self.held + 1 } else { 0 };
        if self.trust < Trust::Loop || self.held < self.rest_after + self.observation.window as u32 {
            return Ok(());
        }
        for i in 0..N {
            let rest = self.rules.joints[i].rest_speed;
            if let Some(speed) = self.observation.mean(i, 0, self.rules.period)
                && speed.abs() > rest
            {
                return broken(
                    SafetyProperty::Rest,
                    format!("joint {}: {speed} after {} ticks of holding", i + 1, self.held),
                );
            }
        }
        Ok(())
    }

    /// Checks that an armed arm stays where it was armed.
    pub(super) fn standing(&mut self, seen: &ReadingFaults<N>, status: &Status) -> Result<(), Unsafe> {
        if status.state != StateCode::Armed {
            return Ok(());
        }
        if self.before.0 != StateCode::Armed {
            self.armed = seen.position;
        }
        let Some(Actuation::Drive { limits, .. }) = &status.actuation else { return Ok(()) };
        // The arm yields to a collision, or did until now.
        if limits.iter().any(|flags| flags & LimitFlags::COLLISION.bits() != 0) {
            self.armed = seen.position;
        }
        for i in 0..N {
            let (place, armed) = (seen.position[i], self.armed[i]);
            if self.is_astray(seen, i, armed) {
                return broken(
                    SafetyProperty::Standing,
                    format!("joint {}: armed at {armed}, the arm at {place}", i + 1),
                );
            }
        }
        Ok(())
    }

    /// True if a joint is certainly farther than its `reach` from this position.
    fn is_astray(&self, seen: &ReadingFaults<N>, i: usize, from: f64) -> bool {
        let joint = &self.rules.joints[i];
        // With encoders the machine measures the distance from its observer's estimate, which may lag by up to a jump.
        let lag = if seen.counted { 2.0 * joint.jump_step.min(1.0) + joint.resolution } else { 0.0 };
        (!seen.counted || self.trust >= Trust::Arm) && beyond((from - seen.position[i]).abs(), joint.reach + lag)
    }
}
