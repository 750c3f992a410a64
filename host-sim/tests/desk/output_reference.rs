//! The reference of the program's output: keys of `--json`, columns of logs and topics of MCAP files, compared with real output.

use crate::program::{at_the_top, new, told};
use serde_json::Value;
use sim::run::mcap_file::reader::{Item, Reader};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

const PAGE: &str = "docs/reference/output-files.md";

const HEAD: &str = "# Output files

> Generated from the program's output by `UPDATE_EMITTED=1 cargo nextest run --workspace -E 'test(reference_of_the_output)'`; a test compares it.

[Formats](formats.md) says what a version means and for how long a format is read. Units are SI units and radians. Numbers that JSON cannot hold (NaN, infinity) are `null`.

## `log.csv` of a run

One row a tick. `N` is the number of a joint, from 1.

| column | unit | meaning |
|---|---|---|
| `t` | s | time of the tick |
| `qN_reference`, `qN` | rad, m | reference and measured position |
| `qdN_reference`, `qdN` | rad/s, m/s | reference and measured velocity |
| `tauN` | N m, N | commanded torque or force |
| `limitsN` | - | limits that acted, as bits: [the list](../safety/protections.md) |
| `fault` | - | [number of the fault](../operate/faults.md); 0 for none |

## MCAP

`--mcap` of `run` and `--record FILE.mcap` of `connect` write JSON messages for Foxglove and PlotJuggler. A run has these topics; the log time is the time of the simulation.
";

const JSON_HEAD: &str = "
## JSON

`[]` is an entry of a list, `{}` a key that is a name of yours. The example is from the call above its table. `connect --json` prints an object for each event:
`about` (the command or the kind of event), `text` (the message), and `status` with `tick`, `state`, `cause`, `joint`, `homed`, `room`, `refused`, `q`, `torque`, `limits`, `external`, `wrench` and
`heat`, or `null` before the board has reported.
";

/// Calls whose output the page shows; `OUT` is a folder of this test.
const CALLS: [&str; 13] = [
    "check robots/yam.toml --json",
    "identify robots/yam.toml --log OUT/identify/log.csv --json",
    "run scenes/puma560_pick.toml --duration 0.1 --no-report --out OUT/run --json",
    "explain scenes/puma560_auto.toml --json",
    "choose bound scenes/planar2r_swing.toml --json",
    "choose margins scenes/planar2r_swing.toml --json",
    "model dynamics robots/ur5.toml --input scenes/example_states.jsonl",
    "model terms robots/planar2r.toml --q 0.1,0.2 --qd 0.3,0.4 --json",
    "model statics robots/planar2r.toml --q 0.1,0.2 --json",
    "model contact robots/planar2r.toml --q 0.1,0.2 --tip-wrench 1,0,0,0,0,0 --json",
    "model energy scenes/planar2r_swing.toml --duration 0.2 --out OUT/energy --json",
    "model linkage robots/chapter12/four_bar.toml --out OUT/linkage --json",
    "sweep scenes/studies/pick_payload_friction.toml --runs 4 --out OUT/sweep --json",
];

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn called(call: &str, folder: &Path) -> (i32, String, String) {
    let words: Vec<_> = call.split(' ').map(|word| word.replace("OUT", folder.to_str().unwrap())).collect();
    told(at_the_top().args(words).output().unwrap())
}

/// Keys of a value with their types and first examples, by their paths.
fn keys(value: &Value, path: &str, found: &mut BTreeMap<String, (Vec<&'static str>, String)>) {
    match value {
        Value::Object(fields) => {
            for (key, field) in fields {
                // The name of a joint or a link is chosen by the user.
                let key = if key.contains(' ') || key.contains('/') { "{}" } else { key };
                keys(field, &if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }, found);
            }
        }
        Value::Array(entries) => {
            entries.iter().for_each(|entry| keys(entry, &format!("{path}[]"), found));
            if entries.is_empty() {
                found.entry(format!("{path}[]")).or_default();
            }
        }
        _ => {
            let (kind, example) = match value {
                Value::Null => ("null", String::new()),
                Value::Bool(x) => ("bool", x.to_string()),
                Value::Number(x) => (
                    "number",
                    x.as_f64().map_or_else(String::new, |x| {
                        format!("{x:.4}").trim_end_matches('0').trim_end_matches('.').to_owned()
                    }),
                ),
                Value::String(x) => {
                    ("text", x.chars().take(50).collect::<String>().replace('|', "\\|").replace('\n', " "))
                }
                Value::Array(_) | Value::Object(_) => unreachable!("handled above"),
            };
            let entry = found.entry(path.to_owned()).or_default();
            if !entry.0.contains(&kind) {
                entry.0.push(kind);
                entry.0.sort_unstable();
            }
            if entry.1.is_empty() {
                entry.1 = example;
            }
        }
    }
}

