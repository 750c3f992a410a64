//! Example 324: a four-bar linkage. The closed form by the book's method, eq. 12.29-12.47 with 12.41 corrected, compared with the
//! general code; energy, virtual work, branches, Grashof's rule, dead points; and the wrong printed forms.
#![allow(clippy::unwrap_used, reason = "a random linkage that cannot be built should stop the test")]
#![allow(clippy::float_cmp, reason = "a mirror image is exact")]

use crate::common::linkages::{
    Case, bodies, cases, cross, energy_rate, length, missed, nine, shaking, turn, virtual_work, work_size,
};
use dynamics_core::SinCos;
use dynamics_core::linkage::{
    Branch, CrankForm, DeadPoint, FourBar, FourBarLengths, Grashof, Linkage, LinkageError, Member, PlanarBody,
    PlanarMotion,
};
use nalgebra::Vector2;
use std::f64::consts::{PI, TAU};

const FLOOR: Vector2<f64> = Vector2::new(0.0, -9.81);

fn lengths<S>([ground, crank, coupler, follower]: [S; 4]) -> FourBarLengths<S> {
    FourBarLengths { ground, crank, coupler, follower }
}

fn random(count: usize) -> Vec<Case<FourBar<f64>>> {
    let sizes = [0.1..1.0, 0.1..1.0, 0.1..1.0, 0.1..1.0];
    cases(count, (sizes, bodies()), |(sizes, bodies)| FourBar::new(lengths(sizes), bodies).ok())
}

fn rods(sizes: [f64; 4]) -> Result<FourBar<f64>, LinkageError<f64>> {
    let rod = |length: f64| PlanarBody {
        mass: 2.0 * length,
        centre: Vector2::new(0.5 * length, 0.0),
        inertia: length.powi(3) / 6.0,
    };
    FourBar::new(lengths(sizes), [rod(sizes[1]), rod(sizes[2]), rod(sizes[3])])
}

/// A crank-rocker.
const CRANK_ROCKER: [f64; 4] = [0.40, 0.12, 0.36, 0.30];

fn unit(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

/// `z x v`.
fn across(v: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v.y, v.x)
}

/// Results of the book's method, in angles, sines and cosines.
struct Book {
    angles: [f64; 3],
    motion: [PlanarMotion<f64>; 3],
    /// `F_0` to `F_3`.
    joints: [Vector2<f64>; 4],
    driving_moment: f64,
}

