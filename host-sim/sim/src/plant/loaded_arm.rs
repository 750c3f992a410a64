//! The simulated arm with friction, ripple and the wrench at the tip: accelerations under its actuators' torques, for the integrators.

use super::actuator::{Drive, rippled};
use super::arm_kernel::ArmKernel;
use super::dynamics::Mechanism;
use super::elasticity::{BothSides, Motors};
use super::flow::{Dry, Flow};
use super::friction::{JointFriction, level, middle};
use super::state::{Diverged, Lanes, State, States};
use core::cell::{Cell, OnceCell, RefCell};
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointKind, Wrench};
use robot_compiler::scene::Ripple;

/// Number of solutions of the equations of motion after which an arm gets a kernel. Compiling a kernel takes about as long as this many solutions of a
/// six-joint arm without it. So a run that ends right after the compilation has not lost much.
const WORTH_A_KERNEL: u64 = 1000;

/// The arm's bodies, with gravity, wrench at the tip, friction and ripple, but without the torque.
#[derive(Clone, Debug)]
pub(crate) struct LoadedArm<const N: usize> {
    pub(super) mechanism: Mechanism<N>,
    pub(super) friction: Option<[JointFriction; N]>,
    /// One for each joint with dry friction, zero for the others; `None` if there is none.
    rough: Option<[[f64; 1]; N]>,
    pub(super) ripple: Option<Ripple>,
    pub(super) kinds: [JointKind; N],
    /// Number of solutions of the equations of motion.
    solved: Cell<u64>,
    /// The equations of motion in machine code, once they are compiled; `None` inside if this processor has no kernel. After compilation, only the
    /// wrench at the tip may change.
    kernel: OnceCell<Option<RefCell<ArmKernel<N>>>>,
}

impl<const N: usize> LoadedArm<N> {
    /// An arm of these bodies and kinds of joints, with friction and ripple.
    pub(super) fn new(
        mechanism: Mechanism<N>,
        friction: Option<[JointFriction; N]>,
        ripple: Option<Ripple>,
        kinds: [JointKind; N],
    ) -> Self {
        let rough = friction.map(|friction| friction.map(|joint| [f64::from(u8::from(joint.is_dry()))]));
        let rough = rough.filter(|rough| rough.contains(&[1.0]));
        Self { mechanism, friction, rough, ripple, kinds, solved: Cell::new(0), kernel: OnceCell::new() }
    }

    /// Makes the next solution compile the kernel.
    pub(super) fn compile_next(&self) {
        self.solved.set(self.solved.get().max(WORTH_A_KERNEL));
    }

    /// True if a joint has dry friction.
    pub(super) fn is_dry(&self) -> bool {
        self.rough.is_some()
    }

    /// Torques of the actuators after ripple at this state, on the joints or their motors, N m or N.
    pub(super) fn acting(&self, torque: &[f64; N], state: &State<N>) -> [f64; N] {
        self.ripple.map_or(*torque, |ripple| rippled(ripple, &self.kinds, torque, &state.q))
    }

    /// Torques of the actuators after ripple, minus viscous friction and the dry friction of sliding joints, N m or N.
    fn driving(&self, torque: &[f64; N], state: &State<N>, dry: &mut Dry<N, 1>) -> [f64; N] {
        let mut torque = self.acting(torque, state);
        if let Some(friction) = &self.friction {
            for i in 0..N {
                let level = level(&friction[i], torque[i], state.qd[i]);
                torque[i] -= friction[i].viscous * state.qd[i] + level * dry.sign[i][0] + middle(&friction[i]);
                dry.level[i][0] = level;
            }
        }
        torque
    }

    /// Wrench of the environment on the tip, now.
    pub(crate) fn tip_wrench(&self) -> Option<Wrench<f64>> {
        self.mechanism.tip_wrench()
    }

