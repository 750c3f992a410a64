//! Newton's and Euler's equation of every link in the base frame, as the book writes them before anything is eliminated.
//!
//! For link `i` with mass centre `C_i`, `n_i` and `m_i` from there to its two ends ([`Posture::inner_arm`],
//! [`Posture::outer_arm`]), `(F_{i-1}, M_{i-1})` the wrench of the link before on it and `(F_i, M_i)` its own wrench on
//! the next, each about the origin of that joint:
//!
//! ```text
//! F_{i-1} - F_i + F_e = m a                                                          12.1, 12.5
//! M_{i-1} - M_i + M_e + n x F_{i-1} - m x F_i = I alpha + omega x (I omega)          12.2, 12.6 with the gyroscopic term
//! ```
//!
//! `I` is about `C_i` in base axes, and so is the moment `M_e` of the external loads: weight adds a force to `F_e` and
//! nothing to `M_e`. The chapter prints `I alpha` alone, which is right in a plane only, and gives weight a moment
//! about the base (12.4). The wrench at the tip is given, `(F_n, M_n) = -w`; that leaves 6 N equations in the 6 N
//! components of the joint wrenches, which [`Assembled`] solves as a general linear system, without use of the chain's
//! structure.
//!
//! | quantity | unit | frame |
//! |---|---|---|
//! | joint wrench `[i]`: on link `i` (counted from 0) by the link or base before it, about `links[i].origin` | N, N m | base axes |
//! | external load `[i]`: on link `i`, about its mass centre | N, N m | base axes |
//! | tip wrench: of the environment on the arm, about the tip's origin | N, N m | base axes |

use crate::chapter::posture::{BaseFrameMotion, LinkPosture, Posture};
use crate::dynamics::solve::solve_rows;
use crate::geometry::apply;
use crate::inertia::Wrench;
use crate::scalar::{Real, Scalar};
use nalgebra::Vector3;

/// Rate of change of a link's momentum and, about its mass centre, of its angular momentum, N and N m.
///
/// `m a` and `I alpha + omega x (I omega)` (eq. 12.169-12.170).
#[must_use]
pub fn momentum_rate<S: Scalar>(link: &LinkPosture<S>, motion: &BaseFrameMotion<S>) -> Wrench<S> {
    let turning = apply(&link.inertia, &motion.omega);
    Wrench {
        force: motion.acceleration * link.mass,
        moment: apply(&link.inertia, &motion.alpha) + motion.omega.cross(&turning),
    }
}

/// Weight of every link about its mass centre: `m g` and no moment (eq. 12.3; 12.4 corrected).
///
/// `gravity` is the acceleration in the base frame, m/s^2.
#[must_use]
pub fn weights<S: Scalar, const N: usize>(posture: &Posture<S, N>, gravity: &Vector3<S>) -> [Wrench<S>; N] {
    posture.links.map(|link| Wrench { force: gravity * link.mass, moment: Vector3::zeros() })
}

/// Residuals of every link's two equations, left side less right side, N and N m; zero for the wrenches that belong to
/// the motion.
///
/// | name | quantity |
/// |---|---|
/// | `motion` | [`Posture::motion`]; all zero for an arm at rest (12.458-12.459) |
/// | `joint` | joint wrenches |
/// | `external` | loads on the links, weight among them |
/// | `tip` | tip wrench |
///
/// O(N).
#[must_use]
pub fn residuals<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    motion: &[BaseFrameMotion<S>; N],
    joint: &[Wrench<S>; N],
    external: &[Wrench<S>; N],
    tip: &Wrench<S>,
) -> [Wrench<S>; N] {
    core::array::from_fn(|i| {
        let (inner, outer) = (joint[i], joint.get(i + 1).map_or_else(|| Wrench::zero() - *tip, |next| *next));
        let rate = momentum_rate(&posture.links[i], &motion[i]);
        let arms = posture.inner_arm(i).cross(&inner.force) - posture.outer_arm(i).cross(&outer.force);
        let missed = inner - outer + external[i] - rate;
        Wrench { moment: missed.moment + arms, ..missed }
    })
}

/// All equations of an open chain as one system, `[A] x = b` (eq. 12.44, 12.74): the unknowns are all forces and
/// moments of the joints.
///
/// Eq. 12.75-12.76 for a chain of any length in space. The chapter's third and sixth row, the moments, have the signs of `n` and
/// `m` turned over: `n x F` about z is `n_x F_y - n_y F_x`.
///
/// The determinant is one: the unknowns can be found one link after another, as the recursions do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assembled<S, const N: usize> {
    /// `[A]`: `matrix[i][r][j][c]` multiplies component `c` of joint `j`'s wrench in equation `r` of link `i`; components and
    /// equations are force x, y, z, moment x, y, z. Entries are 0, 1 or a length in m.
    pub matrix: [[[[S; 6]; N]; 6]; N],
    /// `b`, N and N m: rates of momentum less the loads that are known.
    pub right: [[S; 6]; N],
}

impl<S: Scalar, const N: usize> Assembled<S, N> {
    /// The system of an arm in motion; inputs as [`residuals`].
    #[must_use]
    pub fn new(
        posture: &Posture<S, N>,
        motion: &[BaseFrameMotion<S>; N],
        external: &[Wrench<S>; N],
        tip: &Wrench<S>,
    ) -> Self {
        let mut matrix = [[[[S::zero(); 6]; N]; 6]; N];
        for i in 0..N {
            let (inner, outer) = (cross_matrix(&posture.inner_arm(i)), cross_matrix(&posture.outer_arm(i)));
            for r in 0..3 {
                matrix[i][r][i][r] = S::one();
                matrix[i][r + 3][i][r + 3] = S::one();
                matrix[i][r + 3][i][..3].copy_from_slice(&inner[r]);
                if i + 1 < N {
                    matrix[i][r][i + 1][r] = -S::one();
                    matrix[i][r + 3][i + 1][r + 3] = -S::one();
                    matrix[i][r + 3][i + 1][..3].copy_from_slice(&outer[r].map(|x| -x));
                }
            }
        }
        // The joint wrenches have to make up for the residuals without them.
        let missed = residuals(posture, motion, &[Wrench::zero(); N], external, tip);
        let right = missed.map(|Wrench { force: f, moment: m }| [-f.x, -f.y, -f.z, -m.x, -m.y, -m.z]);
        Self { matrix, right }
    }
}

impl<S: Real, const N: usize> Assembled<S, N> {
    /// The joint wrenches, by elimination with row exchanges. `None` if a number is not finite, or if a lever arm is so long (over
    /// 200 km in single precision) that the unit entries vanish compared with it.
    ///
    /// O(N^3): (6 N)^3 / 3 multiplications. [`crate::newton_euler::joint_wrenches`] is O(N).
    #[must_use]
    pub fn solve(&self) -> Option<[Wrench<S>; N]> {
        let (mut a, mut x) = (self.matrix, self.right);
        let rows = a.as_flattened_mut().as_flattened_mut().as_flattened_mut();
        let split =
            |x: [S; 6]| Wrench { force: Vector3::new(x[0], x[1], x[2]), moment: Vector3::new(x[3], x[4], x[5]) };
        solve_rows(rows, x.as_flattened_mut()).then(|| x.map(split))
    }
}

/// `[v]x`, rows.
fn cross_matrix<S: Scalar>(v: &Vector3<S>) -> [[S; 3]; 3] {
    let zero = S::zero();
    [[zero, -v.z, v.y], [v.z, zero, -v.x], [-v.y, v.x, zero]]
}
