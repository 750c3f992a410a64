//! Torque error in single precision: the proven bound holds in every evaluated state, and a wrong proof is detected.

#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "tests")]

#[path = "../../../../robot-compiler/tests/common/wrong_rounding.rs"]
mod wrong_rounding;

use dynamics_core::trig::Polynomial;
use dynamics_core::{SinCos, Trig};
use indicatif::ProgressBar;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use robot_compiler::kernel::Level;
use robot_compiler::precision::{Double, Rounding, Single};
use robot_compiler::{Robot, SceneFile};
use std::path::Path;
use studies::bound::{Bounds, Effort, Region, TRIG_ERROR, TorqueError, random_states, search};
use studies::posture_search::positions;
use wrong_rounding::{FreeProducts, QuarterUnit};

const TOP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A shipped arm in its default scene, and its region of all states within limits.
fn arm<const N: usize>(name: &str, level: Level) -> (TorqueError<N>, Region<N>) {
    let robot = Robot::load(&Path::new(TOP).join(format!("robots/{name}.toml"))).unwrap();
    let file = SceneFile::default_for(robot);
    let model = file.robot.model::<N>().unwrap();
    let limits = model.links().map(|link| link.limits);
    let position = model.links().map(|link| positions(link.kind, link.limits.position).unwrap());
    let velocity = limits.map(|limits| limits.velocity);
    let region = Region::new(position, velocity, velocity.map(|speed| 5.0 * speed));
    (TorqueError::new(&model, &file.scene(&model), &file.live(&model), level), region)
}

fn proven<R: Rounding, const N: usize>(bounds: &Bounds<'_, R, N>, region: &Region<N>, boxes: usize) -> [f64; N] {
    bounds.everywhere(region, boxes, &ProgressBar::hidden())
}

/// Upper estimate of each joint's largest error in `thousands` of random states. It includes the error of f64 itself, which is at most f64's own
/// bound.
fn largest_error<const N: usize>(arm: &TorqueError<N>, region: &Region<N>, thousands: usize) -> [f64; N] {
    // libm's errors are below a unit in the last place.
    let of_double = arm.bounds_of::<Double>(Some((f64::EPSILON, f64::EPSILON))).over(region);
    let largest = (0..thousands)
        .into_par_iter()
        .map(|lot| {
            let mut largest = [0.0_f64; N];
            for state in random_states(region, 5, lot) {
                let (single, double) = (arm.single(&state), arm.double(&state));
                for i in 0..N {
                    let error = (f64::from(single[i]) - double[i]).abs();
                    assert!(error.is_finite());
                    largest[i] = largest[i].max(error);
                }
            }
            largest
        })
        .reduce(|| [0.0; N], |a, b| core::array::from_fn(|i| a[i].max(b[i])));
    core::array::from_fn(|i| largest[i] + of_double[i])
}

#[track_caller]
fn assert_below<const N: usize>(found: &[f64; N], bound: &[f64; N]) {
    println!("{found:?} of {bound:?}");
    assert!(found.iter().zip(bound).all(|(found, bound)| found <= bound), "{found:?} of {bound:?}");
}

#[test]
fn a_million_states_of_the_puma_stay_below_its_bound() {
    let (arm, region) = arm::<6>("puma560", Level::Exact);
    assert_below(&largest_error(&arm, &region, 1000), &proven(&arm.bounds(), &region, 2000));
}

fn thousands_stay_below<const N: usize>(name: &str, thousands: usize) {
    for level in Level::ALL {
        let (arm, region) = arm::<N>(name, level);
        assert_below(&largest_error(&arm, &region, thousands), &proven(&arm.bounds(), &region, 500));
    }
}

#[test]
fn states_of_every_shipped_arm_stay_below_its_bound_at_both_levels() {
    thousands_stay_below::<2>("planar2r", 20);
    thousands_stay_below::<3>("planar3r", 20);
    thousands_stay_below::<4>("scara", 20);
    thousands_stay_below::<6>("puma560", 5);
    thousands_stay_below::<6>("stanford", 5);
    thousands_stay_below::<6>("ur5", 5);
    thousands_stay_below::<6>("yam", 5);
    thousands_stay_below::<6>("rebot_b601_rs", 5);
}

#[test]
#[ignore = "a million states of each arm at both levels, minutes; `cargo xtask test` runs it, or cargo nextest run -p studies --run-ignored only"]
fn a_million_states_of_every_shipped_arm_stay_below_its_bound_at_both_levels() {
    thousands_stay_below::<2>("planar2r", 1000);
    thousands_stay_below::<3>("planar3r", 1000);
    thousands_stay_below::<4>("scara", 1000);
    thousands_stay_below::<6>("puma560", 1000);
    thousands_stay_below::<6>("stanford", 1000);
    thousands_stay_below::<6>("ur5", 1000);
    thousands_stay_below::<6>("yam", 200);
    thousands_stay_below::<6>("rebot_b601_rs", 200);
}

const EFFORT: Effort = Effort { samples: 4000, climbs: 4, steps: 300, seed: 1 };

