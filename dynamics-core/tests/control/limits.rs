//! Each limit acts, is reported when it acts, and only then.

use crate::control::support::{driven, measured, one_joint, wanting};
use dynamics_core::control::{Gains, LimitFlags};
use dynamics_core::{Controller, Limits, Reference};

const LIMITS: Limits<f64> = Limits { position: (-1.0, 2.0), velocity: 3.0, torque: 10.0, torque_rate: f64::INFINITY };

/// The flags of the first tick, and the reference that the controller followed, computed back from the torque.
fn kept(reference: Reference<f64, 1>) -> (LimitFlags, [f64; 3]) {
    let open = |position, velocity, inertia| {
        let mut settings = *one_joint(LIMITS, f64::INFINITY).config();
        settings.limits[0].torque = f64::INFINITY;
        settings.gains = [Gains { position, velocity, inertia }];
        let mut controller =
            Controller::new(settings, crate::control::support::UnitMasses::default(), crate::control::support::Desk);
        driven(controller.tick(&reference, &measured([0.0], [0.0])))
    };
    // Unit mass at 0 and at rest: the torque is qdd + Kd qd + Kp q of the reference in force.
    let (acceleration, flags) = open(0.0, 0.0, 0.0);
    let (with_q, _) = open(1.0, 0.0, 0.0);
    let (with_qd, _) = open(0.0, 1.0, 0.0);
    let qdd = acceleration[0];
    (flags[0], [with_q[0] - qdd, with_qd[0] - qdd, qdd])
}

#[test]
fn reference_limits_take_away_what_leads_further_out_and_nothing_else() {
    const NONE: LimitFlags = LimitFlags::NONE;
    const Q: LimitFlags = LimitFlags::POSITION;
    const QD: LimitFlags = LimitFlags::VELOCITY;
    // (reference q, qd, qdd), flags, the kept reference
    let table = [
        ([0.5, 1.0, 4.0], NONE, [0.5, 1.0, 4.0]),
        ([2.0, 1.0, 4.0], NONE, [2.0, 1.0, 4.0]),
        ([-1.0, -1.0, -4.0], NONE, [-1.0, -1.0, -4.0]),
        ([2.5, 1.0, 4.0], Q, [2.0, 0.0, 0.0]),
        ([2.5, 1.0, -4.0], Q, [2.0, 0.0, -4.0]),
        ([2.5, -0.5, -4.0], Q, [2.0, -0.5, -4.0]),
        ([2.5, -1.0, 4.0], Q, [2.0, -1.0, 0.0]),
        ([-1.5, -1.0, -4.0], Q, [-1.0, 0.0, 0.0]),
        ([-1.5, 0.5, 4.0], Q, [-1.0, 0.5, 4.0]),
        ([-1.5, 1.0, -4.0], Q, [-1.0, 1.0, 0.0]),
        ([0.5, 3.0, 4.0], NONE, [0.5, 3.0, 4.0]),
        ([0.5, 3.5, 4.0], QD, [0.5, 3.0, 0.0]),
        ([0.5, 3.5, -4.0], QD, [0.5, 3.0, -4.0]),
        ([0.5, -3.5, -4.0], QD, [0.5, -3.0, 0.0]),
        ([0.5, -3.5, 4.0], QD, [0.5, -3.0, 4.0]),
        // Outward at a position limit the velocity is zero, so its limit does not act.
        ([2.5, 9.0, 4.0], Q, [2.0, 0.0, 0.0]),
        ([2.5, -9.0, 4.0], Q | QD, [2.0, -3.0, 0.0]),
    ];
    for (wanted, flags, expected) in table {
        let [q, qd, qdd] = wanted;
        let (got, kept) = kept(Reference { q: [q], qd: [qd], qdd: [qdd] });
        assert_eq!(got, flags, "{wanted:?}");
        for i in 0..3 {
            assert!((kept[i] - expected[i]).abs() < 1e-12, "{wanted:?} became {kept:?}, not {expected:?}");
        }
    }
}

