use super::{ARM, ARM_NAMES, JOINT_NAMES, of_words, unit};

fn read(words: &[&str]) -> Result<Vec<u8>, String> {
    of_words("get", words, &["shoulder".into(), "elbow".into()])
}

#[test]
fn words_name_all_those_of_a_joint_or_one() {
    let all = read(&[]).unwrap_or_default();
    assert_eq!(all.len(), 2 * JOINT_NAMES.len() + ARM_NAMES.len());
    assert!(all.iter().all(|number| session::parameters::name(*number).is_some()));
    assert_eq!((read(&["elbow"]), read(&["2"])), (Ok((16..27).collect()), Ok((16..27).collect())));
    assert_eq!(read(&["elbow", "velocity", "gain"]), Ok(vec![17]));
    assert_eq!(read(&["payload", "mass"]), Ok(vec![ARM]));
    assert_eq!(read(&["gravity", "z"]), Ok(vec![ARM + 12]));
}

#[test]
fn what_is_wrong_is_named_with_what_was_expected() {
    let why = read(&["wrist", "gain"]).unwrap_err();
    assert!(why.starts_with("get: wrist gain: expected a joint (shoulder, elbow) or one of payload mass, "), "{why}");
    let why = read(&["elbow", "gain"]).unwrap_err();
    assert!(why.starts_with("get: gain: expected a parameter of a joint, one of position gain, "), "{why}");
    assert!(read(&["3"]).is_err());
}

#[test]
fn units_follow_the_joint() {
    assert_eq!((unit(2, "rad", "N m"), unit(18, "m", "N")), ("N m s/rad".into(), "N s/m".into()));
    assert_eq!(
        (unit(ARM, "", ""), unit(ARM + 9, "", ""), unit(ARM + 12, "", "")),
        ("kg".into(), "kg m^2".into(), "m/s^2".into())
    );
}
