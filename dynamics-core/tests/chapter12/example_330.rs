//! Example 330: the general 2R arm's equations in matrix form.

use super::support::{Letters, STATED, TwoLinks, two_links};
use super::support_b::{Equations, G, STATED_2, State, assert_equal, assert_stated};
use nalgebra::{Matrix2, Vector2};

/// Eq. 12.141-12.150.
struct Z {
    z1: f64,
    z2: f64,
    z3: f64,
    z4: f64,
    z5: f64,
    z6: f64,
    z7: f64,
    z8: f64,
    z9: f64,
    z10: f64,
}

impl Z {
    fn of(arm: &TwoLinks) -> Self {
        let TwoLinks { l1, l2, c1, c2, m1, m2, iz1, iz2, m0 } = *arm;
        Self {
            z1: iz2 + m2 * c2 * c2,
            z2: m2 * l2 * c2,
            z3: m2 * l1 * c2,
            z4: iz1 + m1 * c1 * c1,
            z5: m2 * l1 * l1,
            z6: m2 * l1 * (2.0 * c2 - l2),
            z7: m2 * l1 * l2,
            z8: m2 * l1 * (l2 - c2),
            z9: (m2 * c2 + m0 * l2) * G,
            z10: (m0 * l1 + m1 * c1 + m2 * l1) * G,
        }
    }
}

/// Eq. 12.138-12.140, corrected, in the order `(Q0, Q1)`; `Z2` and `Z6` to `Z8` do not occur in them.
fn equations(arm: &TwoLinks, state: &State<2>) -> Equations<2> {
    let Letters { sin2, cos2, cos1, cos12, w1, w2, w12, .. } = Letters::of(state);
    let Z { z1, z3, z4, z5, z9, z10, .. } = Z::of(arm);
    let beside = z1 + z3 * cos2;
    Equations {
        d: Matrix2::new(z1 + z4 + z5 + 2.0 * z3 * cos2, beside, beside, z1),
        c: Matrix2::new(-w2, -w12, w1, 0.0) * (z3 * sin2),
        g: Vector2::new(z9 * cos12 + z10 * cos1, z9 * cos12),
    }
}

/// As printed, with its rows `(Q1, Q0)` brought into the same order. The printed sign in `G` holds for a signed `g`.
fn printed(arm: &TwoLinks, state: &State<2>) -> Equations<2> {
    let Letters { sin2, cos2, cos1, cos12, w1, w2, .. } = Letters::of(state);
    let Z { z1, z2, z3, z4, z5, z6, z7, z8, z9, z10 } = Z::of(arm);
    Equations {
        d: Matrix2::new(z1 + z4 - z2 + z5 + z6 * cos2, z1 + z3 * cos2, z1 - z2 + z3 * cos2, z1),
        c: Matrix2::new(-z7 * w1 - z8 * w2, z3 * w2 - z8 * w1, -z3 * w1, 0.0) * sin2,
        g: Vector2::new(z9 * cos12 - z10 * cos1, z9 * cos12),
    }
}

#[test]
fn the_corrected_matrices_are_those_of_the_recursion() {
    assert_equal("12.138-12.150", two_links(), |(arm, state)| {
        let arm = TwoLinks { m0: 0.0, ..arm };
        equations(&arm, &state).error(&arm.dynamics(), &state)
    });
    assert_equal("12.140 with a payload", two_links(), |(arm, state)| {
        let Equations { g, .. } = Equations::of(&arm.dynamics(), &state.q, &state.qd);
        (equations(&arm, &state).g - g).amax() / (Z::of(&arm).z9 + Z::of(&arm).z10)
    });
}

#[test]
fn the_printed_matrices_are_wrong() {
    let right = Equations::of(&TwoLinks { m0: 0.0, ..STATED }.dynamics(), &STATED_2.q, &STATED_2.qd);
    let wrong = printed(&TwoLinks { m0: 0.0, ..STATED }, &STATED_2);
    let found = [
        (wrong.d - right.d).amax() / right.d.amax(),
        (wrong.c - right.c).amax() / right.c.amax(),
        (wrong.g - right.g).amax() / right.g.amax(),
        // An inertia matrix is symmetric.
        (wrong.d[(0, 1)] - wrong.d[(1, 0)]).abs() / right.d.amax(),
    ];
    assert_stated(&found, &[0.36663, 2.3077, 1.9036, 0.11935]);
}
