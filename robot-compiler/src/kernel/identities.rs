//! Level `regrouped`: what is equal in every state is computed once, and what is always zero not at all.
//!
//! Rules on single operations cannot see that `s^2 + c^2` is one, or that the weight of an arm has no moment about a vertical
//! axis. A few random states can: two expressions that agree in all of them, to the last bits of f64, are the same function
//! of the state, for functions that are polynomials in positions, sines and cosines cannot agree there by accident. Sines and
//! cosines are those of one angle, so their identities count. An agreement that is off by a rounding error would be worth a
//! rounding error.

use super::program::needed;
use super::rules::RuleSet;
use super::tape::{Arena, Expr, Node, Precision};
use std::collections::{BTreeMap, HashMap};

/// How many states are looked at.
const STATES: usize = 3;

/// What an expression is in each state.
type Values = [f64; STATES];

/// Whether two numbers are the same, given the size of what they were made of. A test puts a wrong one in.
pub(super) type Same = fn(f64, f64, f64) -> bool;

/// The right one: up to rounding.
pub(super) const SAME: Same = |a, b, size| (a - b).abs() <= 1e-13 * size;

/// An expression that stays, what it is, and the size of the terms that it was summed from.
struct Known {
    place: Expr,
    values: Values,
    sizes: Values,
}

/// The outputs on a new tape, with every expression replaced by an equal, an opposite or a number that is known before it.
///
/// `joints` says which inputs are sine and cosine of the same angle; see [`super::functions`].
#[must_use]
pub(super) fn once(
    arena: &Arena,
    outputs: &[Expr],
    joints: usize,
    precision: Precision,
    same: Same,
) -> (Arena, Vec<Expr>) {
    let mut fresh = Arena::new(RuleSet::ALL, precision);
    let mut moved: HashMap<Expr, usize> = HashMap::new();
    let mut known: Vec<Known> = Vec::new();
    let mut by_value: BTreeMap<i64, usize> = BTreeMap::new();
    for expr in needed(arena, outputs) {
        let node = arena.node(expr);
        let of = |e: Expr| moved.get(&e).and_then(|&k| known.get(k));
        let at = |e: Expr| of(e).map_or(e, |k| k.place);
        let (values, sizes) = evaluate(node, joints, &of);
        // Near in the first state, and then in all.
        let find = |sign: f64| {
            let (middle, reach) = (sign * values[0], NEAR * sizes[0]);
            let mut near = by_value.range(ordered(middle - reach)..=ordered(middle + reach)).map(|(_, &k)| &known[k]);
            let agrees =
                |k: &&Known| (0..STATES).all(|s| same(values[s], sign * k.values[s], sizes[s].max(k.sizes[s])));
            near.find(agrees).map(|k| k.place)
        };
        let place = match node {
            Node::Constant(bits) => fresh.constant(f64::from_bits(bits)),
            Node::Input(_) => fresh.write(node),
            Node::Add(..) | Node::Sub(..) | Node::Mul(..) | Node::Div(..) | Node::Neg(_) => {
                if let Some(number) =
                    [0.0, 1.0].into_iter().find(|x| (0..STATES).all(|s| same(values[s], *x, sizes[s])))
                {
                    fresh.constant(number)
                } else if let Some(equal) = find(1.0) {
                    equal
                } else if let Some(opposite) = find(-1.0) {
                    fresh.make(Node::Neg(opposite))
                } else {
                    fresh.make(node.map(at))
                }
            }
        };
        if let Some(label) = arena.label(expr) {
            fresh.name(place, label);
        }
        by_value.entry(ordered(values[0])).or_insert(known.len());
        moved.insert(expr, known.len());
        known.push(Known { place, values, sizes });
    }
    let at = |e: &Expr| moved.get(e).and_then(|&k| known.get(k)).map_or(*e, |k| k.place);
    let outputs = outputs.iter().map(at).collect();
    (fresh, outputs)
}

/// How far apart equal values are looked for, relative to the size of their terms; [`SAME`] is stricter.
const NEAR: f64 = 1e-12;

