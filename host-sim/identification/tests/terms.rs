//! Terms of friction beyond viscous and Coulomb friction, found in logs that have them and in no others.

use crate::arms::{Known, load};
use crate::made::{Making, Random, log};
use identification::choose::WITHOUT_OFFSET;
use identification::friction::{Direction, FrictionLaw, JointLaw, Term};
use identification::identify::{Identified, Settings, identify};
use identification::log::Log;

/// Joint with the friction that the tests search for.
const SHOULDER: usize = 1;

/// A slow log of the YAM. Every joint has 0.1 N m s/rad and 0.2 N m of friction; the shoulder has this law in addition.
fn recorded(known: &Known, law: &JointLaw, motion: u64) -> Log {
    let bare = Making { duration: 40.0, friction: (0.1, 0.2), noise: 0.0, encoder: 0.0, motion, ..Making::default() };
    let mut log = log(known, &known.parameters, &bare);
    let without = crate::made::log(known, &known.parameters, &Making { friction: (0.0, 0.0), ..bare });
    let (q, rate) = (log.q[SHOULDER].clone(), 100.0);
    let direction = Direction::Hysteresis(1e-4).along(&q, &[]);
    let mut random = Random::new(99);
    for k in 0..q.len() {
        let qd = rate * 0.5 * (q[(k + 1).min(q.len() - 1)] - q[k.saturating_sub(1)]);
        let (s, load) = (direction[k], without.tau[SHOULDER][k].abs());
        let bell = if law.stribeck_speed > 0.0 { (-(qd / law.stribeck_speed).powi(2)).exp() } else { 0.0 };
        let level = law.coulomb + law.coulomb_load * load + (law.rise.0 + law.rise.1 * load) * bell;
        log.tau[SHOULDER][k] += law.viscous * qd + s * level + law.asymmetry * s * s + law.offset;
        log.tau[SHOULDER][k] += 0.01 * random.normal();
    }
    log
}

fn found(law: &JointLaw) -> Identified {
    let known = load("yam.toml");
    let logs = [recorded(&known, law, 7), recorded(&known, law, 9)];
    identify(known.arm.as_ref(), &known.maker(), &logs, &Settings::default())
}

fn offset_is_earned(found: &Identified) -> bool {
    found.tried.iter().any(|tried| tried.what == WITHOUT_OFFSET && !tried.kept[SHOULDER])
}

#[test]
fn a_rise_towards_rest_is_found_with_its_velocity() {
    let law = JointLaw { coulomb: 0.5, rise: (2.1, 0.0), stribeck_speed: 0.05, ..JointLaw::default() };
    let found = found(&law);
    let by = found.laws[SHOULDER].by_joint(&found.friction[SHOULDER]).unwrap();
    assert!((by.coulomb - 0.7).abs() < 0.07, "{by:?}");
    assert!((by.coulomb + by.rise.0 - 2.8).abs() < 0.28, "{by:?}");
    assert!((by.stribeck_speed - 0.05).abs() < 0.0125, "{by:?}");
    let deviation = &found.friction_deviations[SHOULDER];
    assert!(deviation.iter().all(|x| *x > 0.0 && *x < 0.3), "{deviation:?}");
    // The fit finds these terms in no other joint, and no asymmetry and no offset.
    for joint in (0..6).filter(|joint| *joint != SHOULDER) {
        assert_eq!(found.laws[joint].stribeck_speed(), None, "joint {joint}: {:?}", found.laws[joint].terms);
    }
    assert!(!found.laws[SHOULDER].terms.contains(&Term::Asymmetric) && !offset_is_earned(&found));
}

#[test]
fn a_growth_with_the_load_and_an_offset_are_found_where_they_are() {
    let law = JointLaw { coulomb: 0.3, coulomb_load: 0.1, offset: 0.25, ..JointLaw::default() };
    let found = found(&law);
    let by = found.laws[SHOULDER].by_joint(&found.friction[SHOULDER]).unwrap();
    assert!((by.coulomb_load - 0.1).abs() < 0.02, "{by:?}");
    assert!((by.offset - 0.25).abs() < 0.05 && offset_is_earned(&found), "{by:?}");
    assert_eq!(found.laws[SHOULDER].stribeck_speed(), None);
}

#[test]
fn a_plain_joint_gets_no_term_beyond_viscous_and_coulomb_friction() {
    let found = found(&JointLaw::default());
    for (joint, law) in found.laws.iter().enumerate() {
        assert!(law.stribeck_speed().is_none(), "joint {joint}: {:?}", law.terms);
        assert!(!law.terms.contains(&Term::Asymmetric), "joint {joint}: {:?}", law.terms);
    }
    assert!(!offset_is_earned(&found));
}

#[test]
fn what_no_robot_file_can_hold_is_not_taken_for_one() {
    let terms = |more: &[Term]| FrictionLaw::with(Direction::Hysteresis(1e-4), more);
    let plain = terms(&[]).by_joint(&[0.1, -0.2, 0.5]).unwrap();
    assert_eq!((plain.offset, plain.viscous, plain.coulomb), (0.1, 0.0, 0.5));
    for (more, coefficients) in [
        (Term::Root, 0.1),
        (Term::Stribeck(0.05), -0.1),
        (Term::Load, -0.01),
        (Term::Load, 0.6),
        (Term::Asymmetric, 0.7),
    ] {
        assert_eq!(terms(&[more]).by_joint(&[0.0, 0.1, 0.5, coefficients]), None, "{more:?}");
    }
}