/// Angles from the triangle with the diagonal, speeds and accelerations from the loop, and eq. 12.37-12.42 eliminated by hand.
fn book(case: &Case<FourBar<f64>>) -> Book {
    let FourBarLengths { ground, crank: l1, coupler: l2, follower: l3 } = *case.linkage.lengths();
    let [one, two, three] = *case.linkage.bodies();
    let (t1, w1, a1) = (case.angle, case.speed, case.acceleration);

    let diagonal = Vector2::new(ground - l1 * t1.cos(), -l1 * t1.sin());
    let (s, lean) = (length(diagonal), diagonal.y.atan2(diagonal.x));
    let inner = ((s * s + l2 * l2 - l3 * l3) / (2.0 * s * l2)).acos();
    let outer = ((s * s + l3 * l3 - l2 * l2) / (2.0 * s * l3)).acos();
    let (t2, t3) = match case.branch {
        Branch::Open => (lean + inner, lean + PI - outer),
        Branch::Crossed => (lean - inner, lean - PI + outer),
    };

    // l1 e1 + l2 e2 = ground + l3 e3, differentiated and multiplied by e3, then by e2.
    let w2 = l1 * w1 * (t3 - t1).sin() / (l2 * (t2 - t3).sin());
    let w3 = l1 * w1 * (t1 - t2).sin() / (l3 * (t3 - t2).sin());
    let a2 =
        (l1 * w1 * w1 * (t3 - t1).cos() + l2 * w2 * w2 * (t3 - t2).cos() - l3 * w3 * w3 - l1 * a1 * (t3 - t1).sin())
            / (l2 * (t3 - t2).sin());
    let a3 = (l1 * a1 * (t2 - t1).sin() - l1 * w1 * w1 * (t2 - t1).cos() - l2 * w2 * w2
        + l3 * w3 * w3 * (t2 - t3).cos())
        / (l3 * (t2 - t3).sin());

    let arm = |angle: f64, body: &PlanarBody<f64>| unit(angle) * body.centre.x + across(unit(angle)) * body.centre.y;
    let (r1, r2, r3) = (arm(t1, &one), arm(t2, &two), arm(t3, &three));
    let moved = |base: PlanarMotion<f64>, w: f64, a: f64, arm: Vector2<f64>| PlanarMotion {
        omega: w,
        alpha: a,
        velocity: base.velocity + across(arm) * w,
        acceleration: base.acceleration + across(arm) * a - arm * (w * w),
    };
    let still = PlanarMotion { omega: 0.0, alpha: 0.0, velocity: Vector2::zeros(), acceleration: Vector2::zeros() };
    let pin = moved(still, w1, a1, unit(t1) * l1);
    let motion = [moved(still, w1, a1, r1), moved(pin, w2, a2, r2), moved(still, w3, a3, r3)];

    // n_i leads to the joint before, m_i to the joint after.
    let (n1, m1) = (-r1, unit(t1) * l1 - r1);
    let (n2, m3) = (-r2, -r3);
    let net = |i: usize, body: &PlanarBody<f64>| (motion[i].acceleration - case.gravity) * body.mass;
    let (c, f) = (unit(t2) * l2, unit(t3) * l3);
    // 12.39 inserted in 12.40, about joint 1; 12.41 (for link 3) inserted in 12.42, about joint 3.
    let of_coupler = cross(&n2, &net(1, &two)) - two.inertia * a2;
    let of_follower = three.inertia * a3 - cross(&m3, &net(2, &three));
    let f2 = (f * of_coupler - c * of_follower) / cross(&c, &f);
    let f1 = f2 + net(1, &two);
    let f0 = f1 + net(0, &one);
    let f3 = f2 - net(2, &three);
    // 12.38.
    let driving_moment = one.inertia * a1 - cross(&n1, &f0) + cross(&m1, &f1);
    Book { angles: [t1, t2, t3], motion, joints: [f0, f1, f2, f3], driving_moment }
}

/// Greatest relative error of the results.
fn off(found: &[f64], wanted: &[f64]) -> f64 {
    crate::common::relative_error(found, wanted)
}

#[test]
fn the_closed_form_gives_positions_motion_forces_and_driving_moment() {
    let (mut places, mut motions, mut forces, mut moments) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    for case in random(2000) {
        let (book, posture, motion) = (book(&case), case.posture(), case.motion());
        for i in 0..3 {
            let direction = unit(book.angles[i]);
            places = places.max(length(posture.links[i].direction - direction));
        }
        let flat = |motion: &[PlanarMotion<f64>; 3]| {
            let of = |m: &PlanarMotion<f64>| {
                [m.omega, m.velocity.x, m.velocity.y, m.alpha, m.acceleration.x, m.acceleration.y]
            };
            motion.iter().map(of).collect::<Vec<_>>()
        };
        // Velocities are compared relative to velocities, accelerations relative to accelerations.
        for (found, wanted) in [(0..3), (3..6)].map(|part: std::ops::Range<usize>| {
            let pick = |all: &[PlanarMotion<f64>; 3]| {
                flat(all).iter().flat_map(|m| m[part.clone()].to_vec()).collect::<Vec<_>>()
            };
            (pick(&motion), pick(&book.motion))
        }) {
            motions = motions.max(off(&found, &wanted));
        }
        let found = posture.forces(&motion, &case.gravity).unwrap();
        let pairs = |joints: &[Vector2<f64>; 4]| joints.iter().flat_map(|f| [f.x, f.y]).collect::<Vec<_>>();
        forces = forces.max(off(&pairs(&found.joints), &pairs(&book.joints)));
        // The moment is a sum of forces times lever arms.
        let size = book.joints.iter().map(|f| length(*f)).fold(0.0, f64::max) * case.linkage.lengths().crank;
        moments = moments.max((found.driving_moment - book.driving_moment).abs() / size.max(book.driving_moment.abs()));
        assert_eq!(found.guide_moment, 0.0);
    }
    // Measured: directions 4.3e-15, motion 8.9e-14, forces 1.9e-13, moment 6.1e-14. Two computations of some forty roundings each, with divisions
    // by sines down to 0.2.
    println!("closed form: directions {places:.1e}, motion {motions:.1e}, forces {forces:.1e}, moment {moments:.1e}");
    assert!(places < 1e-12 && motions < 1e-12 && forces < 1e-12 && moments < 1e-12);
}

