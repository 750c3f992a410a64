//! Level `regrouped`: expressions that are equal in every state are computed once, and those that are always zero are not computed
//! at all.
//!
//! Rules on single operations cannot detect that `s^2 + c^2` is one, or that the weight of an arm has no moment about a
//! vertical axis. Evaluation at a random state can. The state is in a finite field, the whole numbers modulo a prime above `2^60`, in which
//! nothing is rounded. Every `f64` constant has an exact representation there, a sine and its cosine are a random point of the
//! circle `s^2 + c^2 = 1`, and all other inputs are random. Two different polynomials of degree `d` agree in such a state
//! with a probability of at most `d / 2^60` (Schwartz 1980, Zippel 1979). So expressions that agree there are treated as the same function
//! of the state.
//!
//! The identities are those of the arm with its constants as written. Expressions that differ only in the rounding of
//! a constant (such as the sine of a twist of 30 degrees) count as different.

use super::arena::{Arena, Expr, Node, Precision};
use super::program::needed;
use super::rules::RuleSet;
use rustc_hash::FxHashMap;

/// Sine and cosine of a random angle, in the field. A test replaces this by a wrong one.
pub(super) type Angle = fn(Element) -> [Element; 2];

/// The correct one: `2 t / (1 + t^2)`, `(1 - t^2) / (1 + t^2)`.
pub(super) const ANGLE: Angle = |t| {
    let (one, square) = (Element(1), t.times(t));
    // Minus one has no square root modulo this prime: the sum is not zero.
    let all = one.plus(square).inverse();
    [t.plus(t).times(all), one.plus(square.negative()).times(all)]
};

/// The outputs on a new tape. Every expression is replaced by an earlier one that is equal or opposite, or by a number.
///
/// `joints` determines which inputs are sine and cosine of the same angle; see [`super::functions`].
#[must_use]
pub(super) fn once(
    arena: &Arena,
    outputs: &[Expr],
    joints: usize,
    precision: Precision,
    angle: Angle,
) -> (Arena, Vec<Expr>) {
    let mut fresh = Arena::new(RuleSet::ALL, precision);
    let mut moved: FxHashMap<Expr, (Expr, Element)> = FxHashMap::default();
    let mut known: FxHashMap<Element, Expr> = FxHashMap::default();
    for (k, expr) in needed(arena, outputs).into_iter().enumerate() {
        let node = arena.node(expr);
        let of = |e: Expr| moved.get(&e).map_or((e, Element(0)), |found| *found);
        let value = match node {
            Node::Constant(bits) => Element::from_f64(f64::from_bits(bits)),
            Node::Input(number) => Some(input(number as usize, joints, angle)),
            Node::Add(a, b) => Some(of(a).1.plus(of(b).1)),
            Node::Sub(a, b) => Some(of(a).1.plus(of(b).1.negative())),
            Node::Mul(a, b) => Some(of(a).1.times(of(b).1)),
            Node::Neg(a) => Some(of(a).1.negative()),
            Node::Div(a, b) => Some(of(b).1).filter(|b| *b != Element(0)).map(|b| of(a).1.times(b.inverse())),
        };
        // An expression without a value in the field gets a random one, which equals no other.
        let value = value.unwrap_or_else(|| Element::random(usize::MAX - k));
        let place = match node {
            Node::Constant(bits) => fresh.constant(f64::from_bits(bits)),
            Node::Input(_) => fresh.write(node),
            Node::Add(..) | Node::Sub(..) | Node::Mul(..) | Node::Div(..) | Node::Neg(_) => match value {
                Element(0) => fresh.constant(0.0),
                Element(1) => fresh.constant(1.0),
                _ => match (known.get(&value), known.get(&value.negative())) {
                    (Some(&equal), _) => equal,
                    (None, Some(&opposite)) => fresh.make(Node::Neg(opposite)),
                    (None, None) => fresh.make(node.map(|operand| of(operand).0)),
                },
            },
        };
        if let Some(label) = arena.label(expr) {
            fresh.name(place, label);
        }
        known.entry(value).or_insert(place);
        moved.insert(expr, (place, value));
    }
    let outputs = outputs.iter().map(|e| moved.get(e).map_or(*e, |(place, _)| *place)).collect();
    (fresh, outputs)
}

/// Value of an input in the random state.
fn input(number: usize, joints: usize, angle: Angle) -> Element {
    let [sin, cos] = angle(Element::random(number % joints));
    match number / joints {
        0 => sin,
        1 => cos,
        _ => Element::random(number),
    }
}

/// A whole number modulo [`PRIME`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Element(u64);

/// A prime near `2^61` divided by the golden ratio, and 3 modulo 4. Constants are whole numbers times powers of two, so these
/// powers must be far from small numbers: modulo `2^61 - 1` a constant of `2^-61`, the rounding of a rotation, would be 1.
const PRIME: u64 = 1_425_089_352_415_399_771;

/// `2^-1074` multiplied by 2 again and again: every power of two in an `f64`.
static POWERS: [u64; 2046] = {
    let mut power = 1_u64;
    let mut halvings = 0;
    while halvings < 1074 {
        power = if power.is_multiple_of(2) { power / 2 } else { power.midpoint(PRIME) };
        halvings += 1;
    }
    let mut powers = [0; 2046];
    let mut k = 0;
    while k < powers.len() {
        powers[k] = power;
        power = 2 * power % PRIME;
        k += 1;
    }
    powers
};