#[test]
fn no_climb_on_the_error_passes_the_bound_of_its_own_state() {
    for level in Level::ALL {
        let (arm, region) = arm::<6>("puma560", level);
        let bounds = arm.bounds();
        let everywhere = proven(&bounds, &region, 500);
        // Checks every state that the climbs evaluate, not only the last ones.
        search(
            &region,
            &Effort { climbs: 2, ..EFFORT },
            &|state| {
                let (error, bound) = (arm.error(state), bounds.over(&Region::of(state)));
                for i in 0..6 {
                    assert!(error[i] <= bound[i] && bound[i] <= everywhere[i], "{state:?}: {error:?}, {bound:?}");
                }
                error
            },
            &ProgressBar::hidden(),
        );
    }
}

/// Asserts that the largest error found and the proven bound are within 5 % of these numbers.
#[track_caller]
fn assert_pinned<const N: usize>(name: &str, found: [f64; N], bound: [f64; N]) {
    let (arm, region) = arm::<N>(name, Level::Exact);
    let largest = search(&region, &EFFORT, &|state| arm.error(state), &ProgressBar::hidden()).map(|found| found.value);
    let everywhere = proven(&arm.bounds(), &region, 500);
    println!("{name}: {largest:?} {everywhere:?}");
    assert_below(&largest, &everywhere);
    for (measured, written) in largest.iter().zip(found).chain(everywhere.iter().zip(bound)) {
        assert!((measured / written - 1.0).abs() < 0.05, "{name}: {measured:e}, not {written:e}");
    }
}

#[test]
fn found_and_proven_of_two_rods_are_the_stated_ones() {
    assert_pinned("planar2r", [6.82e-5, 1.15e-5], [2.41e-4, 2.34e-5]);
}

#[test]
fn found_and_proven_of_the_puma_are_the_stated_ones() {
    assert_pinned(
        "puma560",
        [1.20e-5, 1.91e-5, 5.06e-6, 5.53e-7, 5.89e-7, 6.74e-7],
        [4.51e-4, 3.23e-4, 1.05e-4, 1.63e-6, 1.41e-6, 6.90e-7],
    );
}

#[test]
fn found_and_proven_of_the_ur5_are_the_stated_ones() {
    assert_pinned(
        "ur5",
        [2.83e-5, 3.86e-5, 1.24e-5, 1.70e-6, 3.83e-7, 1.82e-9],
        [9.73e-4, 9.98e-4, 3.55e-4, 4.79e-5, 9.54e-6, 2.64e-8],
    );
}

#[test]
fn cutting_boxes_only_lowers_the_bound_and_holds_for_each_part() {
    let (arm, region) = arm::<6>("puma560", Level::Exact);
    let bounds = arm.bounds();
    let mut last = bounds.over(&region);
    for boxes in [1, 100, 400] {
        let next = proven(&bounds, &region, boxes);
        assert_below(&next, &last);
        last = next;
    }
    assert!(last[0] < 0.997 * bounds.over(&region)[0], "{last:?}");
}

/// Number of states, out of some thousand of the two-rod arm, in which the bound for the state fails.
fn failures<R: Rounding>(trig: Option<(f64, f64)>) -> usize {
    let (arm, region) = arm::<2>("planar2r", Level::Exact);
    let bounds = arm.bounds_of::<R>(trig);
    (0..4)
        .flat_map(|lot| random_states(&region, 3, lot))
        .filter(|state| {
            let (error, bound) = (arm.error(state), bounds.over(&Region::of(state)));
            error.iter().zip(bound).any(|(error, bound)| *error > bound)
        })
        .count()
}

#[test]
fn a_bound_that_is_too_small_is_caught() {
    assert_eq!(failures::<Single>(None), 0);
    let quarter_unit = [failures::<QuarterUnit>(None), failures::<QuarterUnit>(Some((0.0, 0.0)))];
    let others = [failures::<FreeProducts>(Some((0.0, 0.0))), failures::<Single>(Some((0.0, 0.0)))];
    println!("{quarter_unit:?} {others:?}");
    assert!(quarter_unit[0] > 0 && others[0] > 0 && others[1] > 0, "{quarter_unit:?} {others:?}");
}

#[test]
fn the_errors_of_sine_and_cosine_are_those_of_the_polynomials() {
    for (limit, sin_error, cos_error) in TRIG_ERROR {
        let mut worst = [0.0_f64; 2];
        for k in 0..2_000_000 {
            let angle = (limit * f64::from(k) / 2e6) as f32;
            let SinCos { sin, cos } = Polynomial.sin_cos(angle);
            let (exact_sin, exact_cos) = libm::sincos(f64::from(angle));
            worst[0] = worst[0].max((f64::from(sin) - exact_sin).abs());
            worst[1] = worst[1].max((f64::from(cos) - exact_cos).abs());
        }
        assert!(worst[0] <= sin_error && worst[1] <= cos_error, "{limit}: {worst:?}");
        assert!(worst[0] > 0.9 * sin_error && worst[1] > 0.9 * cos_error, "{limit}: {worst:?}");
    }
}

#[test]
fn threads_do_not_change_what_is_found() {
    let (arm, region) = arm::<3>("planar3r", Level::Exact);
    let effort = Effort { samples: 5000, steps: 100, ..EFFORT };
    let look = || search(&region, &effort, &|state| arm.error(state), &ProgressBar::hidden());
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(look);
    let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap().install(look);
    assert_eq!(alone, three);
}
