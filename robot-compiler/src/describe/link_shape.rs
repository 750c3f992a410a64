//! Collision shapes of links, as a URDF file describes them.

use dynamics_core::model::Placement;
use nalgebra::Vector3;

/// A collision shape that is fixed to a link of an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkShape {
    /// Link of the file that the shape belongs to.
    pub link: String,
    /// 0 for the base, else the number of the joint that moves it, from 1.
    pub frame: usize,
    /// Its frame in the model's frame of that link, whose z lies along the joint; in the base frame for the base.
    pub place: Placement<f64>,
    /// Its form.
    pub geometry: Geometry,
}

/// Form of a collision shape, about the origin of its frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// Edges along x, y and z, m.
    Box(Vector3<f64>),
    /// Radius, m.
    Sphere(f64),
    /// Along z.
    Cylinder {
        /// m.
        radius: f64,
        /// m.
        length: f64,
    },
    /// Vertices of a file, each times a scale along x, y and z.
    Mesh {
        /// As the file has it: a path, `package://` or `file://`.
        file: String,
        /// Metres per unit of the file.
        scale: Vector3<f64>,
    },
}
