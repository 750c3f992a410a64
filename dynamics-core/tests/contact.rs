//! The wrench at the tip, computed from the base's wrench.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use crate::common::moving::{Moving, fixed, moving, worst, worst_over_arms};
use crate::common::{Golden, cast, numbers_of, pinned, pinned_rounding, relative_error, turns};
use dynamics_core::chapter::contact::{base_wrench, contact_wrench};
use dynamics_core::{Dynamics, Live, Scene, Term, Wrench, geometry};
use nalgebra::Vector3;

fn reading<const N: usize>(case: &Moving<N>) -> Wrench<f64> {
    base_wrench(&case.dynamics(), &turns(&case.q), &case.q, &case.qd, &case.qdd, &Live::zero())
}

fn felt<const N: usize>(case: &Moving<N>, reading: &Wrench<f64>) -> Wrench<f64> {
    // The contact is not part of the model; the payload is live, like a body that has been picked up.
    let scene = Scene { tip_wrench: Term::Absent, payload: Term::Live, ..*case.dynamics().scene() };
    let dynamics = Dynamics::new(case.model, scene);
    let live = Live { payload: dynamics.payload_in_last_link(&case.payload), ..Live::zero() };
    contact_wrench(&dynamics, &turns(&case.q), &case.q, &case.qd, &case.qdd, reading, &live)
}

/// Difference of the computed wrench from the applied one, relative to the base's wrench, because the rest of the base's wrench has
/// to cancel.
fn undone<const N: usize>(case: &Moving<N>) -> f64 {
    let reading = reading(case);
    let off = felt(case, &reading) - case.contact;
    let most = |w: &Wrench<f64>| w.force.amax().max(w.moment.amax());
    most(&off) / most(&reading)
}

#[test]
fn outward_undoes_inward() {
    pinned_rounding("outward after inward", worst_over_arms!(undone), 2.22e-15);
}

#[test]
fn single_precision_feels_to_its_rounding_of_what_the_base_carries() {
    let worst = worst::<6>(|case| {
        let scene = Scene { tip_wrench: Term::Absent, ..*case.dynamics().scene() };
        let dynamics = Dynamics::new(case.model.cast::<f32>(), scene.cast());
        let [q, qd, qdd] = [&case.q, &case.qd, &case.qdd].map(cast::<f32, 6>);
        let reading = reading(case);
        let felt = contact_wrench(&dynamics, &turns(&case.q), &q, &qd, &qdd, &reading.cast(), &Live::zero());
        let most = |w: &Wrench<f64>| w.force.amax().max(w.moment.amax());
        most(&(felt.cast() - case.contact)) / most(&reading)
    });
    pinned_rounding("single precision", worst, 5.73e-7);
}

#[test]
fn an_arm_left_alone_feels_nothing_and_a_push_along_the_tips_x_is_felt_along_it() {
    let case = fixed(moving::<4>(), 1).next().unwrap();
    let alone = Moving { contact: Wrench::zero(), ..case };
    let nothing = felt(&alone, &reading(&alone));
    let size = numbers_of(&[reading(&alone)]).into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    assert!(numbers_of(&[nothing]).iter().all(|x| x.abs() < 1e-13 * size), "{nothing:?}");
    // Wrench of the environment on the arm; the base has to hold against it.
    let push = Wrench { force: Vector3::new(7.0, 0.0, 0.0), moment: Vector3::zeros() };
    let pushed = Moving { contact: push, ..case };
    let more = reading(&pushed) - reading(&alone);
    assert!((more.force + case.posture().tip.rotation * push.force).amax() < 1e-12 * size);
    let felt = felt(&pushed, &reading(&pushed));
    assert!((felt.force.x - 7.0).abs() < 1e-12 * size, "{felt:?}");
}

