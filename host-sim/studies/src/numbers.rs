//! Parsing of number lists from the user, and formatting of numbers.

use dynamics_core::{Real, Wrench};
use nalgebra::Vector3;

/// Converts a list to `K` numbers of the scalar.
pub(crate) fn numbers<S: Real, const K: usize>(name: &str, values: &[f64], meaning: &str) -> Result<[S; K], String> {
    let wrong = |_| {
        let count = |n: usize| if n == 1 { "1 number".to_owned() } else { format!("{n} numbers") };
        format!("`{name}` has {}; expected {}: {meaning}", count(values.len()), count(K))
    };
    let values: [f64; K] = values.try_into().map_err(wrong)?;
    let cast = values.map(S::literal);
    match cast.iter().position(|x| !x.is_finite()) {
        None => Ok(cast),
        Some(i) => Err(format!("entry {} of `{name}`, {:e}, is too large for the scalar", i + 1, values[i])),
    }
}

/// Converts a list to `K` finite numbers.
pub(super) fn finite<const K: usize>(name: &str, values: &[f64], meaning: &str) -> Result<[f64; K], String> {
    finite_entries(name, values)?;
    numbers::<f64, K>(name, values, meaning)
}

/// Converts a list to force (N) and moment (N m).
pub(super) fn wrench(name: &str, values: &[f64]) -> Result<Wrench<f64>, String> {
    let [fx, fy, fz, mx, my, mz] = finite::<6>(name, values, "fx, fy, fz, mx, my, mz")?;
    Ok(Wrench { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) })
}

/// Checks that all numbers are finite.
pub(super) fn finite_entries(name: &str, values: &[f64]) -> Result<(), String> {
    match values.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => Err(format!("entry {} of `{name}` is {}; expected a finite number", i + 1, values[i])),
    }
}

/// Formats with three digits.
pub(super) fn digits(value: f64) -> String {
    let decimals = if value == 0.0 { 0 } else { (2 - value.abs().log10().floor() as i32).clamp(0, 6) as usize };
    format!("{value:.decimals$}")
}
