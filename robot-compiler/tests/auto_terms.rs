//! `terms = "auto"`: the fewest terms that keep a tolerance, the same for desk, firmware and hash.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]
#![allow(clippy::float_cmp, reason = "a tolerance from a file must come through unchanged")]

use dynamics_core::control::ControlLaw;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Term, Trig};
use nalgebra::Vector3;
use robot_compiler::choose::{Along, LoopGain};
use robot_compiler::scene::ModelTerm;
use robot_compiler::{SceneFile, emit, with_dof};
use std::path::Path;

use crate::common::top;

const AUTO: &str = "scenes/puma560_auto.toml";

/// The shipped scene with another tolerance, and some of its text replaced.
fn auto(tolerance: f64, replaced: &[(&str, &str)]) -> SceneFile {
    let mut text = std::fs::read_to_string(top(AUTO)).unwrap();
    let tolerance = format!("tolerance = {tolerance:?}");
    for (old, new) in [("tolerance = 0.002", tolerance.as_str())].iter().chain(replaced) {
        assert!(text.contains(old), "{old} is not in the scene");
        text = text.replace(old, new);
    }
    SceneFile::from_toml_str(&text, &top(AUTO)).unwrap()
}

fn given_up(scene: &SceneFile) -> Vec<ModelTerm> {
    let kept = scene.model.terms();
    scene.model.full().terms().into_iter().filter(|term| !kept.contains(term)).collect()
}

#[test]
fn the_full_model_is_everything_in_the_plant() {
    let scene = auto(0.0, &[]);
    let full = scene.model.full();
    assert_eq!(full.gravity, Term::Constant(Vector3::new(0.0, 0.0, -9.81)));
    assert_eq!(full.payload, Term::Constant(scene.plant.payload.unwrap()));
    assert_eq!(full.tip_wrench, Term::Constant(scene.plant.tip_wrench.unwrap()));
    assert_eq!((full.rotor, full.coriolis.clone(), full.friction), (Term::Constant(()), Term::Live, true));
    let plant = ("[plant]\n", "[plant]\ngravity = \"absent\"\nfriction = false\n");
    let scene = auto(0.0, &[plant, ("tip_wrench = {", "start = [0, 0.9, -1.6, 0, 0.5, 0]\n# {")]);
    let full = scene.model.full();
    assert_eq!((full.gravity, full.tip_wrench, full.friction), (Term::Absent, Term::Absent, false));
}

#[test]
fn a_wider_tolerance_never_keeps_more_and_ends_with_the_rotors() {
    let mut last = 0;
    for tolerance in [0.0, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.5] {
        let scene = auto(tolerance, &[]);
        let gone = given_up(&scene).len();
        assert!(gone >= last, "{tolerance}: {gone} terms go, {last} with less");
        last = gone;
    }
    // Without rotors the flange would have almost no loop gain, whatever the torque error.
    assert_eq!(last, 5);
    assert_eq!(auto(0.5, &[]).model.terms(), [ModelTerm::Rotors]);
    assert_eq!(given_up(&auto(0.0, &[])), []);
}

#[test]
fn what_is_left_keeps_the_tolerance_and_no_other_set_is_smaller() {
    let whole = auto(0.0, &[]);
    let model = whole.robot.model::<6>().unwrap();
    let along = Along::new(&whole, &model).unwrap();
    // Computed here from the error and the operations of every set.
    let terms =
        |set: usize| -> Vec<ModelTerm> { (0..6).filter(|i| set & (1 << i) != 0).map(|i| ModelTerm::ALL[i]).collect() };
    let errors: Vec<f64> = (0..64).map(|set| along.error_without(&terms(set)).worst_share()).collect();
    let operations: Vec<usize> = (0..64).map(|set| along.operations_without(&terms(set)).total()).collect();
    let gains: Vec<f64> = (0..64).map(|set| along.loop_gain_without(&terms(set)).least).collect();
    for tolerance in [1e-3, 3e-3, 1e-2, 3e-2] {
        let gone = given_up(&auto(tolerance, &[]));
        let chosen = (0..64).find(|&set| terms(set) == gone).unwrap();
        assert!(errors[chosen] <= tolerance, "{tolerance}: {}", errors[chosen]);
        // No set needs fewer operations, unless its errors cancel and a part of it alone exceeds the tolerance, or it
        // removes half of the feedback.
        let may_go = |set: usize| {
            let mut parts = (1..64).filter(|part| part & set == *part);
            parts.all(|part| errors[part] <= tolerance && gains[part] >= LoopGain::LEAST)
        };
        for set in (0..64).filter(|&set| may_go(set)) {
            assert!(operations[set] >= operations[chosen], "{tolerance}: {:?} before {gone:?}", terms(set));
        }
    }
}