#[test]
fn the_nine_equations_hold_link_by_link() {
    let worst = random(2000).iter().map(missed).fold(0.0, f64::max);
    println!("nine equations: {worst:.1e}");
    assert!(worst < 1e-13);
}

#[test]
fn the_determinant_is_the_area_of_coupler_and_follower() {
    for case in random(200) {
        let posture = case.posture();
        let system = posture.system(&case.motion(), &case.gravity);
        let found = nine(system.a, system.b).1;
        let FourBarLengths { coupler, follower, .. } = *case.linkage.lengths();
        let wanted = coupler * follower * posture.transmission();
        assert!((found.abs() - wanted.abs()).abs() < 1e-13, "{found} {wanted}");
    }
}

#[test]
fn power_of_the_driving_moment_is_the_rate_of_energy() {
    let mut worst = 0.0_f64;
    for case in random(2000) {
        let (posture, motion) = (case.posture(), case.motion());
        let moment = posture.forces(&motion, &case.gravity).unwrap().driving_moment;
        let rate = energy_rate(&posture, &motion, &case.gravity);
        let size = work_size(&posture, &motion, &case.gravity);
        worst = worst.max((moment * case.speed - rate).abs() / size);
    }
    println!("power: {worst:.1e}");
    assert!(worst < 1e-12);
}

#[test]
fn the_driving_moment_does_the_virtual_work() {
    let mut worst = 0.0_f64;
    for case in random(500) {
        let (posture, motion) = (case.posture(), case.motion());
        let moment = posture.forces(&motion, &case.gravity).unwrap().driving_moment;
        let size = work_size(&posture, &motion, &case.gravity) / case.speed.abs();
        worst = worst.max((moment - virtual_work(&case)).abs() / size);
    }
    println!("virtual work: {worst:.1e}");
    // Differences of positions over 2e-5 rad.
    assert!(worst > 0.0 && worst < 1e-6);
}

#[test]
fn one_coordinate_says_the_same_as_nine_equations() {
    let (mut worst, mut slope, mut back) = (0.0_f64, 0.0_f64, 0.0_f64);
    for case in random(1000) {
        let form = |more: f64| {
            let posture = case.posture_at(more);
            CrankForm::new(&posture, &posture.coefficients().unwrap(), &case.gravity)
        };
        let (now, posture) = (form(0.0), case.posture());
        let moment = posture.forces(&case.motion(), &case.gravity).unwrap().driving_moment;
        let found = now.moment(case.speed, case.acceleration);
        let size =
            now.inertia * case.acceleration.abs() + now.half_slope.abs() * case.speed.powi(2) + now.gravity.abs();
        worst = worst.max((found - moment).abs() / size);
        back = back.max((now.acceleration(found, case.speed).unwrap() - case.acceleration).abs() * now.inertia / size);
        // I' and dV/dtheta are derivatives.
        let h = 1e-5;
        let (inertia, potential) = (
            (form(h).inertia - form(-h).inertia) / (2.0 * h),
            (case.posture_at(h).potential_energy(&case.gravity) - case.posture_at(-h).potential_energy(&case.gravity))
                / (2.0 * h),
        );
        let held = case.linkage.bodies().iter().map(|body| body.mass).sum::<f64>() * length(case.gravity);
        slope = slope.max((inertia - 2.0 * now.half_slope).abs() / (now.inertia + now.half_slope.abs()));
        slope = slope.max((potential - now.gravity).abs() / held);
    }
    println!("one coordinate: moment {worst:.1e}, derivatives {slope:.1e}, there and back {back:.1e}");
    // The derivatives are compared with differences over 2e-5 rad.
    assert!(worst < 1e-12 && slope < 1e-5 && back < 1e-14);
}

