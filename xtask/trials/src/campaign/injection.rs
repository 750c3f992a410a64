//! One fault with its random parameters: its effect on readings, lines, frames and the arm.

use super::fault::FaultKind;
use super::host::Host;
use super::machine::TickInputs;
use super::random::Random;
use super::stage::{JointScale, Stage};
use dynamics_core::{Inertia, Live, Reference, Sensed, Wrench};
use link::codec::FrameTooLong;
use link::{Frame, Request};
use nalgebra::{Matrix3, Vector3};

/// A temporary fault.
#[derive(Clone, Debug)]
pub(super) struct Injection<const N: usize> {
    kind: FaultKind,
    joint: usize,
    scale: JointScale,
    /// NaN, infinite or far too large.
    wild: f32,
    /// -1 or 1.
    sign: f64,
    /// Size of the fault, from 0 to 1.
    share: f64,
    /// The live inputs as they should be.
    truth: Live<f32, N>,
    /// Largest payload that the machine accepts, kg.
    payload_max: f32,
    /// Reading and ages before the fault.
    before: Option<(Sensed<f32, N>, [u32; N])>,
}

const WILD: [f32; 6] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1e30, 1e9];

impl<const N: usize> Injection<N> {
    /// Draws the parameters of a fault.
    pub(super) fn new(kind: FaultKind, stage: &Stage<N>, random: &mut Random) -> Self {
        let joint = random.index(N);
        let wild = random.pick(&WILD).unwrap_or(f32::NAN);
        let (scale, truth, payload_max) = (stage.scales[joint], stage.truth, stage.rules.payload.mass as f32);
        let (sign, share) = (random.sign(), random.unit());
        Self { kind, joint, scale, wild, sign, share, truth, payload_max, before: None }
    }

    /// Applies the fault to readings and lines in its tick number `k`, counted from 0.
    pub(super) fn tell(&mut self, k: u32, told: &mut TickInputs<N>, random: &mut Random) {
        let (sensed, ages) = *self.before.get_or_insert((told.sensed, told.age_ticks));
        let bad = |low: f32, high: f32| [low, high, f32::NAN, f32::INFINITY][((self.share * 4.0) as usize).min(3)];
        match self.kind {
            FaultKind::EmergencyStop => told.emergency_stop = true,
            FaultKind::Overrun => told.overrun = k == 0 || random.chance(0.3),
            FaultKind::Drive => told.drive_fault[self.joint] = true,
            FaultKind::Supply => told.supply = Some(bad(3.0, 60.0)),
            FaultKind::Temperature => told.temperature = Some(bad(-80.0, 150.0)),
            FaultKind::Position => {
                if let Sensed::State { q, .. } = &mut told.sensed {
                    q[self.joint] = if self.wild.abs() < f32::MAX { f32::NAN } else { self.wild };
                }
            }
            FaultKind::Velocity => {
                if let Sensed::State { qd, .. } = &mut told.sensed {
                    qd[self.joint] = self.wild;
                }
            }
            FaultKind::Jump => {
                // From half of the allowed change to far beyond it.
                let way = self.scale.jump_step * (0.5 * (self.share * 16.0).exp2());
                move_by(told, self.joint, self.sign * way, &self.scale);
            }
            FaultKind::Runaway => {
                let way = self.scale.jump_step * self.share * f64::from(k + 1);
                move_by(told, self.joint, self.sign * way, &self.scale);
            }
            FaultKind::Stuck => hold_still(told, self.joint, &sensed),
            FaultKind::Stale => told.age_ticks = [1 + (self.share * 10.0) as u32; N],
            FaultKind::Missing => (told.sensed, told.age_ticks) = (sensed, ages.map(|age| age.saturating_add(k))),
            _ => {}
        }
    }

