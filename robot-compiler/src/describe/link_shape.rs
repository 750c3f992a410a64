//! Collision shapes of links, as a URDF file describes them.

use dynamics_core::model::Placement;
use nalgebra::Vector3;

/// A collision shape that is fixed to a link of an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkShape {
    /// Link of the file that the shape belongs to.
    pub link: String,
    /// 0 for the base, otherwise the number of the joint that moves it, from 1.
    pub frame: usize,
    /// Its frame, placed in the model's frame of that link, whose z axis lies along the joint; for the base, in the base frame.
    pub place: Placement<f64>,
    /// Its form.
    pub geometry: Geometry,
}

/// Form of a collision shape, about the origin of its frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// Edges along x, y and z, m.
    Box(Vector3<f64>),
    /// A sphere by its radius, m.
    Sphere(f64),
    /// A cylinder along z.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Length, m.
        length: f64,
    },
    /// Vertices from a file, each multiplied by a scale along x, y and z.
    Mesh {
        /// Name as given in the URDF: a path, `package://` or `file://`.
        file: String,
        /// Metres per unit of the file.
        scale: Vector3<f64>,
    },
}
