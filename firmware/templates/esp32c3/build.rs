//! Compiles the arm from its files, in every build in which they have changed.

fn main() {
    robot_compiler::emit::build_arm("arm/move.toml");
}