impl Element {
    /// `SplitMix64` (Steele, Lea and Flood, 2014).
    fn random(number: usize) -> Self {
        let mut z = (number as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self((z ^ (z >> 31)) % PRIME)
    }

    /// The exact representation of a number `m 2^e`; `None` for NaN and infinity.
    fn from_f64(x: f64) -> Option<Self> {
        let bits = x.to_bits();
        let (exponent, fraction) = ((bits >> 52) as usize & 0x7ff, bits & ((1 << 52) - 1));
        let mantissa = match exponent {
            0x7ff => return None,
            0 => fraction,
            _ => fraction | 1 << 52,
        };
        // Subnormal numbers have the exponent of the smallest normal ones.
        let size = Self(mantissa).times(Self(POWERS[exponent.max(1) - 1]));
        Some(if x < 0.0 { size.negative() } else { size })
    }

    fn plus(self, other: Self) -> Self {
        Self((self.0 + other.0) % PRIME)
    }

    fn negative(self) -> Self {
        Self((PRIME - self.0) % PRIME)
    }

    fn times(self, other: Self) -> Self {
        Self((u128::from(self.0) * u128::from(other.0) % u128::from(PRIME)) as u64)
    }

    /// `x^(p - 2)` (Fermat); of zero, zero.
    fn inverse(self) -> Self {
        let (mut power, mut found) = (self, Self(1));
        let mut exponent = PRIME - 2;
        while exponent > 0 {
            if exponent % 2 == 1 {
                found = found.times(power);
            }
            power = power.times(power);
            exponent /= 2;
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::tape::{input, trace};
    use super::*;

    /// Number of operations left in a function of an arm with two joints: sines are inputs 0 and 1, cosines 2 and 3.
    fn left<const M: usize>(f: impl FnOnce([Expr; 6]) -> [Expr; M]) -> usize {
        let (outputs, arena) =
            trace(Arena::new(RuleSet::ALL, Precision::Double), || f(core::array::from_fn(|i| input(i as u32))));
        let (arena, outputs) = once(&arena, &outputs, 2, Precision::Double, ANGLE);
        super::super::program::operations(&arena, &outputs)
    }

    #[test]
    fn squares_of_sine_and_cosine_of_one_angle_make_one() {
        assert_eq!(left(|[s, _, c, _, x, _]| [(s * s + c * c) * x]), 0);
        // The sine and cosine of two different angles give no identity.
        assert_eq!(left(|[s, _, _, c, x, _]| [(s * s + c * c) * x]), 4);
    }

    #[test]
    fn what_was_summed_in_another_order_or_multiplied_out_is_known() {
        assert_eq!(left(|[.., x, y]| [(x + y) * x, x * x + y * x]), 2);
        assert_eq!(left(|[a, b, .., x, y]| [(x + a) + (y + b), (y + a) + (b + x)]), 3);
        assert_eq!(left(|[a, .., x, y]| [x * a - y * a, (y - x) * a]), 3);
        assert_eq!(left(|[a, .., x, y]| [x / a * y, y * x / a]), 2);
    }

    #[test]
    fn what_is_always_zero_is_not_computed() {
        assert_eq!(left(|[s, _, c, _, x, y]| [(x * s + y * c) * c - (x * c - y * s) * s - y]), 0);
        // A quotient by such an expression is unchanged too.
        assert_eq!(left(|[s, _, c, _, x, y]| [x / (s * s + c * c - (x + y) / (y + x)), y]), 1);
    }

    #[test]
    fn no_power_of_two_is_a_small_number() {
        // Covers products of the smallest and of the largest f64 number with another.
        let (two, half) = (Element(2), Element(2).inverse());
        let size = |x: Element| x.0.min(PRIME - x.0);
        let (mut up, mut down) = (Element(1), Element(1));
        for exponent in 1..=2148 {
            (up, down) = (up.times(two), down.times(half));
            assert!(exponent < 49 || size(up) >= 1 << 48, "2^{exponent} is {}", size(up));
            assert!(size(down) >= 1 << 48, "2^-{exponent} is {}", size(down));
        }
    }

    #[test]
    fn the_rounding_of_a_constant_is_no_number_that_is_left_out() {
        let dust = |power: i32| <Expr as dynamics_core::Scalar>::literal(2.0_f64.powi(power));
        for power in [-122, -62, -61, -60, 61] {
            // One multiplication and an addition each; x + y is another sum.
            assert_eq!(left(|[.., x, y]| [x * dust(power) + y, x + y]), 3, "2^{power}");
        }
    }

    #[test]
    fn a_number_has_its_exact_place_in_the_field() {
        let of = |x: f64| Element::from_f64(x).unwrap();
        for (a, b) in [(0.1, 3.7), (-1e-300, 1e300), (5e-324, -0.0), (1.5, f64::MAX), (-7.25, -1e9)] {
            assert_eq!(of(-a), of(a).negative());
            assert_eq!(of(a).plus(of(-a)), Element(0));
            // Powers of two and small sums are exact in f64 as well.
            assert_eq!(of(a).times(of(4.0)), of(a * 4.0));
            assert_eq!(of(b), of(b / 2.0).plus(of(b / 2.0)));
        }
        assert_eq!(of(3.0).times(of(0.375)), of(1.125));
        assert_eq!(of(0.3).times(of(0.3).inverse()), of(1.0));
        assert_eq!(Element::from_f64(f64::NAN), None);
        assert_eq!(Element::from_f64(f64::INFINITY), None);
        let [s, c] = ANGLE(Element::random(5));
        assert_eq!(s.times(s).plus(c.times(c)), Element(1));
    }
}
