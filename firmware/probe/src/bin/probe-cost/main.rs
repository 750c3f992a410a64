//! Counts the instructions of a scene's control tick in the emulated chip; `cargo xtask firmware cost` builds it, once for each scene,
//! and reads its lines.
//!
//! The list of scenes may hold several, but the compiler then no longer specialises the functions that ticks share to
//! each tick's numbers: for the cost of a tick as its firmware has it, build for one scene.
//!
//! | line | what |
//! |---|---|
//! | `scene,K,ADDRESS,BYTES` | the scene that is K-th in the list: where `tick_K` is, and the size of its controller |
//! | `tick,K,T,COUNT,drive,TORQUE..,LIMITS..` | its tick T: instructions; bits of each joint's torque as f64, in hexadecimal; limits that acted |
//! | `tick,K,T,COUNT,brake,CODE,JOINT` | the same where it brakes; the joint is empty where the fault is not that of one joint |
//!
//! The lines include the ticks before the counted ones, because their torques are compared.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod count;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("ticks are counted in the emulated chip: cargo xtask firmware cost");
}
