//! Checks for descriptions that no arm can have, and their errors.

use crate::joint::{Body, Frame, JointSpec, Limits, Rotor, Tool};
use core::fmt;
use nalgebra::{Matrix3, Vector3};

/// Part of a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A joint or the link that moves with it, counted from 0.
    Joint(usize),
    /// The tool.
    Tool,
}

/// A description that was rejected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelError {
    /// The part at fault.
    pub place: Place,
    /// The reason.
    pub what: Impossible,
}

/// Reason why a description is impossible. The numbers are the values found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Impossible {
    /// A number is NaN or infinite; the name of the quantity.
    NotFinite(&'static str),
    /// A mass below zero, kg.
    NegativeMass(f64),
    /// An inertia tensor on a link without mass, kg.
    InertiaWithoutMass(f64),
    /// An inertia tensor that is not symmetric: the largest difference across the diagonal, kg m^2.
    AsymmetricInertia(f64),
    /// An inertia tensor with a negative principal moment: the smallest, kg m^2.
    NegativePrincipalMoment(f64),
    /// Principal moments `a <= b <= c` with `a + b < c`, kg m^2.
    TriangleInequality([f64; 3]),
    /// A joint axis that is not of unit length: its length.
    NonUnitAxis(f64),
    /// A rotation matrix that is not orthonormal and right-handed: its largest error.
    NotARotation(f64),
    /// The lower position limit is not below the upper: both.
    PositionLimitsReversed(f64, f64),
    /// A limit that must be above zero: its name and value.
    LimitNotPositive(&'static str, f64),
    /// A rotor inertia below zero, kg m^2.
    NegativeRotorInertia(f64),
}

impl fmt::Display for Impossible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(name) => write!(f, "{name} is not a finite number"),
            Self::NegativeMass(m) => write!(f, "mass {m} kg is negative"),
            Self::InertiaWithoutMass(m) => write!(f, "an inertia tensor is given, but the mass is {m} kg"),
            Self::AsymmetricInertia(d) => {
                write!(f, "the inertia tensor is not symmetric: entries differ by {d} kg m^2")
            }
            Self::NegativePrincipalMoment(p) => {
                write!(f, "the inertia tensor is not positive semidefinite: a principal moment is {p} kg m^2")
            }
            Self::TriangleInequality([a, b, c]) => {
                write!(f, "the inertia tensor breaks the triangle inequality: principal moments {a} + {b} < {c} kg m^2")
            }
            Self::NonUnitAxis(n) => write!(f, "the joint axis has length {n}, not 1"),
            Self::NotARotation(d) => write!(f, "the rotation matrix is off orthonormal by {d}"),
            Self::PositionLimitsReversed(lo, hi) => {
                write!(f, "the lower position limit {lo} is not below the upper {hi}")
            }
            Self::LimitNotPositive(name, x) => write!(f, "the {name} limit {x} is not above zero"),
            Self::NegativeRotorInertia(x) => write!(f, "the rotor inertia {x} kg m^2 is negative"),
        }
    }
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::Joint(i) => write!(f, "joint {}: {}", i + 1, self.what),
            Place::Tool => write!(f, "tool: {}", self.what),
        }
    }
}

impl core::error::Error for ModelError {}

/// Tolerance for published axes, rotations and symmetric tensors: six printed digits.
const PRINTED: f64 = 1e-6;

pub(super) fn joint(joint: &JointSpec, physical: bool) -> Result<(), Impossible> {
    frame(&joint.frame)?;
    body(&joint.body, physical)?;
    rotor(&joint.rotor)?;
    limits(&joint.limits)
}

pub(super) fn tool(tool: &Tool, physical: bool) -> Result<(), Impossible> {
    finite("tool placement", tool.translation.as_slice())?;
    rotation(&tool.rotation)?;
    body(&tool.body, physical)
}

fn finite(name: &'static str, numbers: &[f64]) -> Result<(), Impossible> {
    if numbers.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Impossible::NotFinite(name)) }
}

