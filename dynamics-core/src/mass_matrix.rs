//! The joint-space inertia matrix, by composite rigid bodies.

use crate::geometry::apply;
use crate::inertia::{Inertia, Wrench};
use crate::joint::JointKind;
use crate::model::Link;
use crate::newton_euler::{out_of_link, to_parent};
use crate::scalar::Scalar;
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Joint-space inertia matrix, with what the scene holds and the rotors that it counts.
///
/// `D_ij = s_i . (wrench at joint i when joint j alone accelerates the composite body beyond it)`: column `j` of the
/// torques `D(q) qdd` of eq. 12.215. Equal to eq. 12.219 without its factor 1/2 on the rotational part.
///
/// | name | quantity | unit | shape |
/// |---|---|---|---|
/// | `turn`, `q`, `live` | as [`crate::InverseDynamics::inverse_dynamics`] | | N |
/// | return | inertia matrix, symmetric | kg m^2, kg m, kg | N x N |
///
/// O(N^2); no branch on data, no division.
pub fn mass_matrix<S: Scalar, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    live: &Live<S, N>,
) -> SMatrix<S, N, N> {
    let links = dynamics.model().links();
    let mut matrix = SMatrix::<S, N, N>::zeros();
    let mut composite = Inertia::zero();
    for j in (0..N).rev() {
        composite = if j + 1 < N {
            dynamics.inertia(j, live) + inertia_in_parent(&links[j + 1], turn[j + 1], q[j + 1], &composite)
        } else {
            dynamics.inertia(j, live)
        };
        let mut wrench = unit_acceleration(links[j].kind, &composite);
        for i in (0..=j).rev() {
            let along = match links[i].kind {
                JointKind::Revolute => wrench.moment.z,
                JointKind::Prismatic => wrench.force.z,
            };
            matrix[(i, j)] = along;
            matrix[(j, i)] = along;
            if i > 0 {
                wrench = to_parent(&links[i], turn[i], q[i], &wrench);
            }
        }
    }
    if let Some(rotor) = dynamics.scene().rotor.value(&live.rotor) {
        for i in 0..N {
            matrix[(i, i)] += rotor[i];
        }
    }
    matrix
}

/// Wrench about the joint's origin that accelerates a body by one unit along the joint.
fn unit_acceleration<S: Scalar>(kind: JointKind, body: &Inertia<S>) -> Wrench<S> {
    let h = &body.first_moment;
    let j = &body.about_origin;
    match kind {
        JointKind::Revolute => {
            Wrench { force: Vector3::new(-h.y, h.x, S::zero()), moment: Vector3::new(j.m13, j.m23, j.m33) }
        }
        JointKind::Prismatic => {
            Wrench { force: Vector3::new(S::zero(), S::zero(), body.mass), moment: Vector3::new(h.y, -h.x, S::zero()) }
        }
    }
}

fn inertia_in_parent<S: Scalar>(link: &Link<S>, turn: SinCos<S>, q: S, body: &Inertia<S>) -> Inertia<S> {
    let (rotation, translation) = link_placement(link, turn, q);
    body.in_parent(&rotation, &translation)
}

/// `parent_from_link` at a joint position: rotation and origin.
pub(crate) fn link_placement<S: Scalar>(link: &Link<S>, turn: SinCos<S>, q: S) -> (Matrix3<S>, Vector3<S>) {
    let (zero, one) = (S::zero(), S::one());
    let column = |x, y, z| out_of_link(link, turn, &Vector3::new(x, y, z));
    let rotation = Matrix3::from_columns(&[column(one, zero, zero), column(zero, one, zero), column(zero, zero, one)]);
    let translation = match link.kind {
        JointKind::Revolute => link.translation,
        JointKind::Prismatic => link.translation + apply(&link.rotation, &Vector3::new(zero, zero, q)),
    };
    (rotation, translation)
}