    /// Number of solutions of the equations of motion.
    pub(super) fn solutions(&self) -> u64 {
        self.solved.get()
    }

    /// Adds to the number of solutions of the equations of motion.
    pub(crate) fn count(&self, solutions: u64) {
        self.solved.set(self.solved.get() + solutions);
    }

    /// `(qd, qdd)` under these torques. With `dry`, joints may be held, and their loads are written to it.
    fn moved(&self, state: &State<N>, torque: &[f64; N], dry: Option<&mut Dry<N, 1>>) -> Result<State<N>, Diverged> {
        if !within(state) {
            return Err(Diverged::NotFinite);
        }
        self.solved.set(self.solved.get() + 1);
        let qdd = self.acceleration(state, torque, dry).ok_or(Diverged::SingularInertia)?;
        Ok(State { q: state.qd, qd: qdd })
    }

    /// Accelerations under these torques; `None` if the inertia matrix is not positive definite.
    fn acceleration(&self, state: &State<N>, torque: &[f64; N], dry: Option<&mut Dry<N, 1>>) -> Option<[f64; N]> {
        let Self { mechanism, kernel, .. } = self;
        if self.solved.get() > WORTH_A_KERNEL {
            let kernel = kernel.get_or_init(|| ArmKernel::of_one(mechanism, dry.is_some()).map(RefCell::new));
            let kernel = kernel.as_ref().map(RefCell::borrow_mut);
            if let Some(mut kernel) = kernel
                && kernel.feels(mechanism.tip_wrench())
            {
                return kernel.solve_one(&state.q, &state.qd, torque, dry);
            }
        }
        let Some(dry) = dry else { return mechanism.acceleration(&state.q, &state.qd, torque) };
        let free = dry.free.map(|[free]| free);
        let (qdd, load) = mechanism.acceleration_held((&state.q, &state.qd), torque, &free)?;
        dry.load = load.map(|load| [load]);
        Some(qdd)
    }
}

/// True if a state is finite and its positions are within the range of the sine.
fn within<const N: usize>(state: &State<N>) -> bool {
    state.q.iter().all(|q| q.abs() <= Polynomial::LIMIT_F64) && state.qd.iter().all(|x| x.is_finite())
}

/// Arm with rigid joints.
pub(super) struct Rigid<'a, const N: usize> {
    pub(super) body: &'a LoadedArm<N>,
    pub(super) drive: &'a Drive<N>,
}

impl<const N: usize> Flow<States<N, 1>, N, 1> for Rigid<'_, N> {
    type Input = [f64; N];

    fn rough(&self) -> Option<&[[f64; 1]; N]> {
        self.body.rough.as_ref()
    }

    fn input(&self, [t]: &[f64; 1]) -> [f64; N] {
        self.drive.at(*t)
    }

    fn slope(
        &self,
        point: &States<N, 1>,
        torque: &[f64; N],
        dry: &mut Dry<N, 1>,
        slope: &mut States<N, 1>,
        lanes: &mut Lanes<1>,
    ) {
        let state = point.lane(0);
        let driving = self.body.driving(torque, &state, dry);
        match self.body.moved(&state, &driving, self.body.is_dry().then_some(dry)) {
            Ok(found) => *slope = States::alone(&found),
            Err(why) => lanes.fail(0, why),
        }
    }
}

/// Arm with springs in its joints.
pub(super) struct Elastic<'a, const N: usize> {
    pub(super) body: &'a LoadedArm<N>,
    pub(super) motors: &'a Motors<N>,
    pub(super) drive: &'a Drive<N>,
}

