//! Level `regrouped`: inertia that a joint cannot feel moves into its parent.
//!
//! A link's ten inertial parameters act on the joints before it only in combinations. Some inertia the link's own joint
//! cannot distinguish from a body fixed to the parent, at any joint position. It may be moved to the parent (the base inertial
//! parameters of Gautier and Khalil, *Direct calculation of minimum set of inertial parameters*, 1990):
//!
//! - a revolute joint: the mass and the first moment along the axis (points on the axis do not move), and an inertia
//!   `diag(t, t, 0)`, which a turn about z leaves unchanged, for any `t`. With `t = Iyy` the link keeps `Ixx - Iyy`,
//!   `Izz`, the products of inertia and the first moments across the axis. A search finds the `t` that saves most
//!   ([`Across`]).
//! - a prismatic joint: the whole inertia about the origin, together with the first moment that gives its position. A slide
//!   changes the inertia about the parent's origin through mass and first moment alone.
//!
//! No joint feels inertia that reaches the base. The torques stay the same in exact arithmetic; rounding changes.

use dynamics_core::model::{Link, Model};
use dynamics_core::{Inertia, JointKind};
use nalgebra::{Matrix3, Vector3};

/// The moment of inertia across a revolute axis that a link passes to its parent. Each variant names the moment that then vanishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Across {
    /// `Iyy = 0`
    Iyy,
    /// `Ixx = 0`
    Ixx,
    /// `Iyy = Izz`: of the terms about x, only the one in the acceleration remains.
    IyyToIzz,
    /// `Ixx = Izz`: of the terms about y, only the one in the acceleration remains.
    IxxToIzz,
}

impl Across {
    /// All of them.
    pub(super) const ALL: [Self; 4] = [Self::Iyy, Self::Ixx, Self::IyyToIzz, Self::IxxToIzz];

    /// `t`, the moment that is passed to the parent, kg m^2.
    fn given_away(self, inertia: &Matrix3<f64>) -> f64 {
        match self {
            Self::Iyy => inertia.m22,
            Self::Ixx => inertia.m11,
            Self::IyyToIzz => inertia.m22 - inertia.m33,
            Self::IxxToIzz => inertia.m11 - inertia.m33,
        }
    }
}

/// Function that returns the part of a link's inertia that its own joint cannot distinguish from the parent's.
pub(super) type Unfelt = fn(&Link<f64>, Across) -> Inertia<f64>;

/// The same arm with base inertial parameters: equal torques, more zeros. The wrenches at the joints are *not* the same.
#[must_use]
pub(super) fn moved_inward<const N: usize>(
    model: &Model<f64, N>,
    across: &[Across; N],
    unfelt: Unfelt,
) -> Model<f64, N> {
    let mut links = *model.links();
    let mut sizes = links.map(|link| Sizes::of(&link.inertia));
    for i in (0..N).rev() {
        let unfelt = unfelt(&links[i], across[i]);
        let own = &mut links[i].inertia;
        own.mass -= unfelt.mass;
        own.first_moment -= unfelt.first_moment;
        own.about_origin -= unfelt.about_origin;
        if i > 0 {
            let (rotation, translation) = (links[i].rotation, links[i].translation);
            links[i - 1].inertia = links[i - 1].inertia + unfelt.in_parent(&rotation, &translation);
            sizes[i - 1] = sizes[i - 1].max(Sizes::of(&unfelt).at(translation.norm(), unfelt.mass));
        }
    }
    for (link, size) in links.iter_mut().zip(sizes) {
        // The two moments are equal only up to rounding; later passes see the equality only if the bits agree.
        let j = &mut link.inertia.about_origin;
        (j.m11, j.m22) = (equal_if_near(j.m11, j.m33, size.second), equal_if_near(j.m22, j.m33, size.second));
        link.inertia.about_origin = link.inertia.about_origin.map(|x| without_dust(x, size.second));
        link.inertia.first_moment = link.inertia.first_moment.map(|x| without_dust(x, size.first));
    }
    Model::from_checked(links, *model.tip())
}

/// The part of a link's inertia that its own joint cannot distinguish from the parent's, at any joint position.
pub(super) fn unfelt(link: &Link<f64>, across: Across) -> Inertia<f64> {
    let Inertia { mass, first_moment, about_origin } = link.inertia;
    match link.kind {
        JointKind::Revolute => {
            let across = across.given_away(&about_origin);
            Inertia {
                mass,
                first_moment: Vector3::new(0.0, 0.0, first_moment.z),
                about_origin: Matrix3::from_diagonal(&Vector3::new(across, across, 0.0)),
            }
        }
        JointKind::Prismatic => Inertia { mass: 0.0, first_moment: Vector3::zeros(), about_origin },
    }
}

/// Magnitudes of the numbers summed to a link's inertia. They show how much of the sum is rounding error.
///
/// Each link has its own, so that a gripper's moments are not mistaken for rounding errors because the base is heavy.
#[derive(Clone, Copy)]
struct Sizes {
    /// Magnitude of the first moments, kg m.
    first: f64,
    /// Magnitude of the second moments, kg m^2.
    second: f64,
}

impl Sizes {
    fn of(body: &Inertia<f64>) -> Self {
        Self { first: body.first_moment.amax(), second: body.about_origin.amax() }
    }

    /// Magnitudes about a point at a distance, by the parallel-axis rule without its signs.
    fn at(self, distance: f64, mass: f64) -> Self {
        let first = self.first + mass.abs() * distance;
        Self { first, second: self.second + 2.0 * self.first * distance + mass.abs() * distance * distance }
    }

    fn max(self, other: Self) -> Self {
        Self { first: self.first.max(other.first), second: self.second.max(other.second) }
    }
}

fn equal_if_near(x: f64, to: f64, size: f64) -> f64 {
    if without_dust(x - to, size) == 0.0 { to } else { x }
}

/// Returns zero if `x` is only the rounding error of a sum that cancels; a zero there saves operations.
pub(super) fn without_dust(x: f64, size: f64) -> f64 {
    const DUST: f64 = 16.0 * f64::EPSILON;
    if x.abs() <= DUST * size { 0.0 } else { x }
}
