//! Motions for identification that stay clear of the arm itself, a floor and boxes.

use crate::program::{at_the_top, told};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The elbow is up, and the shoulder's capsule is 0.05 m above the floor.
const UR5: [&str; 8] =
    ["robots/ur5.toml", "--centre", "0,-1.2,1.4,-1.6,-1.6,0", "--tries", "60", "--json", "--radius", "0.04"];

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("excite").join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn excite(arguments: &[&str]) -> (i32, String, String) {
    told(at_the_top().args(["identify", "excite"]).args(arguments).output().unwrap())
}

fn json(arguments: &[&str]) -> Value {
    let (code, out, error) = excite(arguments);
    assert_eq!(code, 0, "{arguments:?}: {error}");
    serde_json::from_str(&out).unwrap()
}

#[test]
fn a_clearance_is_kept_and_stated() {
    let with = |more: &[&str]| json(&[&UR5[..], more].concat());
    let found = with(&["--floor", "0", "--box", "0.55,0.5,0.3,0.3,0.3,0.6", "--clearance", "0.03"]);
    let least = &found["clearance"]["least"];
    let (bound, seen) = (least["bound"].as_f64().unwrap(), least["found"].as_f64().unwrap());
    assert!(bound >= 0.03 && seen >= bound && seen < bound + 3e-4, "{least}");
    assert!(least["between"].as_array().unwrap().len() == 2 && least["time"].as_f64().unwrap() >= 0.0);
    let text = found["clearance"].to_string();
    assert!(text.contains("neighbours") && text.contains("cables"), "{text}");
    let usual = json(&["robots/yam.toml", "--tries", "20", "--json"])["clearance"].to_string();
    assert!(usual.contains("6 % of the arm's length") && usual.contains("rest pose"), "{usual}");
    // Without the box, the same search finds another motion, which gives more information.
    let free = with(&["--clearance", "0.03"]);
    assert!(
        free["log_det"].as_f64().unwrap() > found["log_det"].as_f64().unwrap(),
        "{} {}",
        free["log_det"],
        found["log_det"]
    );
    for kind in ["--friction", "--static"] {
        let found = with(&[kind, "--floor", "0", "--box", "0.55,0.5,0.3,0.3,0.3,0.6"]);
        assert!(found["clearance"]["least"]["bound"].as_f64().unwrap() >= 0.02, "{kind}: {found}");
    }
}

#[test]
fn a_start_without_clearance_and_bad_options_are_refused_with_their_reason() {
    let cases: [(&[&str], &str); 6] = [
        (&["--box", "0.4,0.1,0.4,0.9,0.9,0.9"], "box 1 and link 2 (shoulder_lift) overlap by"),
        (&["--floor", "2"], "floor and link"),
        (&["--clearance", "0.3", "--floor", "0"], "with a --clearance of 0.3 m"),
        (&["--box", "1,2,3"], "six numbers"),
        (&["--box", "0,0,9,1,1,-1"], "edges above zero"),
        (&["--clearance", "-1"], "zero or more"),
    ];
    for (more, expected) in cases {
        let (code, out, error) = excite(&[&UR5[..], more].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{more:?}: {error}");
        assert!(error.contains(expected), "{more:?}: {error}");
    }
}

/// A URDF of two rods with meshes, in a folder of a package.
fn with_meshes(name: &str, mesh: Option<&str>) -> String {
    let folder = folder(name);
    for inside in ["urdf", "meshes"] {
        std::fs::create_dir_all(folder.join("arm_description").join(inside)).unwrap();
    }
    let link = |name: &str, collision: &str| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 0 0.2\"/><mass value=\"1\"/><inertia ixx=\"0.02\" iyy=\"0.02\" izz=\"0.01\" \
             ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{collision}</link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, z: f64, axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"0 0 {z}\"/>\
             <axis xyz=\"{axis}\"/><limit lower=\"-2\" upper=\"2\" effort=\"60\" velocity=\"2\"/></joint>"
        )
    };
    let rod =
        "<collision><geometry><mesh filename=\"package://arm_description/meshes/rod.stl\"/></geometry></collision>";
    let text = [
        "<robot name=\"rods\"><link name=\"ground\"/>".to_owned(),
        link("upper", rod),
        link("fore", rod),
        link("hand", ""),
        joint("turn", "ground", "upper", 0.3, "0 1 0"),
        joint("lift", "upper", "fore", 0.4, "0 1 0"),
        joint("bend", "fore", "hand", 0.4, "0 1 0"),
        "</robot>".to_owned(),
    ];
    let (file, rod) = (folder.join("arm_description/urdf/arm.urdf"), folder.join("arm_description/meshes/rod.stl"));
    std::fs::write(&file, text.concat()).unwrap();
    match mesh {
        Some(text) => std::fs::write(rod, text).unwrap(),
        None => drop(std::fs::remove_file(rod)),
    }
    file.to_str().unwrap().to_owned()
}

/// A rod of 0.4 by 0.06 by 0.06 m, in a unit of this many metres.
fn rod(metre: f64) -> String {
    let corner = |k: u32| {
        let end = |bit: u32, size: f64| if k & bit == 0 { 0.0 } else { size * metre };
        format!("vertex {} {} {}\n", end(1, 0.06) - 0.03 * metre, end(2, 0.06) - 0.03 * metre, end(4, 0.4))
    };
    let facets = (0..6).map(|k| {
        format!("facet normal 0 0 1\nouter loop\n{}{}{}endloop\nendfacet\n", corner(k), corner(k + 1), corner(k + 2))
    });
    format!("solid rod\n{}endsolid rod\n", facets.collect::<String>())
}

#[test]
fn meshes_of_a_urdf_are_used_and_what_is_missing_is_said() {
    let notes =
        |file: &str| json(&[file, "--tries", "20", "--json", "--floor", "-1"])["clearance"]["notes"].to_string();
    let good = notes(&with_meshes("good", Some(&rod(1.0))));
    assert!(
        good.contains("2 collision shapes") && good.contains("2 meshes") && good.contains("link 3 (bend)"),
        "{good}"
    );
    assert!(!good.contains("link 2 (lift) 0"), "a capsule beside a mesh: {good}");
    let missing = notes(&with_meshes("missing", None));
    assert!(
        missing.contains("no mesh of fore")
            && missing.contains("rod.stl is not there")
            && missing.contains("all links 0"),
        "{missing}"
    );
    for (name, mesh, expected) in [
        ("millimetres", rod(1000.0), "millimetres"),
        ("cut", rod(1.0).replace("endsolid rod", ""), "endsolid"),
        ("word", rod(1.0).replace("vertex", "vertex x"), "line 4: found"),
    ] {
        let file = with_meshes(name, Some(&mesh));
        let (code, out, error) = excite(&[&file, "--tries", "20"]);
        assert_eq!((code, out.as_str()), (2, ""), "{name}: {error}");
        assert!(error.contains(expected) && error.contains("rod.stl"), "{name}: {error}");
    }
}
