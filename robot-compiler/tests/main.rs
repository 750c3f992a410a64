//! Robots and scenes from file to emitted source.

mod auto_terms;
mod bad_files;
mod check;
mod common;
mod drives;
mod emitted;
mod emitted_scalars;
mod huge_files;
mod kernel;
mod kernel_error;
mod kernel_interpreter;
mod kernel_source;
mod law;
mod linkage;
mod precision;
mod rooms;
mod rotor_coupling;
mod safety_rules;
mod scene;
mod shipped;
mod shipped_arms;
mod skipped;
mod urdf;
mod urdf_corpus;
mod urdf_cut;
mod zero_cost;
