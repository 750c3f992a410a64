//! Exercise 7: a slider-crank. Its closed form by the usual textbook method, compared with the general code; equations link
//! by link, energy, virtual work, dead points.
#![allow(clippy::unwrap_used, reason = "a random linkage that cannot be built should stop the test")]
#![allow(clippy::float_cmp, reason = "a guide without friction bears exactly nothing along itself")]

use crate::common::linkages::{
    Case, bodies, cases, cross, energy_rate, length, missed, nine, shaking, signed, turn, virtual_work, work_size,
};
use crate::common::relative_error;
use dynamics_core::SinCos;
use dynamics_core::linkage::{
    Branch, CrankForm, DeadPoint, Linkage, LinkageError, Member, PlanarBody, SliderCrank, SliderCrankLengths,
};
use nalgebra::Vector2;
use std::f64::consts::TAU;

fn random(count: usize) -> Vec<Case<SliderCrank<f64>>> {
    let sizes = (0.1..1.0, 0.1..1.0, signed(0.8));
    cases(count, (sizes, bodies()), |((crank, rod, offset), bodies)| {
        SliderCrank::new(SliderCrankLengths { crank, rod, offset }, bodies).ok()
    })
}

fn light(crank: f64, rod: f64, offset: f64) -> Result<SliderCrank<f64>, LinkageError<f64>> {
    let body = PlanarBody { mass: 1.0, centre: Vector2::zeros(), inertia: 0.01 };
    SliderCrank::new(SliderCrankLengths { crank, rod, offset }, [body; 3])
}

/// From the rod's angle `phi`, `l sin phi = e - r sin theta`, differentiated twice.
#[test]
fn the_closed_form_gives_the_slider_the_rod_and_all_forces() {
    let (mut motions, mut forces, mut moments) = (0.0_f64, 0.0_f64, 0.0_f64);
    for case in random(2000) {
        let SliderCrankLengths { crank: r, rod: l, offset: e } = *case.linkage.lengths();
        let [one, two, three] = *case.linkage.bodies();
        let (theta, w, a, g) = (case.angle, case.speed, case.acceleration, case.gravity);
        let ahead = if case.branch == Branch::Open { 1.0 } else { -1.0 };
        let sine = (e - r * theta.sin()) / l;
        let cosine = ahead * (1.0 - sine * sine).sqrt();
        let rod_speed = -r * w * theta.cos() / (l * cosine);
        let rod_acceleration =
            (r * w * w * theta.sin() - r * a * theta.cos() + l * rod_speed * rod_speed * sine) / (l * cosine);
        let place = r * theta.cos() + l * cosine;
        let speed = -r * w * theta.sin() - l * rod_speed * sine;
        let acceleration = -r * (a * theta.sin() + w * w * theta.cos())
            - l * (rod_acceleration * sine + rod_speed * rod_speed * cosine);

        let (posture, motion) = (case.posture(), case.motion());
        let found = [posture.links[2].outer.x, motion[1].omega, motion[2].velocity.x];
        motions = motions.max(relative_error(&found, &[place, rod_speed, speed]));
        let found = [motion[1].alpha, motion[2].acceleration.x];
        motions = motions.max(relative_error(&found, &[rod_acceleration, acceleration]));
        assert_eq!((motion[2].omega, motion[2].alpha, motion[2].acceleration.y), (0.0, 0.0, 0.0));

        // First the slider along x, then the rod about the crank pin, then link by link.
        let ex = |angle: (f64, f64), p: Vector2<f64>| {
            Vector2::new(p.x * angle.0 - p.y * angle.1, p.x * angle.1 + p.y * angle.0)
        };
        let (r1, r2) = (ex((theta.cos(), theta.sin()), one.centre), ex((cosine, sine), two.centre));
        let quarter = |v: Vector2<f64>| Vector2::new(-v.y, v.x);
        let pin = Vector2::new(theta.cos(), theta.sin()) * r;
        let a1 = quarter(r1) * a - r1 * (w * w);
        let a2 = quarter(pin) * a - pin * (w * w) + quarter(r2) * rod_acceleration - r2 * (rod_speed * rod_speed);
        let net = |body: &PlanarBody<f64>, acceleration: Vector2<f64>| (acceleration - g) * body.mass;
        let push = three.mass * (acceleration - g.x);
        let arm = Vector2::new(cosine, sine) * l;
        // arm x F_2 = -(I2 alpha2 + r2 x m2 (a2 - g)), and F_2x is known.
        let balance = -(two.inertia * rod_acceleration + cross(&r2, &net(&two, a2)));
        let f2 = Vector2::new(push, (balance + arm.y * push) / arm.x);
        let f1 = f2 + net(&two, a2);
        let f0 = f1 + net(&one, a1);
        let normal = f2.y + three.mass * g.y;
        let couple = cross(&-three.centre, &f2) + three.centre.x * normal;
        let moment = one.inertia * a + cross(&r1, &net(&one, a1)) + cross(&pin, &f1);

        let solved = posture.forces(&motion, &g).unwrap();
        let found: Vec<f64> = solved.joints.iter().flat_map(|f| [f.x, f.y]).collect();
        let wanted = [f0.x, f0.y, f1.x, f1.y, f2.x, f2.y, 0.0, normal];
        forces = forces.max(relative_error(&found, &wanted));
        let size = length(f0).max(length(f1)).max(length(f2));
        moments = moments.max((solved.driving_moment - moment).abs() / size);
        moments = moments.max((solved.guide_moment - couple).abs() / size);
    }
    println!("closed form: motion {motions:.1e}, forces {forces:.1e}, moments {moments:.1e}");
    assert!(motions < 1e-12 && forces < 1e-12 && moments < 1e-12);
}