#[test]
fn a_sensor_elsewhere_in_the_base_is_moved_to_its_origin() {
    let case = fixed(moving::<5>(), 1).next().unwrap();
    let (rotation, translation) = (geometry::from_rpy(0.3, -0.8, 2.0), Vector3::new(0.1, -0.2, -0.4));
    let at_origin = reading(&case);
    // Reading of that sensor, computed from the laws of statics only.
    let read = Wrench {
        force: rotation.transpose() * at_origin.force,
        moment: rotation.transpose() * (at_origin.moment - translation.cross(&at_origin.force)),
    };
    let felt = felt(&case, &read.in_parent(&rotation, &translation));
    assert!(relative_error(&numbers_of(&[felt]), &numbers_of(&[case.contact])) < 1e-13);
}

/// According to the text after 12.168, the negative of the wrench that a link passes on acts on the next link.
#[test]
fn a_wrench_handed_on_with_its_sign_turned_over_is_wrong() {
    let handed_on = |case: &Moving<2>, sign: f64| {
        let posture = case.posture();
        let motion = posture.motion(&case.qd, &case.qdd);
        let needed = |i: usize| (motion[i].acceleration - case.gravity) * posture.links[i].mass;
        let at_tip = sign * (reading(case).force - needed(0)) - needed(1);
        // The arm's force on the world, by the recursion.
        let wanted = -(posture.tip.rotation * felt(case, &reading(case)).force);
        relative_error(at_tip.as_slice(), wanted.as_slice())
    };
    let right = worst(|case| handed_on(case, 1.0));
    assert!(right < 1e-12, "{right:e}");
    pinned("sign as printed", worst(|case| handed_on(case, -1.0)), 43.4);
}

/// Standard deviations of one reading, each component independent.
struct Noise {
    /// Force, N.
    force: f64,
    /// Moment, N m.
    moment: f64,
    /// Position, rad.
    q: f64,
    /// Velocity, rad/s.
    qd: f64,
    /// Acceleration, rad/s^2.
    qdd: f64,
}

/// Noise of a base sensor for some hundred newtons, of encoders with 2^16 counts a turn, and of their first and second differences over some
/// milliseconds.
const NOISE: Noise = Noise { force: 0.5, moment: 0.05, q: 1e-4, qd: 5e-3, qdd: 0.2 };

/// A Puma 560 at a fast moment of a reach, without contact.
fn puma() -> Moving<6> {
    let golden = Golden::load("puma560");
    Moving {
        model: golden.classical(),
        gravity: golden.gravity(),
        payload: dynamics_core::Inertia::zero(),
        contact: Wrench::zero(),
        q: [0.4, 0.7, -2.2, 0.3, 0.6, -0.2],
        qd: [1.0, -0.8, 1.2, 0.5, -1.5, 2.0],
        qdd: [3.0, 2.0, -4.0, 5.0, 6.0, -8.0],
    }
}

/// Computed wrench with errors of reading and state: force x, y, z and moment x, y, z of the reading, then q, qd, qdd.
fn felt_with(case: &Moving<6>, error: &[f64; 24]) -> Wrench<f64> {
    let part = |from: usize, of: &[f64; 6]| core::array::from_fn(|i| of[i] + error[from + i]);
    let disturbed = Moving { q: part(6, &case.q), qd: part(12, &case.qd), qdd: part(18, &case.qdd), ..*case };
    let off =
        Wrench { force: Vector3::from_column_slice(&error[..3]), moment: Vector3::from_column_slice(&error[3..6]) };
    felt(&disturbed, &(reading(case) + off))
}

fn deviations() -> [f64; 24] {
    core::array::from_fn(|k| match k {
        0..3 => NOISE.force,
        3..6 => NOISE.moment,
        6..12 => NOISE.q,
        12..18 => NOISE.qd,
        _ => NOISE.qdd,
    })
}

fn square(v: &Vector3<f64>) -> f64 {
    v.dot(v)
}

