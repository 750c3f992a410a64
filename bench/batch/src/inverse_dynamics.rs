//! Inverse dynamics of many states: the loop over the states.

use crate::lanes::{Float, Lanes};
use crate::states::{LengthError, States, check};
use core::mem::take;
use dynamics_core::inertia::cast_vector;
use dynamics_core::{InverseDynamics, Live, Scalar, SinCos, Trig};
use num_traits::Zero as _;

/// Number of states with sines and cosines computed together: a few vectors of each joint, which stay in the L1 cache.
const BLOCK: usize = 64;

/// Smallest number of states for a separate core.
const GRAIN: usize = 16 * BLOCK;

/// Smallest number of states for which it pays off to find out which sines and cosines the dynamics reads.
const PROBED: usize = 4 * BLOCK;

/// Computes the joint torques of many states: `tau[joint][state]`, N m or N.
///
/// `tau = D(q) qdd + C(q, qd) qd + G(q) - J^T w`, state by state.
///
/// | name | quantity | unit |
/// |---|---|---|
/// | `dynamics` | the arm: `Dynamics` cast to lanes, or a kernel for every scalar | |
/// | `trig` | sine and cosine, called with single floats | |
/// | `states` | see [`States`] | |
/// | `live` | live inputs of the scene, the same for all states | |
/// | `tau` | output: one list per joint, with one element per state | N m, N |
///
/// Each state's torques have the same bits as if `dynamics` were run on single floats. One pass; no allocation.
///
/// # Errors
/// [`LengthError`] if a list of `tau` does not have one element for each state; nothing is written then.
pub fn inverse_dynamics_batch<F, D, T, const N: usize>(
    dynamics: &D,
    trig: &T,
    states: &States<'_, F, N>,
    live: &Live<F, N>,
    mut tau: [&mut [F]; N],
) -> Result<(), LengthError>
where
    F: Float,
    D: InverseDynamics<F::Lanes, N>,
    T: Trig<F>,
{
    check("tau", tau.each_ref().map(|list| list.len()), states.len())?;
    Batch::new(dynamics, trig, live, states.len()).run(states, &mut tau);
    Ok(())
}

/// As [`inverse_dynamics_batch`], with the states distributed to all cores. Gives the same bits.
///
/// # Errors
/// As [`inverse_dynamics_batch`].
pub fn inverse_dynamics_batch_parallel<F, D, T, const N: usize>(
    dynamics: &D,
    trig: &T,
    states: &States<'_, F, N>,
    live: &Live<F, N>,
    tau: [&mut [F]; N],
) -> Result<(), LengthError>
where
    F: Float,
    F::Lanes: Send + Sync,
    D: InverseDynamics<F::Lanes, N> + Sync,
    T: Trig<F> + Sync,
{
    check("tau", tau.each_ref().map(|list| list.len()), states.len())?;
    Batch::new(dynamics, trig, live, states.len()).share_out(states, tau);
    Ok(())
}

/// Data shared by all states.
struct Batch<'a, F: Float, D, T, const N: usize> {
    dynamics: &'a D,
    trig: &'a T,
    live: Live<F::Lanes, N>,
    /// True for each joint with a sine and cosine that the dynamics reads.
    read: [bool; N],
}

