//! The regressor: the matrix that maps inertial parameters to joint torques.

use crate::inertia::{Inertia, Wrench};
use crate::joint::JointKind;
use crate::newton_euler::{JointMotion, LinkMotion, to_parent};
use crate::scalar::Scalar;
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::{Matrix3, Vector3};

/// Number of inertial parameters of a link: mass, three of the first moment, and six entries of the tensor.
pub const PARAMETERS: usize = 10;

/// Names of the parameters of a link, in their order: `m`, `h = m c`, and the tensor about the link's origin.
pub const PARAMETER_NAMES: [&str; PARAMETERS] = ["m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];

/// The columns of every link's parameters, `[joint][link][parameter]`; those of a link before the joint are zero.
pub type Columns<S, const N: usize> = [[[S; PARAMETERS]; N]; N];

/// Derivatives of the joint torques by the inertial parameters of every link, in which they are linear.
///
/// `tau = Y(q, qd, qdd) pi`, with `pi_l = (m, h_x, h_y, h_z, I_xx, I_xy, I_xz, I_yy, I_yz, I_zz)` of link `l`. Column `k` of link `l`
/// is the torque of a body with parameter `k` alone: `n_i = s_i . (wrench of that body about the origin of joint i)`
/// (chapter 12, eq. 12.157-12.162 with unit parameters).
///
/// | name | quantity | unit | shape | frame |
/// |---|---|---|---|---|
/// | `dynamics` | geometry, gravity and velocity terms; its bodies, payload, rotors and tip wrench are not read | | | |
/// | `turn`, `q`, `qd`, `qdd`, `live` | as [`crate::InverseDynamics::inverse_dynamics`] | | N | |
/// | return | torque per parameter | N m (N) per kg, kg m, kg m^2 | N x N x 10 | parameters in the link's own, about its origin |
///
/// O(N^2); no branch on data, no division. The column of a rotor is `qdd` of its own joint, and is not included.
pub fn inverse_dynamics_regressor<S: Scalar, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    qdd: &[S; N],
    live: &Live<S, N>,
) -> Columns<S, N> {
    let links = dynamics.model().links();
    let scene = dynamics.scene();
    let velocity = scene.coriolis.value(qd);
    let mut columns = [[[S::zero(); PARAMETERS]; N]; N];
    let mut motion = LinkMotion::new(None, None, scene.gravity.value(&live.gravity).map(|g| -g));
    for l in 0..N {
        let joint = JointMotion { turn: turn[l], q: q[l], qd: velocity.map(|v| v[l]), qdd: qdd[l] };
        motion = motion.next(&links[l], &joint);
        let mut wrenches: [Wrench<S>; PARAMETERS] = core::array::from_fn(|k| motion.wrench_of(&unit(k)));
        for i in (0..=l).rev() {
            for (column, wrench) in columns[i][l].iter_mut().zip(&mut wrenches) {
                *column = match links[i].kind {
                    JointKind::Revolute => wrench.moment.z,
                    JointKind::Prismatic => wrench.force.z,
                };
                if i > 0 {
                    *wrench = to_parent(&links[i], turn[i], q[i], wrench);
                }
            }
        }
    }
    columns
}

impl<S: Scalar> Inertia<S> {
    /// The ten numbers, in the order of [`PARAMETER_NAMES`].
    #[must_use]
    pub fn parameters(&self) -> [S; PARAMETERS] {
        let (h, j) = (&self.first_moment, &self.about_origin);
        [self.mass, h.x, h.y, h.z, j.m11, j.m12, j.m13, j.m22, j.m23, j.m33]
    }

    /// The body with these ten numbers: undoes [`Inertia::parameters`].
    #[must_use]
    pub fn from_parameters(parameters: &[S; PARAMETERS]) -> Self {
        let [mass, hx, hy, hz, xx, xy, xz, yy, yz, zz] = *parameters;
        let about_origin = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Self { mass, first_moment: Vector3::new(hx, hy, hz), about_origin }
    }
}

/// One parameter equal to one, the others zero. No body has these, but the torques are linear in them.
fn unit<S: Scalar>(parameter: usize) -> Inertia<S> {
    Inertia::from_parameters(&core::array::from_fn(|k| if k == parameter { S::one() } else { S::zero() }))
}