fn frame(frame: &Frame) -> Result<(), Impossible> {
    match frame {
        Frame::ClassicalDh(dh) | Frame::ModifiedDh(dh) => finite("DH row", &[dh.a, dh.alpha, dh.d, dh.theta]),
        Frame::Placement { rotation: r, translation, axis } => {
            finite("placement", translation.as_slice())?;
            finite("axis", axis.as_slice())?;
            let length = libm::sqrt(axis.dot(axis));
            if (length - 1.0).abs() > PRINTED {
                return Err(Impossible::NonUnitAxis(length));
            }
            rotation(r)
        }
    }
}

fn rotation(r: &Matrix3<f64>) -> Result<(), Impossible> {
    finite("rotation", r.as_slice())?;
    let off = (r.transpose() * r - Matrix3::identity()).amax().max((determinant(r) - 1.0).abs());
    if off > PRINTED { Err(Impossible::NotARotation(off)) } else { Ok(()) }
}

fn determinant(m: &Matrix3<f64>) -> f64 {
    let column = |k: usize| Vector3::from(m.column(k));
    column(0).cross(&column(1)).dot(&column(2))
}

fn body(body: &Body, physical: bool) -> Result<(), Impossible> {
    finite("mass", &[body.mass])?;
    finite("centre of mass", body.com.as_slice())?;
    finite("inertia tensor", body.inertia.as_slice())?;
    let size = body.inertia.amax();
    let asymmetry = (body.inertia - body.inertia.transpose()).amax();
    if asymmetry > PRINTED * size {
        return Err(Impossible::AsymmetricInertia(asymmetry));
    }
    // Never accepted: no identified parameter set with a negative mass should be used by a controller.
    if body.mass < 0.0 {
        return Err(Impossible::NegativeMass(body.mass));
    }
    if !physical {
        return Ok(());
    }
    if body.mass == 0.0 && size > 0.0 {
        return Err(Impossible::InertiaWithoutMass(body.mass));
    }
    let [a, b, c] = principal_moments(&body.inertia);
    let slack = PRINTED * c.abs();
    if a < -slack {
        return Err(Impossible::NegativePrincipalMoment(a));
    }
    if a + b < c - slack {
        return Err(Impossible::TriangleInequality([a, b, c]));
    }
    Ok(())
}

/// Eigenvalues of a symmetric matrix, smallest first, by Jacobi's rotations.
///
/// Six sweeps bring a 3 x 3 matrix to machine precision (convergence is quadratic); the count is fixed so that the loop is bounded.
fn principal_moments(inertia: &Matrix3<f64>) -> [f64; 3] {
    let mut m = (inertia + inertia.transpose()) * 0.5;
    for _sweep in 0..6 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[(p, q)] == 0.0 {
                continue;
            }
            let ratio = (m[(q, q)] - m[(p, p)]) / (2.0 * m[(p, q)]);
            let t = libm::copysign(1.0, ratio) / (ratio.abs() + libm::sqrt(ratio * ratio + 1.0));
            let c = 1.0 / libm::sqrt(t * t + 1.0);
            let mut turn = Matrix3::identity();
            turn[(p, p)] = c;
            turn[(q, q)] = c;
            turn[(p, q)] = t * c;
            turn[(q, p)] = -t * c;
            m = turn.transpose() * m * turn;
        }
    }
    let mut moments: [f64; 3] = Vector3::from(m.diagonal()).into();
    moments.sort_unstable_by(f64::total_cmp);
    moments
}

fn rotor(rotor: &Rotor) -> Result<(), Impossible> {
    finite("rotor inertia", &[rotor.inertia])?;
    finite("gear", &[rotor.gear])?;
    if rotor.inertia < 0.0 { Err(Impossible::NegativeRotorInertia(rotor.inertia)) } else { Ok(()) }
}

fn limits(limits: &Limits<f64>) -> Result<(), Impossible> {
    let (lo, hi) = limits.position;
    if lo.is_nan() || hi.is_nan() {
        return Err(Impossible::NotFinite("position limit"));
    }
    if lo >= hi {
        return Err(Impossible::PositionLimitsReversed(lo, hi));
    }
    for (name, x) in [("velocity", limits.velocity), ("torque", limits.torque), ("torque rate", limits.torque_rate)] {
        if x.is_nan() {
            return Err(Impossible::NotFinite("limit"));
        }
        if x <= 0.0 {
            return Err(Impossible::LimitNotPositive(name, x));
        }
    }
    Ok(())
}