#[test]
fn newton_and_euler_hold_for_every_link() {
    let mut worst = 0.0_f64;
    for case in random(1000) {
        let (posture, motion) = (case.posture(), case.motion());
        let forces = posture.forces(&motion, &case.gravity).unwrap();
        let largest = forces.joints.iter().map(|f| length(*f)).fold(0.0, f64::max);
        worst = worst.max(missed(&case));
        // A guide without friction.
        assert_eq!(forces.joints[3].x, 0.0);
        // 12.47, and the moment about the crank's pivot.
        let (force, moment) = shaking(&posture, &motion, &case.gravity);
        worst = worst.max(length(forces.shaking_force() - force) / largest);
        worst = worst.max((forces.shaking_moment() - moment).abs() / largest);
    }
    println!("equations: {worst:.1e}");
    assert!(worst < 1e-12);
}

#[test]
fn the_driving_moment_gives_the_power_and_does_the_virtual_work() {
    let (mut power, mut work, mut form_off) = (0.0_f64, 0.0_f64, 0.0_f64);
    for case in random(1000) {
        let (posture, motion) = (case.posture(), case.motion());
        let moment = posture.forces(&motion, &case.gravity).unwrap().driving_moment;
        let size = work_size(&posture, &motion, &case.gravity);
        power = power.max((moment * case.speed - energy_rate(&posture, &motion, &case.gravity)).abs() / size);
        let size = size / case.speed.abs();
        work = work.max((moment - virtual_work(&case)).abs() / size);
        let form = CrankForm::new(&posture, &posture.coefficients().unwrap(), &case.gravity);
        form_off = form_off.max((form.moment(case.speed, case.acceleration) - moment).abs() / size);
    }
    println!("power {power:.1e}, virtual work {work:.1e}, one coordinate {form_off:.1e}");
    // The work is over differences of positions, 2e-5 rad apart.
    assert!(power < 1e-12 && form_off < 1e-12 && work < 1e-6);
}

#[test]
fn the_determinant_is_the_run_of_the_rod() {
    for case in random(200) {
        let (posture, rod) = (case.posture(), case.linkage.lengths().rod);
        let (_, determinant) = nine(posture.system(&case.motion(), &case.gravity).a, [0.0; 9]);
        assert!((determinant.abs() - rod * posture.transmission().abs()).abs() < 1e-13);
    }
}

