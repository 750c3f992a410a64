//! Several arms in the lanes of one [kernel](super::arm_kernel). Each arm integrates its own interval of time.

use super::actuator::{Drive, rippled};
use super::arm_kernel::{ArmKernel, Flags, JointLanes, Shape, take_apart};
use super::flow::{Dry, Flow};
use super::friction::{JointFriction, level, middle, varies};
use super::integrator;
use super::solver::IntegrationRequest;
use super::state::{Lanes, States};
use super::{Diverged, LoadedArm, Plant};
use core::cell::{Cell, RefCell};
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointKind, Wrench};
pub(crate) use machine_code::LANES;
use machine_code::{Instructions, Work};
use robot_compiler::scene::Ripple;

impl<const N: usize> Plant<N> {
    /// Shape that arms must share to be integrated together with this one. `None` for an arm that must be integrated alone, because it has springs in
    /// its joints or an energy ledger.
    pub(crate) fn shape(&self) -> Option<Shape> {
        let alone = self.motors.is_some() || self.ledger.is_some();
        (!alone).then(|| take_apart(&self.body.mechanism, self.may_touch(), self.body.is_dry()).0)
    }

    /// True if a wrench acts at the tip, now or later.
    fn may_touch(&self) -> bool {
        self.push.is_some() || self.body.mechanism.tip_wrench().is_some()
    }
}

/// Arms of one shape, one per lane.
#[derive(Clone, Debug)]
pub(crate) struct ArmLanes<const N: usize> {
    kernel: RefCell<ArmKernel<N>>,
    instructions: Instructions,
    friction: Frictions<N>,
    ripple: [Option<Ripple>; LANES],
    kinds: [JointKind; N],
    /// Torque curve of each lane, and the torques if all curves are constant.
    drives: [Drive<N>; LANES],
    constant: Option<JointLanes<N>>,
    /// Number of solutions of the equations of motion by each lane, in the present interval.
    solved: Cell<[u64; LANES]>,
}

impl<const N: usize> ArmLanes<N> {
    /// Lanes for arms of this plant's shape; `None` if this processor has no kernel.
    pub(crate) fn new(plant: &Plant<N>) -> Option<Self> {
        let kernel = ArmKernel::new(&plant.body.mechanism, plant.may_touch(), plant.body.is_dry())?;
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

    /// Puts an arm into a lane. Returns false if the arm has another shape.
    pub(crate) fn place(&mut self, lane: usize, plant: &Plant<N>) -> bool {
        let LoadedArm { mechanism, friction, ripple, .. } = &plant.body;
        self.friction.place(lane, friction.as_ref());
        self.ripple[lane] = *ripple;
        self.kernel.get_mut().place(lane, mechanism, plant.body.is_dry())
    }

    /// Sets the wrench at the tip of a lane's arm.
    pub(crate) fn push(&mut self, lane: usize, wrench: Option<Wrench<f64>>) {
        self.kernel.get_mut().push(lane, wrench);
    }

    /// Integrates the arms that have a request. Returns for every lane the error that stopped it, if any, and the number of solutions of the
    /// equations of motion.
    pub(crate) fn pass(
        &mut self,
        passages: &mut [Option<IntegrationRequest<N>>; LANES],
    ) -> ([Option<Diverged>; LANES], [u64; LANES]) {
        self.instructions.run(Pass { arms: self, passages })
    }
}

impl<const N: usize> Flow<States<N, LANES>, N, LANES> for ArmLanes<N> {
    type Input = JointLanes<N>;

    #[inline(always)]
    fn rough(&self) -> Option<&JointLanes<N>> {
        self.friction.is_dry.then_some(&self.friction.rough)
    }

    #[inline(always)]
    fn input(&self, t: &[f64; LANES]) -> JointLanes<N> {
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
        torque: &JointLanes<N>,
        dry: &mut Dry<N, LANES>,
        slope: &mut States<N, LANES>,
        lanes: &mut Lanes<LANES>,
    ) {
        self.instructions.run(Slope { arms: self, point, torque, dry, slope, lanes });
    }
}

/// Integration of the arms over their intervals.
struct Pass<'a, const N: usize> {
    arms: &'a mut ArmLanes<N>,
    passages: &'a mut [Option<IntegrationRequest<N>>; LANES],
}

