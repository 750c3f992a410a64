//! Energies and derivatives of the Lagrangian by traces (12.396-12.413), each term compared with an expression without a trace.
#![allow(clippy::unwrap_used, reason = "a random arm that cannot be built should stop the test")]

use crate::common::moving::{Moving, fixed, worst};
use crate::common::{along, derivative, relative_error, stepped, turns};
use dynamics_core::chapter::lagrange;
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::chapter::trace_form::Transforms;
use dynamics_core::geometry::about_x;
use dynamics_core::{Body, Dynamics, Frame, Inertia, JointSpec, Limits, Live, Model, Rotor, Scene, Term, Tool, energy};
use nalgebra::{Matrix3, Vector3};

fn at<const N: usize>(case: &Moving<N>, q: &[f64; N]) -> Transforms<f64, N> {
    Transforms::new(&case.chain(), &turns(q), q)
}

fn transforms<const N: usize>(case: &Moving<N>) -> Transforms<f64, N> {
    at(case, &case.q)
}

/// A tip in general position.
const POINT: Vector3<f64> = Vector3::new(0.3, -0.7, 0.4);

/// 12.396-12.397 compared with `O + R r` and `v_C + omega x (r - r_C)`.
#[test]
fn points_move_as_rigid_links_do() {
    let off = worst::<6>(|case| {
        let (traces, posture) = (transforms(case), case.posture());
        let motion = posture.motion(&case.qd, &[0.0; 6]);
        (0..6).fold(0.0, |most: f64, r| {
            let (link, moving) = (&posture.links[r], &motion[r]);
            let place = link.origin + link.rotation * POINT;
            let speed = moving.velocity + moving.omega.cross(&(place - link.centre));
            most.max(relative_error(traces.position(r, &POINT).as_slice(), place.as_slice()))
                .max(relative_error(traces.velocity(r, &POINT, &case.qd).as_slice(), speed.as_slice()))
        })
    });
    assert!(off < 1e-13, "{off:e}");
}

/// Four particles in each link: a body is defined only by their masses and positions.
fn particles(seed: usize) -> [(f64, Vector3<f64>); 4] {
    core::array::from_fn(|k| {
        let x = (7 * seed + 3 * k) as f64;
        (0.5 + 0.3 * (x.sin() + 1.0), Vector3::new((1.3 * x).sin(), (2.1 * x).cos(), (0.7 * x).sin()) * 0.4)
    })
}

fn joined(particles: &[(f64, Vector3<f64>)]) -> Body {
    let mass = particles.iter().map(|(m, _)| m).sum::<f64>();
    let com = particles.iter().fold(Vector3::zeros(), |sum, (m, at)| sum + at * (*m / mass));
    let inertia = particles.iter().fold(Matrix3::zeros(), |sum, (m, at)| {
        let r = at - com;
        sum + (Matrix3::identity() * r.dot(&r) - r * r.transpose()) * *m
    });
    Body { mass, com, inertia }
}

/// 12.398-12.403: a link's energy by traces is the sum of its particles' `1/2 m v^2`, link by link.
#[test]
fn a_links_energy_is_that_of_its_particles() {
    for case in fixed(crate::common::moving::moving::<5>(), 32) {
        let joints: [JointSpec; 5] = core::array::from_fn(|r| JointSpec {
            kind: case.model.links()[r].kind,
            // With a placement, the body's axes stay as given.
            frame: Frame::Placement {
                rotation: about_x(0.4 + r as f64),
                translation: Vector3::new(0.3, 0.1 * r as f64, -0.2),
                axis: Vector3::z(),
            },
            body: joined(&particles(r)),
            rotor: Rotor::default(),
            limits: Limits::none(),
        });
        let model = Model::new(&joints, &Tool::default()).unwrap();
        let traces = Transforms::new(&Chain::new(&model, &Inertia::zero()), &turns(&case.q), &case.q);
        let mut whole = 0.0;
        for r in 0..5 {
            let each = particles(r).map(|(m, at)| {
                let v = traces.velocity(r, &at, &case.qd);
                0.5 * m * v.dot(&v)
            });
            let wanted: f64 = each.iter().sum();
            let found = traces.link_kinetic_energy(r, &case.qd);
            assert!((found - wanted).abs() < 1e-12 * wanted.max(1e-3), "link {r}: {found} {wanted}");
            whole += wanted;
        }
        assert!((traces.kinetic_energy(&case.qd) / whole - 1.0).abs() < 1e-12);
    }
}

