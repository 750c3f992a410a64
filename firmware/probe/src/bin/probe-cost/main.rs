//! Counts the instructions of a scene's control tick in the emulated chip. `cargo xtask firmware cost` builds it once for each scene and reads its
//! output.
//!
//! The list of scenes may contain several. The compiler then no longer specialises shared functions for the numbers of one scene: to get the cost
//! of a tick in its firmware, build for one scene.
//!
//! | line | meaning |
//! |---|---|
//! | `scene,K,ADDRESS,BYTES` | scene K of the list: address of `tick_K`, and size of its controller |
//! | `tick,K,T,COUNT,drive,TORQUE..,LIMITS..` | tick T: instructions; bits of each joint's torque as f64, in hexadecimal; limits that acted |
//! | `tick,K,T,COUNT,brake,CODE,JOINT` | a tick that brakes; JOINT is empty if the fault is not that of a single joint |
//!
//! The output includes the ticks before the counted ones, because their torques are compared.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod count;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("ticks are counted in the emulated chip: cargo xtask firmware cost");
}
