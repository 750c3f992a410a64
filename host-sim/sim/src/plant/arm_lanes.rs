//! Arms side by side: each passes its own stretch of time, all in the lanes of one [kernel](super::arm_kernel).

use super::actuator::{Drive, rippled};
use super::arm_kernel::{ArmKernel, Flags, Joints, Shape, take_apart};
use super::friction::JointFriction;
use super::integrator::{self, Flow, Lanes, States};
use super::solver::Passage;
use super::tanh::tanh;
use super::{Acted, Diverged, Plant};
use core::cell::{Cell, RefCell};
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointKind, Wrench};
pub(crate) use machine_code::LANES;
use machine_code::{Instructions, Work};
use robot_compiler::scene::Ripple;

impl<const N: usize> Plant<N> {
    /// What arms must have in common with this one to pass their time beside it; `None` for an arm that passes it alone: one with springs
    /// in its joints, or with a ledger.
    pub(crate) fn shape(&self) -> Option<Shape> {
        let alone = self.motors.is_some() || self.ledger.is_some();
        (!alone).then(|| take_apart(&self.body.mechanism, self.may_touch()).0)
    }

    /// Whether a wrench acts at the tip, now or later.
    fn may_touch(&self) -> bool {
        self.push.is_some() || self.body.mechanism.tip_wrench().is_some()
    }
}

/// Arms of one shape, one a lane.
#[derive(Clone, Debug)]
pub(crate) struct ArmLanes<const N: usize> {
    kernel: RefCell<ArmKernel<N>>,
    instructions: Instructions,
    friction: Frictions<N>,
    ripple: [Option<Ripple>; LANES],
    kinds: [JointKind; N],
    /// Torque curve of each lane, and the torques where none of the curves bends.
    drives: [Drive<N>; LANES],
    constant: Option<Joints<N>>,
    /// Solutions of the equations of motion by each lane, while it passes a stretch.
    solved: Cell<[u64; LANES]>,
}

impl<const N: usize> ArmLanes<N> {
    /// Lanes for arms of this plant's shape; `None` where this processor has no kernel.
    pub(crate) fn new(plant: &Plant<N>) -> Option<Self> {
        let kernel = ArmKernel::new(&plant.body.mechanism, plant.may_touch())?;
        Some(Self {
            instructions: kernel.instructions(),
            kernel: RefCell::new(kernel),
            friction: Frictions::none(),
            ripple: [None; LANES],
            kinds: plant.body.kinds,
            drives: [Drive::none(); LANES],
            constant: None,
            solved: Cell::new([0; LANES]),
        })
    }

    /// Place an arm of this shape in a lane; false if it has another shape.
    pub(crate) fn place(&mut self, lane: usize, plant: &Plant<N>) -> bool {
        let Acted { mechanism, friction, ripple, .. } = &plant.body;
        self.friction.place(lane, friction.as_ref());
        self.ripple[lane] = *ripple;
        self.kernel.get_mut().place(lane, mechanism)
    }

    /// Set the wrench at the tip of a lane's arm.
    pub(crate) fn push(&mut self, lane: usize, wrench: Option<Wrench<f64>>) {
        self.kernel.get_mut().push(lane, wrench);
    }

    /// Let the arms that have a passage pass it. Returns for every lane why it could not be continued, and the number of solutions of the
    /// equations of motion.
    pub(crate) fn pass(
        &mut self,
        passages: &mut [Option<Passage<N>>; LANES],
    ) -> ([Option<Diverged>; LANES], [u64; LANES]) {
        self.instructions.run(Pass { arms: self, passages })
    }
}

impl<const N: usize> Flow<States<N, LANES>, LANES> for ArmLanes<N> {
    type Input = Joints<N>;

    #[inline(always)]
    fn input(&self, t: &[f64; LANES]) -> Joints<N> {
        if let Some(constant) = &self.constant {
            return *constant;
        }
        let mut torques = [[0.0; LANES]; N];
        for lane in 0..LANES {
            let torque = self.drives[lane].at(t[lane]);
            for joint in 0..N {
                torques[joint][lane] = torque[joint];
            }
        }
        torques
    }