/// Root mean square of the force's and the moment's error for these columns, to first order in the noise.
fn predicted(case: &Moving<6>, columns: core::ops::Range<usize>) -> (f64, f64) {
    let (mut force, mut moment) = (0.0_f64, 0.0_f64);
    for k in columns {
        let sigma = deviations()[k];
        let at = |x: f64| {
            let mut error = [0.0; 24];
            error[k] = x;
            felt_with(case, &error)
        };
        let twice = at(sigma) - at(-sigma);
        force += square(&twice.force) / 4.0;
        moment += square(&twice.moment) / 4.0;
    }
    (force.sqrt(), moment.sqrt())
}

#[test]
fn noise_of_the_reading_comes_through_as_the_formula_has_it() {
    let case = puma();
    let (force, moment) = predicted(&case, 0..6);
    let reach = square(&case.posture().tip.translation).sqrt();
    let (s_f, s_m) = (NOISE.force, NOISE.moment);
    assert!((force / (3.0_f64.sqrt() * s_f) - 1.0).abs() < 1e-12);
    let wanted = (3.0 * s_m * s_m + 2.0 * reach * reach * s_f * s_f).sqrt();
    assert!((moment / wanted - 1.0).abs() < 1e-12, "{moment} {wanted}");
}

#[test]
fn noise_of_the_acceleration_comes_through_as_the_mass_beyond_the_joint() {
    // A unit acceleration of joint j moves the mass beyond it, at its distance from the axis: k x (sum m r - d sum m).
    let case = puma();
    let posture = case.posture();
    for j in 0..6 {
        let (mass, first) = posture.links[j..].iter().fold((0.0, Vector3::zeros()), |(mass, first), link| {
            (mass + link.mass, first + (link.centre - posture.links[j].origin) * link.mass)
        });
        assert!(mass > 0.0);
        let needed = posture.tip.rotation.transpose() * posture.links[j].axis.cross(&first);
        let mut error = [0.0; 24];
        error[18 + j] = 1.0;
        let found = felt_with(&case, &error).force;
        assert!((found - needed).amax() < 1e-11, "joint {j}: {found} {needed}");
    }
}

#[test]
fn a_puma_feels_its_tip_as_well_as_its_sensors_allow() {
    let case = puma();
    for (what, columns, force, moment) in [
        ("reading", 0..6, 0.866, 0.878),
        ("q", 6..12, 2.21e-3, 6.64e-3),
        ("qd", 12..18, 0.0875, 0.0419),
        ("qdd", 18..24, 1.54, 0.261),
        ("all", 0..24, 1.77, 0.917),
    ] {
        let found = predicted(&case, columns);
        pinned(&format!("force from {what}, N"), found.0, force);
        pinned(&format!("moment from {what}, N m"), found.1, moment);
    }
}

/// Ten thousand readings, each with its own noise: the root mean squares agree with the first-order prediction.
#[test]
fn a_puma_that_is_asked_ten_thousand_times_scatters_as_predicted() {
    const DRAWS: usize = 10_000;
    let case = puma();
    let mut random = Random(1);
    let (mut force, mut moment) = (0.0_f64, 0.0_f64);
    for _ in 0..DRAWS {
        let error = deviations().map(|sigma| sigma * random.normal());
        let felt = felt_with(&case, &error);
        force += square(&felt.force);
        moment += square(&felt.moment);
    }
    let rms = |sum: f64| (sum / DRAWS as f64).sqrt();
    let wanted = predicted(&case, 0..24);
    // Each draw contributes at most three numbers, so the root mean square itself has a relative error of at most 1 / sqrt(2 DRAWS), 0.7 %.
    assert!((rms(force) / wanted.0 - 1.0).abs() < 0.02, "{} {}", rms(force), wanted.0);
    assert!((rms(moment) / wanted.1 - 1.0).abs() < 0.02, "{} {}", rms(moment), wanted.1);
    pinned("scatter of the force, N", rms(force), 1.78);
    pinned("scatter of the moment, N m", rms(moment), 0.919);
}

/// SplitMix64, and the sum of twelve uniform numbers for a normal one.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}
