//! A run in progress: host, board, buses, arm and judge, tick by tick.

mod script_steps;

use super::broken::{Breakage, Faulty, Memory, without_timeouts};
use super::injection::{Board, DriveInjection};
use super::judge::{DriveJudge, Truth};
use super::stage::{BRAKES_ENGAGE, DrivesStage, blended, pass};
use crate::campaign::host::Host;
use crate::campaign::judge::{SafetyProperty, Unsafe};
use crate::campaign::machine::Desk;
use crate::campaign::outcome::Number;
use crate::campaign::random::Random;
use crate::campaign::script::{Script as _, Stop};
use crate::campaign::stage::Stage;
use actuator_model::mit::Shaft;
use link::StateCode;
use link::codec::FrameTooLong;
use link::{Hello, Pacing, Status};
use session::readings::Lines;
use sim::failure::Failure;
use sim::plant::{Diverged, State};
use sim::run::world::World;

/// A run in progress.
pub(super) struct DriveRun<'a, const N: usize> {
    stage: &'a DrivesStage<N>,
    desk: &'a mut Desk<N>,
    breakage: Option<Breakage>,
    memory: Memory<N>,
    host: Host<N>,
    pub(super) judge: DriveJudge<'a, N>,
    world: World<N>,
    random: Random,
    pub(super) pair: u64,
    /// Ticks until the brakes engage, after their line closes.
    engaging: u32,
    /// The fault of this run, while it lasts.
    injection: Option<DriveInjection>,
    /// True while the host is silent.
    mute: bool,
    pub(super) tick: u32,
    status: Option<Status>,
    /// Ticks along the trajectory, and the arm's position at its start relative to the start of the scene's motion.
    along: u32,
    offset: [f64; N],
    /// Ticks of arming so far.
    pub(super) armed_in: u32,
}

impl<'a, const N: usize> DriveRun<'a, N> {
    pub(super) fn new(
        stage: &'a DrivesStage<N>,
        desk: &'a mut Desk<N>,
        Number { seed, run }: Number,
        breakage: Option<Breakage>,
    ) -> Result<Self, Failure> {
        desk.restart();
        let Stage { config, rules, hello, .. } = &stage.stage;
        let hello = Hello { pacing: Pacing::Live, ..*hello };
        let target = |error: FrameTooLong| Failure::Target(miette::Report::from_err(error));
        let mut host = Host::new(hello, None).map_err(target)?;
        host.deaf_to = (breakage == Some(Breakage::HoldLost)).then_some(link::Request::Hold);
        let arm = (&stage.arm, &stage.known);
        Ok(Self {
            judge: DriveJudge::new(arm, rules, (config.age_max, stage.tells_state), stage.world.plant.state().q),
            stage,
            desk,
            breakage,
            memory: Memory::NONE,
            host,
            world: stage.world.clone(),
            random: Random::new(seed, run),
            pair: 0,
            engaging: 0,
            injection: None,
            mute: false,
            tick: 0,
            status: None,
            along: 0,
            offset: [0.0; N],
            armed_in: 0,
        })
    }

    /// Runs one tick: host, board, buses, arm, judge.
    fn pass(&mut self, board: Board) -> Result<(), Stop> {
        self.tick += 1;
        if self.state() == StateCode::Running && !self.host.gone {
            self.feed()?;
        }
        let sent = self.host.finish(None, None, false)?;
        let requests = sent.requests;
        let (supply, _) = self.stage.stage.calm;
        let lines = Lines { emergency_stop: board.emergency_stop, supply, temperature: None };
        let state = self.state();
        let Self { world, desk, memory, breakage, engaging, .. } = &mut *self;
        let Some(drives) = &mut world.drives else { return Ok(()) };
        memory.begin(state);
        let carried = core::array::from_fn(|i| drives.given(i));
        let late = core::cell::Cell::new(board.late == Some(true));
        let is_due = || late.replace(board.late.is_some());
        let mut joints = Faulty { joints: drives.board(), breakage: *breakage, memory };
        let status = desk.on_board(&sent.bytes, &mut joints, lines, is_due).map_err(Stop::Machine)?;
        drives.serve(&world.sensors.disturbed(world.plant.measured()));
        let heard = core::array::from_fn(|i| drives.electronics(i).is_some_and(|it| it.silent_for() == 0.0));
        if *breakage == Some(Breakage::TimeoutNeverActs) {
            without_timeouts(drives);
        }
        let released = !drives.brakes_hold() || memory.opens;
        let open = released || *engaging > 0;
        *engaging = if released { (BRAKES_ENGAGE / world.period).ceil() as u32 } else { engaging.saturating_sub(1) };
        let slips = memory.slips(*breakage, open, world.period);
        self.move_arm(open || slips).map_err(|diverged| {
            let broken = Unsafe { law: SafetyProperty::RanAway, what: diverged.to_string() };
            Stop::Unsafe { what: broken.what.clone(), broken: Some(broken), inputs: format!("{status:?}") }
        })?;
        self.judge(UnjudgedTick {
            board,
            status,
            requests,
            spoke: sent.spoke && !self.mute,
            carried,
            heard,
            released,
            open,
        })
    }

