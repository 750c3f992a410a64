//! Linear systems without structure: Gaussian elimination with row exchanges.
//!
//! For the book's own systems, with every unknown of every free body at once. The recursions never solve a system; the
//! one of [`crate::forward_dynamics`] is symmetric and has its own factorisation.

use crate::scalar::Real;

/// `x` with `A x = b`; `None` if `A` is singular, to rounding, or if a number is not finite.
///
/// Singular: in some column no pivot is left that is above `N eps max |A|`. The entries of `A` should be of similar magnitude.
pub(crate) fn solve<S: Real, const N: usize>(mut a: [[S; N]; N], mut b: [S; N]) -> Option<[S; N]> {
    solve_rows(a.as_flattened_mut(), &mut b).then_some(b)
}

/// As [`solve`], with as many unknowns as `b` has entries: `a` holds the rows one after another, and `b` becomes `x`.
/// Both are overwritten, also if it returns `false`.
///
/// O(N^3): N^3 / 3 multiplications, N divisions.
pub(crate) fn solve_rows<S: Real>(a: &mut [S], b: &mut [S]) -> bool {
    let n = b.len();
    debug_assert_eq!(a.len(), n * n);
    let floor = a.iter().fold(S::zero(), |most, x| if x.abs() > most { x.abs() } else { most }) * rounding(n);
    for k in 0..n {
        let mut pivot = k;
        for i in k + 1..n {
            if a[i * n + k].abs() > a[pivot * n + k].abs() {
                pivot = i;
            }
        }
        let size = a[pivot * n + k].abs();
        if !(size > floor && size.is_finite()) {
            return false;
        }
        if pivot != k {
            for j in k..n {
                a.swap(k * n + j, pivot * n + j);
            }
            b.swap(k, pivot);
        }
        let inverse = S::one() / a[k * n + k];
        for i in k + 1..n {
            let ratio = a[i * n + k] * inverse;
            for j in k + 1..n {
                let taken = ratio * a[k * n + j];
                a[i * n + j] -= taken;
            }
            let taken = ratio * b[k];
            b[i] -= taken;
        }
    }
    for k in (0..n).rev() {
        for j in k + 1..n {
            let taken = a[k * n + j] * b[j];
            b[k] -= taken;
        }
        b[k] = b[k] / a[k * n + k];
    }
    b.iter().all(|x| x.is_finite())
}

/// `n eps` of the scalar: four thirds, rounded, miss one and a third by a third of `eps`.
pub(crate) fn rounding<S: Real>(n: usize) -> S {
    let four_thirds = S::literal(4.0) / S::literal(3.0);
    let eps = ((four_thirds - S::one()) * S::literal(3.0) - S::one()).abs();
    eps * S::from_i32(n as i32)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "exactness is what is claimed")]
mod tests {
    use super::{rounding, solve};
    use crate::scalar::Real;

    #[test]
    fn a_zero_in_the_corner_is_exchanged_and_the_answer_is_exact() {
        // det = -1: by hand, x = (1, -2, 3).
        let a = [[0.0, 2.0, 1.0], [1.0, 1.0, 0.0], [2.0, 3.0, 1.0]];
        assert_eq!(solve(a, [-1.0, -1.0, -1.0]), Some([1.0, -2.0, 3.0]));
    }

    #[test]
    fn a_hilbert_matrix_loses_its_conditioning_and_no_more() {
        let a: [[f64; 5]; 5] = core::array::from_fn(|i| core::array::from_fn(|j| 1.0 / (i + j + 1) as f64));
        let b = core::array::from_fn(|i| a[i].iter().sum());
        let x = solve(a, b).unwrap();
        let worst = x.iter().fold(0.0_f64, |worst, x| worst.max((x - 1.0).abs()));
        // Condition number 4.8e5.
        assert!(worst > 0.0 && worst < 4.8e5 * f64::EPSILON, "{worst:e}");
    }

    #[test]
    fn what_is_singular_to_rounding_or_not_finite_has_no_answer() {
        let b = [1.0, 1.0, 1.0];
        assert_eq!(solve([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [0.7, 0.8, 0.9]], b), None);
        assert_eq!(solve([[0.0; 3]; 3], b), None);
        assert_eq!(solve([[1.0, 0.0, 0.0], [0.0, f64::NAN, 0.0], [0.0, 0.0, 1.0]], b), None);
        assert_eq!(solve([[1.0, 0.0, 0.0], [0.0, 1.0, f64::NAN], [0.0, 0.0, 1.0]], b), None);
        assert_eq!(solve([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, f64::INFINITY]], b), None);
        assert_eq!(solve([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [1.0, f64::NAN, 1.0]), None);
    }

    #[test]
    fn one_unit_in_the_last_place_is_known() {
        assert_eq!(rounding::<f32>(1), f32::EPSILON);
        assert_eq!(rounding::<f64>(3).to_f64(), 3.0 * f64::EPSILON);
    }
}