impl<const N: usize> Work for Pass<'_, N> {
    type Outcome = ([Option<Diverged>; LANES], [u64; LANES]);

    #[inline(always)]
    fn run(self) -> Self::Outcome {
        let Self { arms, passages } = self;
        let mut point = States { q: [[0.0; LANES]; N], qd: [[0.0; LANES]; N] };
        for (lane, passage) in passages.iter().enumerate() {
            let Some(IntegrationRequest { state, drive, .. }) = passage else { continue };
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

/// Accelerations of the arms under their drives' torques.
struct Slope<'a, const N: usize> {
    arms: &'a ArmLanes<N>,
    point: &'a States<N, LANES>,
    torque: &'a JointLanes<N>,
    dry: &'a mut Dry<N, LANES>,
    slope: &'a mut States<N, LANES>,
    lanes: &'a mut Lanes<LANES>,
}

impl<const N: usize> Work for Slope<'_, N> {
    type Outcome = ();

    #[inline(always)]
    fn run(self) {
        let Self { arms, point, torque, dry, slope, lanes } = self;
        let mut driving = *torque;
        for lane in (0..LANES).filter(|&lane| arms.ripple[lane].is_some()) {
            let Some(ripple) = arms.ripple[lane] else { continue };
            let rippled = rippled(ripple, &arms.kinds, &torque.map(|x| x[lane]), &point.lane(lane).q);
            for joint in 0..N {
                driving[joint][lane] = rippled[joint];
            }
        }
        arms.friction.oppose(&point.qd, dry, &mut driving);
        fail_others(within(point), Diverged::NotFinite, lanes);
        let (mut solved, live) = (arms.solved.get(), lanes.live());
        for lane in 0..LANES {
            solved[lane] += u64::from(live[lane]);
        }
        arms.solved.set(solved);
        slope.q = point.qd;
        let definite = arms.kernel.borrow_mut().solve((&point.q, &point.qd), &driving, dry, &mut slope.qd);
        fail_others(definite, Diverged::SingularInertia, lanes);
    }
}

/// Marks the lanes that are not fine as failed. Nearly always all are fine, and then no lane is examined.
#[inline(always)]
fn fail_others(fine: Flags, why: Diverged, lanes: &mut Lanes<LANES>) {
    if fine == [1; LANES] {
        return;
    }
    for lane in (0..LANES).filter(|&lane| fine[lane] == 0) {
        lanes.fail(lane, why);
    }
}

/// Lanes with a finite state and positions within the range of the sine: [`super::within`] for each lane.
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

/// Friction of the joints of all lanes' arms.
#[derive(Clone, Debug)]
struct Frictions<const N: usize> {
    viscous: JointLanes<N>,
    coulomb: JointLanes<N>,
    /// One for a joint with dry friction, zero for the others.
    rough: JointLanes<N>,
    is_dry: bool,
    /// Friction of each lane's arm; `None` without friction.
    whole: [Option<[JointFriction; N]>; LANES],
    /// Torque that does not depend on the motion.
    constant: JointLanes<N>,
    /// True for a joint if the friction level depends on torque or velocity in some lane.
    special: [bool; N],
}

impl<const N: usize> Frictions<N> {
    fn none() -> Self {
        let zero = [[0.0; LANES]; N];
        let special = [false; N];
        Self { viscous: zero, coulomb: zero, constant: zero, rough: zero, is_dry: false, whole: [None; LANES], special }
    }

    fn place(&mut self, lane: usize, friction: Option<&[JointFriction; N]>) {
        self.whole[lane] = friction.copied();
        for joint in 0..N {
            let own = friction.map(|friction| friction[joint]);
            self.viscous[joint][lane] = own.map_or(0.0, |own| own.viscous);
            self.coulomb[joint][lane] = own.map_or(0.0, |own| own.coulomb);
            self.constant[joint][lane] = own.map_or(0.0, |own| middle(&own));
            self.rough[joint][lane] = f64::from(u8::from(own.is_some_and(|own| own.is_dry())));
            let varies = |friction: &Option<[JointFriction; N]>| friction.is_some_and(|it| varies(&it[joint]));
            self.special[joint] = self.whole.iter().any(varies);
        }
        self.is_dry = self.rough.as_flattened().contains(&1.0);
    }

    /// Subtracts friction from the torques of the drives: viscous friction at these velocities, and the dry friction of sliding joints.
    #[inline(always)]
    fn oppose(&self, qd: &JointLanes<N>, dry: &mut Dry<N, LANES>, torque: &mut JointLanes<N>) {
        for joint in 0..N {
            dry.level[joint] = self.coulomb[joint];
            if self.special[joint] {
                for lane in 0..LANES {
                    let own = self.whole[lane].map(|friction| friction[joint]);
                    dry.level[joint][lane] = own.map_or(0.0, |own| level(&own, torque[joint][lane], qd[joint][lane]));
                }
            }
            let (viscous, level, sign) = (&self.viscous[joint], &dry.level[joint], &dry.sign[joint]);
            let constant = &self.constant[joint];
            for lane in 0..LANES {
                torque[joint][lane] -= viscous[lane] * qd[joint][lane] + level[lane] * sign[lane] + constant[lane];
            }
        }
    }
}
