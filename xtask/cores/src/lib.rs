//! The program for every core: the inverse dynamics of a UR5 by both kernels, six sines and cosines, and whole control ticks, in both precisions.
//!
//! [`run`] calls back once for each row with a hash of all results and the time of one evaluation. Hashes that are equal come from equal bits.
//! Some angles are subnormal, and so are their sines: a core that flushes these to zero gets another hash.
#![cfg_attr(feature = "bare", no_std)]

use core::hint::black_box;
#[cfg(feature = "c")]
use dynamics_core::SinCos;
use dynamics_core::{Command, Fault, Measurement, Reference, Sensed};

/// Number of states.
pub const STATES: usize = 24;

/// Number of consecutive control ticks.
pub const TICKS: usize = 16;

/// Results of one row.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Floating-point type.
    pub scalar: &'static str,
    /// The computation.
    pub what: &'static str,
    /// Hash of all results.
    pub hash: u64,
    /// Time of one evaluation, in the clock's units times 1000; 0 without a clock.
    pub time: u64,
}

/// FNV-1a over 64 bits: a byte at a time, the same on every core.
#[derive(Clone, Copy)]
struct Hash(u64);

impl Hash {
    const START: Self = Self(0xcbf2_9ce4_8422_2325);

    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// The next number between -1 and 1 with 20 bits, which both precisions represent exactly.
fn next(seed: &mut u32) -> i32 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*seed >> 11) as i32 - (1 << 20)
}

/// The time of one evaluation: of `count` evaluations by `work`, less those by `idle`, which reads the same inputs.
fn time(clock: &mut dyn FnMut() -> u64, count: u64, mut work: impl FnMut(), mut idle: impl FnMut()) -> u64 {
    let mut of = |work: &mut dyn FnMut()| {
        let start = clock();
        work();
        clock().wrapping_sub(start)
    };
    let (all, empty) = (of(&mut work), of(&mut idle));
    all.saturating_sub(empty) * 1000 / count.max(1)
}

