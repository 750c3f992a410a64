//! Files as they are written, read into what they describe.

mod fields;
mod linkage;
mod robot;
mod scene;
mod table;
mod text;
mod urdf;
