//! The Sobol sequence: points that fill a box more evenly than random ones.
//!
//! Direction numbers: S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional projections", SIAM J. Sci. Comput.
//! 30 (2008), their list `new-joe-kuo-6`, dimensions 1 to 32. A digital shift, the same for all points, replaces the point at the
//! corner and makes the mean of a study's figures unbiased.

/// For each dimension except the first: the primitive polynomial with its coefficients as bits, and the first direction numbers.
const DIRECTIONS: [(u64, &[u64]); 31] = [
    (3, &[1]),
    (7, &[1, 3]),
    (11, &[1, 3, 1]),
    (13, &[1, 1, 1]),
    (19, &[1, 1, 3, 3]),
    (25, &[1, 3, 5, 13]),
    (37, &[1, 1, 5, 5, 17]),
    (41, &[1, 1, 5, 5, 5]),
    (47, &[1, 1, 7, 11, 19]),
    (55, &[1, 1, 5, 1, 1]),
    (59, &[1, 1, 1, 3, 11]),
    (61, &[1, 3, 5, 5, 31]),
    (67, &[1, 3, 3, 9, 7, 49]),
    (91, &[1, 1, 1, 15, 21, 21]),
    (97, &[1, 3, 1, 13, 27, 49]),
    (103, &[1, 1, 1, 15, 7, 5]),
    (109, &[1, 3, 1, 15, 13, 25]),
    (115, &[1, 1, 5, 5, 19, 61]),
    (131, &[1, 3, 7, 11, 23, 15, 103]),
    (137, &[1, 3, 7, 13, 13, 15, 69]),
    (143, &[1, 1, 3, 13, 7, 35, 63]),
    (145, &[1, 3, 5, 9, 1, 25, 53]),
    (157, &[1, 3, 1, 13, 9, 35, 107]),
    (167, &[1, 3, 1, 5, 27, 61, 31]),
    (171, &[1, 1, 5, 11, 19, 41, 61]),
    (185, &[1, 3, 5, 3, 3, 13, 69]),
    (191, &[1, 1, 7, 13, 1, 19, 1]),
    (193, &[1, 3, 7, 5, 13, 19, 59]),
    (203, &[1, 1, 3, 9, 25, 29, 41]),
    (211, &[1, 3, 5, 13, 23, 1, 55]),
    (213, &[1, 3, 7, 3, 13, 59, 17]),
];

/// Number of bits of an index and of a coordinate.
const BITS: usize = 64;

/// One dimension of the sequence.
#[derive(Clone, Debug)]
pub(super) struct Dimension {
    directions: [u64; BITS],
    shift: u64,
}

impl Dimension {
    /// Creates dimension `number`, counted from 0, with a digital shift; `None` beyond the 32nd.
    pub(super) fn new(number: usize, shift: u64) -> Option<Self> {
        let mut m = [0_u64; BITS];
        match number.checked_sub(1) {
            None => m.fill(1),
            Some(row) => {
                let (polynomial, first) = DIRECTIONS.get(row)?;
                let degree = first.len();
                m.iter_mut().zip(*first).for_each(|(m, first)| *m = *first);
                // m_k = 2 a_1 m_(k-1) ^ 4 a_2 m_(k-2) ^ ... ^ 2^s m_(k-s) ^ m_(k-s)
                for k in degree..BITS {
                    let taps = (1..=degree).filter(|j| polynomial >> (degree - j) & 1 == 1);
                    m[k] = taps.fold(m[k - degree], |sum, j| sum ^ (m[k - j] << j));
                }
            }
        }
        Some(Self { directions: core::array::from_fn(|k| m[k] << (BITS - 1 - k)), shift })
    }

    /// Coordinate of the point with this index, as a fraction of 2^64.
    pub(super) fn at(&self, index: u64) -> u64 {
        // Use Gray code order, in which other programs number the points.
        let gray = index ^ (index >> 1);
        let chosen = self.directions.iter().enumerate().filter(|(bit, _)| gray >> bit & 1 == 1);
        chosen.fold(self.shift, |sum, (_, direction)| sum ^ direction)
    }
}

#[cfg(test)]
mod tests {
    use super::Dimension;

    /// Points of SciPy 1.17's `qmc.Sobol(6, scramble=False)`.
    const POINTS: [[f64; 6]; 8] = [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.5, 0.5, 0.5, 0.5, 0.5, 0.5],
        [0.75, 0.25, 0.25, 0.25, 0.75, 0.75],
        [0.25, 0.75, 0.75, 0.75, 0.25, 0.25],
        [0.375, 0.375, 0.625, 0.875, 0.375, 0.125],
        [0.875, 0.875, 0.125, 0.375, 0.875, 0.625],
        [0.625, 0.125, 0.875, 0.625, 0.625, 0.875],
        [0.125, 0.625, 0.375, 0.125, 0.125, 0.375],
    ];

    #[test]
    fn the_first_points_are_those_of_another_program() {
        for (index, point) in POINTS.iter().enumerate() {
            for (number, expected) in point.iter().enumerate() {
                let found = Dimension::new(number, 0).unwrap().at(index as u64) as f64 / 2_f64.powi(64);
                assert!((found - expected).abs() < 1e-15, "point {index}, dimension {number}: {found}");
            }
        }
    }

    #[test]
    fn every_dimension_fills_its_side_evenly_whatever_the_shift() {
        for number in 0..32 {
            let dimension = Dimension::new(number, 0x9e37_79b9_7f4a_7c15).unwrap();
            let mut cells = [false; 256];
            (0..256).for_each(|index| cells[(dimension.at(index) >> 56) as usize] = true);
            assert!(cells.iter().all(|hit| *hit), "dimension {number}");
        }
        assert!(Dimension::new(32, 0).is_none());
    }
}
