//! Instructions on the desk, counted by callgrind through gungraun; `cargo xtask bench` compares them with `bench/baseline.toml`.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::panic,
    unreachable_pub,
    reason = "a measurement stops at the first surprise"
)]

mod list;

use gungraun::{library_benchmark, library_benchmark_group, main};
use list::Work;

/// Number of states that a benchmark runs through; `cargo xtask bench` divides by it.
const STATES: usize = 64;

fn find(name: &str) -> Work {
    list::all().into_iter().find(|work| work.name == name).unwrap_or_else(|| panic!("nothing is called {name}"))
}

// The attribute does not work inside a macro.
#[library_benchmark(setup = find)]
#[bench::trig_polynomial_f64("trig_polynomial_f64")]
#[bench::trig_polynomial_f32("trig_polynomial_f32")]
#[bench::ur5_generic_f64("ur5_generic_f64")]
#[bench::ur5_exact_f64("ur5_exact_f64")]
#[bench::ur5_regrouped_f64("ur5_regrouped_f64")]
#[bench::ur5_regrouped_f64_with_trig("ur5_regrouped_f64_with_trig")]
#[bench::ur5_regrouped_f64_with_libm("ur5_regrouped_f64_with_libm")]
#[bench::ur5_generic_f32("ur5_generic_f32")]
#[bench::ur5_exact_f32("ur5_exact_f32")]
#[bench::ur5_regrouped_f32("ur5_regrouped_f32")]
#[bench::ur5_gravity_f64("ur5_gravity_f64")]
#[bench::ur5_mass_matrix_f64("ur5_mass_matrix_f64")]
#[bench::puma560_generic_f64("puma560_generic_f64")]
#[bench::puma560_exact_f64("puma560_exact_f64")]
#[bench::puma560_regrouped_f64("puma560_regrouped_f64")]
#[bench::puma560_regrouped_f64_with_trig("puma560_regrouped_f64_with_trig")]
#[bench::puma560_regrouped_f64_with_libm("puma560_regrouped_f64_with_libm")]
#[bench::puma560_generic_f32("puma560_generic_f32")]
#[bench::puma560_exact_f32("puma560_exact_f32")]
#[bench::puma560_regrouped_f32("puma560_regrouped_f32")]
#[bench::puma560_gravity_f64("puma560_gravity_f64")]
#[bench::puma560_mass_matrix_f64("puma560_mass_matrix_f64")]
#[bench::stanford_generic_f64("stanford_generic_f64")]
#[bench::stanford_exact_f64("stanford_exact_f64")]
#[bench::stanford_regrouped_f64("stanford_regrouped_f64")]
#[bench::stanford_regrouped_f64_with_trig("stanford_regrouped_f64_with_trig")]
#[bench::stanford_regrouped_f64_with_libm("stanford_regrouped_f64_with_libm")]
#[bench::stanford_generic_f32("stanford_generic_f32")]
#[bench::stanford_exact_f32("stanford_exact_f32")]
#[bench::stanford_regrouped_f32("stanford_regrouped_f32")]
#[bench::stanford_gravity_f64("stanford_gravity_f64")]
#[bench::stanford_mass_matrix_f64("stanford_mass_matrix_f64")]
fn work(work: Work) {
    (work.run)(STATES);
}

library_benchmark_group!(name = all, benchmarks = [work]);
main!(library_benchmark_groups = all);