impl<const N: usize> Flow<BothSides<N>, N, 1> for Elastic<'_, N> {
    type Input = [f64; N];

    fn rough(&self) -> Option<&[[f64; 1]; N]> {
        self.body.rough.as_ref()
    }

    fn input(&self, [t]: &[f64; 1]) -> [f64; N] {
        self.drive.at(*t)
    }

    fn slope(
        &self,
        pair: &BothSides<N>,
        torque: &[f64; N],
        dry: &mut Dry<N, 1>,
        slope: &mut BothSides<N>,
        lanes: &mut Lanes<1>,
    ) {
        let (link, motor) = (pair.link.lane(0), pair.motor.lane(0));
        let driving = self.body.driving(torque, &motor, dry);
        let carried = self.motors.springs.torques(&motor, &link);
        match self.body.moved(&link, &carried, None) {
            Ok(link) => {
                // Rotors are coupled only through the links, so each is held or moves independently.
                dry.load = core::array::from_fn(|i| [driving[i] - carried[i]]);
                let qdd = core::array::from_fn(|i| dry.free[i][0] * dry.load[i][0] / self.motors.inertia[i]);
                let motor = State { q: motor.qd, qd: qdd };
                *slope = BothSides { link: States::alone(&link), motor: States::alone(&motor) };
            }
            Err(why) => lanes.fail(0, why),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::{LoadedArm, WORTH_A_KERNEL};
    use crate::plant::State;
    use crate::plant::dynamics::Arm;
    use dynamics_core::{JointKind, Wrench};
    use machine_code::Instructions;
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use proptest::test_runner::TestRunner;
    use robot_compiler::Robot;
    use std::path::Path;

    fn arm(name: &str) -> Arm<6> {
        let robot = Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(name)).unwrap();
        Arm {
            joints: core::array::from_fn(|i| robot.joints[i].spec),
            tool: robot.tool,
            payload: None,
            gravity: Vector3::new(0.0, 0.0, -9.81),
            tip_wrench: None,
        }
    }

    /// A body without a kernel, and the same body after so many solutions that it gets one.
    fn bodies(arm: &Arm<6>) -> [LoadedArm<6>; 2] {
        let body = LoadedArm::new(arm.mechanism(), None, None, [JointKind::Revolute; 6]);
        let often = body.clone();
        often.count(WORTH_A_KERNEL);
        [body, often]
    }

    fn wrench() -> Option<Wrench<f64>> {
        Some(Wrench { force: Vector3::new(3.0, -20.0, 11.0), moment: Vector3::new(0.4, 0.0, -1.5) })
    }

    #[test]
    fn an_arm_alone_has_the_same_accelerations_with_a_kernel() {
        let each = |most: f64| prop::array::uniform6(-most..most);
        for name in ["puma560.toml", "stanford.toml", "yam.toml"] {
            let mut arm = arm(name);
            for wrench in [None, wrench()] {
                arm.tip_wrench = wrench;
                let bodies = bodies(&arm);
                let drawn = TestRunner::default().run(&(each(3.0), each(2.0), each(80.0)), |(q, qd, torque)| {
                    let [computed, run] = bodies.each_ref().map(|body| body.moved(&State { q, qd }, &torque, None));
                    prop_assert_eq!(computed, run);
                    Ok(())
                });
                assert_eq!(drawn, Ok(()), "{name}");
            }
        }
    }

    #[test]
    fn a_kernel_is_made_when_it_is_worth_it_and_feels_a_push() {
        let [few, often] = bodies(&arm("puma560.toml"));
        let state = State { q: [0.3; 6], qd: [0.1; 6] };
        let mut pushed = [few.clone(), often.clone()];
        for body in &mut pushed {
            body.moved(&state, &[1.0; 6], None).unwrap();
            body.mechanism.push(wrench());
        }
        let [computed, run] = pushed.each_ref().map(|body| body.moved(&state, &[1.0; 6], None).unwrap());
        assert_eq!(computed, run);
        assert_ne!(computed, few.moved(&state, &[1.0; 6], None).unwrap());
        let [few, often] = pushed.map(|body| body.kernel.get().is_some_and(Option::is_some));
        assert_eq!((few, often), (false, Instructions::AvxOne.are_here()));
    }
}