#[test]
fn the_ground_feels_what_the_bodies_do_not_take_up() {
    let mut worst = 0.0_f64;
    for case in random(1000) {
        let (posture, motion) = (case.posture(), case.motion());
        let forces = posture.forces(&motion, &case.gravity).unwrap();
        let (force, moment) = shaking(&posture, &motion, &case.gravity);
        let largest = forces.joints.iter().map(|f| length(*f)).fold(0.0, f64::max);
        // 12.47.
        worst = worst.max(length(forces.shaking_force() - force) / largest);
        worst = worst.max((forces.shaking_moment() - moment).abs() / largest);
    }
    println!("shaking: {worst:.1e}");
    assert!(worst < 1e-12);
}

#[test]
fn both_branches_close_and_are_mirror_images_about_the_diagonal() {
    for case in random(500) {
        let FourBarLengths { ground, coupler, follower, .. } = *case.linkage.lengths();
        let [open, crossed] = [Branch::Open, Branch::Crossed].map(|branch| {
            let posture = case.linkage.posture(&turn(case.angle), branch).unwrap();
            let [crank, second, third] = posture.links;
            assert_eq!((crank.outer, second.outer), (second.inner, third.inner));
            assert_eq!(third.outer, Vector2::new(ground, 0.0));
            assert!((length(second.outer - second.inner) - coupler).abs() < 1e-15);
            assert!((length(third.inner - third.outer) - follower).abs() < 1e-15);
            assert!((length(second.direction) - 1.0).abs() < 1e-14 && (length(third.direction) - 1.0).abs() < 1e-14);
            cross(&(third.outer - crank.outer), &(second.outer - crank.outer))
        });
        assert!(open > 0.0 && (open + crossed).abs() < 1e-14, "{open} {crossed}");
    }
    // With the crank between 0 and a half turn the open crank-rocker has its coupler above the ground.
    let posture = rods(CRANK_ROCKER).unwrap().posture(&turn(1.0), Branch::Open).unwrap();
    assert!(posture.links[1].outer.y > 0.0);
}

#[test]
fn grashofs_rule_names_what_turns() {
    // The last column is true if the crank turns fully.
    let table = [
        ([0.40, 0.12, 0.36, 0.30], Grashof::CrankRocker, true),
        ([0.12, 0.40, 0.36, 0.30], Grashof::DoubleCrank, true),
        ([0.40, 0.36, 0.12, 0.30], Grashof::DoubleRocker, false),
        ([0.40, 0.36, 0.30, 0.12], Grashof::RockerCrank, false),
        ([0.40, 0.30, 0.20, 0.26], Grashof::TripleRocker, false),
        // A parallelogram, kites, and decimals whose sums are equal only before rounding.
        ([0.40, 0.10, 0.40, 0.10], Grashof::ChangePoint, true),
        ([0.40, 0.40, 0.10, 0.10], Grashof::ChangePoint, false),
        ([0.10, 0.10, 0.40, 0.40], Grashof::ChangePoint, true),
        ([0.30, 0.10, 0.40, 0.20], Grashof::ChangePoint, true),
    ];
    for (sizes, class, full) in table {
        let linkage = rods(sizes).unwrap();
        assert_eq!(linkage.class(), class, "{sizes:?}");
        assert_eq!(linkage.crank_range().is_full_turn(), full, "{sizes:?}");
    }
}