/// A whole number that orders as the value does.
fn ordered(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    if bits < 0 { i64::MIN.wrapping_sub(bits) } else { bits }
}

/// A node's values from those of its operands.
fn evaluate<'a>(node: Node, joints: usize, of: &dyn Fn(Expr) -> Option<&'a Known>) -> (Values, Values) {
    let values = |e: Expr| of(e).map_or([f64::NAN; STATES], |k| k.values);
    let sizes = |e: Expr| of(e).map_or([f64::NAN; STATES], |k| k.sizes);
    let each = |f: &dyn Fn(usize) -> f64| -> Values { core::array::from_fn(f) };
    match node {
        Node::Constant(bits) => ([f64::from_bits(bits); STATES], [f64::from_bits(bits).abs(); STATES]),
        Node::Input(number) => {
            let x = each(&|s| input(number as usize, joints, s));
            (x, x.map(f64::abs))
        }
        Node::Neg(a) => (values(a).map(|x| -x), sizes(a)),
        Node::Add(a, b) => {
            let (x, y, p, q) = (values(a), values(b), sizes(a), sizes(b));
            (each(&|s| x[s] + y[s]), each(&|s| p[s] + q[s]))
        }
        Node::Sub(a, b) => {
            let (x, y, p, q) = (values(a), values(b), sizes(a), sizes(b));
            (each(&|s| x[s] - y[s]), each(&|s| p[s] + q[s]))
        }
        Node::Mul(a, b) => {
            let (x, y, p, q) = (values(a), values(b), sizes(a), sizes(b));
            (each(&|s| x[s] * y[s]), each(&|s| p[s] * q[s]))
        }
        Node::Div(a, b) => {
            let (x, y, p) = (values(a), values(b), sizes(a));
            (each(&|s| x[s] / y[s]), each(&|s| p[s] / y[s].abs()))
        }
    }
}

/// Value of an input in a state: numbers between 1 and 2 of either sign, none the same; sine and cosine of one angle.
fn input(number: usize, joints: usize, state: usize) -> f64 {
    let random = |n: usize| {
        // SplitMix64 (Steele, Lea and Flood, 2014). Evenly spaced numbers would have sums and differences in common.
        let mut z = ((n * STATES + state + 1) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        let x = 1.0 + (z >> 12) as f64 / (1_u64 << 52) as f64;
        if z & 1 == 0 { x } else { -x }
    };
    match number / joints {
        0 => libm::sin(random(number)),
        1 => libm::cos(random(number - joints)),
        _ => random(number),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tape::{input, trace};
    use super::*;

    /// Operations that are left of a function of an arm with two joints: sines are inputs 0 and 1, cosines 2 and 3.
    fn left<const M: usize>(f: impl FnOnce([Expr; 6]) -> [Expr; M]) -> usize {
        let (outputs, arena) =
            trace(Arena::new(RuleSet::ALL, Precision::Double), || f(core::array::from_fn(|i| input(i as u32))));
        let (arena, outputs) = once(&arena, &outputs, 2, Precision::Double, SAME);
        super::super::program::operations(&arena, &outputs)
    }

    #[test]
    fn squares_of_sine_and_cosine_of_one_angle_make_one() {
        assert_eq!(left(|[s, _, c, _, x, _]| [(s * s + c * c) * x]), 0);
        // Of two angles they do not.
        assert_eq!(left(|[s, _, _, c, x, _]| [(s * s + c * c) * x]), 4);
    }

    #[test]
    fn what_was_summed_in_another_order_or_multiplied_out_is_known() {
        assert_eq!(left(|[.., x, y]| [(x + y) * x, x * x + y * x]), 4);
        assert_eq!(left(|[a, b, .., x, y]| [(x + a) + (y + b), (y + a) + (b + x)]), 3);
        assert_eq!(left(|[a, .., x, y]| [x * a - y * a, (y - x) * a]), 3);
    }

    #[test]
    fn what_is_always_zero_is_not_computed() {
        assert_eq!(left(|[s, _, c, _, x, y]| [(x * s + y * c) * c - (x * c - y * s) * s - y]), 0);
    }
}
