//! Compiles the arm from its files, in every build in which they have changed.

fn main() {
    println!("cargo::rerun-if-changed=memory.x");
    robot_compiler::emit::build_arm("arm/move.toml");
}
