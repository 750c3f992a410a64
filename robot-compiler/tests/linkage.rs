//! The shipped linkages.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]
#![allow(clippy::float_cmp, reason = "numbers from a file must come through unchanged")]
#![allow(clippy::panic, reason = "a test names the file that fails")]

use dynamics_core::linkage::{Grashof, Linkage};
use nalgebra::Vector2;
use robot_compiler::{LinkageFile, Mechanism, Robot, SceneFile};
use std::path::PathBuf;

use crate::common::{files, top};

#[test]
fn every_linkage_loads_names_its_source_and_turns_fully() {
    // Arms are in the same folder; only a linkage file has a key `kind`.
    let says_its_kind =
        |path: &PathBuf| std::fs::read_to_string(path).unwrap().lines().any(|line| line.starts_with("kind = "));
    let all = files(&top("robots/chapter12"), &["toml"]).into_iter().filter(says_its_kind);
    let linkages: Vec<LinkageFile> =
        all.map(|path| LinkageFile::load(&path).unwrap_or_else(|error| panic!("{error}"))).collect();
    let names: Vec<&str> = linkages.iter().map(|linkage| linkage.name.as_str()).collect();
    assert_eq!(names, ["example 324", "exercise 7"]);
    assert_eq!([0, 1].map(|i| linkages[i].mechanism.kind()), ["four-bar", "slider-crank"]);
    for linkage in linkages {
        assert!(linkage.source.len() > 20 && linkage.gravity == Vector2::new(0.0, -9.81), "{}", linkage.name);
        assert!(linkage.mechanism.crank_range().is_full_turn(), "{}", linkage.name);
    }
}

#[test]
fn numbers_come_through_and_rods_are_uniform() {
    let linkage = LinkageFile::load(&top("robots/chapter12/four_bar.toml")).unwrap();
    let Mechanism::FourBar(four_bar) = linkage.mechanism else { panic!("{linkage:?}") };
    assert_eq!(four_bar.class(), Grashof::CrankRocker);
    let lengths = four_bar.lengths();
    assert_eq!((lengths.ground, lengths.crank, lengths.coupler, lengths.follower), (0.40, 0.12, 0.36, 0.30));
    for (body, length) in four_bar.bodies().iter().zip([0.12, 0.36, 0.30]) {
        assert!((body.mass - 2.0 * length).abs() < 1e-15 && (body.centre.x - 0.5 * length).abs() < 1e-15);
        assert!((body.inertia - body.mass * length * length / 12.0).abs() < 1e-15);
    }
}

#[test]
fn a_linkage_without_gravity_or_offset_hangs_upright_on_the_axis() {
    let body = "mass = 1.0\ncom = [0.0, 0.0]\n";
    let text = format!(
        "kind = \"slider-crank\"\nname = \"x\"\n[crank]\nlength = 0.1\n{body}[rod]\nlength = 0.3\n{body}[slider]\n{body}"
    );
    let linkage = LinkageFile::from_toml_str(&text, "x.toml").unwrap();
    let Mechanism::SliderCrank(slider_crank) = linkage.mechanism else { panic!("{linkage:?}") };
    assert_eq!((linkage.gravity, slider_crank.lengths().offset), (Vector2::new(0.0, -9.81), 0.0));
    assert_eq!(slider_crank.bodies()[1].inertia, 0.0);
}

#[test]
fn arms_and_scenes_say_what_takes_a_linkage() {
    let path = top("robots/chapter12/four_bar.toml");
    let (arm, scene) = (Robot::load(&path).unwrap_err(), SceneFile::load(&path).unwrap_err());
    for error in [arm, scene] {
        assert_eq!((error.field(), error.problem()), ("kind", "this file describes a closed loop"));
        assert!(error.expected().ends_with("`newtau model linkage` takes this one"), "{}", error.expected());
    }
}
