//! Measures the time of the kernel compiler, from the model to the source text, for the arm that needs the most work. Prints
//! `LEVEL,milliseconds`, the shortest of several runs.

use bench::general;
use robot_compiler::emit::kernel::{Title, module};
use robot_compiler::kernel::{Function, Level, Precision};
use std::error::Error;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Number of runs; the fastest counts.
const RUNS: usize = 10;

fn main() -> Result<(), Box<dyn Error>> {
    let (model, scene) = general::arm()?;
    let title = Title { robot: "general 6R", scene: "everything", hash: 0 };
    for level in Level::ALL {
        let run = || {
            let begin = Instant::now();
            black_box(module(Function::InverseDynamics, &model, &scene, level, Precision::Single, &title));
            begin.elapsed()
        };
        let least = (0..RUNS).map(|_| run()).min().unwrap_or(Duration::MAX);
        println!("{},{:.2}", level.name(), least.as_secs_f64() * 1e3);
    }
    Ok(())
}