    fn slope(
        &self,
        point: &States<N, LANES>,
        torque: &Joints<N>,
        slope: &mut States<N, LANES>,
        lanes: &mut Lanes<LANES>,
    ) {
        self.instructions.run(Slope { arms: self, point, torque, slope, lanes });
    }
}

/// Arms that pass their stretches.
struct Pass<'a, const N: usize> {
    arms: &'a mut ArmLanes<N>,
    passages: &'a mut [Option<Passage<N>>; LANES],
}

impl<const N: usize> Work for Pass<'_, N> {
    type Outcome = ([Option<Diverged>; LANES], [u64; LANES]);

    #[inline(always)]
    fn run(self) -> Self::Outcome {
        let Self { arms, passages } = self;
        let mut point = States { q: [[0.0; LANES]; N], qd: [[0.0; LANES]; N] };
        for (lane, passage) in passages.iter().enumerate() {
            let Some(Passage { state, drive, .. }) = passage else { continue };
            for joint in 0..N {
                (point.q[joint][lane], point.qd[joint][lane]) = (state.q[joint], state.qd[joint]);
            }
            arms.drives[lane] = *drive;
        }
        arms.constant = None;
        if arms.drives.iter().all(Drive::is_constant) {
            arms.constant = Some(arms.input(&[0.0; LANES]));
        }
        arms.solved.set([0; LANES]);
        let mut plans = passages.each_ref().map(|passage| passage.as_ref().map(|passage| passage.plan));
        let failed = integrator::advance(&*arms, &mut point, &mut plans, |_| ());
        for (lane, (passage, plan)) in passages.iter_mut().zip(plans).enumerate() {
            if let (Some(passage), Some(plan)) = (passage, plan) {
                (passage.state, passage.plan) = (point.lane(lane), plan);
            }
        }
        (failed, arms.solved.get())
    }
}

/// Arms' accelerations under their drives.
struct Slope<'a, const N: usize> {
    arms: &'a ArmLanes<N>,
    point: &'a States<N, LANES>,
    torque: &'a Joints<N>,
    slope: &'a mut States<N, LANES>,
    lanes: &'a mut Lanes<LANES>,
}

impl<const N: usize> Work for Slope<'_, N> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { arms, point, torque, slope, lanes } = self;
        let mut driving = *torque;
        for lane in (0..LANES).filter(|&lane| arms.ripple[lane].is_some()) {
            let Some(ripple) = arms.ripple[lane] else { continue };
            let rippled = rippled(ripple, &arms.kinds, &torque.map(|x| x[lane]), &point.lane(lane).q);
            for joint in 0..N {
                driving[joint][lane] = rippled[joint];
            }
        }
        arms.friction.oppose(&point.qd, &mut driving);
        fail_others(within(point), Diverged::NotFinite, lanes);
        let (mut solved, live) = (arms.solved.get(), lanes.live());
        for lane in 0..LANES {
            solved[lane] += u64::from(live[lane]);
        }
        arms.solved.set(solved);
        slope.q = point.qd;
        let definite = arms.kernel.borrow_mut().solve(&point.q, &point.qd, &driving, &mut slope.qd);
        fail_others(definite, Diverged::SingularInertia, lanes);
    }
}

/// Fail the lanes that are not fine; nearly always all are, and then no lane is looked at.
#[inline(always)]
fn fail_others(fine: Flags, why: Diverged, lanes: &mut Lanes<LANES>) {
    if fine == [1; LANES] {
        return;
    }
    for lane in (0..LANES).filter(|&lane| fine[lane] == 0) {
        lanes.fail(lane, why);
    }
}