/// Topics of an MCAP file, and the keys of their messages.
fn topics(file: &Path) -> String {
    let bytes = fs::read(file).unwrap();
    let mut found: BTreeMap<String, BTreeMap<String, (Vec<&'static str>, String)>> = BTreeMap::new();
    for item in Reader::new(&bytes) {
        if let Item::Message(message) = item.unwrap() {
            keys(&serde_json::from_slice(&message.data).unwrap(), "", found.entry(message.topic).or_default());
        }
    }
    let mut text = "\n| topic | keys |\n|---|---|\n".to_owned();
    for (topic, keys) in found {
        let keys: Vec<_> = keys.keys().map(|key| format!("`{key}`")).collect();
        let _ = writeln!(text, "| `{topic}` | {} |", keys.join(", "));
    }
    text
}

/// The page without the examples, which differ between machines.
fn shape(page: &str) -> Vec<String> {
    page.lines()
        .map(|line| {
            line.rsplit_once(" | ").filter(|_| line.starts_with("| `")).map_or(line, |(keys, _)| keys).to_owned()
        })
        .collect()
}

#[test]
fn the_reference_of_the_output_is_the_programs_own() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("output_reference");
    fs::create_dir_all(new(&folder)).unwrap();
    for call in [
        "run scenes/examples/yam_identify.toml --quiet --no-report --out OUT/identify",
        "run scenes/planar2r_swing.toml --quiet --no-report --duration 0.1 --out OUT/a --mcap OUT/a.mcap",
    ] {
        assert_eq!(called(call, &folder).0, 0, "{call}");
    }
    let mut page = HEAD.to_owned() + &topics(&folder.join("a.mcap")) + JSON_HEAD;
    for call in CALLS {
        let (code, out, error) = called(call, &folder);
        assert!([0, 3].contains(&code) && !out.is_empty(), "{call}: {code} {error}");
        let mut found = BTreeMap::new();
        let values: Vec<Value> = serde_json::Deserializer::from_str(&out).into_iter().map(Result::unwrap).collect();
        values.iter().for_each(|value| keys(value, "", &mut found));
        let _ =
            write!(page, "\n### `newtau {}`\n\n| key | type | example |\n|---|---|---|\n", call.replace("OUT", "out"));
        for (key, (kinds, example)) in found {
            let example = example.replace(folder.to_str().unwrap(), "out").replace(top().to_str().unwrap(), "");
            let _ = writeln!(page, "| `{key}` | {} | {example} |", kinds.join(" or "));
        }
    }
    let file = top().join(PAGE);
    if std::env::var_os("UPDATE_EMITTED").is_some() {
        fs::write(&file, &page).unwrap();
    }
    let (shown, made) = (shape(&fs::read_to_string(&file).unwrap_or_default()), shape(&page));
    let missing: Vec<_> = made.iter().filter(|line| !shown.contains(line)).collect();
    let stale: Vec<_> = shown.iter().filter(|line| !made.contains(line)).collect();
    assert!(missing.is_empty() && stale.is_empty(), "{PAGE} lacks {missing:#?} and has {stale:#?}");
}

#[test]
fn keys_of_lists_and_names_are_found() {
    let mut found = BTreeMap::new();
    keys(&serde_json::json!({ "a": [{ "b": 1.5 }, { "b": null, "c": "x" }], "left elbow": true }), "", &mut found);
    let all: Vec<_> = found.iter().map(|(key, (kinds, _))| (key.as_str(), kinds.join(" "))).collect();
    assert_eq!(all, [("a[].b", "null number".to_owned()), ("a[].c", "text".to_owned()), ("{}", "bool".to_owned())]);
}