/// The rule, the range and the positions are three separate computations; they agree on random lengths.
#[test]
fn the_range_is_where_positions_exist() {
    let angles = || (0..1440).map(|i| TAU * f64::from(i) / 1440.0);
    for case in random(300) {
        let linkage = case.linkage;
        let closes = |angle: f64| linkage.posture(&turn(angle), case.branch).is_ok();
        let range = linkage.crank_range();
        for angle in angles() {
            let within =
                range.low.is_none_or(|low| angle.cos() >= low) && range.high.is_none_or(|high| angle.cos() <= high);
            let near_an_end = range.ends().iter().flatten().any(|end| (end.cos - angle.cos()).abs() < 1e-12);
            assert!(closes(angle) == within || near_an_end, "{linkage:?} at {angle}");
        }
        let full = matches!(linkage.class(), Grashof::CrankRocker | Grashof::DoubleCrank);
        assert_eq!(full, angles().all(closes), "{:?} {:?}", linkage.class(), linkage.lengths());
        // The class also gives whether the follower turns fully; it is tested as the crank of the mirrored linkage.
        let FourBarLengths { ground, crank, coupler, follower } = *linkage.lengths();
        let reversed = FourBar::new(lengths([ground, follower, coupler, crank]), *linkage.bodies()).unwrap();
        let full = matches!(linkage.class(), Grashof::RockerCrank | Grashof::DoubleCrank);
        assert_eq!(full, reversed.crank_range().is_full_turn());
    }
}

#[test]
fn ends_of_the_range_are_dead_points_and_beyond_them_the_gap_is_told() {
    let mut ends = 0;
    for case in random(300) {
        let FourBarLengths { ground, crank, coupler, follower } = *case.linkage.lengths();
        for end in case.linkage.crank_range().ends().into_iter().flatten() {
            ends += 1;
            let angle = end.sin.atan2(end.cos);
            for branch in [Branch::Open, Branch::Crossed] {
                let at = |angle: f64| case.linkage.posture(&turn(angle), branch);
                // A rounded angle differs from the end of the range by its rounding error; the sine is then the square root of that.
                if let Ok(posture) = at(angle) {
                    assert!(posture.transmission().abs() < 2e-6, "{}", posture.transmission());
                }
                let beyond = [at(angle + 1e-3), at(angle - 1e-3)];
                let inside = beyond.iter().flatten().next().unwrap();
                assert!(inside.coefficients().is_ok());
                let outside = beyond.iter().find_map(|tried| tried.err()).unwrap();
                let angle = if at(angle + 1e-3).is_err() { angle + 1e-3 } else { angle - 1e-3 };
                let diagonal = (ground - crank * angle.cos()).hypot(crank * angle.sin());
                let gap = match outside {
                    LinkageError::TooFar { gap } => gap - (diagonal - coupler - follower),
                    LinkageError::TooNear { gap } => gap - ((coupler - follower).abs() - diagonal),
                    other => unreachable!("{other}"),
                };
                assert!(gap.abs() < 1e-15, "{outside}");
            }
        }
    }
    assert!(ends > 300, "{ends}");
}

/// Lengths with an exact dead point.
#[test]
fn a_dead_point_is_an_error_that_names_the_links() {
    // Stretched out: 3-4-5 with coupler and follower along the hypotenuse.
    let stretched = rods([4.0, 3.0, 2.0, 3.0]).unwrap();
    // Folded: the diagonal is the difference of the lengths.
    let folded = rods([4.0, 3.0, 8.0, 3.0]).unwrap();
    let up = SinCos { sin: 1.0, cos: 0.0 };
    for linkage in [stretched, folded] {
        for branch in [Branch::Open, Branch::Crossed] {
            let posture = linkage.posture(&up, branch).unwrap();
            assert_eq!(posture.dead_point(), Some(DeadPoint::CouplerAndFollower));
            let error = posture.coefficients().unwrap_err();
            assert_eq!(error, LinkageError::Dead(DeadPoint::CouplerAndFollower));
            assert_eq!(error.to_string(), "dead point: coupler and follower lie in line");
            let still =
                PlanarMotion { omega: 0.0, alpha: 0.0, velocity: Vector2::zeros(), acceleration: Vector2::zeros() };
            assert_eq!(posture.forces(&[still; 3], &FLOOR).unwrap_err(), error);
        }
    }
    // A parallelogram laid flat, and the crank pin of a kite on the follower's pivot.
    let flat = SinCos { sin: 0.0, cos: 1.0 };
    let parallelogram = rods([0.4, 0.1, 0.4, 0.1]).unwrap().posture(&flat, Branch::Open).unwrap();
    assert_eq!(parallelogram.coefficients().unwrap_err(), LinkageError::Dead(DeadPoint::CouplerAndFollower));
    let kite = rods([0.4, 0.4, 0.1, 0.1]).unwrap().posture(&flat, Branch::Open);
    assert_eq!(kite.unwrap_err(), LinkageError::Dead(DeadPoint::CouplerAndFollower));
}