#[test]
fn the_tolerance_is_felt_from_both_sides() {
    // With a tolerance equal to the error of a term, the term may be dropped; just below, it may not.
    let scene = auto(0.0, &[]);
    let model = scene.robot.model::<6>().unwrap();
    let along = Along::new(&scene, &model).unwrap();
    let errors = ModelTerm::ALL.map(|term| along.error_without(&[term]).worst_share());
    let (term, error) = ModelTerm::ALL.into_iter().zip(errors).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!(error > 0.0);
    assert_eq!(given_up(&auto(error * (1.0 + 1e-9), &[])), [term]);
    assert_eq!(given_up(&auto(error * (1.0 - 1e-9), &[])), []);
}

#[test]
fn a_scene_that_says_the_same_terms_is_the_same_to_desk_chip_and_hash() {
    let chosen = SceneFile::load(&top(AUTO)).unwrap();
    assert!(!given_up(&chosen).is_empty() && !chosen.model.terms().is_empty(), "{:?}", chosen.model.terms());
    let mut said = chosen.clone();
    said.model.auto = None;
    with_dof!(chosen.robot.dof(), N => {
        let model = chosen.robot.model::<N>().unwrap();
        assert_eq!(chosen.hash(&model), said.hash(&model));
        assert_eq!(emit::arm_module(&chosen, &model), emit::arm_module(&said, &model));
        assert_eq!(emit::dynamics_module(&chosen, &model), emit::dynamics_module(&said, &model));
        let mut full = chosen.clone();
        full.model = chosen.model.full().clone();
        assert_ne!(chosen.hash(&model), full.hash(&model));
        assert_ne!(emit::dynamics_module(&chosen, &model), emit::dynamics_module(&full, &model));
        // The motion does not depend on the chosen terms.
        assert_eq!(chosen.trajectory(&model).unwrap(), full.trajectory(&model).unwrap());
    });
}

#[test]
fn a_motion_without_durations_is_made_with_every_term() {
    let fast = [("], duration = 2.5 }", "] }")];
    let (none, all) = (auto(0.0, &fast), auto(0.5, &fast));
    assert!(all.model.terms() == [ModelTerm::Rotors] && none.model.terms().len() == 6);
    let model = none.robot.model::<6>().unwrap();
    assert_eq!(none.trajectory(&model).unwrap(), all.trajectory(&model).unwrap());
}

#[test]
fn standing_still_no_velocity_term_is_needed_and_rotors_for_the_loop_alone() {
    let text = std::fs::read_to_string(top(AUTO)).unwrap();
    let (head, tail) = (text.split("[motion]").next().unwrap(), text.split("[plant]").nth(1).unwrap());
    let hold = "[motion]\nkind = \"hold\"\nq = [0.0, 0.9, -1.6, 0.0, 0.5, 0.0]\nduration = 1.0\n";
    let text = format!("{head}{hold}[plant]{tail}").replace("tolerance = 0.002", "tolerance = 0");
    let scene = SceneFile::from_toml_str(&text, &top(AUTO)).unwrap();
    assert_eq!(given_up(&scene), [ModelTerm::VelocityTerms, ModelTerm::Friction]);
    // The rotors need no torque here, but are most of the inertia.
    let model = scene.robot.model::<6>().unwrap();
    let along = Along::new(&scene, &model).unwrap();
    assert_eq!(along.error_without(&[ModelTerm::Rotors]).worst_share(), 0.0);
    assert!(along.loop_gain_without(&[ModelTerm::Rotors]).is_too_weak());
}

