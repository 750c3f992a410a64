//! Gravity torques, optimised by hand: the reference for a kernel of gravity alone.
#![allow(clippy::disallowed_types, reason = "constants alone: the compiler gives each scalar its literal")]

use dynamics_core::{Scalar, SinCos};

/// Standard gravity in the plain scene, m/s^2.
const G: f64 = 9.81;

/// Returns the gravity torques of the Puma 560 (`robots/puma560.toml`) on the floor, N m: the derivatives of its potential energy.
///
/// Joint 1 is along gravity; joints 2 and 3 are parallel and horizontal; the mass of the wrist is on its axes. So
/// `U = A s2 + B c2 + C s23 + D c23 + E (c23 c5 - s23 c4 s5)`, and the torques of joints 1 and 6 are zero.
///
/// Cost: 16 multiplications, 8 additions and subtractions.
pub fn puma560<S: Scalar>(turn: &[SinCos<S>; 6]) -> [S; 6] {
    // Masses (kg) of links 2 to 6, their first moments and the distances between the joints (m), as in the file.
    const M2: f64 = 17.4;
    const M3: f64 = 4.8;
    const M4: f64 = 0.82;
    const M5: f64 = 0.34;
    const M6: f64 = 0.09;
    const A2: f64 = 0.4318;
    const A3: f64 = 0.0203;
    const D4: f64 = 0.4318;
    const A: f64 = G * (M2 * (A2 - 0.3638) + (M3 + M4 + M5 + M6) * A2);
    const B: f64 = G * M2 * 0.006;
    const C: f64 = G * (M3 * (A3 - 0.0203) + (M4 + M5 + M6) * A3);
    const D: f64 = G * (M3 * 0.07 + M4 * (0.019 + D4) + (M5 + M6) * D4);
    const E: f64 = G * M6 * 0.032;

    let [_, two, three, four, five, _] = turn;
    let s23 = two.sin * three.cos + two.cos * three.sin;
    let c23 = two.cos * three.cos - two.sin * three.sin;
    let e_s5 = S::literal(-E) * five.sin;
    let e_c5 = S::literal(E) * five.cos;
    let tau3 = c23 * (S::literal(C) + four.cos * e_s5) - s23 * (S::literal(D) + e_c5);
    let tau2 = S::literal(A) * two.cos - S::literal(B) * two.sin + tau3;
    let tau4 = -(s23 * (four.sin * e_s5));
    let tau5 = c23 * e_s5 - s23 * four.cos * e_c5;
    [S::zero(), tau2, tau3, tau4, tau5, S::zero()]
}
