//! The values of a run, which depend only on the study and the run's index.

use super::normal;
use super::sobol::Dimension;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use robot_compiler::study::{Design, Drawn, Runs, Values, Vary};

/// Generator of the values of a study's keys.
#[derive(Clone, Debug)]
pub(super) struct Draw {
    design: Design,
    /// Generator of the seed, at the start of its first stream.
    random: ChaCha8Rng,
    /// One dimension for each varied key, if the design is a Sobol sequence.
    sobol: Vec<Dimension>,
}

/// Random stream for the digital shift; no index uses it.
const SHIFT_STREAM: u64 = u64::MAX;

impl Draw {
    /// Creates the generator for a study with `keys` varied keys.
    pub(super) fn new(runs: &Runs, keys: usize) -> Self {
        let random = ChaCha8Rng::seed_from_u64(runs.seed);
        let mut shifts = random.clone();
        shifts.set_stream(SHIFT_STREAM);
        let dimension = |number| Dimension::new(number, shifts.next_u64());
        let sobol = if runs.design == Design::Sobol { (0..keys).filter_map(dimension).collect() } else { Vec::new() };
        Self { design: runs.design, random, sobol }
    }

    /// Draws the values of the run with this index.
    pub(super) fn values<'a>(&self, vary: &'a [Vary], index: u64) -> Vec<Drawn<'a>> {
        match self.design {
            Design::Grid => grid(vary, index),
            Design::Sobol => {
                vary.iter().zip(&self.sobol).map(|(vary, sobol)| at(&vary.values, unit(sobol.at(index)))).collect()
            }
            Design::Random => {
                let mut random = self.random.clone();
                random.set_stream(index);
                vary.iter().map(|vary| at(&vary.values, unit(random.next_u64()))).collect()
            }
        }
    }
}

/// Converts 64 bits to a number between 0 and 1, both excluded.
fn unit(bits: u64) -> f64 {
    // 52 bits and a half are exact; one bit more would round up to 1.
    ((bits >> 12) as f64 + 0.5) * f64::EPSILON
}

/// The combination of a grid with this index; the last key changes fastest.
fn grid(vary: &[Vary], index: u64) -> Vec<Drawn<'_>> {
    let mut rest = index;
    let mut values: Vec<Drawn<'_>> = vary
        .iter()
        .rev()
        .map(|vary| {
            let steps = vary.steps.max(1);
            let step = rest % steps;
            rest /= steps;
            match &vary.values {
                Values::List(_) | Values::Whole(..) => of_countable(&vary.values, step),
                continuous => at(continuous, step as f64 / (steps - 1).max(1) as f64),
            }
        })
        .collect();
    values.reverse();
    values
}

/// Value number `number` of a countable set of values.
fn of_countable(values: &Values, number: u64) -> Drawn<'_> {
    match values {
        Values::List(list) => list.get(number as usize).map_or(Drawn::Whole(0), Drawn::Listed),
        Values::Whole(low, _) => Drawn::Whole(low + number as i64),
        _ => Drawn::Whole(0),
    }
}

