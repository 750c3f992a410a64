//! Description of a study, for the beginning of its page.

use super::{Results, VERSION};
use crate::sweep::Prepared;
use robot_compiler::study::{Design, Experiment, Relative, Values, Vary};
use sim::failure::number;

impl Results {
    /// Names with their descriptions: scene, keys with their ranges, design, seed, number of runs, version.
    pub(super) fn about(&self, prepared: &Prepared) -> Vec<(String, String)> {
        let study = &prepared.study;
        let mut facts = Vec::new();
        let mut fact = |name: &str, text: String| facts.push((name.to_owned(), text));
        let Experiment { scene, set, vary, .. } = &study.experiment;
        fact("scene", format!("{} ({})", prepared.runs.scene_name, scene.display()));
        for setting in set {
            let value = setting.value.as_deref().map_or("removed".to_owned(), |value| format!("= {value}"));
            fact("set", format!("{} {value}", setting.key.name));
        }
        for vary in vary {
            fact("varied", format!("{}: {}", vary.key.name, range(vary)));
        }
        let design = match study.runs.design {
            Design::Random => format!("random, seed {}", study.runs.seed),
            Design::Sobol => format!("Sobol sequence, seed {}", study.runs.seed),
            Design::Grid => "grid: every combination".to_owned(),
        };
        fact("design", design);
        fact("runs", self.runs.to_string());
        fact("host-sim", VERSION.to_owned());
        facts
    }
}

/// Description of the values of a key.
fn range(vary: &Vary) -> String {
    let values = match &vary.values {
        Values::Uniform(low, high) => format!("{} to {}", number(*low), number(*high)),
        Values::LogUniform(low, high) => format!("{} to {}, logarithm uniform", number(*low), number(*high)),
        Values::Normal { mean, deviation, within: (low, high) } => {
            let cut = if low.is_finite() || high.is_finite() {
                format!(", within {} to {}", number(*low), number(*high))
            } else {
                String::new()
            };
            format!("normal, mean {}, deviation {}{cut}", number(*mean), number(*deviation))
        }
        Values::Whole(low, high) => format!("whole numbers {low} to {high}"),
        Values::List(list) => listed(list.iter().map(|value| value.cell.as_str())),
    };
    let steps = match vary.values {
        Values::Uniform(..) | Values::LogUniform(..) if vary.steps > 0 => format!(" in {} steps", vary.steps),
        _ => String::new(),
    };
    let relative = match vary.relative {
        Relative::Value => "",
        Relative::Factor => ", times the file's own value",
        Relative::Offset => ", added to the file's own value",
    };
    format!("{values}{steps}{relative}")
}

/// The values that fit on a page, and the number of further ones.
fn listed<'a>(values: impl ExactSizeIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 20;
    let more = values.len().saturating_sub(SHOWN);
    let shown: Vec<&str> = values.take(SHOWN).collect();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    shown.join(", ") + &more
}

#[cfg(test)]
mod tests {
    use super::{listed, range};
    use robot_compiler::study::Study;
    use std::path::Path;

    #[test]
    fn values_are_reported_in_words() {
        let text = "name = \"a\"\nscene = \"a.toml\"\n[runs]\ncount = 9\n[[metric]]\nname = \"drift\"\n\
            [[vary]]\nkey = \"a\"\nuniform = [0.5, 2.0]\nrelative = \"factor\"\n\
            [[vary]]\nkey = \"b\"\nnormal = { mean = 1.0, deviation = 0.2, within = [0.5, 1.5] }\n\
            [[vary]]\nkey = \"c\"\nwhole = [0, 3]\n[[vary]]\nkey = \"d\"\nlist = [\"pd\", \"teach\"]\n";
        let study = Study::from_toml_str(text, Path::new("a.toml")).unwrap();
        let experiment = study.experiment;
        let words: Vec<String> = experiment.vary.iter().map(range).collect();
        assert_eq!(
            words,
            [
                "0.5 to 2, times the file's own value",
                "normal, mean 1, deviation 0.2, within 0.5 to 1.5",
                "whole numbers 0 to 3",
                "pd, teach"
            ]
        );
        assert!(listed(["x"; 23].into_iter()).ends_with("x and 3 more"));
    }
}