/// 12.403 and 12.405-12.406 compared with the composite bodies' energies.
#[test]
fn energies_are_those_of_the_composite_bodies() {
    let off = worst::<6>(|case| {
        let scene = Scene { tip_wrench: Term::Absent, rotor: Term::Absent, ..*case.dynamics().scene() };
        let (dynamics, turn) = (Dynamics::new(case.model, scene), turns(&case.q));
        let kinetic = energy::kinetic(&dynamics, &turn, &case.q, &case.qd, &Live::zero());
        let potential = energy::potential(&dynamics, &turn, &case.q, &Live::zero());
        let found = transforms(case);
        let length = |v: &Vector3<f64>| v.dot(v).sqrt();
        let weights = case.posture().links.map(|link| link.mass * length(&case.gravity) * length(&link.centre));
        let size: f64 = weights.iter().sum();
        let lagrangian = found.lagrangian(&case.qd, &case.gravity);
        relative_error(&[found.kinetic_energy(&case.qd)], &[kinetic])
            .max((found.potential_energy(&case.gravity) - potential).abs() / size)
            .max((lagrangian - (kinetic - potential)).abs() / (size + kinetic))
    });
    assert!(off < 1e-13, "{off:e}");
}

/// `sum_r (m v_i . v_j + w_i . I w_j)`; the columns are velocities under unit joint speeds.
fn by_columns(posture: &Posture<f64, 6>, i: usize, j: usize) -> f64 {
    let unit = |k: usize| core::array::from_fn(|n| if n == k { 1.0 } else { 0.0 });
    let (first, second) = (posture.motion(&unit(i), &[0.0; 6]), posture.motion(&unit(j), &[0.0; 6]));
    let links = posture.links.iter().zip(first.iter().zip(&second));
    links.map(|(link, (a, b))| link.mass * a.velocity.dot(&b.velocity) + a.omega.dot(&(link.inertia * b.omega))).sum()
}

/// 12.393, 12.409-12.410: `D` is symmetric and every element is correct relative to its own row and column.
#[test]
fn the_inertia_matrix_is_right_element_by_element() {
    let off = worst::<6>(|case| {
        let (d, posture) = (transforms(case).mass_matrix(), case.posture());
        let elements = (0..36).map(|n| (n / 6, n % 6));
        elements.fold(0.0, |most: f64, (i, j)| {
            let size = (d[(i, i)] * d[(j, j)]).sqrt();
            let apart = (d[(i, j)] - d[(j, i)]).abs();
            most.max(((d[(i, j)] - by_columns(&posture, i, j)).abs() + apart) / size)
        })
    });
    assert!(off < 1e-12, "{off:e}");
}

/// 12.395, 12.419: the gravity torque of each joint is that of all links beyond it about its axis.
#[test]
fn the_gravity_vector_is_right_element_by_element() {
    let off = worst::<6>(|case| {
        let (found, posture) = (transforms(case).gravity(&case.gravity), case.posture());
        let wanted = lagrange::gravity(&posture, &case.gravity);
        let length = |v: &Vector3<f64>| v.dot(v).sqrt();
        (0..6).fold(0.0, |most: f64, i| {
            let lever = |r: usize| 1.0 + length(&(posture.links[r].centre - posture.links[i].origin));
            let size: f64 = (i..6).map(|r| posture.links[r].mass * length(&case.gravity) * lever(r)).sum();
            most.max((found[i] - wanted[i]).abs() / size)
        })
    });
    assert!(off < 1e-13, "{off:e}");
}

/// 12.408 and 12.411-12.413 compared with differences of the Lagrangian of 12.407; together they give the torques of 12.414.
#[test]
fn derivatives_of_the_lagrangian_are_its_slopes() {
    let off = worst::<6>(|case| {
        let here = transforms(case);
        let lagrangian = |q: &[f64; 6], qd: &[f64; 6]| at(case, q).lagrangian(qd, &case.gravity);
        // Quadratic in the speeds: the central difference is exact.
        let by_speed = |q: &[f64; 6], qd: &[f64; 6], i: usize| {
            (lagrangian(q, &stepped(qd, i, 1.0)) - lagrangian(q, &stepped(qd, i, -1.0))) / 2.0
        };
        let momenta = core::array::from_fn::<f64, 6, _>(|i| by_speed(&case.q, &case.qd, i));
        let rates = core::array::from_fn::<f64, 6, _>(|i| {
            derivative(|t| {
                let (q, qd) = along(&case.q, &case.qd, &case.qdd, t);
                by_speed(&q, &qd, i)
            })
        });
        let slopes =
            core::array::from_fn::<f64, 6, _>(|i| derivative(|step| lagrangian(&stepped(&case.q, i, step), &case.qd)));
        let found_rates = here.momentum_rates(&case.qd, &case.qdd);
        let found_slopes = here.lagrangian_slopes(&case.qd, &case.gravity);
        let torques = core::array::from_fn::<f64, 6, _>(|i| found_rates[i] - found_slopes[i]);
        relative_error(&here.momenta(&case.qd), &momenta)
            .max(relative_error(&found_rates, &rates))
            .max(relative_error(&found_slopes, &slopes))
            .max(relative_error(&torques, &here.inverse_dynamics(&case.qd, &case.qdd, &case.gravity)))
    });
    assert!(off < 1e-8, "{off:e}");
}