#[test]
fn at_dead_centres_crank_and_coupler_are_in_line_and_the_follower_stands() {
    let mut seen = 0;
    for case in random(300) {
        for branch in [Branch::Open, Branch::Crossed] {
            let centres = case.linkage.dead_centres(branch);
            for (centre, along) in centres.into_iter().zip([1.0, -1.0]).filter_map(|(c, along)| Some((c?, along))) {
                let posture = case.linkage.posture(&centre, branch).unwrap();
                let [crank, coupler, follower] = posture.links;
                assert!(length(coupler.direction - crank.direction * along) < 1e-7, "{branch:?} {posture:?}");
                // Triangles that are nearly flat lose digits.
                if posture.transmission().abs() > 0.1 {
                    seen += 1;
                    assert!(posture.coefficients().unwrap()[2].turn.abs() < 1e-11, "{follower:?}");
                }
            }
        }
    }
    assert!(seen > 300, "{seen}");
    let [stretched, folded] = rods(CRANK_ROCKER).unwrap().dead_centres(Branch::Open);
    assert!(stretched.unwrap().sin > 0.0 && folded.unwrap().sin < 0.0);
}

#[test]
fn what_cannot_be_is_refused_and_named() {
    let refused = |sizes| rods(sizes).unwrap_err();
    let LinkageError::NeverCloses { longest: Member::Coupler, excess } = refused([0.1, 0.1, 1.0, 0.2]) else {
        unreachable!("the coupler is too long");
    };
    assert!((excess - 0.6).abs() < 1e-15);
    assert_eq!(refused([0.0, 0.1, 0.1, 0.1]), LinkageError::Length(Member::Ground));
    assert_eq!(refused([0.1, 0.1, 0.1, f64::INFINITY]), LinkageError::Length(Member::Follower));
    assert_eq!(refused([0.1, -0.1, 0.1, 0.1]), LinkageError::Length(Member::Crank));
    let text = refused([0.1, 0.1, 1.0, 0.2]).to_string();
    assert_eq!(text, "the loop never closes: the coupler is 0.6 m longer than all other lengths together");
    let point = PlanarBody { mass: 1.0, centre: Vector2::zeros(), inertia: 0.0 };
    let of = |body| FourBar::new(lengths(CRANK_ROCKER), [point, point, body]).map(|_| ());
    assert_eq!(of(point), Ok(()));
    for body in [
        PlanarBody { mass: -1.0, ..point },
        PlanarBody { mass: 0.0, inertia: 1.0, ..point },
        PlanarBody { inertia: -1.0, ..point },
        PlanarBody { centre: Vector2::new(f64::NAN, 0.0), ..point },
    ] {
        assert_eq!(of(body), Err(LinkageError::Body(Member::Follower)));
    }
    let nothing = PlanarBody { mass: 0.0, ..point };
    let linkage = FourBar::new(lengths(CRANK_ROCKER), [nothing; 3]).unwrap();
    let posture = linkage.posture(&turn(1.0), Branch::Open).unwrap();
    let form = CrankForm::new(&posture, &posture.coefficients().unwrap(), &FLOOR);
    assert_eq!(form.acceleration(1.0, 1.0), Err(LinkageError::NoInertia));
}

