//! Times on the desk. criterion stores its estimates in files, from which `cargo xtask bench` writes the tables; divan 0.1 only prints them.
//!
//! One iteration runs through all states; `cargo xtask bench` divides by their number.
#![allow(clippy::unwrap_used, unreachable_pub, reason = "a measurement stops at the first surprise")]

mod list;

use bench::states::DESK;
use criterion::Criterion;
use std::time::Duration;

fn main() {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(300))
        .sample_size(30)
        .configure_from_args();
    for work in list::all() {
        criterion.bench_function(&work.name, |b| b.iter(|| (work.run)(DESK)));
    }
    criterion.final_summary();
}
