//! The dynamics in C: the bits of the Rust core, with every compiler that is here, at every level of optimisation.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a broken shipped file should stop the test")]

use crate::common::{files, skipped, standing, top};
use crate::kernel::arms::{arm, joints};
use dynamics_core::trig::Method;
use dynamics_core::{Live, Real, Scene, Trig};
use nalgebra::Vector3;
use proptest::strategy::{Strategy, ValueTree as _};
use proptest::test_runner::TestRunner;
use robot_compiler::SceneFile;
use robot_compiler::emit::c::{c_library, kernel_source};
use robot_compiler::emit::kernel::Title;
use robot_compiler::kernel::inputs::input_values;
use robot_compiler::kernel::{Function, Level, Precision, Program, compile};
use robot_compiler::scene::ScalarChoice;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Warnings that a careful user switches on; none is left.
const STRICT: [&str; 8] = [
    "-std=c99",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wstrict-prototypes",
    "-Werror",
];

fn is_here(compiler: &str) -> bool {
    Command::new(compiler).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// The C compilers of this machine.
fn compilers() -> Vec<&'static str> {
    let found: Vec<_> = ["gcc", "clang"].into_iter().filter(|compiler| is_here(compiler)).collect();
    if found.is_empty() {
        skipped("there is no gcc and no clang on this machine");
    }
    found
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c").join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Writes the library of a scene, and returns its folder and prefix.
fn written(file: &SceneFile, scalar: ScalarChoice, name: &str) -> (PathBuf, String) {
    let library = c_library(file, scalar).unwrap();
    let folder = folder(name);
    for (path, text) in &library.files {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    (folder, library.prefix)
}

/// Compiles sources to a program; `Err` is what the compiler says.
fn compiled(compiler: &str, flags: &[&str], include: &Path, sources: &[PathBuf]) -> Result<PathBuf, String> {
    let program = include.join(format!("program_{}", compiler.replace('+', "p")));
    let mut command = Command::new(compiler);
    command.args(flags).arg("-I").arg(include.join("src")).args(sources).arg("-o").arg(&program);
    let output = command.output().unwrap();
    if output.status.success() { Ok(program) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

fn printed(program: &Path) -> String {
    String::from_utf8(Command::new(program).output().unwrap().stdout).unwrap()
}

/// The test of a library, built with these flags: what it prints.
fn golden(compiler: &str, flags: &[&str], (folder, prefix): &(PathBuf, String)) -> String {
    let sources = [folder.join(format!("src/{prefix}.c")), folder.join("test/golden.c")];
    printed(
        &compiled(compiler, flags, folder, &sources).unwrap_or_else(|error| panic!("{compiler} {flags:?}: {error}")),
    )
}

fn scene(path: &str) -> SceneFile {
    SceneFile::load(&top("scenes").join(path)).unwrap()
}

#[test]
fn every_shipped_arm_has_the_desk_s_bits_in_c() {
    let mut seen = Vec::new();
    let of_each_robot = files(&top("scenes"), &["toml"]).into_iter().filter(|path| {
        let file = SceneFile::load(path).unwrap();
        let new = !seen.contains(&file.robot.name);
        if new {
            seen.push(file.robot.name);
        }
        new
    });
    // And one with live inputs.
    let scenes: Vec<_> = of_each_robot.chain([top("scenes/campaign/yam.toml")]).collect();
    assert!(scenes.len() >= 9, "{}", scenes.len());
    for path in scenes {
        let mut file = SceneFile::load(&path).unwrap();
        if matches!(file.control.trig, Method::Libm | Method::Table) {
            file.control.trig = Method::Polynomial;
        }
        for scalar in [ScalarChoice::F32, ScalarChoice::F64] {
            let library = written(&file, scalar, &format!("{}_{scalar:?}", file.name));
            for compiler in compilers() {
                let said = golden(compiler, &[&STRICT[..], &["-O1"]].concat(), &library);
                assert!(said.ends_with("0 of 8 states differ\n"), "{path:?} {compiler}: {said}");
            }
        }
    }
}

#[test]
fn no_level_and_no_flag_changes_a_bit() {
    let mut file = scene("puma560_pick.toml");
    file.control.kernel = robot_compiler::scene::KernelChoice::Regrouped;
    let library = written(&file, ScalarChoice::F32, "levels");
    for compiler in compilers() {
        for flags in [&["-O0"][..], &["-O2"], &["-O3"], &["-Os"], &["-O3", "-march=native"]] {
            let said = golden(compiler, flags, &library);
            assert!(said.ends_with("0 of 8 states differ\n"), "{compiler} {flags:?}: {said}");
        }
        // GCC obeys the source; Clang fuses in spite of it, and the check of the conditions tells.
        let said = golden(compiler, &["-O3", "-march=native", "-ffp-contract=fast"], &library);
        let kept = said.ends_with("0 of 8 states differ\n");
        assert!(
            if compiler == "gcc" { kept } else { kept != said.contains("change results: 1") },
            "{compiler}: {said}"
        );
        for refused in ["-ffast-math", "-Ofast", "-ffinite-math-only"] {
            let source = [library.0.join("src/puma560_pick_arm.c"), library.0.join("test/golden.c")];
            let error = compiled(compiler, &[refused], &library.0, &source).unwrap_err();
            assert!(error.contains("change the results"), "{compiler} {refused}: {error}");
        }
    }
}

/// `PREFIX_conditions` reports each broken condition: rounding, and subnormal numbers.
#[test]
#[cfg(target_arch = "x86_64")]
fn a_processor_that_rounds_otherwise_is_told() {
    for scalar in [ScalarChoice::F32, ScalarChoice::F64] {
        let (folder, prefix) = written(&scene("planar2r_swing.toml"), scalar, &format!("conditions_{scalar:?}"));
        let main = folder.join("conditions.c");
        let text = format!(
            "#include \"{prefix}.h\"\n#include <fenv.h>\n#include <stdio.h>\n#include <xmmintrin.h>\nint main(void) {{\n    \
             printf(\"%d \", {prefix}_conditions());\n    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);\n    printf(\"%d \", {prefix}_conditions());\n    \
             _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_OFF);\n    const int modes[] = {{FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}};\n    \
             for (int i = 0; i < 3; i++) {{\n        fesetround(modes[i]);\n        printf(\"%d \", {prefix}_conditions() & 4);\n    }}\n    return 0;\n}}\n"
        );
        fs::write(&main, text).unwrap();
        for compiler in compilers() {
            let sources = [folder.join(format!("src/{prefix}.c")), main.clone(), "-lm".into()];
            let program = compiled(compiler, &["-O2"], &folder, &sources).unwrap();
            assert_eq!(printed(&program), "0 2 4 4 4 ", "{compiler}");
        }
    }
}

/// Without its guard, a compiler that may fuse operations gets other bits: the comparison sees it.
#[test]
fn without_the_guard_the_bits_differ() {
    let fuses = fs::read_to_string("/proc/cpuinfo").is_ok_and(|info| info.contains(" fma "));
    if !fuses || !is_here("gcc") {
        skipped("there is no processor that fuses operations, or no gcc");
        return;
    }
    let library = written(&scene("puma560_pick.toml"), ScalarChoice::F32, "unguarded");
    let source = library.0.join("src/puma560_pick_arm.c");
    let text = fs::read_to_string(&source).unwrap();
    fs::write(&source, text.replace("#pragma GCC optimize(\"fp-contract=off\")", "")).unwrap();
    let said = golden("gcc", &["-O2", "-mfma"], &library);
    assert!(!said.ends_with("0 of 8 states differ\n"), "{said}");
}

/// A number as its bits in C, and as text in hexadecimal.
trait Bits: Real {
    const SCALAR: ScalarChoice;
    fn hex(self) -> String;
}

impl Bits for f32 {
    const SCALAR: ScalarChoice = ScalarChoice::F32;
    fn hex(self) -> String {
        format!("{:08x}", self.to_bits())
    }
}

impl Bits for f64 {
    const SCALAR: ScalarChoice = ScalarChoice::F64;
    fn hex(self) -> String {
        format!("{:016x}", self.to_bits())
    }
}

/// Lines of C: a table of numbers by their bits, and functions that read and print bits.
fn bits_in_c<S: Bits>(numbers: &[S]) -> String {
    let (real, whole, format) = match S::SCALAR {
        ScalarChoice::F32 => ("float", "uint32_t", "%08\" PRIx32 \"\\n"),
        ScalarChoice::F64 => ("double", "uint64_t", "%016\" PRIx64 \"\\n"),
    };
    let table: Vec<_> = numbers.iter().map(|x| format!("0x{}u", x.hex())).collect();
    format!(
        "#include <inttypes.h>\n#include <stdio.h>\n#include <string.h>\n\
         static const {whole} numbers[] = {{{}}};\n\
         static inline {real} number(int i) {{ {real} x; memcpy(&x, &numbers[i], sizeof x); return x; }}\n\
         static inline void show({real} x) {{ {whole} bits; memcpy(&bits, &x, sizeof bits); printf(\"{format}\", bits); }}\n",
        table.join(", ")
    )
}

fn compare<S: Bits>(said: &str, expected: &[S], about: &str) {
    let lines: Vec<_> = said.lines().collect();
    assert_eq!(lines.len(), expected.len(), "{about}");
    for (i, (line, expected)) in lines.iter().zip(expected).enumerate() {
        // The sign and the payload of NaN are the processor's.
        let equal = if expected.is_finite() { *line == expected.hex() } else { is_nan::<S>(line) };
        assert!(equal, "{about}: number {i}: {line} instead of {}", expected.hex());
    }
}

fn is_nan<S: Bits>(hex: &str) -> bool {
    let bits = u64::from_str_radix(hex, 16).unwrap();
    match S::SCALAR {
        ScalarChoice::F32 => f32::from_bits(bits as u32).is_nan(),
        ScalarChoice::F64 => f64::from_bits(bits).is_nan(),
    }
}

fn sines<S: Bits>(random: &mut impl FnMut() -> f64, limit: f64)
where
    Method: Trig<S>,
{
    for method in [Method::Polynomial, Method::Polynomial5, Method::Polynomial3] {
        let mut file = standing("planar2r", "");
        file.control.trig = method;
        let (folder, prefix) = written(&file, S::SCALAR, &format!("sines_{method:?}_{}", S::zero().hex().len()));
        let mut angles: Vec<f64> = (0..3000).map(|_| random() * 10.0).collect();
        angles.extend((0..1000).map(|_| random() * limit));
        angles.extend((-40..=40).map(|k| f64::from(k) * core::f64::consts::FRAC_PI_4));
        angles.extend([0.0, -0.0, 1e-310, 1e-40, 1e-20, limit, -limit, limit * 1.001, f64::INFINITY, f64::NAN]);
        let angles: Vec<S> = angles.into_iter().map(S::literal).collect();
        let main = format!(
            "#include \"{prefix}.h\"\n{}int main(void) {{\n    for (int i = 0; i < {}; i++) {{\n        \
             const {prefix}_sin_cos_t turn = {prefix}_sin_cos(number(i));\n        show(turn.sin);\n        show(turn.cos);\n    }}\n    return 0;\n}}\n",
            bits_in_c(&angles),
            angles.len()
        );
        let path = folder.join("sines.c");
        fs::write(&path, main).unwrap();
        let expected: Vec<S> = angles
            .iter()
            .flat_map(|angle| {
                let both = method.sin_cos(*angle);
                [both.sin, both.cos]
            })
            .collect();
        for compiler in compilers() {
            let sources = [folder.join(format!("src/{prefix}.c")), path.clone()];
            let program = compiled(compiler, &["-O2"], &folder, &sources).unwrap();
            compare(&printed(&program), &expected, &format!("{compiler} {method:?}"));
        }
    }
}

#[test]
fn sines_and_cosines_have_the_core_s_bits() {
    let mut seed = 1_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    sines::<f32>(&mut random, 8192.0);
    sines::<f64>(&mut random, 1_048_576.0);
}

/// A random arm's inverse dynamics: its program, and inputs of three states.
fn random_arm<const N: usize>(runner: &mut TestRunner, level: Level) -> (Program, Vec<f32>) {
    let (model, gravity, states) =
        (arm::<N>(), joints::<3>(9.0), [joints::<N>(3.1), joints::<N>(2.0), joints::<N>(5.0)])
            .new_tree(runner)
            .unwrap()
            .current();
    let scene = Scene::with_gravity(Vector3::from(gravity), &model);
    let program = compile(Function::InverseDynamics, &model, &scene, level, Precision::Single);
    let [q, qd, qdd] = states.map(|row| row.map(|x| x as f32));
    let inputs = [1.0_f32, -0.5, 1e-22].iter().flat_map(|size| {
        let [q, qd, qdd] = [q, qd, qdd].map(|row| row.map(|x| x * size));
        input_values(&Method::Polynomial.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero())
    });
    (program, inputs.collect())
}

/// A hundred arms in one program: each kernel is a file, included under names of its own.
#[test]
fn a_hundred_random_arms_have_the_interpreter_s_bits() {
    let mut runner = TestRunner::deterministic();
    let folder = folder("random");
    let (mut includes, mut calls) = (String::new(), String::new());
    let (mut numbers, mut expected) = (Vec::new(), Vec::new());
    for i in 0..100 {
        let level = if i % 2 == 0 { Level::Exact } else { Level::Regrouped };
        let joints = 1 + i % 6;
        let (program, inputs) = match joints {
            1 => random_arm::<1>(&mut runner, level),
            2 => random_arm::<2>(&mut runner, level),
            3 => random_arm::<3>(&mut runner, level),
            4 => random_arm::<4>(&mut runner, level),
            5 => random_arm::<5>(&mut runner, level),
            _ => random_arm::<6>(&mut runner, level),
        };
        let title = Title { robot: "random", scene: "random", hash: 0 };
        let text = kernel_source(Function::InverseDynamics, &program, joints, Precision::Single, level, &title);
        // The arguments that this kernel reads.
        let head = text.lines().find(|line| line.starts_with("void ")).unwrap().to_owned();
        fs::write(folder.join(format!("{i}.c")), text).unwrap();
        writeln!(
            includes,
            "#define arm_kernel_inverse_dynamics kernel_{i}\n#define arm_sin_cos_t turn_{i}\n#include \"{i}.c\"\n\
             #undef arm_kernel_inverse_dynamics\n#undef arm_sin_cos_t"
        )
        .unwrap();
        let each = inputs.len() / 3;
        for state in inputs.chunks(each) {
            let given: Vec<_> =
                ["turn", "q", "qd", "qdd"].into_iter().filter(|name| head.contains(&format!(" {name}["))).collect();
            writeln!(
                calls,
                "    {{\n        const int at = {};\n        turn_{i} turn[{joints}]; float q[{joints}], qd[{joints}], qdd[{joints}], tau[{joints}];\n        \
                 for (int j = 0; j < {joints}; j++) {{\n            turn[j].sin = number(at + j); turn[j].cos = number(at + {joints} + j);\n            \
                 q[j] = number(at + {} + j); qd[j] = number(at + {} + j); qdd[j] = number(at + {} + j);\n        }}\n        \
                 (void)turn; (void)q; (void)qd; (void)qdd;\n        kernel_{i}({}, tau);\n        \
                 for (int j = 0; j < {joints}; j++) {{ show(tau[j]); }}\n    }}",
                numbers.len(),
                2 * joints,
                3 * joints,
                4 * joints,
                given.join(", ")
            )
            .unwrap();
            expected.extend(program.evaluate(state));
            numbers.extend_from_slice(state);
        }
    }
    let main = folder.join("main.c");
    fs::write(&main, format!("{}{includes}int main(void) {{\n{calls}    return 0;\n}}\n", bits_in_c::<f32>(&numbers)))
        .unwrap();
    for compiler in compilers() {
        let level = if compiler == "gcc" { "-O1" } else { "-O0" };
        let program = compiled(compiler, &[level], &folder, std::slice::from_ref(&main)).unwrap();
        compare(&printed(&program), &expected, compiler);
    }
}

/// The functions of the library beside inverse dynamics, against the core.
#[test]
fn every_function_of_a_library_has_the_core_s_bits() {
    use dynamics_core::control::computed_torque;
    use dynamics_core::mass_matrix::mass_matrix;
    use dynamics_core::{Dynamics, InverseDynamics, Reference, forward_dynamics};
    let file = scene("puma560_pick.toml");
    let model = file.robot.model::<6>().unwrap();
    let (folder, prefix) = written(&file, ScalarChoice::F32, "functions");
    let dynamics = Dynamics::new(model.cast::<f32>(), file.scene(&model).cast());
    let wave = |phase: f64| -> [f32; 6] { core::array::from_fn(|i| (i as f64 * 0.9 + phase).sin() as f32) };
    let (q, qd, qdd, tau) = (wave(0.3), wave(1.1), wave(2.2), wave(3.0).map(|x| 20.0 * x));
    let reference = Reference { q: wave(0.31), qd: wave(1.2), qdd };
    let (turn, live) = (Method::Polynomial.sin_cos_all(&q), Live::zero());
    let mut expected = dynamics.inverse_dynamics(&turn, &q, &[0.0; 6], &[0.0; 6], &live).to_vec();
    let mass = mass_matrix(&dynamics, &turn, &q, &live);
    expected
        .extend((0..6).flat_map(|row| (0..6).map(move |column| (row.min(column), row.max(column)))).map(|at| mass[at]));
    let found = forward_dynamics::acceleration(&dynamics, &turn, &q, &qd, &tau, &live);
    assert!(found.pivot.iter().all(|pivot| *pivot > 0.0));
    expected.extend(found.qdd);
    let gains = file.controller_config(&model).cast::<f32>().gains;
    expected.extend(computed_torque(&gains, &dynamics, || turn, &reference, (&q, &qd), &live));
    let numbers = [q, qd, tau, reference.q, reference.qd, reference.qdd].concat();
    let main = format!(
        "#include \"{prefix}.h\"\n{}int main(void) {{\n    float in[6][6], out[6], mass[6][6];\n    {prefix}_reference_t reference;\n    \
         for (int i = 0; i < 36; i++) {{ in[i / 6][i % 6] = number(i); }}\n    \
         for (int i = 0; i < 6; i++) {{ reference.q[i] = in[3][i]; reference.qd[i] = in[4][i]; reference.qdd[i] = in[5][i]; }}\n    \
         {prefix}_gravity(in[0], out);\n    for (int i = 0; i < 6; i++) {{ show(out[i]); }}\n    \
         {prefix}_mass_matrix(in[0], mass);\n    for (int i = 0; i < 36; i++) {{ show(mass[i / 6][i % 6]); }}\n    \
         if (!{prefix}_forward_dynamics(in[0], in[1], in[2], out)) {{ return 1; }}\n    for (int i = 0; i < 6; i++) {{ show(out[i]); }}\n    \
         {prefix}_computed_torque(&reference, in[0], in[1], out);\n    for (int i = 0; i < 6; i++) {{ show(out[i]); }}\n    return 0;\n}}\n",
        bits_in_c(&numbers)
    );
    let path = folder.join("functions.c");
    fs::write(&path, main).unwrap();
    for compiler in compilers() {
        let sources = [folder.join(format!("src/{prefix}.c")), path.clone()];
        let program = compiled(compiler, &["-O2"], &folder, &sources).unwrap();
        compare(&printed(&program), &expected, compiler);
    }
}

#[test]
fn the_header_is_one_for_c_plus_plus_too() {
    if !is_here("g++") {
        skipped("there is no g++ on this machine");
        return;
    }
    for name in ["puma560_pick.toml", "campaign/yam.toml"] {
        let file = scene(name);
        let (folder, prefix) = written(&file, ScalarChoice::F32, &format!("cpp_{}", file.name));
        let main = folder.join("main.cpp");
        fs::write(
            &main,
            format!("#include \"{prefix}.hpp\"\nint main() {{ {prefix}::Joints q{{}}; return q[0] != 0; }}\n"),
        )
        .unwrap();
        let flags = ["-std=c++11", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only"];
        compiled("g++", &flags, &folder, &[main]).unwrap();
    }
}

/// Names that would be a header, a keyword or the end of a comment.
#[test]
fn a_name_can_be_anything() {
    for name in ["math", "int", "a--b", "7", "Puma */ #error /* 560"] {
        let mut file = standing("planar2r", "");
        file.name = name.to_owned();
        file.robot.name = name.to_owned();
        let library = written(&file, ScalarChoice::F32, &format!("name_{}", name.len()));
        assert!(!library.1.contains("__") && library.1.contains("arm"), "{}", library.1);
        for compiler in compilers() {
            assert!(golden(compiler, &STRICT, &library).ends_with("0 of 8 states differ\n"), "{name}");
        }
    }
}

#[test]
fn literals_in_single_precision_are_refused() {
    if !is_here("gcc") {
        skipped("there is no gcc on this machine");
        return;
    }
    let (folder, prefix) = written(&scene("planar2r_swing.toml"), ScalarChoice::F64, "literals");
    let sources = [folder.join(format!("src/{prefix}.c"))];
    let error = compiled("gcc", &["-fsingle-precision-constant", "-c"], &folder, &sources).unwrap_err();
    assert!(error.contains("arm_literals_are_double"), "{error}");
}

#[test]
fn a_sine_that_is_not_written_in_c_is_refused() {
    let mut file = standing("planar2r", "");
    file.control.trig = Method::Table;
    let error = c_library(&file, ScalarChoice::F32).unwrap_err().to_string();
    assert!(error.contains("control.trig = \"table\"") && error.contains("expected \"polynomial\""), "{error}");
}