#[test]
fn the_slider_stays_in_its_guide_on_the_side_of_its_branch() {
    for case in random(500) {
        let SliderCrankLengths { rod, offset, .. } = *case.linkage.lengths();
        let runs = [Branch::Open, Branch::Crossed].map(|branch| {
            let [_, second, slider] = case.linkage.posture(&turn(case.angle), branch).unwrap().links;
            assert!((slider.outer.y - offset).abs() < 1e-15);
            assert!((length(second.outer - second.inner) - rod).abs() < 1e-15);
            second.outer.x - second.inner.x
        });
        assert!(runs[0] > 0.0 && (runs[0] + runs[1]).abs() < 1e-14);
    }
}

#[test]
fn the_range_is_where_positions_exist_and_ends_in_dead_points() {
    let mut ends = 0;
    for case in random(300) {
        let SliderCrankLengths { crank, rod, offset } = *case.linkage.lengths();
        let range = case.linkage.crank_range();
        for step in 0..1440 {
            let angle = TAU * f64::from(step) / 1440.0;
            let closes = case.linkage.posture(&turn(angle), case.branch);
            let within =
                range.low.is_none_or(|low| angle.sin() >= low) && range.high.is_none_or(|high| angle.sin() <= high);
            assert_eq!(closes.is_ok(), within, "{:?} at {angle}", case.linkage);
            if let Err(error) = closes {
                let gap = (offset - crank * angle.sin()).abs() - rod;
                assert!(matches!(error, LinkageError::TooFar { gap: told } if (told - gap).abs() < 1e-15), "{error}");
            }
        }
        for end in range.ends().into_iter().flatten() {
            ends += 1;
            if let Ok(posture) = case.linkage.posture(&end, case.branch) {
                assert!(posture.transmission().abs() < 1e-6);
            }
        }
        assert_eq!(range.is_full_turn(), rod >= crank + offset.abs());
    }
    assert!(ends > 300, "{ends}");
}

#[test]
fn a_rod_square_to_the_guide_is_a_dead_point() {
    // The crank points up, and the rod continues in the same direction.
    let up = SinCos { sin: 1.0, cos: 0.0 };
    let posture = light(3.0, 2.0, 5.0).unwrap().posture(&up, Branch::Open).unwrap();
    assert_eq!(posture.dead_point(), Some(DeadPoint::RodAcrossGuide));
    let error = posture.coefficients().unwrap_err();
    assert_eq!(error, LinkageError::Dead(DeadPoint::RodAcrossGuide));
    assert_eq!(error.to_string(), "dead point: the rod lies square to the guide");
    // If the rod is as long as the crank, this happens twice in a turn.
    assert!(light(2.0, 2.0, 0.0).unwrap().posture(&up, Branch::Open).unwrap().dead_point().is_some());
}

#[test]
fn at_dead_centres_the_slider_stands_at_the_ends_of_its_stroke() {
    for case in random(300).iter().filter(|case| case.linkage.crank_range().is_full_turn()) {
        let at = |crank: SinCos<f64>| case.linkage.posture(&crank, case.branch).unwrap();
        let ends = case.linkage.dead_centres(case.branch).map(|centre| at(centre.unwrap()).links[2].outer.x);
        let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        for step in 0..360 {
            let place = at(turn(TAU * f64::from(step) / 360.0)).links[2].outer.x;
            assert!(place >= low - 1e-12 && place <= high + 1e-12, "{place} in {ends:?}");
        }
        for centre in case.linkage.dead_centres(case.branch).into_iter().flatten() {
            if at(centre).transmission().abs() > 0.1 {
                let slider = at(centre).coefficients().unwrap()[2];
                assert!(slider.centre.x.abs() < 1e-12);
            }
        }
    }
}

#[test]
fn what_cannot_be_is_refused_and_named() {
    let LinkageError::NeverCloses { longest: Member::Offset, excess } = light(0.1, 0.2, -0.4).unwrap_err() else {
        unreachable!("the guide is too far away");
    };
    assert!((excess - 0.1).abs() < 1e-15);
    assert_eq!(light(0.0, 0.2, 0.0).unwrap_err(), LinkageError::Length(Member::Crank));
    assert_eq!(light(0.1, f64::NAN, 0.0).unwrap_err(), LinkageError::Length(Member::Rod));
    assert_eq!(light(0.1, 0.2, f64::INFINITY).unwrap_err().to_string(), "the offset is not finite");
}
