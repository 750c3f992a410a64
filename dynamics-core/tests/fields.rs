//! Visitors visit every field of a configuration once, in the order of declaration, and a cast rounds each number.

use dynamics_core::control::{ControlLaw, Encoder, Friction, Gains, Guard, Integral, Teach, TrackingObserver};
use dynamics_core::fields::{Fields, Group, Visitor};
use dynamics_core::{ControllerConfig, Limits, Real};
use std::fmt::Debug;

/// A configuration with all numbers different, and none of them exact in f32.
fn config() -> ControllerConfig<f64, 2> {
    let x = |n: i32| f64::from(n) + 0.1;
    ControllerConfig {
        law: ControlLaw::Feedforward,
        gains: [1, 4].map(|n| Gains { position: x(n), velocity: x(n + 1), inertia: x(n + 2) }),
        friction: Some([7, 10].map(|n| Friction { viscous: x(n), coulomb: x(n + 1), per_smoothing_speed: x(n + 2) })),
        limits: [13, 18].map(|n| Limits {
            position: (x(n), x(n + 1)),
            velocity: x(n + 2),
            torque: x(n + 3),
            torque_rate: x(n + 4),
        }),
        torque_step: [23, 24].map(x),
        guard: [25, 27].map(|n| Guard { position_margin: x(n), velocity_max: x(n + 1) }),
        age_max: u32::MAX,
        encoder: [29, 30].map(|n| Encoder { zero: -n, per_count: x(n) }),
        observer: TrackingObserver::from_gains(x(31), x(32), x(33), x(34)),
        integral: Some([35, 39].map(|n| Integral {
            gain: x(n),
            torque_max: x(n + 1),
            dead_band: x(n + 2),
            friction: x(n + 3),
        })),
        teach: Some([43, 55].map(|n| Teach {
            friction: x(n),
            per_still_speed: x(n + 1),
            breakaway: x(n + 2),
            slip: x(n + 3),
            drag: x(n + 4),
            speed: x(n + 5),
            wall: (x(n + 6), x(n + 7)),
            per_wall: x(n + 8),
            stiffness: x(n + 9),
            damping: x(n + 10),
            slowing: x(n + 11),
        })),
        posture_damping: Some(x(67)),
    }
}

/// The visited parts as text, and the numbers separately.
#[derive(Default)]
struct ObservedState {
    text: String,
    numbers: Vec<f64>,
}

impl<S: Real + Debug> Visitor<S> for ObservedState {
    fn number(&mut self, x: S) {
        self.text += &format!("{x:?} ");
        self.numbers.push(x.to_f64());
    }

    fn integer(&mut self, x: i64) {
        self.text += &format!("{x} ");
    }

    fn word(&mut self, kind: &'static str, name: &'static str, number: u32) {
        self.text += &format!("{kind}::{name}={number} ");
    }

    fn option(&mut self, value: Option<&impl Fields<S>>) {
        self.text += if value.is_some() { "some " } else { "none " };
        if let Some(value) = value {
            value.visit(self);
        }
    }

    fn group(&mut self, group: Group, parts: impl FnOnce(&mut Self)) {
        self.text += &match group {
            Group::Record(name) => format!("{name}{{"),
            Group::Call(function) => format!("{function}("),
            Group::Tuple => "(".to_owned(),
            Group::List => "[".to_owned(),
        };
        parts(self);
        self.text += ". ";
    }

    fn field(&mut self, name: &'static str, value: &impl Fields<S>) {
        self.text += &format!("{name}:");
        value.visit(self);
    }
}

fn seen<S: Real + Debug>(of: &impl Fields<S>) -> ObservedState {
    let mut seen = ObservedState::default();
    of.visit(&mut seen);
    seen
}

#[test]
fn a_visitor_sees_every_field_by_name_in_the_order_of_declaration() {
    let text = seen(&config()).text;
    let start =
        "ControllerConfig{law:ControlLaw::Feedforward=3 gains:[Gains{position:1.1 velocity:2.1 inertia:3.1 . Gains{";
    assert!(text.starts_with(start), "{text}");
    let middle = "friction:some [Friction{viscous:7.1 coulomb:8.1 per_smoothing_speed:9.1 . ";
    let limits = "limits:[Limits{position:(13.1 14.1 . velocity:15.1 torque:16.1 torque_rate:17.1 . ";
    let end = "age_max:4294967295 encoder:[Encoder{zero:-29 per_count:29.1 . Encoder{zero:-30 per_count:30.1 . . \
               observer:TrackingObserver::from_gains(31.1 32.1 33.1 34.1 . \
               integral:some [Integral{gain:35.1 torque_max:36.1 dead_band:37.1 friction:38.1 . Integral{gain:39.1 torque_max:40.1 dead_band:41.1 friction:42.1 . . \
               teach:some [Teach{friction:43.1 per_still_speed:44.1 breakaway:45.1 slip:46.1 drag:47.1 speed:48.1 wall:(49.1 50.1 . per_wall:51.1 stiffness:52.1 damping:53.1 slowing:54.1 . \
               Teach{friction:55.1 per_still_speed:56.1 breakaway:57.1 slip:58.1 drag:59.1 speed:60.1 wall:(61.1 62.1 . per_wall:63.1 stiffness:64.1 damping:65.1 slowing:66.1 . . posture_damping:some 67.1 . ";
    assert!(text.contains(middle) && text.contains(limits) && text.ends_with(end), "{text}");
    let none = seen(&ControllerConfig { friction: None, ..config() }).text;
    assert!(none.contains(". . friction:none limits:["), "{none}");
}

#[test]
fn a_cast_rounds_every_number_once_and_loses_none() {
    let (wide, narrow) = (seen(&config()).numbers, seen(&config().cast::<f32>()).numbers);
    assert_eq!(wide.len(), 67);
    assert_eq!(narrow, wide.iter().map(|x| f64::from(*x as f32)).collect::<Vec<_>>());
    assert!(narrow.iter().zip(&wide).all(|(narrow, wide)| narrow.to_bits() != wide.to_bits()));
    assert_eq!(config().cast::<f64>(), config());
}
