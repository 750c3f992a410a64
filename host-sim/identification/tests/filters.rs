//! Filters and even time.

use identification::filter::{LowPass, derivative, even_times, spline};
use std::f64::consts::TAU;

fn wave(frequency: f64, rate: f64) -> Vec<f64> {
    (0..1000).map(|k| (TAU * frequency * k as f64 / rate).sin()).collect()
}

#[test]
fn a_low_pass_lets_slow_motion_through_without_delay_and_halves_its_cut_off() {
    let filter = LowPass::new(8.0, 100.0);
    for (frequency, gain, allowed) in [(1.0, 1.0, 1e-3), (8.0, 0.5, 0.01), (24.0, 0.0, 1e-3)] {
        let (x, y) = (wave(frequency, 100.0), filter.apply(&wave(frequency, 100.0)));
        // Away from the ends, the output is in phase.
        let worst = (200..800).map(|k| (y[k] - gain * x[k]).abs()).fold(0.0, f64::max);
        assert!(worst < allowed, "{frequency} Hz: {worst}");
    }
}

#[test]
fn a_low_pass_keeps_straight_lines_to_their_ends() {
    let line: Vec<f64> = (0..500).map(|k| 2.0 - 0.01 * f64::from(k)).collect();
    for (x, y) in line.iter().zip(LowPass::new(8.0, 100.0).apply(&line)) {
        assert!((x - y).abs() < 1e-4, "{x}, {y}");
    }
}

#[test]
fn uneven_samples_of_a_wave_become_even_ones() {
    let time: Vec<f64> = (0..500).map(|k| 0.01 * f64::from(k) + 0.002 * f64::from(k % 3)).collect();
    let x: Vec<f64> = time.iter().map(|t| (TAU * t).sin()).collect();
    let even = even_times(&time, 100.0);
    for (t, y) in even.iter().zip(spline(&time, &x, &even)).skip(20).take(400) {
        assert!((y - (TAU * t).sin()).abs() < 1e-5, "{t}");
    }
}

#[test]
fn the_derivative_of_a_wave_is_its_slope() {
    let x = wave(0.5, 100.0);
    for (k, slope) in derivative(&x, 100.0).iter().enumerate().skip(1).take(900) {
        let wanted = TAU * 0.5 * (TAU * 0.5 * k as f64 / 100.0).cos();
        assert!((slope - wanted).abs() < 1e-3 * TAU, "{slope}, {wanted}");
    }
}