    /// Moves the arm for one period.
    fn move_arm(&mut self, open: bool) -> Result<(), Diverged> {
        if open || !self.stage.brakes {
            return pass(&mut self.world, &self.stage.stops);
        }
        if let World { plant, drives: Some(drives), .. } = &mut self.world {
            drives.rest(plant.measured());
            plant.brake();
        }
        Ok(())
    }

    /// Passes the true state of this tick to the judge.
    fn judge(&mut self, seen: UnjudgedTick<N>) -> Result<(), Stop> {
        let UnjudgedTick { board, status, requests, spoke, carried, heard, released, open } = seen;
        let State { q, qd } = *self.world.plant.state();
        let Some(drives) = &mut self.world.drives else { return Ok(()) };
        let (mut torque, mut told) = ([0.0; N], [0.0; N]);
        let (mut on, mut powered, mut told_off, mut zero) = ([false; N], [false; N], [false; N], [0.0; N]);
        for i in 0..N {
            torque[i] = drives.given(i);
            if let Some(it) = drives.electronics(i) {
                (on[i], powered[i], told_off[i]) = (it.gives_torque(), it.powered, it.was_told_off());
                told[i] = it.told().torque * self.stage.ratios[i];
                zero[i] = it.zero() / self.stage.ratios[i];
            }
            torque[i] = if powered[i] { torque[i] } else { 0.0 };
        }
        let (world, along, offset) = (&self.world, self.along, self.offset);
        let motion = |ticks: u32| blended(world, along + ticks, &offset);
        let truth = Truth {
            state: (status.state, status.cause),
            homed: status.homed,
            q,
            qd,
            carried,
            torque,
            told,
            on,
            powered,
            heard,
            told_off,
            zero,
            released,
            open,
            motion: &motion,
            requests: &requests,
            spoke,
        };
        let judged = self.judge.watch(&truth);
        if let Err(broken) = judged {
            let what = format!("{:?}: {}", broken.law, broken.what);
            let inputs = format!(
                "{board:?}, requests {requests:?}\nsaid {status:?}\nq {q:?}\nqd {qd:?}\ntorque {torque:?}, before {carried:?}\non {on:?}, power {powered:?}, heard {heard:?}, brakes open {open}\nreference {:?}",
                motion(0)
            );
            return Err(Stop::Unsafe { broken: Some(broken), what, inputs });
        }
        if status.state == StateCode::Homing && !self.mute {
            // The operator sets the zeros of the drives that have power.
            for i in 0..N {
                let electronics = self.world.drives.as_mut().and_then(|drives| drives.electronics(i));
                if let Some(it) = electronics.filter(|it| it.powered) {
                    it.set_zero(&Shaft::default());
                }
            }
        }
        self.along += u32::from(status.state == StateCode::Running);
        self.armed_in += u32::from(status.state == StateCode::Arming);
        self.status = Some(status);
        Ok(())
    }

    /// Sends the trajectory points that are due.
    fn feed(&mut self) -> Result<(), FrameTooLong> {
        let (world, offset) = (&self.world, self.offset);
        self.host.feed(self.along, |ticks| blended(world, ticks, &offset))
    }
}

/// A tick before it is judged.
struct UnjudgedTick<const N: usize> {
    board: Board,
    status: Status,
    requests: Vec<link::Request>,
    spoke: bool,
    carried: [f64; N],
    heard: [bool; N],
    released: bool,
    open: bool,
}
