//! Writes the arm in both precisions with both kernels, and the linker script of the core in `NEWTAU_MEMORY`.

use robot_compiler::SceneFile;
use robot_compiler::emit::c::c_library;
use robot_compiler::emit::write_arm_of;
use robot_compiler::scene::{KernelChoice, ScalarChoice};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const ARMS: [(&str, ScalarChoice, KernelChoice); 4] = [
    ("exact_f32", ScalarChoice::F32, KernelChoice::Exact),
    ("regrouped_f32", ScalarChoice::F32, KernelChoice::Regrouped),
    ("exact_f64", ScalarChoice::F64, KernelChoice::Exact),
    ("regrouped_f64", ScalarChoice::F64, KernelChoice::Regrouped),
];

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    println!("cargo::rerun-if-env-changed=NEWTAU_SCENE");
    let name = std::env::var("NEWTAU_SCENE").unwrap_or_else(|_| "ur5_wave".to_owned());
    let scene = Path::new("../../scenes").join(name + ".toml");
    let file = SceneFile::load(&scene)?;
    println!("cargo::rerun-if-changed={}", scene.display());
    println!("cargo::rerun-if-changed={}", file.robot.path.display());
    for (name, scalar, kernel) in ARMS {
        let mut file = file.clone();
        file.control.scalar = scalar;
        file.control.kernel = kernel;
        let folder = out.join(name);
        fs::create_dir_all(&folder)?;
        write_arm_of(&file, &folder)?;
        if std::env::var_os("CARGO_FEATURE_C").is_some() {
            // The prefix of the library's functions.
            name.clone_into(&mut file.name);
            compile_c(&c_library(&file, scalar)?.files, &folder, name)?;
        }
    }
    println!("cargo::rerun-if-env-changed=NEWTAU_MEMORY");
    if let Ok(memory) = std::env::var("NEWTAU_MEMORY") {
        fs::write(out.join("link.x"), script(&memory)?)?;
        println!("cargo::rustc-link-arg-bins=-T{}", out.join("link.x").display());
    }
    Ok(())
}

/// Compiles a C library and links it to the program.
fn compile_c(files: &[(String, String)], folder: &Path, name: &str) -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-env-changed=NEWTAU_CC");
    for (path, text) in files.iter().filter(|(path, _)| path.ends_with(".c") || path.ends_with(".h")) {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().ok_or("a file has a folder")?)?;
        fs::write(path, text)?;
    }
    let compiler =
        std::env::var("NEWTAU_CC").map_err(|_| "NEWTAU_CC is not set: expected a C compiler and its flags")?;
    let mut words = compiler.split_whitespace();
    let mut command = Command::new(words.next().ok_or("NEWTAU_CC is empty")?);
    let object = folder.join("arm.o");
    command.args(words).args(["-std=c99", "-ffreestanding", "-ffunction-sections", "-c", "-o"]).arg(&object);
    let status = command.arg(folder.join(format!("src/{name}_arm.c"))).status()?;
    if !status.success() {
        return Err(format!("{command:?}: {status}").into());
    }
    println!("cargo::rustc-link-arg-bins={}", object.display());
    Ok(())
}

/// A linker script for a program without variables that have a first value. `memory` is the address and length of the code's memory, and those
/// of the data's, separated by spaces.
fn script(memory: &str) -> Result<String, String> {
    let parts: Vec<&str> = memory.split(' ').collect();
    let [code, code_length, data, data_length] = parts.as_slice() else {
        return Err(format!("NEWTAU_MEMORY={memory}: expected four numbers"));
    };
    Ok(format!(
        "MEMORY {{\n  CODE : ORIGIN = {code}, LENGTH = {code_length}\n  DATA : ORIGIN = {data}, LENGTH = {data_length}\n}}\n\
         _stack_start = ORIGIN(DATA) + LENGTH(DATA);\nENTRY(start)\nSECTIONS {{\n  .text : {{ KEEP(*(.start)) *(.text .text.*) }} > CODE\n  \
         .rodata : {{ *(.rodata .rodata.*) *(.srodata .srodata.*) }} > CODE\n  \
         .data : {{ *(.data .data.*) *(.sdata .sdata.*) *(.got .got.*) }} > DATA\n  \
         .bss (NOLOAD) : {{ *(.bss .bss.*) *(.sbss .sbss.*) }} > DATA\n  \
         ASSERT(SIZEOF(.data) == 0, \"a variable has a first value, which nobody copies\")\n  \
         /DISCARD/ : {{ *(.ARM.exidx .ARM.exidx.* .eh_frame .eh_frame.*) }}\n}}\n"
    ))
}