/// Quantile of the values at the share `u`.
fn at(values: &Values, u: f64) -> Drawn<'_> {
    let within = |x: f64, low: f64, high: f64| Drawn::Number(x.clamp(low, high));
    match *values {
        Values::Uniform(low, high) => within(low + (high - low) * u, low, high),
        Values::LogUniform(low, high) => {
            let (from, to) = (libm::log(low), libm::log(high));
            // The ends of a grid are exact.
            if u <= 0.0 {
                Drawn::Number(low)
            } else if u >= 1.0 {
                Drawn::Number(high)
            } else {
                within(libm::exp(from + (to - from) * u), low, high)
            }
        }
        Values::Normal { mean, deviation, within: (low, high) } => {
            let from = normal::below((low - mean) / deviation);
            let to = normal::below((high - mean) / deviation);
            within(mean + deviation * normal::inverse(from + (to - from) * u), low, high)
        }
        Values::Whole(..) | Values::List(_) => {
            let count = values.countable().unwrap_or(1);
            of_countable(values, ((u * count as f64) as u64).min(count - 1))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Draw, at, unit};
    use robot_compiler::study::{Drawn, Study, Values, Vary};
    use std::path::Path;

    fn study(runs: &str) -> (Draw, Vec<Vary>) {
        let text = format!(
            "name = \"any\"\nscene = \"any.toml\"\n[runs]\n{runs}\n[[metric]]\nname = \"drift\"\n\
             [[vary]]\nkey = \"a\"\nuniform = [-1.0, 3.0]\nSTEPS\n[[vary]]\nkey = \"b\"\nwhole = [2, 4]\n\
             [[vary]]\nkey = \"c\"\nlist = [\"x\", \"y\"]\n"
        );
        let text = text.replace("STEPS", if runs.contains("grid") { "steps = 5" } else { "" });
        let study = Study::from_toml_str(&text, Path::new("any.toml")).unwrap();
        let experiment = study.experiment;
        (Draw::new(&study.runs, experiment.vary.len()), experiment.vary)
    }

    fn number(drawn: Drawn<'_>) -> f64 {
        match drawn {
            Drawn::Number(x) => x,
            Drawn::Whole(x) => x as f64,
            Drawn::Listed(value) => f64::from(u8::from(value.cell == "y")),
        }
    }

    #[test]
    fn a_run_s_values_are_the_same_whatever_was_drawn_before() {
        for runs in ["count = 1000", "sobol = 1000"] {
            let (draw, vary) = study(runs);
            let forward: Vec<_> = (0..100).map(|index| draw.values(&vary, index)).collect();
            let (again, vary) = study(runs);
            for index in (0..100).rev() {
                assert_eq!(again.values(&vary, index), forward[index as usize]);
            }
            let (other, vary) = study(&format!("{runs}\nseed = 2"));
            assert_ne!(other.values(&vary, 7), forward[7]);
        }
    }

    #[test]
    fn drawn_values_keep_their_ranges_and_their_means() {
        for (runs, near) in [("count = 1000", 0.1), ("sobol = 1024", 0.01)] {
            let (draw, vary) = study(runs);
            let all: Vec<Vec<f64>> =
                (0..1024).map(|index| draw.values(&vary, index).into_iter().map(number).collect()).collect();
            let mean = |k: usize| all.iter().map(|values| values[k]).sum::<f64>() / 1024.0;
            assert!(all.iter().all(|v| (-1.0..=3.0).contains(&v[0]) && [2.0, 3.0, 4.0].contains(&v[1])));
            assert!((mean(0) - 1.0).abs() < near && (mean(1) - 3.0).abs() < near && (mean(2) - 0.5).abs() < near);
        }
    }

    #[test]
    fn a_grid_has_every_combination_once_and_both_ends() {
        let (draw, vary) = study("grid = true");
        let mut all: Vec<String> = (0..30).map(|index| format!("{:?}", draw.values(&vary, index))).collect();
        assert!(all[0].starts_with("[Number(-1.0), Whole(2)") && all[29].starts_with("[Number(3.0), Whole(4)"));
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 30);
    }

    #[test]
    fn bits_make_numbers_between_zero_and_one() {
        assert!(unit(0) > 0.0 && unit(u64::MAX) < 1.0 && (unit(1 << 63) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn a_cut_normal_distribution_stays_inside() {
        let values = Values::Normal { mean: 1.0, deviation: 0.5, within: (0.8, f64::INFINITY) };
        for u in [1e-16, 0.1, 0.5, 0.9, 1.0 - 1e-16] {
            let Drawn::Number(x) = at(&values, u) else { panic!("a number") };
            assert!((0.8..6.0).contains(&x), "{u}: {x}");
        }
    }
}
