//! Fuzz target: any bytes as states for `newtau model dynamics`, one JSON object per line.

use crate::fuzz::FuzzTarget;
use crate::fuzz::examples::{files, top};
use dynamics_core::trig::Libm;
use dynamics_core::{Model, Real, Trig};
use robot_compiler::Robot;
use serde_json::Value;
use sim::failure::Failure;
use std::collections::BTreeMap;
use std::sync::LazyLock;
use studies::dynamics::answer_all;

/// Lines for arms with one, two, four and six joints.
pub const TARGET: FuzzTarget =
    FuzzTarget { name: "json_lines", check, examples, words: include_str!("../../words/json.dict") };

fn examples() -> Vec<Vec<u8>> {
    let mut all = files(&["scenes"], "jsonl");
    for joints in [1, 2, 4, 6] {
        let list = vec!["0.5"; joints].join(", ");
        let all_fields = format!(
            r#"{{"q": [{list}], "qd": [{list}], "qdd": [{list}], "tau": [{list}], "wrench_tip": [1, 2, 3, 4, 5, 6], "gravity": [0, 1, -9.81]}}"#
        );
        all.push(format!("{{\"q\": [{list}]}}\n\n{{\"q\": [{list}], \"qd\": [{list}]}}\r\n{all_fields}").into());
    }
    all
}

static ONE: LazyLock<Model<f64, 1>> = LazyLock::new(|| model("chapter12/one_link"));
static TWO: LazyLock<Model<f64, 2>> = LazyLock::new(|| model("planar2r"));
static FOUR: LazyLock<Model<f64, 4>> = LazyLock::new(|| model("scara"));
static SIX: LazyLock<Model<f64, 6>> = LazyLock::new(|| model("ur5"));

fn model<const N: usize>(name: &str) -> Model<f64, N> {
    Robot::load(&top("robots").join(format!("{name}.toml"))).unwrap().model().unwrap()
}

/// In both precisions every line is answered up to the first rejected one, which the error names. Each answer belongs to its question, and its
/// numbers are consistent.
pub fn check(bytes: &[u8]) {
    check_arm(&ONE, bytes);
    check_arm(&TWO, bytes);
    check_arm(&FOUR, bytes);
    check_arm(&SIX, bytes);
}

fn check_arm<const N: usize>(model: &Model<f64, N>, bytes: &[u8]) {
    check_in(model, bytes, 1e-9);
    check_in(&model.cast::<f32>(), bytes, 1e-3);
}

fn check_in<S: Real, const N: usize>(model: &Model<S, N>, bytes: &[u8], rounding: f64)
where
    Libm: Trig<S>,
{
    let mut output = Vec::new();
    let result = answer_all(model, &[0.0, 0.0, -9.81], "any.jsonl", &mut &bytes[..], &mut output);
    let answers = String::from_utf8(output).unwrap();
    // A byte order mark at the start is no part of the text.
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let mut answers = answers.lines();
    let mut refused = None;
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        // Invalid UTF-8 does not count as an empty line.
        if std::str::from_utf8(line).is_ok_and(|line| line.trim().is_empty()) {
            continue;
        }
        match answers.next() {
            Some(answer) => check_answer::<N>(line, answer, rounding),
            None => {
                refused = Some(index + 1);
                break;
            }
        }
    }
    assert_eq!(answers.next(), None, "an answer to nothing");
    match (result, refused) {
        (Ok(()), None) => {}
        (Err(Failure::Input(report)), Some(line)) => {
            let text = report.to_string();
            assert!(text.starts_with(&format!("any.jsonl, line {line}: ")) && report.help().is_some(), "{text}");
        }
        (other, line) => panic!("{other:?} with line {line:?} unanswered"),
    }
}

type Fields = BTreeMap<String, Value>;

/// Checks that the answer belongs to the line, and that `D qdd + C qd + G` is the torque without an external wrench, within `rounding` of its parts.
fn check_answer<const N: usize>(line: &[u8], answer: &str, rounding: f64) {
    let question: Fields = serde_json::from_slice(line).unwrap();
    let answer: Fields = serde_json::from_str(answer).unwrap();
    for (name, value) in &question {
        let length = match name.as_str() {
            "q" | "qd" | "qdd" | "tau" => N,
            "wrench_tip" => 6,
            "gravity" => 3,
            other => panic!("`{other}` was passed over"),
        };
        assert!(name != "q" || !value.is_null(), "no posture");
        assert!(value.is_null() || numbers(value).len() == length, "{name}: {value}");
    }
    let given = |name: &str| question.get(name).filter(|value| !value.is_null()).map(numbers);
    let list = |name: &str| -> [f64; N] { numbers(&answer[name]).try_into().unwrap() };
    let (tau, gravity, coriolis) = (list("tau"), list("gravity"), list("coriolis_qd"));
    assert_eq!(answer.contains_key("qdd"), given("tau").is_some());
    if given("tau").is_some() {
        list("qdd");
    }
    let matrix: Vec<Vec<f64>> = answer["mass_matrix"].as_array().unwrap().iter().map(numbers).collect();
    assert!(matrix.len() == N && matrix.iter().all(|row| row.len() == N), "{matrix:?}");
    for (i, row) in matrix.iter().enumerate() {
        assert!(row[i] >= 0.0 && (0..i).all(|j| row[j].to_bits() == matrix[j][i].to_bits()), "{matrix:?}");
    }

    let still = vec![0.0; N];
    let (qd, qdd) = (given("qd").unwrap_or(still.clone()), given("qdd").unwrap_or(still));
    let position = given("q").unwrap().iter().fold(0.0_f64, |most, q| most.max(q.abs()));
    let pull = given("gravity").unwrap_or(vec![9.81]).iter().map(|x| x.abs()).fold(0.0, f64::max);
    // If a prismatic joint is extended very far, rounding loses the position of the tip.
    if given("wrench_tip").is_some_and(|wrench| wrench.iter().any(|x| *x != 0.0)) || position > 10.0 {
        return;
    }
    // Size of the terms that may cancel: each arm is lighter than 100 kg and shorter than 10 m, including 10 m for a
    // prismatic joint.
    let speed = qd.iter().map(|x| x.abs()).sum::<f64>();
    let acceleration = qdd.iter().map(|x| x.abs()).sum::<f64>();
    let parts = 1e4 * (speed * speed + acceleration) + 1e3 * pull;
    for (i, row) in matrix.iter().enumerate() {
        let sum = row.iter().zip(&qdd).map(|(d, qdd)| d * qdd).sum::<f64>() + coriolis[i] + gravity[i];
        let near = (tau[i] - sum).abs() <= rounding * parts;
        // The sum may overflow although the recursion did not.
        assert!(near || !sum.is_finite(), "joint {i}: {} and {sum} of {parts}", tau[i]);
    }
}

/// A list of finite numbers.
fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap_or_else(|| panic!("{value} is no list"));
    list.iter().map(|x| x.as_f64().filter(|x| x.is_finite()).unwrap_or_else(|| panic!("{x} in {value}"))).collect()
}
