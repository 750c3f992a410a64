//! Measures sine and cosine of six joints: this project's, libm's, and the platform's (glibc's on Linux).
#![allow(clippy::disallowed_methods, reason = "the platform's functions are what is compared with")]

mod timing;

use dynamics_core::trig::{Libm, Polynomial};
use dynamics_core::{Real, SinCos, Trig};
use std::hint::black_box;
use timing::{Contestant, instruction_set, shortest};

const STATES: usize = 1024;

/// Angles within +-3 rad.
fn angles<S: Real>() -> Vec<[S; 6]> {
    let mut seed = 1_u64;
    (0..STATES)
        .map(|_| {
            core::array::from_fn(|_| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                S::literal(3.0 * ((seed >> 40) as f64 / f64::from(1 << 23) - 1.0))
            })
        })
        .collect()
}

/// Separate functions that are not inlined, as a caller would use them.
#[inline(never)]
fn polynomial<S: Real>(q: &[S; 6]) -> [SinCos<S>; 6]
where
    Polynomial: Trig<S>,
{
    Polynomial.sin_cos_all(q)
}

#[inline(never)]
fn libm<S: Real>(q: &[S; 6]) -> [SinCos<S>; 6]
where
    Libm: Trig<S>,
{
    Libm.sin_cos_all(q)
}

#[inline(never)]
fn platform_f64(q: &[f64; 6]) -> [SinCos<f64>; 6] {
    q.map(|q| SinCos { sin: q.sin(), cos: q.cos() })
}

#[inline(never)]
fn platform_f32(q: &[f32; 6]) -> [SinCos<f32>; 6] {
    q.map(|q| SinCos { sin: q.sin(), cos: q.cos() })
}

fn contestant<'a, S>(name: &'static str, angles: &'a [[S; 6]], all: fn(&[S; 6]) -> [SinCos<S>; 6]) -> Contestant<'a> {
    let run = move || {
        for q in angles {
            black_box(all(black_box(q)));
        }
    };
    (name, Box::new(run))
}

fn main() {
    let (double, single) = (angles::<f64>(), angles::<f32>());
    let mut contestants = [
        contestant("f64, ours", &double, polynomial),
        contestant("f64, libm", &double, libm),
        contestant("f64, platform", &double, platform_f64),
        contestant("f32, ours", &single, polynomial),
        contestant("f32, libm", &single, libm),
        contestant("f32, platform", &single, platform_f32),
    ];
    let times = shortest(&mut contestants, STATES);
    println!("six pairs, ns, {}", instruction_set());
    for ((name, _), time) in contestants.iter().zip(times) {
        println!("{name:<14} {time:6.1}");
    }
}
