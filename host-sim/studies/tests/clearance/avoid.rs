//! Excitation motions that avoid a box.

use crate::motions::{block, links, model};
use dynamics_core::control::trajectory::{Bounds, FourierSpec, HARMONICS_MAX, Motion};
use dynamics_core::kinematics::tip_pose;
use dynamics_core::trig::Libm;
use dynamics_core::{Model, Trig};
use identification::arm::Chain;
use identification::base::Base;
use identification::excite::{FourierSeries, Room, SearchSettings, Subject, Workspace, excite};
use nalgebra::Vector3;
use studies::clearance::cell::Cell;

const CENTRE: [f64; 6] = [0.0, 1.2, 1.2, 0.0, 0.0, 0.0];
const SEARCH: SearchSettings = SearchSettings { harmonics: 3, period: 8.0, tries: 60, seed: 5 };
const CLEARANCE: f64 = 0.03;

struct Watched {
    cell: Cell<6>,
}

fn motion(sine: &[Vec<f64>], cosine: &[Vec<f64>]) -> Motion<f64, 6> {
    let all = |list: &[Vec<f64>]| -> [[f64; 6]; HARMONICS_MAX] {
        core::array::from_fn(|k| core::array::from_fn(|i| list.get(k).map_or(0.0, |a| a[i])))
    };
    let (sine, cosine) = (all(sine), all(cosine));
    let spec = FourierSpec { centre: CENTRE, sine, cosine, period: SEARCH.period, duration: 11.0, ramp: 1.5 };
    Motion::fourier(&spec, &Bounds::none()).unwrap()
}

impl Workspace for Watched {
    fn posture(&self, q: &[f64]) -> bool {
        self.cell.is_clear(&core::array::from_fn(|i| q[i]), CLEARANCE)
    }

    fn line(&self, _: &[f64], _: &[f64]) -> bool {
        true
    }

    fn series(&self, sine: &[Vec<f64>], cosine: &[Vec<f64>]) -> bool {
        self.cell.keeps(&motion(sine, cosine), CLEARANCE)
    }
}

fn search(model: &Model<f64, 6>, workspace: &dyn Workspace) -> Option<FourierSeries> {
    let arm = Chain::new(*model, Vector3::new(0.0, 0.0, -9.81));
    let base = Base::of(&arm);
    let beta = base.of_parameters(&arm.parameters());
    let room = Room {
        centre: CENTRE.to_vec(),
        position: CENTRE.iter().map(|q| (q - 0.8, q + 0.8)).collect(),
        velocity: vec![1.8; 6],
        acceleration: vec![6.0; 6],
        torque: vec![15.0, 15.0, 15.0, 5.0, 5.0, 5.0],
        noise: vec![0.1; 6],
    };
    excite(&Subject { arm: &arm, base: &base, beta: beta.as_slice(), workspace }, &room, &SEARCH, &|| ())
}

#[test]
fn a_box_in_the_way_is_avoided_and_without_it_the_motion_goes_through() {
    let model = model::<6>("yam.toml");
    let nothing = Watched { cell: Cell::new(&model, Vec::new(), &CENTRE, CLEARANCE) };
    let free = search(&model, &nothing).unwrap();
    let motion_of = |series: &FourierSeries| motion(&series.sine, &series.cosine);
    let through = motion_of(&free);
    // A box at the farthest point that the tip reaches from its start.
    let tip = |q: &[f64; 6]| tip_pose(&model, &Libm.sin_cos_all(q), q).translation;
    let farthest = (0..110)
        .map(|k| tip(&through.sample(0.1 * f64::from(k)).q))
        .max_by(|a, b| (a - tip(&CENTRE)).norm().total_cmp(&(b - tip(&CENTRE)).norm()))
        .unwrap();
    let with = |obstacles: Vec<_>| Cell::new(&model, [links(&model, 0.03), obstacles].concat(), &CENTRE, CLEARANCE);
    let cell = with(vec![block(farthest.x, farthest.y, farthest.z, 0.12)]);
    let hit = cell.least(&through, 1e-3).unwrap();
    assert!(hit.bound < -0.02 && cell.names(hit.pair).0 == "box", "{hit:?}");
    let start = cell.posture(&CENTRE).unwrap();
    assert!(start.gap > CLEARANCE, "{start:?} {:?}", cell.names(start.pair));
    let kept = search(&model, &Watched { cell: cell.clone() }).unwrap();
    let least = cell.least(&motion_of(&kept), 1e-4).unwrap();
    assert!(least.found >= CLEARANCE && least.bound >= CLEARANCE - 1e-4, "{least:?}");
    // It still moves, but with less information than without the box.
    assert!(kept.information < free.information && kept.condition < 200.0, "{kept:?}");
    // With a box around the arm itself, no motion is found.
    let inside = tip(&CENTRE);
    let blocked = Watched { cell: with(vec![block(inside.x, inside.y, inside.z, 0.2)]) };
    assert!(search(&model, &blocked).is_none());
}
