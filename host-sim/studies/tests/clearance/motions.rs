//! Clearances of motions: compared with closed forms, and bounds compared with dense sampling.

use dynamics_core::Model;
use dynamics_core::control::trajectory::{Bounds, FourierSpec, HARMONICS_MAX, Motion, Timing, Waypoint};
use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use robot_compiler::Robot;
use std::path::Path;
use studies::clearance::arm::{capsules, length, usual_radius};
use studies::clearance::cell::{Cell, Part, Reason};
use studies::clearance::shape::Shape;

pub(crate) fn model<const N: usize>(name: &str) -> Model<f64, N> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(name);
    Robot::load(&path).unwrap().model::<N>().unwrap()
}

pub(crate) fn links<const N: usize>(model: &Model<f64, N>, radius: f64) -> Vec<Part> {
    (0..=N).flat_map(|frame| capsules(model, frame, &format!("link {frame}"), radius)).collect()
}

pub(crate) fn block(x: f64, y: f64, z: f64, edge: f64) -> Part {
    let edges = Vector3::repeat(edge);
    Part::obstacle("box", Shape::cuboid(&Matrix3::identity(), &Vector3::new(x, y, z), &edges).unwrap())
}

fn turn<const N: usize>(from: [f64; N], to: [f64; N]) -> Motion<f64, N> {
    let points = [Waypoint::through(from), Waypoint::through(to)];
    Motion::quintic(&points, Timing::Durations(&[2.0]), &Bounds::none()).unwrap()
}

#[test]
fn a_turning_rod_passes_a_box_at_the_distance_of_the_closed_form() {
    // Two rods of 1 m, the outer one stretched: the tip moves on a circle of 2 m.
    let model = model::<2>("planar2r.toml");
    let stretch: f64 = model.links()[1].translation.norm() + model.tip().translation.norm();
    let mut parts = links(&model, 0.05);
    // A cube of 0.2 m with its nearest corner outside the circle, in the middle of the motion.
    let far = (stretch + 0.05 + 0.03) / 2.0_f64.sqrt() + 0.1;
    parts.push(block(far, far, 0.0, 0.2));
    let cell = Cell::new(&model, parts, &[0.0; 2], 0.0);
    let motion = turn([0.0, 0.0], [std::f64::consts::FRAC_PI_2, 0.0]);
    let found = cell.least(&motion, 1e-4).unwrap();
    assert!((found.found - 0.03).abs() < 1e-4 && (0.0299 - 1e-6..=0.03).contains(&found.bound), "{found:?}");
    assert!((found.time - 1.0).abs() < 0.02 && cell.names(found.pair) == ("box", "link 2"), "{found:?}");
    assert!(cell.keeps(&motion, 0.0299) && !cell.keeps(&motion, 0.0301));
    // A motion through the box.
    let motion = turn([0.0, 0.2], [std::f64::consts::FRAC_PI_2, 0.2]);
    let near = Cell::new(&model, [links(&model, 0.05), vec![block(1.2, 1.2, 0.0, 0.2)]].concat(), &[0.0; 2], 0.0);
    assert!(near.least(&motion, 1e-3).unwrap().bound < 0.0 && !near.keeps(&motion, 0.0));
}

#[test]
fn a_floor_is_met_where_the_lowest_link_is() {
    let model = model::<2>("planar2r.toml");
    let up = Vector3::new(0.0, 1.0, 0.0);
    let cell = Cell::new(&model, [links(&model, 0.05), vec![Part::floor(&up, -1.2)]].concat(), &[0.0; 2], 0.0);
    let rods = (model.links()[1].translation.norm(), model.tip().translation.norm());
    let q: [f64; 2] = [-0.2, -0.5];
    let height = rods.0 * q[0].sin() + rods.1 * (q[0] + q[1]).sin();
    let found = cell.posture(&q).unwrap();
    assert!((found.gap - (height - 0.05 + 1.2)).abs() < 1e-8, "{found:?}, {height}");
    assert_eq!(cell.names(found.pair), ("floor", "link 2"));
}

