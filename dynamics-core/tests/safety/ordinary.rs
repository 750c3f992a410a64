//! An ordinary tick is decided by one comparison a rule. The result must equal that of the exact rules.

use crate::safety::support::*;
use dynamics_core::safety::{Inputs, Protected, Request, State};
use dynamics_core::{Command, Reference, Sensed};
use proptest::prelude::*;
use std::cell::Cell;

/// Ranges of a joint: about zero, on one side of it, far from it, without ends, with one end.
const RANGES: [(f32, f32); 6] = [
    (-2.0, 2.0),
    (0.3, 2.9),
    (1000.0, 1004.0),
    (-0.6, -0.1),
    (f32::NEG_INFINITY, f32::INFINITY),
    (-2.0, f32::INFINITY),
];

fn with_ranges(ranges: [(f32, f32); 2]) -> Protected<f32, 2> {
    let mut protected = config();
    for (limits, range) in protected.control.limits.iter_mut().zip(ranges) {
        limits.position = range;
    }
    protected
}

/// One joint: position of the joint and its reference, measured from the end of its range at which they could just stop.
#[derive(Clone, Copy, Debug)]
struct Joint {
    range: (f32, f32),
    q: f32,
    qd: f32,
    reference: [f32; 3],
}

fn distance(v: f32) -> f32 {
    v * v / (2.0 * DECELERATION) + v.abs() * LATENCY
}

fn joint() -> impl Strategy<Value = Joint> {
    let number = |size: f32| prop_oneof![-size..size, Just(0.0), -1e-6_f32..1e-6];
    let special =
        prop_oneof![30 => -20.0_f32..20.0, 1 => Just(f32::NAN), 1 => Just(f32::INFINITY), 1 => Just(f32::MAX)];
    // Within about a rounding error of the exact end, in a wider surrounding, and anywhere.
    let from_end = prop_oneof![-9e-7_f32..9e-7, -3e-5_f32..3e-5, -0.2_f32..0.2, -4.0_f32..0.0];
    let ends = (any::<bool>(), any::<bool>());
    (0..RANGES.len(), from_end.clone(), number(6.5), from_end, number(3.2), special, ends).prop_map(
        |(kind, arm, qd, target, speed, qdd, (high, near))| {
            let range @ (lo, hi) = RANGES[kind];
            let side = if high { 1.0 } else { -1.0 };
            let end = if high { hi } else { lo };
            let end = if end.is_finite() { end } else { side * 2.0 };
            let last = |speed: f32, margin: f32, from: f32| {
                let towards = if speed * side > 0.0 { distance(speed) } else { 0.0 };
                end + side * (margin - towards + from)
            };
            let reference = last(speed, 0.0, target);
            let q = if near { reference + arm.clamp(-0.25, 0.25) } else { last(qd, MARGIN, arm) };
            Joint { range, q, qd, reference: [reference, speed, qdd] }
        },
    )
}

/// State and output of a running machine after its next tick: without a request, or with a request that is not possible while the arm runs, so
/// that the exact rules decide.
fn next(joints: [Joint; 2], request: Option<Request>) -> (Machine, Said, bool) {
    let mut machine = Machine::new(with_ranges(joints.map(|joint| joint.range)));
    // Within a jump of the position in the tick, and inside the range.
    let start = joints.map(|joint| joint.q.clamp(joint.range.0 + 0.1, joint.range.1 - 0.1));
    for asked in [None, Some(Request::Home), Some(Request::Confirm), Some(Request::Arm), Some(Request::Run), None] {
        let inputs = Inputs { request: asked, ..calm(start) };
        assert_eq!(machine.tick(&inputs, |_| wanting(1.0)).refused, None, "{asked:?} at {start:?}");
        arm(&mut machine, start);
    }
    let at = |i: usize| joints.map(|joint| joint.reference[i]);
    let inputs = Inputs {
        request,
        sensed: Sensed::State { q: joints.map(|joint| joint.q), qd: joints.map(|joint| joint.qd) },
        reference: Some(Reference { q: at(0), qd: at(1), qdd: at(2) }),
        ..calm(start)
    };
    let ordinary = Cell::new(false);
    let output = machine.tick(&inputs, |ask| {
        ordinary.set(ask.ordinary);
        Command::Drive { torque: ask.reference.q, limits: [Default::default(); 2] }
    });
    (machine, output, ordinary.get())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn an_ordinary_tick_is_what_the_exact_rules_make_of_it(a in joint(), b in joint()) {
        let (machine, output, ordinary) = next([a, b], None);
        let (exact, said, never) = next([a, b], Some(Request::Confirm));
        prop_assert!(!never);
        // Compared as debug texts, in which a NaN equals itself.
        prop_assert_eq!(format!("{:?}", machine), format!("{:?}", exact));
        prop_assert_eq!(Said { refused: None, ..output }, Said { refused: None, ..said });
        if ordinary {
            prop_assert_eq!(output.state, State::Running);
            for Joint { range: (lo, hi), reference: [q, qd, qdd], .. } in [a, b] {
                prop_assert!(lo <= q && q <= hi && qd.abs() <= 3.0 && qdd.is_finite(), "a limit would act");
            }
        }
    }
}

/// Counts the ordinary states in a grid: nearly all states inside the bounds, and none of the others.
#[test]
fn nearly_every_state_inside_is_ordinary_and_none_outside_is() {
    let (mut inside, mut missed) = (0, 0);
    for range in [RANGES[0], RANGES[1], RANGES[2], RANGES[3], RANGES[4]] {
        let (lo, hi) = if range.0.is_finite() { range } else { (-2.0, 2.0) };
        for step in 1..100 {
            let q = lo + (hi - lo) * step as f32 / 100.0;
            for qd in [-2.9, -1.0, 0.0, 0.5, 2.0] {
                let joint = Joint { range, q, qd, reference: [q, qd, 1.0] };
                let room = if qd > 0.0 { hi - q } else { q - lo };
                let stops = range.0.is_infinite() || distance(qd) < room - 1e-3 * (1.0 + 1e-3 * q.abs());
                let (_, _, ordinary) = next([joint; 2], None);
                match (stops, ordinary) {
                    (true, _) => (inside, missed) = (inside + 1, missed + usize::from(!ordinary)),
                    (false, ordinary) => {
                        assert!(!ordinary || distance(qd) <= room, "{joint:?}");
                    }
                }
            }
        }
    }
    assert!(inside > 1500 && missed == 0, "{missed} of {inside}");
    // For a range with only one end the exact rules always decide.
    assert!(!next([Joint { range: RANGES[5], q: 0.0, qd: 0.0, reference: [0.0; 3] }; 2], None).2);
}
