//! The joint-space inertia matrix, by composite rigid bodies.

use crate::geometry::{apply, compose};
use crate::inertia::{Inertia, Wrench};
use crate::joint::JointKind;
use crate::model::Link;
use crate::newton_euler::{out_of_link, to_parent};
use crate::scalar::Scalar;
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Joint-space inertia matrix, with the scene's payload and the rotors that it counts.
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

/// A link's inertia about the parent's origin and in its axes. As [`Inertia::in_parent`], in fewer operations: a turn about z
/// takes 8 multiplications for the tensor and 4 for the first moment, and one triangle of the tensor is computed.
fn inertia_in_parent<S: Scalar>(link: &Link<S>, turn: SinCos<S>, q: S, body: &Inertia<S>) -> Inertia<S> {
    let mass = body.mass;
    let (h, j) = match link.kind {
        JointKind::Revolute => (body.first_moment, body.about_origin),
        JointKind::Prismatic => slid(q, body),
    };
    let (h, j, p) = (out_of_link(link, turn, &h), tensor_out_of_link(link, turn, &j), link.translation);
    // With h' = h + m p: J + (p.(h + h')) 1 - p h^T - h' p^T is J + 2 (p.h) 1 - p h^T - h p^T + m (p.p 1 - p p^T).
    let moved = h + p * mass;
    let (xx, yy, zz) = (p.x * (h.x + moved.x), p.y * (h.y + moved.y), p.z * (h.z + moved.z));
    let about_origin = symmetric(
        j.m11 + (yy + zz),
        j.m12 - (p.x * h.y + moved.x * p.y),
        j.m13 - (p.x * h.z + moved.x * p.z),
        j.m22 + (xx + zz),
        j.m23 - (p.y * h.z + moved.y * p.z),
        j.m33 + (xx + yy),
    );
    Inertia { mass, first_moment: moved, about_origin }
}

/// First moment and tensor about a point that lies `-q` along z.
fn slid<S: Scalar>(q: S, body: &Inertia<S>) -> (Vector3<S>, Matrix3<S>) {
    let (h, j) = (&body.first_moment, &body.about_origin);
    let z = h.z + body.mass * q;
    let across = q * (h.z + z);
    let tensor = symmetric(j.m11 + across, j.m12, j.m13 - q * h.x, j.m22 + across, j.m23 - q * h.y, j.m33);
    (Vector3::new(h.x, h.y, z), tensor)
}

/// A symmetric tensor of this link's frame in the parent's frame: `R Rz(q) J Rz(q)^T R^T`; the upper triangle is read.
fn tensor_out_of_link<S: Scalar>(link: &Link<S>, turn: SinCos<S>, j: &Matrix3<S>) -> Matrix3<S> {
    let j = match link.kind {
        // With u = s (Jxx - Jyy) + 2 c Jxy the turned entries are Jxx - s u, Jyy + s u and c u - Jxy.
        JointKind::Revolute => {
            let SinCos { sin, cos } = turn;
            let u = sin * (j.m11 - j.m22) + cos * (j.m12 + j.m12);
            let change = sin * u;
            symmetric(
                j.m11 - change,
                cos * u - j.m12,
                cos * j.m13 - sin * j.m23,
                j.m22 + change,
                cos * j.m23 + sin * j.m13,
                j.m33,
            )
        }
        JointKind::Prismatic => symmetric(j.m11, j.m12, j.m13, j.m22, j.m23, j.m33),
    };
    let r = &link.rotation;
    let half = compose(r, &j);
    let entry = |i: usize, k: usize| half[(i, 0)] * r[(k, 0)] + half[(i, 1)] * r[(k, 1)] + half[(i, 2)] * r[(k, 2)];
    symmetric(entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2))
}

/// From the upper triangle, row by row.
fn symmetric<S: Scalar>(xx: S, xy: S, xz: S, yy: S, yz: S, zz: S) -> Matrix3<S> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
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