#[test]
fn an_arm_that_folds_onto_itself_is_found() {
    let model = model::<3>("planar3r.toml");
    let cell = Cell::new(&model, links(&model, 0.02), &[0.0; 3], 0.0);
    assert!(cell.exempt.contains(&("link 1".to_owned(), "link 2".to_owned(), Reason::Neighbours)));
    assert!(!cell.exempt.iter().any(|(a, b, _)| (a, b) == (&"link 1".to_owned(), &"link 3".to_owned())));
    // The third link folds back over the first.
    let folded = cell.least(&turn([0.0; 3], [0.0, 2.8, 2.8]), 1e-3).unwrap();
    assert!(folded.bound < 0.0 && cell.names(folded.pair).1 == "link 3", "{folded:?}");
    let open = cell.least(&turn([0.0; 3], [0.5, 0.3, -0.3]), 1e-3).unwrap();
    assert!(open.bound > 0.1, "{open:?}");
}

#[test]
fn links_that_overlap_at_rest_are_exempt_and_listed() {
    let model = model::<6>("yam.toml");
    let parts = links(&model, usual_radius(&model));
    let folded = Cell::new(&model, parts.clone(), &[0.0, 0.02, 0.02, 1.55, 0.0, 0.0], 0.0);
    let stretched = Cell::new(&model, parts, &[0.0, 1.5, 1.5, 0.0, 0.0, 0.0], 0.0);
    let at_rest = |cell: &Cell<6>| cell.exempt.iter().filter(|exempt| exempt.2 == Reason::OverlapAtRest).count();
    assert!(at_rest(&folded) > at_rest(&stretched), "{:?}\n{:?}", folded.exempt, stretched.exempt);
    assert!((0.6..1.6).contains(&length(&model)), "{}", length(&model));
}

fn series<const N: usize>(model: &Model<f64, N>, random: &mut dyn FnMut() -> f64) -> Motion<f64, N> {
    let mut coefficients = || -> [[f64; N]; HARMONICS_MAX] {
        core::array::from_fn(|k| core::array::from_fn(|_| if k < 4 { 0.8 * random() / (k + 1) as f64 } else { 0.0 }))
    };
    let centre = core::array::from_fn(|i| {
        let (lo, hi) = model.links()[i].limits.position;
        if lo.is_finite() && hi.is_finite() { 0.5 * (lo + hi) } else { 0.0 }
    });
    let (sine, cosine) = (coefficients(), coefficients());
    let spec = FourierSpec { centre, sine, cosine, period: 4.0, duration: 6.0, ramp: 1.0 };
    Motion::fourier(&spec, &Bounds::none()).unwrap()
}

/// Checks bounds against 20,000 samples, and that they are as tight as requested.
fn bounds_hold<const N: usize>(name: &str, seed: u64) {
    let model = model::<N>(name);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut share = move || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
    for round in 0..4 {
        let mut parts = links(&model, 0.3 * usual_radius(&model));
        let size = length(&model);
        let tool = Shape::cylinder(&Matrix3::identity(), &Vector3::new(0.0, 0.1 * size, 0.0), 0.05 * size, 0.1 * size);
        parts.push(Part::link("tool", N, tool.unwrap()));
        for _ in 0..3 {
            parts.push(block(size * share(), size * share(), size * share(), 0.1 * size));
        }
        let cell = Cell::new(&model, parts, &[0.1; N], 0.0);
        let motion = series(&model, &mut share);
        let found = cell.least(&motion, 2e-3).unwrap();
        let dense = (0..=20_000)
            .map(|k| cell.posture(&motion.sample(motion.duration() * f64::from(k) / 20_000.0).q).unwrap().gap)
            .fold(f64::INFINITY, f64::min);
        assert!(found.bound <= dense + 1e-9, "{name} {round}: {found:?} against {dense}");
        assert!(
            found.bound >= found.found - 2e-3 - 1e-9 && found.found >= dense - 1e-5,
            "{name} {round}: {found:?}, {dense}"
        );
        assert!(!cell.keeps(&motion, dense + 1e-4), "{name} {round}");
        assert!(cell.keeps(&motion, found.bound - 1e-6), "{name} {round}");
    }
}

#[test]
fn bounds_of_random_motions_hold_against_dense_sampling() {
    bounds_hold::<6>("ur5.toml", 3);
    bounds_hold::<6>("yam.toml", 4);
    bounds_hold::<6>("stanford.toml", 5);
    bounds_hold::<4>("scara.toml", 6);
}