/// Eq. 12.41 as printed has the coupler's `m2 a2` instead of the follower's `m3 a3`. A wrong force on link 3 gives a wrong driving moment.
#[test]
fn the_printed_force_balance_of_the_follower_breaks_the_energy() {
    let linkage = rods(CRANK_ROCKER).unwrap();
    let case = Case { linkage, angle: 1.0, branch: Branch::Open, speed: 10.0, acceleration: 0.0, gravity: FLOOR };
    let (posture, motion) = (case.posture(), case.motion());
    let system = posture.system(&motion, &case.gravity);
    let mut printed = system.b;
    for (row, axis) in [(6, 0), (7, 1)] {
        printed[row] =
            posture.links[1].mass * motion[1].acceleration[axis] - posture.links[2].mass * case.gravity[axis];
    }
    let (right, wrong) = (nine(system.a, system.b).0, nine(system.a, printed).0);
    let rate = energy_rate(&posture, &motion, &case.gravity) / case.speed;
    let away = (wrong[8] - rate).abs() / rate.abs();
    let force = (wrong[6] - right[6]).hypot(wrong[7] - right[7]) / right[6].hypot(right[7]);
    println!("12.41 as printed: the moment is off by {:.0} %, F_3 by {:.0} %", 100.0 * away, 100.0 * force);
    assert!((right[8] - rate).abs() < 1e-13 * rate.abs());
    // Measured: 12 % and 28 %.
    assert!((0.11..0.13).contains(&away) && (0.27..0.29).contains(&force));
}

/// Eq. 12.46 has `- m g` in the rows of y, which is correct for a signed `g = -9.81`. With `g = 9.81` the weight acts upwards.
#[test]
fn the_printed_weight_with_a_positive_g_holds_the_linkage_from_the_wrong_side() {
    let linkage = rods(CRANK_ROCKER).unwrap();
    let case = Case { linkage, angle: 1.0, branch: Branch::Open, speed: 0.0, acceleration: 0.0, gravity: FLOOR };
    let (posture, motion) = (case.posture(), case.motion());
    let right = posture.forces(&motion, &case.gravity).unwrap();
    let printed = |g: f64| {
        let mut system = posture.system(&motion, &Vector2::zeros());
        for (i, link) in posture.links.iter().enumerate() {
            system.b[3 * i + 1] -= link.mass * g;
        }
        nine(system.a, system.b).0
    };
    // At rest it is exactly the opposite: an error of 200 %.
    assert!((printed(9.81)[8] + right.driving_moment).abs() < 1e-14);
    assert!((printed(-9.81)[8] - right.driving_moment).abs() < 1e-14);
    assert!(right.driving_moment > 0.1);
    // The ground carries the weight, downwards.
    let weight = 9.81 * posture.links.iter().map(|link| link.mass).sum::<f64>();
    assert!(length(right.shaking_force() - Vector2::new(0.0, -weight)) < 1e-14);
}

#[test]
fn single_precision_differs_by_its_rounding() {
    let mut worst = 0.0_f64;
    for case in random(300) {
        let f = |x: f64| x as f32;
        let FourBarLengths { ground, crank, coupler, follower } = *case.linkage.lengths();
        let bodies = case.linkage.bodies().map(|body| PlanarBody {
            mass: f(body.mass),
            centre: body.centre.map(f),
            inertia: f(body.inertia),
        });
        let single = FourBar::new(lengths([ground, crank, coupler, follower].map(f)), bodies).unwrap();
        let crank = SinCos { sin: f(case.angle.sin()), cos: f(case.angle.cos()) };
        let posture = single.posture(&crank, case.branch).unwrap();
        let motion = posture.coefficients().unwrap().map(|k| k.motion(f(case.speed), f(case.acceleration)));
        let found = posture.forces(&motion, &case.gravity.map(f)).unwrap();
        let wanted = case.posture().forces(&case.motion(), &case.gravity).unwrap();
        let pairs: Vec<f64> = wanted.joints.iter().flat_map(|f| [f.x, f.y]).collect();
        let single: Vec<f32> = found.joints.iter().flat_map(|f| [f.x, f.y]).collect();
        worst = worst.max(crate::common::relative_error(&single, &pairs));
    }
    println!("single precision: {worst:.1e}");
    assert!(worst > 1e-8 && worst < 1e-3);
}