macro_rules! arm {
    ($module:ident, $c:ident, $folder:literal, $real:ident, $scalar:literal, $small:expr, $dynamics:literal, $first:expr) => {
        /// The arm with one kernel in one precision.
        #[allow(missing_docs, unused_imports)]
        pub mod $module {
            include!(concat!(env!("OUT_DIR"), "/", $folder, "/arm.rs"));

            pub fn rows(repeats: u64, clock: &mut dyn FnMut() -> u64, row: &mut dyn FnMut(crate::Row)) {
                use crate::{
                    Command, Fault, Hash, Measurement, Reference, STATES, Sensed, TICKS, black_box, next, time,
                };
                let mut seed = 1;
                let unit = 1.0 / (1u32 << 20) as $real;
                // The angles of the last states are subnormal, and so are their sines.
                let states: [[[$real; N]; 3]; STATES] = core::array::from_fn(|i| {
                    let size: $real = if i < STATES - 6 { 1.0 } else { $small };
                    [3.0, 2.0, 4.0]
                        .map(|most: $real| core::array::from_fn(|_| next(&mut seed) as $real * unit * most * size))
                });
                let evaluations = repeats * STATES as u64;
                let mut hash = Hash::START;
                for [q, qd, qdd] in &states {
                    for tau in inverse_dynamics(q, qd, qdd) {
                        hash.bytes(&tau.to_bits().to_le_bytes());
                    }
                }
                let turns = states.map(|[q, ..]| TRIG.sin_cos_all(&q));
                let live = Live::zero();
                let each = |f: &mut dyn FnMut(usize)| (0..repeats).for_each(|_| (0..STATES).for_each(&mut *f));
                let took = time(
                    clock,
                    evaluations,
                    || {
                        each(&mut |i| {
                            let ([q, qd, qdd], turn) = (black_box(&states[i]), black_box(&turns[i]));
                            black_box(dynamics::arm().inverse_dynamics(turn, q, qd, qdd, &live));
                        });
                    },
                    || {
                        each(&mut |i| {
                            let ([q, ..], _) = (black_box(&states[i]), black_box(&turns[i]));
                            black_box(*q);
                        });
                    },
                );
                row(crate::Row { scalar: $scalar, what: $dynamics, hash: hash.0, time: took });
                #[cfg(feature = "c")]
                {
                    #[allow(unsafe_code)]
                    unsafe extern "C" {
                        fn $c(
                            turn: *const crate::SinCos<$real>,
                            q: *const $real,
                            qd: *const $real,
                            qdd: *const $real,
                            tau: *mut $real,
                        );
                    }
                    let in_c = |i: usize| {
                        let ([q, qd, qdd], turn) = (black_box(&states[i]), black_box(&turns[i]));
                        let mut tau = [0.0; N];
                        // SAFETY: the function reads and writes as many numbers as the arm has joints.
                        unsafe { $c(turn.as_ptr(), q.as_ptr(), qd.as_ptr(), qdd.as_ptr(), tau.as_mut_ptr()) };
                        tau
                    };
                    let mut hash = Hash::START;
                    for tau in (0..STATES).flat_map(in_c) {
                        hash.bytes(&tau.to_bits().to_le_bytes());
                    }
                    let took = time(
                        clock,
                        evaluations,
                        || {
                            each(&mut |i| {
                                black_box(in_c(i));
                            });
                        },
                        || {
                            each(&mut |i| {
                                let ([q, ..], _) = (black_box(&states[i]), black_box(&turns[i]));
                                black_box(*q);
                            });
                        },
                    );
                    row(crate::Row { scalar: $scalar, what: concat!($dynamics, ", in C"), hash: hash.0, time: took });
                }
                if !$first {
                    return;
                }
                let mut hash = Hash::START;
                for turn in turns.iter().flatten() {
                    hash.bytes(&turn.sin.to_bits().to_le_bytes());
                    hash.bytes(&turn.cos.to_bits().to_le_bytes());
                }
                let took = time(
                    clock,
                    evaluations,
                    || {
                        each(&mut |i| {
                            black_box(TRIG.sin_cos_all(&black_box(&states[i])[0]));
                        });
                    },
                    || {
                        each(&mut |i| {
                            black_box(black_box(&states[i])[0]);
                        });
                    },
                );
                row(crate::Row { scalar: $scalar, what: "six sines and cosines", hash: hash.0, time: took });
                // A slow motion of all joints; the measured state lags behind the reference.
                let tick = |k: usize| {
                    let at = |t: $real, joint: usize| (joint as $real + 1.0) * 0.125 + t * 0.000_976_562_5;
                    let q = core::array::from_fn(|joint| at(k as $real + 0.5, joint));
                    let measured = core::array::from_fn(|joint| at(k as $real, joint));
                    let (qd, qdd) = ([0.976_562_5; N], [0.25; N]);
                    (
                        Reference { q, qd, qdd },
                        Measurement { sensed: Sensed::State { q: measured, qd: [0.968_75; N] }, age_ticks: 0 },
                    )
                };
                let ticks: [_; TICKS] = core::array::from_fn(tick);
                let mut hash = Hash::START;
                let mut controller = controller();
                for (reference, measurement) in &ticks {
                    match controller.tick(reference, measurement) {
                        Command::Drive { torque, .. } => {
                            torque.iter().for_each(|tau| hash.bytes(&tau.to_bits().to_le_bytes()));
                        }
                        // No tick of these is a fault; if one is, the hash is another one.
                        Command::Brake(fault) => hash.bytes(&[Fault::code(&fault)]),
                    }
                }
                let took = time(
                    clock,
                    TICKS as u64,
                    || {
                        let mut controller = self::controller();
                        for (reference, measurement) in &ticks {
                            black_box(controller.tick(black_box(reference), black_box(measurement)));
                        }
                    },
                    || {
                        black_box(self::controller());
                        for (reference, measurement) in &ticks {
                            black_box(black_box(reference).q);
                            black_box(measurement);
                        }
                    },
                );
                row(crate::Row { scalar: $scalar, what: "control tick", hash: hash.0, time: took });
            }
        }
    };
}

arm!(exact_f32, exact_f32_arm_inverse_dynamics_at, "exact_f32", f32, "f32", 1e-39, "inverse dynamics, exact", true);
arm!(
    regrouped_f32,
    regrouped_f32_arm_inverse_dynamics_at,
    "regrouped_f32",
    f32,
    "f32",
    1e-39,
    "inverse dynamics, regrouped",
    false
);
arm!(exact_f64, exact_f64_arm_inverse_dynamics_at, "exact_f64", f64, "f64", 1e-309, "inverse dynamics, exact", true);
arm!(
    regrouped_f64,
    regrouped_f64_arm_inverse_dynamics_at,
    "regrouped_f64",
    f64,
    "f64",
    1e-309,
    "inverse dynamics, regrouped",
    false
);

/// Computes every row; those in f64 if `double`. `repeats` is the number of times that all states are computed for the time.
pub fn run(double: bool, repeats: u64, clock: &mut dyn FnMut() -> u64, row: &mut dyn FnMut(Row)) {
    exact_f32::rows(repeats, clock, row);
    regrouped_f32::rows(repeats, clock, row);
    if double {
        exact_f64::rows(repeats, clock, row);
        regrouped_f64::rows(repeats, clock, row);
    }
}

/// For WebAssembly: the hash of row number `row`, or 0 beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn newtau_hash(row: u32) -> u64 {
    let (mut found, mut at) = (0, 0);
    run(true, 0, &mut || 0, &mut |one: Row| {
        if at == row {
            found = one.hash;
        }
        at += 1;
    });
    found
}
