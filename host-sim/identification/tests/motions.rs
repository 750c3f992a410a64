//! Excitation motions.

use crate::arms::load;
use identification::base::Base;
use identification::excite::{Room, SearchSettings, Subject, Workspace, excite, postures};

/// A workspace in which everything is free, or nothing is.
struct Workroom(bool);

impl Workspace for Workroom {
    fn posture(&self, _: &[f64]) -> bool {
        self.0
    }

    fn line(&self, _: &[f64], _: &[f64]) -> bool {
        self.0
    }

    fn series(&self, _: &[Vec<f64>], _: &[Vec<f64>]) -> bool {
        self.0
    }
}

fn room() -> Room {
    Room {
        centre: vec![0.0, 1.2, 1.2, 0.0, 0.0, 0.0],
        position: vec![(-1.0, 1.0), (0.2, 2.2), (0.2, 2.2), (-1.0, 1.0), (-1.0, 1.0), (-1.0, 1.0)],
        velocity: vec![1.8; 6],
        acceleration: vec![6.0; 6],
        torque: vec![15.0, 15.0, 15.0, 5.0, 5.0, 5.0],
        noise: vec![0.1; 6],
    }
}

#[test]
fn a_motion_keeps_its_limits_is_the_same_for_a_seed_and_better_for_more_tries() {
    let known = load("yam.toml");
    let base = Base::of(known.arm.as_ref());
    let beta = base.of_parameters(&known.parameters);
    let subject = Subject { arm: known.arm.as_ref(), base: &base, beta: beta.as_slice(), workspace: &Workroom(true) };
    let search = SearchSettings { harmonics: 4, period: 8.0, tries: 40, seed: 5 };
    let first = excite(&subject, &room(), &search, &|| ()).unwrap();
    assert_eq!(first, excite(&subject, &room(), &search, &|| ()).unwrap());
    let more = excite(&subject, &room(), &SearchSettings { tries: 200, ..search }, &|| ()).unwrap();
    assert!(more.information > first.information && more.condition < 50.0, "{more:?}");
    for joint in 0..6 {
        for step in 0..800 {
            let at = std::f64::consts::TAU * f64::from(step) / 800.0;
            let wave = |k: usize| {
                let (sin, cos) = ((k + 1) as f64 * at).sin_cos();
                more.sine[k][joint] * sin + more.cosine[k][joint] * cos
            };
            let q = room().centre[joint] + (0..4).map(wave).sum::<f64>();
            let (lo, hi) = room().position[joint];
            assert!(q > lo && q < hi, "joint {joint}: {q}");
        }
    }
}

#[test]
fn no_motion_is_found_where_no_posture_is_allowed() {
    let known = load("yam.toml");
    let base = Base::of(known.arm.as_ref());
    let beta = base.of_parameters(&known.parameters);
    let subject = Subject { arm: known.arm.as_ref(), base: &base, beta: beta.as_slice(), workspace: &Workroom(false) };
    assert!(
        excite(&subject, &room(), &SearchSettings { harmonics: 3, period: 8.0, tries: 5, seed: 1 }, &|| ()).is_none()
    );
    assert_eq!(postures(&subject, &room(), 4, 1, &|| ()).len(), 1);
}
