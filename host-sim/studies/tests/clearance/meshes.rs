//! Meshes, good and damaged.

use nalgebra::Vector3;
use studies::clearance::mesh::points;

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn binary() -> Vec<u8> {
    let mut bytes = b"solid misleading: a binary file may begin like this".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(4u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|k| CORNERS[*k]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text() -> String {
    let facet = |face: &[usize; 3]| {
        let vertex = |k: &usize| format!("vertex {:e} {} {}\n", CORNERS[*k][0], CORNERS[*k][1], CORNERS[*k][2]);
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", face.iter().map(vertex).collect::<String>())
    };
    format!("solid tetrahedron\n{}endsolid tetrahedron\n", FACES.iter().map(facet).collect::<String>())
}

#[test]
fn three_formats_of_one_tetrahedron_are_the_same() {
    let object: String = CORNERS.iter().map(|c| format!("v {} {} {}\n", c[0], c[1], c[2])).collect();
    let object = format!("# tetrahedron\n{object}vn 0 0 1\nf 1 3 2\nf 1 2 4\n");
    let expected: Vec<Vector3<f64>> = points(&binary()).unwrap();
    assert_eq!(expected.len(), 4);
    assert!((expected.iter().map(|p| p.sum()).sum::<f64>() - 6.0).abs() < 1e-12);
    assert_eq!(points(text().as_bytes()).unwrap(), expected);
    assert_eq!(points(object.as_bytes()).unwrap(), expected);
}

#[test]
fn damaged_meshes_are_named() {
    let mut cut = binary();
    cut.truncate(200);
    let mut infinite = binary();
    infinite[96..100].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let cut_text = text().replace("endsolid tetrahedron\n", "");
    let cases: [(&str, Vec<u8>, &str); 8] = [
        ("cut binary", cut, "expected the 4"),
        ("infinite", infinite, "triangle 1: found a number"),
        ("cut text", cut_text.into_bytes(), "endsolid"),
        ("a word", text().replace("vertex 1e0 0 0", "vertex one 0 0").into_bytes(), "line 6: found \"vertex one 0 0\""),
        ("COLLADA", b"<?xml version=\"1.0\"?><COLLADA/>".to_vec(), "COLLADA"),
        ("pointer", b"version https://git-lfs.github.com/spec/v1\noid sha256:1\n".to_vec(), "git lfs pull"),
        ("empty", Vec::new(), "no vertex"),
        ("prose", b"not a mesh at all".to_vec(), "no vertex"),
    ];
    for (name, bytes, expected) in cases {
        let error = points(&bytes).unwrap_err();
        assert!(error.contains(expected), "{name}: {error}");
    }
}