    /// Applies the fault to the host's frames in its tick number `k`, counted from 0. Returns `true` if the host sends no regular points.
    pub(super) fn talk(&self, k: u32, host: &mut Host<N>, random: &mut Random) -> Result<bool, FrameTooLong> {
        match self.kind {
            FaultKind::Underrun => return Ok(true),
            FaultKind::PointJump => {
                let way = self.sign * 3.0 * self.share;
                if k.is_multiple_of(5) {
                    self.astray(host, random.whole(1, 10) as u16, |at, i| at.q[i] += way)?;
                }
            }
            FaultKind::ToLimit => {
                let (low, high) = self.scale.position;
                let (end, speed) = if self.sign > 0.0 { (high + 0.5, 1.0) } else { (low - 0.5, -1.0) };
                let speed = speed * self.scale.velocity * (0.2 + 0.8 * self.share);
                if k.is_multiple_of(10) {
                    self.astray(host, 10, |at, i| {
                        let next = at.q[i] + speed * 0.01;
                        let beyond = (next - end) * speed > 0.0;
                        (at.q[i], at.qd[i], at.qdd[i]) = if beyond { (end, 0.0, 0.0) } else { (next, speed, 0.0) };
                    })?;
                }
                return Ok(true);
            }
            FaultKind::TooFast => {
                let speed = self.sign * self.scale.velocity * (1.0 + 10.0 * self.share);
                if k.is_multiple_of(10) {
                    self.astray(host, 10, |at, i| (at.q[i], at.qd[i]) = (at.q[i] + speed * 0.01, speed))?;
                }
                return Ok(true);
            }
            FaultKind::PointNumbers => {
                let (ticks, which) = (random.whole(0, 10) as u16, random.whole(0, 2));
                let wild = f64::from(random.pick(&WILD).unwrap_or(f32::NAN));
                let before = host.last;
                self.astray(host, ticks, |at, i| match which {
                    0 => at.q[i] = wild,
                    1 => at.qd[i] = wild,
                    _ => at.qdd[i] = wild,
                })?;
                // Forget the wrong point: the next one starts from the last regular one.
                host.last = before;
            }
            FaultKind::Flood => {
                for _ in 0..6 {
                    self.astray(host, 1, |_, _| {})?;
                }
            }
            FaultKind::LiveNumbers => {
                let mut live = link::Live::new(&Live::<f32, N>::zero()).map_err(|_| FrameTooLong)?;
                live.gravity[random.index(3)] = [f32::NAN, f32::INFINITY][random.index(2)];
                host.send(&Frame::Live(live))?;
            }
            kind if kind == FaultKind::Requests || kind.is_of_the_link() => chatter(host, random, kind)?,
            kind if k == 0 => {
                if let Some(live) = self.falsehood(kind) {
                    host.send(&Frame::Live(link::Live::new(&live).map_err(|_| FrameTooLong)?))?;
                }
            }
            _ => {}
        }
        Ok(false)
    }

    /// Live inputs that are finite but wrong; `None` for every other fault.
    fn falsehood(&self, kind: FaultKind) -> Option<Live<f32, N>> {
        let mut live = self.truth;
        let sign = self.sign as f32;
        let size = |least: f64, decades: f64| (least * 10.0_f64.powf(decades * self.share)) as f32;
        match kind {
            FaultKind::Payload => live.payload = point_mass(size(10.0, 5.0), 0.5 * sign),
            FaultKind::Model => live.payload = point_mass(self.share as f32 * self.payload_max, 0.2 * sign),
            FaultKind::Wrench => {
                let size = sign * size(1.0, 4.0);
                live.tip_wrench.force = Vector3::new(size, -size, size);
                live.tip_wrench.moment = Vector3::new(0.0, 0.1 * size, 0.0);
            }
            FaultKind::Rotor => live.rotor[self.joint] = sign * size(0.1, 5.0),
            _ => return None,
        }
        Some(live)
    }

    /// Force at the tip, N; `None` for every other fault.
    pub(super) fn push(&self) -> Option<Wrench<f64>> {
        let force = self.sign * 400.0 * self.share;
        (self.kind == FaultKind::Push)
            .then(|| Wrench { force: Vector3::new(force, -force, force), moment: Vector3::zeros() })
    }

    /// Sends the last point again with one joint changed.
    fn astray(
        &self,
        host: &mut Host<N>,
        ticks: u16,
        change: impl Fn(&mut Reference<f64, N>, usize),
    ) -> Result<(), FrameTooLong> {
        let Some(mut at) = host.last else { return Ok(()) };
        change(&mut at, self.joint);
        host.point(ticks, &at)
    }
}

/// Sends some frames for the link to damage: requests and `Alive` frames.
fn chatter<const N: usize>(host: &mut Host<N>, random: &mut Random, kind: FaultKind) -> Result<(), FrameTooLong> {
    let most = if kind == FaultKind::Requests { 4 } else { 2 };
    for _ in 0..random.whole(0, most) {
        match random.pick(&Request::NAMES) {
            Some((request, _)) if kind == FaultKind::Requests || random.chance(0.3) => host.ask(request)?,
            _ => host.send(&Frame::Alive)?,
        }
    }
    Ok(())
}

/// A point mass on the z axis of the last link's frame, kg and m.
fn point_mass(mass: f32, at: f32) -> Inertia<f32> {
    let turned = mass * at * at;
    let about_origin = Matrix3::from_diagonal(&Vector3::new(turned, turned, 0.0));
    Inertia { mass, first_moment: Vector3::new(0.0, 0.0, at * mass), about_origin }
}

/// Moves the reading of a joint by `way`, rad or m.
fn move_by<const N: usize>(told: &mut TickInputs<N>, joint: usize, way: f64, scale: &JointScale) {
    match &mut told.sensed {
        Sensed::State { q, .. } => q[joint] += way as f32,
        // The encoder's counter wraps around.
        Sensed::Counts(counts) => counts[joint] = counts[joint].wrapping_add((way / scale.per_count) as i32),
    }
}

/// Replaces the reading of a joint by an earlier one.
fn hold_still<const N: usize>(told: &mut TickInputs<N>, joint: usize, before: &Sensed<f32, N>) {
    match (&mut told.sensed, before) {
        (Sensed::State { q, qd }, Sensed::State { q: q_before, .. }) => (q[joint], qd[joint]) = (q_before[joint], 0.0),
        (Sensed::Counts(counts), Sensed::Counts(before)) => counts[joint] = before[joint],
        _ => {}
    }
}
