//! Steps of the campaign's script in a run with simulated drives.

use super::DriveRun;
use crate::campaign::case::{Case, Situation};
use crate::campaign::drives::broken::Breakage;
use crate::campaign::drives::injection::{Board, DriveInjection};
use crate::campaign::drives::stage::blended;
use crate::campaign::fault::FaultKind;
use crate::campaign::host::Host;
use crate::campaign::random::Random;
use crate::campaign::script::{Script, Stop};
use crate::campaign::stage::Stage;
use link::{Frame, Status};
use sim::run::world::World;

/// Additional duration of an undisturbed hold, s: enough for any stop, for settling, and for some time at rest.
const RESTS: f64 = 1.0;

impl<const N: usize> Script<N> for DriveRun<'_, N> {
    fn host(&mut self) -> &mut Host<N> {
        &mut self.host
    }

    fn random(&mut self) -> &mut Random {
        &mut self.random
    }

    fn status(&self) -> Option<&Status> {
        self.status.as_ref()
    }

    fn live(&self) -> Frame {
        self.stage.stage.live.clone()
    }

    fn limits_first_motion(&self) -> bool {
        self.stage.stage.rules.first_motion.is_some()
    }

    fn step(&mut self) -> Result<(), Stop> {
        self.pass(Board::default())
    }

    fn press(&mut self) -> Result<(), Stop> {
        self.pass(Board { emergency_stop: true, ..Board::default() })
    }

    fn begin_motion(&mut self) -> Result<(), Stop> {
        let (q, from) = (self.world.plant.state().q, self.world.reference(0.0).q);
        self.offset = core::array::from_fn(|i| q[i] - from[i]);
        self.along = 0;
        let start = blended(&self.world, 0, &self.offset);
        self.host.start(&start)?;
        Ok(self.feed()?)
    }

    fn begin_fault(&mut self, case: Case) -> Result<u32, Stop> {
        let injection = DriveInjection::new::<N>(case.fault, self.pair, &mut self.random);
        let Stage { config, rules, .. } = &self.stage.stage;
        let silence = rules.heartbeat_max.saturating_add(rules.hold_max).min(5000);
        if matches!(case.fault, FaultKind::HostSilent | FaultKind::HostGone) {
            self.lose_host();
        }
        let (least, most) = injection.ticks(config.age_max, silence, self.stage.lowering);
        self.injection = Some(injection);
        // An undisturbed hold lasts until the arm must be at rest, and longer.
        let undisturbed = (case.fault, case.situation) == (FaultKind::Nothing, Situation::Holding);
        let more = if undisturbed { (RESTS / self.world.period) as u32 } else { 0 };
        Ok(self.random.whole(least, most + more))
    }

    fn disturbed(&mut self, k: u32) -> Result<(), Stop> {
        let Some(injection) = self.injection else { return self.step() };
        let Self { world, host, random, .. } = self;
        let state = *world.plant.measured();
        let Some(drives) = &mut world.drives else { return self.step() };
        let board = injection.act(k, (drives, &state), host, random)?;
        self.pass(board)
    }

    fn end_fault(&mut self) {
        let Some(injection) = self.injection.take() else { return };
        let World { plant, drives: Some(drives), .. } = &mut self.world else { return };
        injection.end(drives, plant.measured());
        self.mute = injection.kind == FaultKind::HostGone;
        self.host.gone &= self.mute;
    }

    fn lose_host(&mut self) {
        self.mute = true;
        self.host.gone = self.breakage != Some(Breakage::HostNeverMissed);
    }

    fn homes_again(&mut self) -> bool {
        self.random.chance(0.5)
    }

    fn arming(&self) -> u32 {
        self.stage.arming
    }

    fn disarming(&self) -> u32 {
        self.stage.stage.rules.brake_delay
    }
}
