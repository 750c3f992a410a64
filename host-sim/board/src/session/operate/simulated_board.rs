//! A simulated board on a simulated cable: the firmware's session in live mode on the desk, the scene's simulated arm and drives, and links that lose
//! frames.
//!
//! ```text
//! operator -> wire -> session -> drives' buses -> arm
//!          <- wire <-         <-               <-
//! ```
//!
//! Time is simulated, one control period at a time; for a user at a terminal it runs at the pace of the clock.

use super::device::{Cut, Device, DeviceError, Pace, Tap};
use super::on_wire::ALIVE_EVERY;
use super::wire::{Chance, Disturbance, Wire};
use crate::session::dry_run::{DeskSession, Uncounted, desk_session};
use actuator_model::bus::Fate;
use dynamics_core::{Model, Sensed};
use link::{Frame, Pacing};
use robot_compiler::SceneFile;
use session::black_box::Report;
use session::meter::Meter;
use session::readings::{JointFaults, Lines, Readings};
use session::{Drives, Reaction};
use sim::plant::drives::Drives as Electronics;
use sim::plant::sensor::Sample;
use sim::run::world::World;
use std::time::Duration;

/// Links of a simulated board that are disturbed at random.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Places {
    /// The link between host and board.
    pub host: bool,
    /// The buses between board and drives.
    pub buses: bool,
}

/// A simulated board.
pub struct SimulatedBoard<const N: usize> {
    session: DeskSession<N>,
    meter: Meter<Uncounted>,
    world: World<N>,
    ticks: u64,
    sent: u64,
    to_board: Wire,
    to_host: Wire,
    /// Disturbance of the drives' buses.
    buses: Disturbance,
    chance: Chance,
    lines: Lines,
    /// Joints whose drives are disconnected.
    cut_drives: [bool; N],
    pace: Pace,
    tap: Tap,
}

impl<const N: usize> SimulatedBoard<N> {
    /// A board that waits for a hello.
    #[must_use]
    pub fn new(
        (scene, model): (&SceneFile, &Model<f64, N>),
        mut world: World<N>,
        disturbance: Disturbance,
        places: Places,
        pace: Pace,
    ) -> Self {
        world.ask();
        let none = Disturbance { seed: disturbance.seed, ..Disturbance::default() };
        let host = if places.host { disturbance } else { none };
        Self {
            session: desk_session(scene, model),
            meter: Meter::new(Uncounted),
            world,
            ticks: 0,
            sent: 0,
            to_board: Wire::new(host, 0),
            to_host: Wire::new(host, 1),
            buses: if places.buses { disturbance } else { none },
            chance: Chance::new(disturbance.seed, 2),
            lines: Lines::NONE,
            cut_drives: [false; N],
            pace,
            tap: Tap::default(),
        }
    }

    fn seconds(&self) -> f64 {
        self.ticks as f64 * self.world.period
    }

    /// Returns the readings of all joints at the start of a tick, and the drives' highest temperature.
    fn readings(&mut self) -> (Option<Readings<N>>, Option<f32>) {
        if let Some(drives) = &mut self.world.drives {
            return drives.measure();
        }
        let reading = self.world.sensors.read(self.world.plant.measured());
        let sensed = match reading.sample {
            Sample::State(state) => Sensed::State { q: state.q.map(|x| x as f32), qd: state.qd.map(|x| x as f32) },
            Sample::Counts(counts) => Sensed::Counts(counts),
        };
        let readings = Readings {
            sensed,
            torque: [0.0; N],
            age_ticks: [reading.age_ticks; N],
            faults: [JointFaults::NONE; N],
            errors: [0; N],
            on: [true; N],
            zero_lost: false,
        };
        (Some(readings), None)
    }

    /// Applies the random losses and the cut cables to the drives' buses in this tick.
    fn disturb(&mut self) {
        let (chance, buses, cut) = (&mut self.chance, self.buses, &self.cut_drives);
        let Some(drives) = &mut self.world.drives else { return };
        for joint in 0..N {
            let (deaf, silent) = (chance.happens(buses.drop), chance.happens(buses.drop));
            let short = chance.happens(buses.corrupt);
            let deaf = deaf || cut.get(joint).copied().unwrap_or(false);
            drives.disturb(joint, deaf, [(silent, Fate::Lost), (short, Fate::Short)]);
        }
    }