#[test]
fn a_line_is_found_where_the_file_says_the_key() {
    let scene = SceneFile::load(&top(AUTO)).unwrap();
    let text = std::fs::read_to_string(top(AUTO)).unwrap();
    let line = text.lines().position(|line| line.starts_with("terms")).unwrap() + 1;
    assert_eq!(scene.line_of("model", "terms"), Some(line));
    assert_eq!((scene.line_of("model", "gravity"), scene.line_of("nothing", "gravity")), (None, None));
    let nowhere = SceneFile { path: Path::new("").to_path_buf(), ..scene };
    assert_eq!(nowhere.line_of("model", "terms"), None);
}

#[test]
fn without_rotors_the_flange_has_next_to_no_loop_gain_and_they_stay() {
    let scene = auto(0.003, &[]);
    let model = scene.robot.model::<6>().unwrap();
    let along = Along::new(&scene, &model).unwrap();
    // By the torque error alone they could be dropped.
    assert!(along.error_without(&[ModelTerm::Rotors]).worst_share() < 0.003);
    let gain = along.loop_gain_without(&[ModelTerm::Rotors]);
    assert_eq!((gain.joint, gain.is_too_weak()), (5, true), "{gain:?}");
    assert!(!given_up(&scene).contains(&ModelTerm::Rotors));
    assert_eq!(along.fewest_terms(0.003).loop_gain.least, along.loop_gain_without(&given_up(&scene)).least);
    // If only the flange moves, the loop gain without rotors is the flange's own inertia divided by the whole.
    let by_hand = {
        let full = Dynamics::new(model, scene.model.full().scene(&model));
        let q: [f64; 6] = scene.motion.start().try_into().unwrap();
        let matrix = mass_matrix(&full, &Libm.sin_cos_all(&q), &q, &scene.live(&model));
        (matrix[(5, 5)] - model.links()[5].rotor) / matrix[(5, 5)]
    };
    // Measured: 2.02e-4. The eigenvalue is at most any joint's own ratio, and near that of the named joint.
    assert!(gain.least <= by_hand && gain.least > 0.9 * by_hand, "{gain:?}, {by_hand}");
}

#[test]
fn only_inertia_bears_on_the_loop_gain_and_more_of_it_left_out_weakens_it() {
    let scene = auto(0.0, &[]);
    let model = scene.robot.model::<6>().unwrap();
    let along = Along::new(&scene, &model).unwrap();
    let least = |terms: &[ModelTerm]| along.loop_gain_without(terms).least;
    for term in [ModelTerm::Gravity, ModelTerm::TipWrench, ModelTerm::VelocityTerms, ModelTerm::Friction] {
        assert_eq!(along.loop_gain_without(&[term]), LoopGain::FULL);
    }
    let [payload, rotors] = [ModelTerm::Payload, ModelTerm::Rotors].map(|term| least(&[term]));
    let both = least(&[ModelTerm::Payload, ModelTerm::Rotors]);
    assert!(0.0 < both && both < rotors && rotors < payload && payload < 1.0, "{both}, {rotors}, {payload}");
    // A law with fixed inertias loses the dropped term in these inertias: at the start, joint by joint.
    let mut fixed = scene.clone();
    fixed.control.law = ControlLaw::PdGravity;
    let lost = Along::new(&fixed, &model).unwrap().loop_gain_without(&[ModelTerm::Rotors]);
    let inertia = |scene: &SceneFile| scene.controller_config(&model).gains.map(|gains| gains.inertia);
    let mut without = fixed.clone();
    without.model = fixed.model.full().without(&[ModelTerm::Rotors]);
    let (full, less) = (inertia(&fixed), inertia(&without));
    let ratio = (0..6).map(|i| less[i] / full[i]).fold(f64::INFINITY, f64::min);
    assert!((lost.least - ratio).abs() < 1e-12, "{lost:?}, {ratio}");
}