/// Lanes whose state is finite and whose positions have sines: [`super::within`] of each.
#[inline(always)]
fn within<const N: usize>(point: &States<N, LANES>) -> Flags {
    let mut fine = [1_u64; LANES];
    for joint in 0..N {
        for lane in 0..LANES {
            fine[lane] &= u64::from(point.q[joint][lane].abs() <= Polynomial::LIMIT_F64);
            fine[lane] &= u64::from(point.qd[joint][lane].is_finite());
        }
    }
    fine
}

/// Ratio of speeds from which the sign is one to the last bit, and above where [`tanh`] says so, so that roundings do not matter.
const FAST: f64 = 21.0;

/// Friction of the joints of all lanes' arms.
#[derive(Clone, Debug)]
struct Frictions<const N: usize> {
    viscous: Joints<N>,
    coulomb: Joints<N>,
    sign_speed: Joints<N>,
    /// As each lane's arm has it; `None` without friction.
    whole: [Option<[JointFriction; N]>; LANES],
    /// Joints of which some arm has Coulomb friction, and of which some has more than viscous and Coulomb friction.
    rough: [bool; N],
    special: [bool; N],
}

impl<const N: usize> Frictions<N> {
    fn none() -> Self {
        let zero = [[0.0; LANES]; N];
        Self {
            viscous: zero,
            coulomb: zero,
            sign_speed: [[1.0; LANES]; N],
            whole: [None; LANES],
            rough: [false; N],
            special: [false; N],
        }
    }

    fn place(&mut self, lane: usize, friction: Option<&[JointFriction; N]>) {
        self.whole[lane] = friction.copied();
        for joint in 0..N {
            let own = friction.map(|friction| friction[joint]);
            self.viscous[joint][lane] = own.map_or(0.0, |own| own.viscous);
            self.coulomb[joint][lane] = own.map_or(0.0, |own| own.coulomb);
            self.sign_speed[joint][lane] = own.map_or(1.0, |own| own.sign_speed);
            let special = |friction: &Option<[JointFriction; N]>| friction.is_some_and(|it| !it[joint].is_plain());
            self.special[joint] = self.whole.iter().any(special);
            self.rough[joint] = self.coulomb[joint].iter().any(|coulomb| *coulomb > 0.0);
        }
    }

    /// Take friction at these velocities off the torques of the drives.
    #[inline(always)]
    fn oppose(&self, qd: &Joints<N>, torque: &mut Joints<N>) {
        for joint in 0..N {
            if self.special[joint] {
                for lane in 0..LANES {
                    let own = self.whole[lane].map(|friction| friction[joint]);
                    let drive = torque[joint][lane];
                    torque[joint][lane] -= own.map_or(0.0, |own| own.torque_under(drive, qd[joint][lane]));
                }
                continue;
            }
            let (coulomb, qd) = (&self.coulomb[joint], &qd[joint]);
            let signs = if self.rough[joint] { self.signs(joint, qd) } else { [0.0; LANES] };
            for lane in 0..LANES {
                torque[joint][lane] -= self.viscous[joint][lane] * qd[lane] + coulomb[lane] * signs[lane];
            }
        }
    }

    /// Sign of a joint's speed in every lane, smooth about rest; zero where the joint has no Coulomb friction.
    #[inline(always)]
    fn signs(&self, joint: usize, qd: &[f64; LANES]) -> [f64; LANES] {
        let (coulomb, speed) = (&self.coulomb[joint], &self.sign_speed[joint]);
        let mut fast = [1_u64; LANES];
        let mut signs = [0.0; LANES];
        for lane in 0..LANES {
            fast[lane] = u64::from(qd[lane].abs() > FAST * speed[lane]);
            signs[lane] = 1.0_f64.copysign(qd[lane]);
        }
        // Most of the time all joints are fast, or at rest in all lanes.
        if fast != [1; LANES] {
            for lane in 0..LANES {
                signs[lane] = qd[lane] / speed[lane];
            }
            signs = tanh(&signs);
        }
        for lane in 0..LANES {
            signs[lane] = if coulomb[lane] > 0.0 { signs[lane] } else { 0.0 };
        }
        signs
    }
}