#[test]
fn the_torque_limit_acts_above_it_and_not_at_it() {
    let table = [
        (9.9, 9.9, LimitFlags::NONE),
        (10.0, 10.0, LimitFlags::NONE),
        (10.0_f64.next_up(), 10.0, LimitFlags::TORQUE),
        (-10.0, -10.0, LimitFlags::NONE),
        (-1e30, -10.0, LimitFlags::TORQUE),
    ];
    for (wanted, torque, flag) in table {
        let command = one_joint(LIMITS, f64::INFINITY).tick(&wanting(wanted), &measured([0.0], [0.0]));
        assert_eq!(driven(command), ([torque], [flag]), "wanted {wanted}");
    }
}

#[test]
fn the_torque_rate_limit_acts_from_the_second_tick_on_and_the_torque_limit_holds_meanwhile() {
    const NONE: LimitFlags = LimitFlags::NONE;
    const RATE: LimitFlags = LimitFlags::TORQUE_RATE;
    const TORQUE: LimitFlags = LimitFlags::TORQUE;
    let mut controller = one_joint(LIMITS, 4.0);
    let sequence = [
        (5.0, 5.0, NONE),
        (9.0, 9.0, NONE),
        (4.0, 5.0, RATE),
        (-20.0, 1.0, RATE | TORQUE),
        (-20.0, -3.0, RATE | TORQUE),
        (-20.0, -7.0, RATE | TORQUE),
        (-20.0, -10.0, TORQUE),
        (-8.0, -8.0, NONE),
    ];
    for (wanted, torque, flags) in sequence {
        assert_eq!(driven(controller.tick(&wanting(wanted), &measured([0.0], [0.0]))), ([torque], [flags]));
    }
}

#[test]
fn the_torque_rate_limit_starts_afresh_after_a_reset() {
    let mut controller = one_joint(LIMITS, 0.5);
    driven(controller.tick(&wanting(-8.0), &measured([0.0], [0.0])));
    controller.overrun();
    controller.tick(&wanting(8.0), &measured([0.0], [0.0]));
    controller.reset();
    assert_eq!(driven(controller.tick(&wanting(8.0), &measured([0.0], [0.0]))), ([8.0], [LimitFlags::NONE]));
    // And the limit is in force again from there.
    assert_eq!(driven(controller.tick(&wanting(0.0), &measured([0.0], [0.0]))), ([7.5], [LimitFlags::TORQUE_RATE]));
}

#[test]
fn flags_belong_to_the_joint_whose_limit_acts() {
    use crate::control::support::{config, controller};
    let mut settings = config(dynamics_core::control::ControlLaw::Pd);
    settings.limits[1].torque = 1e-3;
    let (torque, flags) =
        driven(controller(settings).tick(&Reference::at_rest([0.1, 0.1]), &measured([0.0; 2], [0.0; 2])));
    assert_eq!(flags, [LimitFlags::NONE, LimitFlags::TORQUE]);
    assert!(torque[0] > 1.0 && torque[1] == 1e-3);
}

#[test]
fn flag_bits_are_stable_and_named() {
    let pinned = [
        (LimitFlags::POSITION, 1),
        (LimitFlags::VELOCITY, 2),
        (LimitFlags::TORQUE, 4),
        (LimitFlags::TORQUE_RATE, 8),
        (LimitFlags::COLLISION, 16),
        (LimitFlags::HEAT, 32),
    ];
    for ((flag, bits), (named, _)) in pinned.into_iter().zip(LimitFlags::NAMES) {
        assert_eq!((flag.bits(), flag), (bits, named));
    }
    for bits in 0..=u8::MAX {
        assert_eq!(LimitFlags::from_bits(bits).bits(), bits & 0x3f);
        for (flag, value) in pinned {
            assert_eq!(LimitFlags::from_bits(bits).contains(flag), bits & value != 0);
        }
    }
}