    /// Gives the session a frame that has arrived, and sends its answers.
    fn take(&mut self, received: Result<link::Received, link::DecodeError>) {
        let now = self.seconds();
        match self.session.receive(received) {
            Reaction::Reply(frame) | Reaction::Start(_, frame) | Reaction::Resume(frame) => {
                self.to_host.send(now, frame)
            }
            Reaction::Stop(hello, refusal) => {
                self.to_host.send(now, hello);
                self.to_host.send(now, refusal);
            }
            Reaction::None | Reaction::Tick => {}
        }
    }

    fn tick(&mut self) -> Result<(), DeviceError> {
        let (readings, temperature) = self.readings();
        self.session.sense(readings.as_ref(), &Lines { temperature, ..self.lines });
        if self.session.clears()
            && let Some(drives) = &mut self.world.drives
        {
            drives.clear();
        }
        self.disturb();
        let moved = match self.session.tick(&self.meter) {
            Drives::Drive(torque) => self.world.drive(&torque.map(f64::from)),
            Drives::Enable(action) => self.world.enable(action),
            Drives::Preload(torque) => self.world.preload(&torque.map(f64::from)),
            Drives::Safe(_) => self.world.stop(),
        };
        moved.map_err(DeviceError::Diverged)?;
        let now = self.seconds();
        while let Some(report) = self.session.say() {
            self.to_host.send(now, Report::frame(report));
        }
        Ok(())
    }
}

impl<const N: usize> Device for SimulatedBoard<N> {
    fn pacing(&self) -> Pacing {
        Pacing::Live
    }

    fn send(&mut self, frame: &Frame) -> Result<(), DeviceError> {
        self.sent = self.ticks;
        let now = self.seconds();
        self.tap.hear_sent(self.now(), frame)?;
        self.to_board.send(now, frame.clone());
        Ok(())
    }

    fn pass(&mut self) -> Result<Vec<Frame>, DeviceError> {
        if (self.ticks - self.sent) as f64 * self.world.period >= ALIVE_EVERY.as_secs_f64() {
            self.send(&Frame::Alive)?;
        }
        self.ticks += 1;
        let now = self.seconds();
        while let Some(received) = self.to_board.receive(now) {
            self.take(received);
        }
        if self.session.is_live() {
            self.tick()?;
        }
        let mut frames = Vec::new();
        while let Some(received) = self.to_host.receive(now) {
            // A corrupted packet is counted in the number of packets lost before the next one.
            let Ok(received) = received else { continue };
            self.tap.hear_received(received.missed, self.now(), &received.frame)?;
            frames.push(received.frame);
        }
        self.pace.keep(self.now());
        Ok(frames)
    }

    fn now(&self) -> Duration {
        Duration::from_secs_f64(self.seconds())
    }

    fn is_simulated(&self) -> bool {
        true
    }

    fn is_cut(&self) -> bool {
        self.to_board.cut
    }

    fn press(&mut self, pressed: bool) -> bool {
        self.lines.emergency_stop = pressed;
        true
    }

    fn cut(&mut self, what: Cut, cut: bool) -> Result<(), String> {
        let drives = self.world.drives.as_mut();
        let missing = || "the scene's drives are not simulated, so they have no bus".to_owned();
        match what {
            Cut::Host => (self.to_board.cut, self.to_host.cut) = (cut, cut),
            Cut::Bus(bus) => {
                drives.map(|drives: &mut Electronics<N>| drives.bus(bus).stuck = cut).ok_or_else(missing)?
            }
            Cut::Drive(joint) => {
                drives.ok_or_else(missing)?;
                if let Some(it) = self.cut_drives.get_mut(joint) {
                    *it = cut;
                }
            }
        }
        Ok(())
    }

    fn tap(&mut self) -> &mut Tap {
        &mut self.tap
    }
}