impl<'a, F, D, T, const N: usize> Batch<'a, F, D, T, N>
where
    F: Float,
    D: InverseDynamics<F::Lanes, N>,
    T: Trig<F>,
{
    /// Prepares the shared data for the torques of `count` states.
    fn new(dynamics: &'a D, trig: &'a T, live: &Live<F, N>, count: usize) -> Self {
        let live = in_every_lane(live);
        let read = if count < PROBED { [true; N] } else { turns_read(dynamics, &live) };
        Self { dynamics, trig, live, read }
    }

    fn run(&self, states: &States<'_, F, N>, tau: &mut [&mut [F]; N]) {
        let mut turn = [[[F::zero(); BLOCK]; 2]; N];
        let inputs = [&states.q, &states.qd, &states.qdd].map(|lists| lists.map(|list| list.as_chunks::<BLOCK>()));
        let mut tau = tau.each_mut().map(|list| list.as_chunks_mut::<BLOCK>());
        for at in 0..states.len() / BLOCK {
            let block = inputs.each_ref().map(|lists| lists.each_ref().map(|(blocks, _)| &blocks[at]));
            self.block(block, tau.each_mut().map(|(blocks, _)| &mut blocks[at]), &mut turn, BLOCK);
        }

        let count = states.len() % BLOCK;
        if count > 0 {
            let filled = inputs.each_ref().map(|lists| {
                lists.each_ref().map(|(_, rest)| {
                    let mut block = [F::zero(); BLOCK];
                    block[..count].copy_from_slice(rest);
                    block
                })
            });
            let mut found = [[F::zero(); BLOCK]; N];
            let block = filled.each_ref().map(|lists| lists.each_ref());
            self.block(block, found.each_mut(), &mut turn, count);
            for ((_, rest), found) in tau.iter_mut().zip(&found) {
                rest.copy_from_slice(&found[..count]);
            }
        }
    }

    /// Computes the torques of the first `count` states of a block. The compiler knows the lists' length, so one instruction loads or stores a
    /// vector, without a check.
    #[inline]
    fn block(
        &self,
        [q, qd, qdd]: [[&[F; BLOCK]; N]; 3],
        tau: [&mut [F; BLOCK]; N],
        turn: &mut [[[F; BLOCK]; 2]; N],
        count: usize,
    ) {
        for ((q, [sin, cos]), read) in q.iter().zip(turn.iter_mut()).zip(self.read) {
            if read {
                self.trig.sin_cos_lists(*q, sin, cos);
            }
        }
        // Plain loops: with `map`, arrays of vectors became calls that pass them through memory, which took a third of the time.
        let zero = F::Lanes::zero();
        for place in 0..count.min(BLOCK).div_ceil(F::Lanes::COUNT) {
            let (mut turns, mut inputs) = ([SinCos { sin: zero, cos: zero }; N], [[zero; N]; 3]);
            for i in 0..N {
                let [sin, cos] = &turn[i];
                turns[i] = SinCos { sin: Lanes::load(sin, place), cos: Lanes::load(cos, place) };
                inputs[0][i] = Lanes::load(q[i], place);
                inputs[1][i] = Lanes::load(qd[i], place);
                inputs[2][i] = Lanes::load(qdd[i], place);
            }
            let found = self.dynamics.inverse_dynamics(&turns, &inputs[0], &inputs[1], &inputs[2], &self.live);
            for i in 0..N {
                found[i].store(tau[i], place);
            }
        }
    }

    /// Divides the states between two cores, recursively down to [`GRAIN`].
    fn share_out(&self, states: &States<'_, F, N>, mut tau: [&mut [F]; N])
    where
        F::Lanes: Send + Sync,
        D: Sync,
        T: Sync,
    {
        if states.len() <= GRAIN {
            return self.run(states, &mut tau);
        }
        let middle = (states.len() / 2).next_multiple_of(BLOCK);
        let (first, second) = states.split(middle);
        let mut rest: [&mut [F]; N] = core::array::from_fn(|_| <&mut [F]>::default());
        for (list, rest) in tau.iter_mut().zip(&mut rest) {
            (*list, *rest) = take(list).split_at_mut(middle);
        }
        rayon::join(|| self.share_out(&first, tau), || self.share_out(&second, rest));
    }
}

/// Returns true for each joint with a sine and cosine that affect the torques. Kernels do not read those of a vertical first joint, of a last
/// joint about an axis of symmetry, and of prismatic joints. Computing a pair takes a sixth of the time of such a kernel.
///
/// There are only sums, differences and products, so every result that depends on a NaN is NaN. So each joint in turn is set to NaN.
#[expect(clippy::eq_op, reason = "a NaN is what differs from itself")]
fn turns_read<L: Lanes, const N: usize>(dynamics: &impl InverseDynamics<L, N>, live: &Live<L, N>) -> [bool; N] {
    let nan = L::literal(f64::NAN);
    let still = [L::zero(); N];
    core::array::from_fn(|joint| {
        let turn = core::array::from_fn(|i| {
            let x = if i == joint { nan } else { L::zero() };
            SinCos { sin: x, cos: x }
        });
        let tau = dynamics.inverse_dynamics(&turn, &still, &still, &still, live);
        tau.iter().any(|tau| tau != tau)
    })
}

fn in_every_lane<F: Float, const N: usize>(live: &Live<F, N>) -> Live<F::Lanes, N> {
    Live {
        gravity: cast_vector(&live.gravity),
        payload: live.payload.cast(),
        tip_wrench: live.tip_wrench.cast(),
        rotor: live.rotor.map(|x| F::Lanes::literal(x.into())),
    }
}

#[cfg(test)]
mod tests {
    use super::turns_read;
    use crate::F64Lanes;
    use dynamics_core::{Dynamics, Live};
    use robot_compiler::SceneFile;
    use std::path::Path;

    #[test]
    fn the_turn_of_a_prismatic_joint_alone_is_not_read() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let read = |scene: &str| {
            let file = SceneFile::load(&folder.join(scene)).ok()?;
            let model = file.robot.model::<6>().ok()?;
            let dynamics = Dynamics::<F64Lanes, 6>::new(model.cast(), file.scene(&model).cast());
            Some(turns_read(&dynamics, &Live::zero()))
        };
        assert_eq!(read("stanford_reach.toml"), Some([true, true, false, true, true, true]));
        assert_eq!(read("puma560_pick.toml"), Some([true; 6]));
    }
}
