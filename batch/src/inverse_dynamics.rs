//! The loop over many states.

use crate::lanes::{Float, Lanes};
use crate::states::{LengthError, States, check};
use core::mem::take;
use dynamics_core::inertia::cast_vector;
use dynamics_core::{InverseDynamics, Live, Scalar, SinCos, Trig};

/// States whose sines and cosines are computed together: a few vectors of each joint, which stay in the nearest cache.
const BLOCK: usize = 64;

/// Fewest states that are worth a core's attention.
const GRAIN: usize = 16 * BLOCK;

/// Joint torques of many states: `tau[joint][state]`, N m or N.
///
/// `tau = D(q) qdd + C(q, qd) qd + G(q) - J^T w`, state by state.
///
/// | name | quantity | unit |
/// |---|---|---|
/// | `dynamics` | the arm: `Dynamics` cast to lanes, or a kernel that is written for every scalar | |
/// | `trig` | sine and cosine, called with single floats | |
/// | `states` | see [`States`] | |
/// | `live` | live inputs of the scene, the same for all states | |
/// | `tau` | as many as there are states, any number | N m, N |
///
/// Each state's bits are those of `dynamics` on the float alone. One pass; no allocation.
///
/// # Errors
/// [`LengthError`] where `tau` has not one place for each state; nothing is written then.
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
    Batch::<F, D, T, N> { dynamics, trig, live: in_every_lane(live) }.run(states, &mut tau);
    Ok(())
}

/// As [`inverse_dynamics_batch`], with the states shared out among all cores. The same bits.
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
    Batch::<F, D, T, N> { dynamics, trig, live: in_every_lane(live) }.share_out(states, tau);
    Ok(())
}

/// What is the same for all states.
struct Batch<'a, F: Float, D, T, const N: usize> {
    dynamics: &'a D,
    trig: &'a T,
    live: Live<F::Lanes, N>,
}

impl<F, D, T, const N: usize> Batch<'_, F, D, T, N>
where
    F: Float,
    D: InverseDynamics<F::Lanes, N>,
    T: Trig<F>,
{
    fn run(&self, states: &States<'_, F, N>, tau: &mut [&mut [F]; N]) {
        let (mut sin, mut cos) = ([[F::zero(); BLOCK]; N], [[F::zero(); BLOCK]; N]);
        for start in (0..states.len()).step_by(BLOCK) {
            let count = BLOCK.min(states.len() - start);
            for (i, q) in states.q.iter().enumerate() {
                self.trig.sin_cos_lists(&q[start..start + count], &mut sin[i], &mut cos[i]);
            }
            for offset in (0..count).step_by(F::Lanes::COUNT) {
                let at = start + offset;
                let load = |lists: &[&[F]; N]| -> [F::Lanes; N] { lists.map(|list| Lanes::load(list, at)) };
                let turn = core::array::from_fn(|i| SinCos {
                    sin: Lanes::load(&sin[i], offset),
                    cos: Lanes::load(&cos[i], offset),
                });
                let (q, qd, qdd) = (load(&states.q), load(&states.qd), load(&states.qdd));
                let found = self.dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &self.live);
                for (found, list) in found.into_iter().zip(tau.iter_mut()) {
                    found.store(list, at);
                }
            }
        }
    }

    /// Halves of the states on two cores, down to the grain.
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

fn in_every_lane<F: Float, const N: usize>(live: &Live<F, N>) -> Live<F::Lanes, N> {
    Live {
        gravity: cast_vector(&live.gravity),
        payload: live.payload.cast(),
        tip_wrench: live.tip_wrench.cast(),
        rotor: live.rotor.map(|x| F::Lanes::literal(x.into())),
    }
}
