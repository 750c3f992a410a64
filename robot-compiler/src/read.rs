//! Readers of files, from text to descriptions.

mod fields;
mod linkage;
mod robot;
mod scene;
mod table;
mod text;
mod urdf;
