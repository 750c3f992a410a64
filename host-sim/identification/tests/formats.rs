//! One log in the formats of many programs: the same samples each time.

use crate::arms::load;
use crate::made::{Making, log};
use identification::Series;
use identification::log::{BadLog, ColumnNames, Log, Reading};

const JOINTS: [&str; 6] = ["base_yaw", "shoulder", "elbow", "wrist_pitch", "wrist_yaw", "wrist_roll"];

fn reading() -> Reading {
    Reading {
        joints: JOINTS.map(str::to_owned).to_vec(),
        turns: vec![true; 6],
        limits: vec![(-3.2, 3.7); 6],
        torque: vec![20.0; 6],
        ..Reading::default()
    }
}

fn truth() -> Log {
    let known = load("yam.toml");
    let mut log = log(&known, &known.parameters, &Making { duration: 2.0, ..Making::default() });
    log.qd = Some(log.q.iter().map(|q| identification::filter::derivative(q, 100.0)).collect());
    log
}

/// A file: names of columns and their values, in the order in which they are written.
#[derive(Clone)]
struct File {
    columns: Vec<(String, Vec<String>)>,
    separator: &'static str,
    comma: bool,
    before: &'static str,
    units: Option<Vec<&'static str>>,
}

fn text(values: &[f64], factor: f64) -> Vec<String> {
    values.iter().map(|x| format!("{:.12}", x * factor)).collect()
}

impl File {
    /// Time, then positions and torques, with these column names and factors.
    fn new(time: &str, names: [&dyn Fn(usize) -> String; 2], factors: [f64; 2]) -> Self {
        let log = truth();
        let mut columns = vec![(time.to_owned(), text(&log.time, 1.0))];
        for ((series, name), factor) in [&log.q, &log.tau].into_iter().zip(names).zip(factors) {
            columns.extend(series.iter().enumerate().map(|(joint, x)| (name(joint), text(x, factor))));
        }
        Self { columns, separator: ",", comma: false, before: "", units: None }
    }

    /// Columns with a joint number in place of `{}`, counted from `first`.
    fn numbered(time: &str, q: &str, tau: &str, first: usize) -> Self {
        let name = |pattern: &'_ str, joint: usize| pattern.replace("{}", &(first + joint).to_string());
        Self::new(time, [&|joint| name(q, joint), &|joint| name(tau, joint)], [1.0, 1.0])
    }

    fn usual() -> Self {
        Self::numbered("time", "q_{}", "tau_{}", 1)
    }

    fn scaled(mut self, q: f64, tau: f64) -> Self {
        let log = truth();
        for (joint, (a, b)) in log.q.iter().zip(&log.tau).enumerate() {
            self.columns[1 + joint].1 = text(a, q);
            self.columns[7 + joint].1 = text(b, tau);
        }
        self
    }

    fn timed(mut self, of: impl Fn(f64) -> String) -> Self {
        self.columns[0].1 = truth().time.iter().map(|t| of(*t)).collect();
        self
    }

    /// Adds a column.
    fn with(mut self, name: &str, of: impl Fn(usize) -> String) -> Self {
        let count = self.columns[0].1.len();
        self.columns.push((name.to_owned(), (0..count).map(of).collect()));
        self
    }

    /// Adds a quantity of all joints.
    fn and(mut self, pattern: &str, first: usize, series: &Series, factor: f64) -> Self {
        for (joint, x) in series.iter().enumerate() {
            self.columns.push((pattern.replace("{}", &(first + joint).to_string()), text(x, factor)));
        }
        self
    }

    fn text(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = self.before.to_owned() + &names.join(self.separator) + "\n";
        if let Some(units) = &self.units {
            text += &(units.join(self.separator) + "\n");
        }
        for k in 0..self.columns[0].1.len() {
            let row: Vec<String> = self
                .columns
                .iter()
                .map(|(_, values)| if self.comma { values[k].replace('.', ",") } else { values[k].clone() })
                .collect();
            text += &(row.join(self.separator) + "\n");
        }
        text
    }

    fn read(&self) -> Result<(Log, Vec<String>), BadLog> {
        Log::read_noted(self.text().as_bytes(), "a.csv", &reading())
    }
}

/// Largest difference of positions, torques (divided by `factor`) and times from the truth.
fn differs(log: &Log, factor: f64) -> f64 {
    let truth = truth();
    let pairs = truth.q.iter().flatten().zip(log.q.iter().flatten()).map(|(a, b)| (a - b).abs());
    let torques = truth.tau.iter().flatten().zip(log.tau.iter().flatten()).map(|(a, b)| (a - b / factor).abs());
    let time = truth.time.iter().zip(&log.time).map(|(a, b)| (a - (b - log.time[0])).abs());
    assert_eq!((truth.time.len(), truth.q.len()), (log.time.len(), log.q.len()));
    pairs.chain(torques).chain(time).fold(0.0, f64::max)
}

fn by_name(pattern: &str) -> impl Fn(usize) -> String {
    let pattern = pattern.to_owned();
    move |joint| pattern.replace("{}", JOINTS[joint])
}

/// Files that contain the same log.
fn files() -> Vec<(&'static str, File)> {
    let deg = 180.0 / std::f64::consts::PI;
    let usual = File::usual;
    let log = truth();
    let qd = log.qd.clone().unwrap();
    let ros =
        || File::numbered("/joint_states/header/stamp", "/joint_states/position[{}]", "/joint_states/effort[{}]", 0);
    // Positions of joint 1 are in the column of index 5, and so on.
    let mut backwards = ros();
    for k in 0..6 {
        backwards.columns[1 + k].0 = format!("/joint_states/position[{}]", 5 - k);
        backwards.columns[7 + k].0 = format!("/joint_states/effort[{}]", 5 - k);
    }
    for k in 0..6 {
        backwards = backwards.with(&format!("/joint_states/name[{}]", 5 - k), |_| JOINTS[k].to_owned());
    }
    let lists = |name: &str, series: &Series| {
        let cell = |k: usize| series.iter().map(|x| format!("{:.12}", x[k])).collect::<Vec<_>>().join(", ");
        (name.to_owned(), (0..log.time.len()).map(|k| format!("\"[{}]\"", cell(k))).collect::<Vec<_>>())
    };
    let listed = File {
        columns: vec![usual().columns[0].clone(), lists("position", &log.q), lists("effort", &log.tau)],
        ..usual()
    };
    vec![
        ("ours", usual()),
        ("units in brackets", File::numbered("time [s]", "q{} [deg]", "tau_{} [mN m]", 1).scaled(deg, 1e3)),
        ("units in parentheses", File::numbered("t (s)", "q{} (deg)", "torque {} (N cm)", 1).scaled(deg, 1e2)),
        ("units as endings", File::numbered("time_s", "q{}_deg", "tau{}_mNm", 1).scaled(deg, 1e3)),
        ("units behind a slash", File::numbered("t / s", "q{} / rad", "tau{} / (N m)", 1)),
        ("signs of degrees", File::numbered("t", "pos{} [°]", "moment{} [N·m]", 1).scaled(deg, 1.0)),
        (
            "a row of units",
            File { units: Some([vec!["s"], vec!["deg"; 6], vec!["Nmm"; 6]].concat()), ..usual().scaled(deg, 1e3) },
        ),
        ("units above the header", {
            let before = "s,deg,deg,deg,deg,deg,deg,Nmm,Nmm,Nmm,Nmm,Nmm,Nmm\n";
            File { before, ..usual().scaled(deg, 1e3) }
        }),
        ("units in a comment", {
            let before = "# s,deg,deg,deg,deg,deg,deg,Nmm,Nmm,Nmm,Nmm,Nmm,Nmm\n";
            File { before, ..usual().scaled(deg, 1e3) }
        }),
        (
            "a row of units in brackets",
            File {
                units: Some([vec!["[s]"], vec!["[deg]"; 6], vec!["[mN m]"; 6]].concat()),
                ..usual().scaled(deg, 1e3)
            },
        ),
        ("semicolons and decimal commas", File { separator: ";", comma: true, ..usual() }),
        ("tabs and decimal commas", File { separator: "\t", comma: true, ..usual() }),
        ("tabs", File { separator: "\t", ..usual() }),
        ("blanks", File { separator: "   ", ..usual() }),
        (
            "blanks, with units",
            File { separator: " ", ..File::numbered("time [s]", "q{} [deg]", "tau_{} [N cm]", 1).scaled(deg, 1e2) },
        ),
        ("comma and blank", File { separator: ", ", ..usual() }),
        ("comments", File { before: "# a robot\n% of 2026\n// and more, with, commas\n\n", ..usual() }),
        ("a header that is a comment", File { before: "# ", separator: " ", ..usual() }),
        ("text above the header", File { before: "Exported on Monday\nRate,100\n", ..usual() }),
        ("a spreadsheet's hint", File { before: "sep=;\n", separator: ";", comma: true, ..usual() }),
        ("from 0", File::numbered("t", "q_{}", "tau_{}", 0)),
        (
            "from 0 with a gripper",
            File::numbered("t", "q_{}", "tau_{}", 0).with("q_6", |_| "0.02".into()).with("tau_6", |_| "0.1".into()),
        ),
        ("ROS brackets", File::numbered("time", "position[{}]", "effort[{}]", 0)),
        ("joint_1.position", File::numbered("time", "joint_{}.position", "joint_{}.effort", 1)),
        ("PlotJuggler by index", ros()),
        ("PlotJuggler by index and name", backwards.clone()),
        (
            "PlotJuggler by name",
            File::new(
                "__time",
                [&by_name("/joint_states/{}/position"), &by_name("/joint_states/{}/effort")],
                [1.0, 1.0],
            ),
        ),
        ("by name", File::new("timestamp", [&by_name("{}_pos"), &by_name("{}_torque")], [1.0, 1.0])),
        ("names only", File::new("time", [&by_name("{}"), &by_name("tau_{}")], [1.0, 1.0])),
        ("units inside", File::numbered("time", "q_deg_{}", "tau_mNm_{}", 0).scaled(deg, 1e3)),
        ("a column of row numbers", {
            let mut file = usual();
            let rows = (0..log.time.len()).map(|k| k.to_string()).collect();
            file.columns.insert(0, (String::new(), rows));
            file
        }),
        ("name in brackets", File::new("timestamp", [&by_name("position[{}]"), &by_name("effort[{}]")], [1.0, 1.0])),
        (
            "rostopic",
            File::numbered("%time", "field.position{}", "field.effort{}", 0)
                .timed(|t| format!("{:.0}", 1.7e18 + 1e9 * t)),
        ),
        (
            "seconds and nanoseconds",
            File::numbered("header.stamp.secs", "position_{}", "effort_{}", 0)
                .timed(|t| format!("{}", 1_700_000_000 + (t + 0.3) as u64))
                .with("header.stamp.nsecs", |k| format!("{}", (k as u64 * 10_000_000 + 300_000_000) % 1_000_000_000)),
        ),
        (
            "Universal Robots, targets beside actual values",
            File { separator: " ", ..File::numbered("timestamp", "actual_q_{}", "target_moment_{}", 0) }
                .and("target_q_{}", 0, &log.q, 1.1)
                .and("actual_qd_{}", 0, &qd, 1.0)
                .with("robot_mode", |_| "7".into()),
        ),
        ("reference beside", usual().and("q{}_reference", 1, &log.q, 1.1)),
        (
            "franka",
            File::numbered("time", "q[{}]", "tau_J[{}]", 0).and("q_d[{}]", 0, &log.q, 1.1).and(
                "tau_J_d[{}]",
                0,
                &log.tau,
                2.0,
            ),
        ),
        ("velocities that follow degrees", {
            File::numbered("t", "q{} [deg]", "tau{}", 1).scaled(deg, 1.0).and("qd{}", 1, &qd, deg)
        }),
        ("velocities in rpm", usual().and("qd_{} [rpm]", 1, &qd, 60.0 / std::f64::consts::TAU)),
        ("lists", listed),
        ("milliseconds in the header", usual().timed(|t| format!("{:.3}", 1e3 * t)).renamed("time_ms")),
        ("milliseconds without", usual().timed(|t| format!("{:.3}", 1e3 * t))),
        ("microseconds without", usual().timed(|t| format!("{:.0}", 1e6 * t))),
        ("nanoseconds without", usual().timed(|t| format!("{:.0}", 1e9 * t))),
        ("two times that agree", usual().with("timestamp", |k| format!("{:.2}", 1.7e9 + 0.01 * k as f64))),
    ]
}

impl File {
    fn renamed(mut self, time: &str) -> Self {
        self.columns[0].0 = time.to_owned();
        self
    }
}

#[test]
fn one_log_in_the_formats_of_many_programs_is_the_same_samples() {
    for (name, file) in files() {
        let (log, notes) = file.read().unwrap_or_else(|error| panic!("{name}: {error:?}"));
        let worst = differs(&log, 1.0);
        assert!(worst < 1e-6, "{name}: {worst}, {notes:?}");
    }
    // The comparison detects an order that is off by one, and a unit that is ignored.
    let mut wrong = truth();
    wrong.q.rotate_left(1);
    assert!(differs(&wrong, 1.0) > 0.1);
    assert!(differs(&truth(), 1e-3) > 1.0);
}

#[test]
fn encodings_and_ends_of_lines_change_nothing() {
    let text = File::numbered("time", "q{} [°]", "tau_{}", 1).scaled(180.0 / std::f64::consts::PI, 1.0).text();
    let utf16 = |big: bool| -> Vec<u8> {
        let units = text.encode_utf16();
        units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect()
    };
    let marked = |mark: &[u8], bytes: Vec<u8>| [mark.to_vec(), bytes].concat();
    let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    for (name, bytes) in [
        ("UTF-8 with a mark", marked(b"\xef\xbb\xbf", text.clone().into_bytes())),
        ("UTF-16 LE", marked(b"\xff\xfe", utf16(false))),
        ("UTF-16 BE", marked(b"\xfe\xff", utf16(true))),
        ("UTF-16 LE without a mark", utf16(false)),
        ("Latin-1", latin),
        ("CR LF", text.replace('\n', "\r\n").into_bytes()),
        ("CR", text.replace('\n', "\r").into_bytes()),
    ] {
        let log = Log::read(&bytes, "a.csv", &reading()).unwrap_or_else(|error| panic!("{name}: {error:?}"));
        assert!(differs(&log, 1.0) < 1e-6, "{name}");
    }
}

#[test]
fn quoted_fields_and_decimal_commas_between_commas_are_read() {
    let file = File::usual();
    let text = file.text();
    let rows = text.lines().map(|line| {
        let fields: Vec<String> = line.split(',').map(|field| format!("\"{}\"", field.replace('.', ","))).collect();
        fields.join(",")
    });
    let log = Log::read(rows.collect::<Vec<_>>().join("\n").as_bytes(), "a.csv", &reading()).unwrap();
    assert!(differs(&log, 1.0) < 1e-6);
}

#[test]
fn rows_before_the_first_reading_are_no_header() {
    let mut file = File::usual();
    for (_, values) in &mut file.columns[1..] {
        values[..5].iter_mut().for_each(String::clear);
    }
    let (log, notes) = file.read().unwrap();
    assert!((log.q[2][0] - truth().q[2][5]).abs() < 1e-9);
    assert_eq!((log.time.len(), notes), (195, Vec::new()));
}

#[test]
fn a_file_that_was_cut_loses_its_last_row_only_and_says_so() {
    let text = File::usual().text();
    let (log, notes) = Log::read_noted(&text.as_bytes()[..text.len() - 60], "a.csv", &reading()).unwrap();
    assert_eq!(log.time.len(), truth().time.len() - 1);
    assert!(notes.iter().any(|note| note.contains("line 201 is left out")), "{notes:?}");
}

#[test]
fn currents_are_read_in_their_unit_with_a_torque_per_ampere() {
    let file =
        |unit: &str, factor| File::numbered("t", "q_{}", &format!("current_{{}} [{unit}]"), 1).scaled(1.0, factor);
    for (unit, factor) in [("A", 1.0), ("mA", 1e3)] {
        let refused = file(unit, factor).read().unwrap_err();
        assert!(refused.expected.contains("--torque-per-ampere"), "{refused:?}");
        let with = Reading { per_ampere: Some(vec![2.0; 6]), ..reading() };
        let log = Log::read(file(unit, factor).text().as_bytes(), "a.csv", &with).unwrap();
        assert!(log.from_current && differs(&log, 2.0) < 1e-6, "{unit}");
    }
    // A unit is more reliable than a word.
    let effort = File::numbered("t", "q_{}", "effort_{} [A]", 1).read().unwrap_err();
    assert!(effort.found.contains("currents"), "{effort:?}");
}

#[test]
fn torques_and_currents_both_are_a_choice_that_a_torque_per_ampere_makes() {
    let log = truth();
    let file = File::numbered("time", "position[{}]", "effort[{}]", 0).and("current[{}]", 0, &log.tau, 0.5);
    let refused = file.read().unwrap_err();
    assert!(
        refused.found.contains("effort[0] .. effort[5]") && refused.found.contains("current[0] .. current[5]"),
        "{refused:?}"
    );
    assert!(refused.expected.contains("--torque-per-ampere"), "{refused:?}");
    // The option that the message suggests works.
    assert!(refused.expected.contains("--columns 'tau=effort[{}]'"), "{refused:?}");
    let named = Reading { columns: Some(ColumnNames::parse("tau=effort[{}]").unwrap()), ..reading() };
    assert!(differs(&Log::read(file.text().as_bytes(), "a.csv", &named).unwrap(), 1.0) < 1e-6);
    let with = Reading { per_ampere: Some(vec![2.0; 6]), currents_meant: true, ..reading() };
    let (log, notes) = Log::read_noted(file.text().as_bytes(), "a.csv", &with).unwrap();
    assert!(
        log.from_current && differs(&log, 1.0) < 1e-6 && notes.iter().any(|note| note.contains("not effort[0]")),
        "{notes:?}"
    );
    // A torque constant in the robot file alone does not select the currents.
    let file_only = Reading { per_ampere: Some(vec![2.0; 6]), ..reading() };
    assert!(Log::read(file.text().as_bytes(), "a.csv", &file_only).is_err());
}

#[test]
fn columns_by_hand_are_read_whatever_their_names_are() {
    let log = truth();
    let file = File::numbered("stamp_x", "alpha{}", "beta{}", 1).and("gamma{}", 1, &log.tau, 1e3);
    assert!(file.read().is_err());
    for (columns, factor) in [
        ("t=stamp_x,q=alpha{},tau=beta{}", 1.0),
        ("t=#1,q=#2-#7,tau=#8-#13", 1.0),
        ("t=stamp_x,q=alpha1,alpha2,alpha3,alpha4,alpha5,alpha6,tau[mNm]=gamma{}", 1.0),
        ("t=stamp_x,q=alpha{},tau=gamma{}", 1e3),
    ] {
        let torque = vec![2e4; 6];
        let with = Reading { columns: Some(ColumnNames::parse(columns).unwrap()), torque, ..reading() };
        let log =
            Log::read(file.text().as_bytes(), "a.csv", &with).unwrap_or_else(|error| panic!("{columns}: {error:?}"));
        assert!(differs(&log, factor) < 1e-6, "{columns}");
    }
    // Headings of which only the unit is understood.
    let deg = 180.0 / std::f64::consts::PI;
    for (name, columns) in [
        ("Winkel {} [deg]", "t=stamp_x,q=Winkel {} [deg],tau=beta{}"),
        ("winkel{}_deg", "t=stamp_x,q=winkel{}_deg,tau=beta{}"),
        ("Winkel {} [Grad]", "t=stamp_x,q[deg]=Winkel {} [Grad],tau=beta{}"),
    ] {
        let file = File::numbered("stamp_x", name, "beta{}", 1).scaled(deg, 1.0);
        let with = Reading { columns: Some(ColumnNames::parse(columns).unwrap()), ..reading() };
        let log =
            Log::read(file.text().as_bytes(), "a.csv", &with).unwrap_or_else(|error| panic!("{columns}: {error:?}"));
        assert!(differs(&log, 1.0) < 1e-6, "{columns}");
    }
    let german = File::numbered("stamp_x", "Winkel {} [Grad]", "beta{}", 1);
    let by_hand = Some(ColumnNames::parse("t=stamp_x,q=Winkel {} [Grad],tau=beta{}").unwrap());
    let refused = Log::read(german.text().as_bytes(), "a.csv", &Reading { columns: by_hand, ..reading() }).unwrap_err();
    assert!(refused.found.contains("Grad") && refused.expected.contains("'q[deg]=..'"), "{refused:?}");
    // Rows without a header.
    let text = file.text();
    let rows = &text[text.find('\n').unwrap() + 1..];
    let refused = Log::read(rows.as_bytes(), "a.csv", &reading()).unwrap_err();
    assert!(refused.found.contains("without names") && refused.expected.contains("#1"), "{refused:?}");
    let with = Reading { columns: Some(ColumnNames::parse("t=#1,q=#2-#7,tau=#8-#13").unwrap()), ..reading() };
    assert!(differs(&Log::read(rows.as_bytes(), "a.csv", &with).unwrap(), 1.0) < 1e-6);
}

#[test]
fn what_was_assumed_is_said() {
    let said = |file: &File, words: &str| {
        let (_, notes) = file.read().unwrap();
        assert!(notes.iter().any(|note| note.contains(words)), "{words}: {notes:?}");
    };
    let files: std::collections::HashMap<_, _> = files().into_iter().collect();
    said(&files["from 0 with a gripper"], "q_0 is joint 1 (base_yaw)");
    said(&files["from 0 with a gripper"], "q_6 left out");
    said(&files["units in brackets"], "q1 [deg] .. q6 [deg] converted from deg");
    said(&files["milliseconds without"], "time in ms, judged by its steps: 0.01 s");
    said(
        &files["Universal Robots, targets beside actual values"],
        "actual_q_0 .. actual_q_5 (measured), not target_q_0",
    );
    said(&files["Universal Robots, targets beside actual values"], "target_moment_0 .. target_moment_5 are commanded");
    said(&files["PlotJuggler by index and name"], "/joint_states/position[5] is base_yaw");
    said(&files["velocities that follow degrees"], "qd1 .. qd6 taken in deg/s");
    said(&files["names only"], "base_yaw .. wrist_roll have no word for their quantity");
    said(&files["two times that agree"], "time: time, not timestamp");
    assert_eq!(files["ours"].read().unwrap().1, Vec::<String>::new());
}

#[test]
fn what_could_mean_two_things_is_refused_with_both() {
    let log = truth();
    let usual = File::usual;
    let renamed = |from: &'static str, to: &'static str| {
        let mut file = usual();
        file.columns.iter_mut().for_each(|(name, _)| *name = name.replace(from, to));
        file
    };
    let mut names = files().into_iter().find(|(name, _)| *name == "PlotJuggler by index and name").unwrap().1;
    for (name, values) in &mut names.columns {
        if name.contains("name[5]") {
            values.iter_mut().for_each(|value| *value = "waist".to_owned());
        }
    }
    let mut moved = files().into_iter().find(|(name, _)| *name == "PlotJuggler by index and name").unwrap().1;
    moved.columns[13].1[50] = "elbow".to_owned();
    let mut fewer = usual();
    fewer.columns.retain(|(name, _)| name != "q_4");
    let mut point = File { separator: ";", comma: true, ..usual() }.text();
    let at = point.rfind("0,").unwrap();
    point.replace_range(at..=at + 1, "0.");
    let cases: Vec<(&str, String, &str, &str)> = vec![
        ("positions of two names", usual().and("pos_{}", 1, &log.q, 1.0).text(), "pos_1 .. pos_6", "--columns 'q=..'"),
        (
            "torques of two names",
            usual().and("effort_{}", 1, &log.q, 1.0).text(),
            "effort_1 .. effort_6",
            "--columns 'tau=..'",
        ),
        (
            "two topics",
            File::numbered("t", "/left/position[{}]", "/left/effort[{}]", 0)
                .and("/right/position[{}]", 0, &log.q, 1.0)
                .text(),
            "/right/position[0]",
            "--columns",
        ),
        ("targets only", renamed("q_", "target_q_").text(), "commanded positions only", "measured"),
        ("names of another robot", names.text(), "waist", "base_yaw"),
        ("names that move", moved.text(), "elbow", "one order"),
        (
            "from 0 and from 1",
            File::numbered("t", "q_{}", "tau_{}", 0)
                .with("q_6", |_| "1".into())
                .and("qd_{}", 1, log.qd.as_ref().unwrap(), 1.0)
                .text(),
            "counts from 0",
            "--columns",
        ),
        (
            "a joint less of those from 0",
            {
                let mut file = File::numbered("t", "q_{}", "tau_{}", 0);
                file.columns.retain(|(name, _)| name != "q_4");
                file.text()
            },
            "the columns t, q_0",
            "`q_4` for joint 5 (wrist_yaw)",
        ),
        ("a joint less", fewer.text(), "the columns time, q_1", "`q_4` for joint 4 (wrist_pitch)"),
        ("a unit that nobody knows", renamed("q_1", "q_1 [furlong]").text(), "furlong", "rad"),
        (
            "a force for a joint that turns",
            renamed("tau_2", "tau_2 [N]").text(),
            "joint 2 (shoulder) is revolute",
            "N m",
        ),
        ("counts", renamed("q_2", "q_2 [counts]").text(), "counts", "rad"),
        ("per cent", renamed("tau_2", "tau_2 [%]").text(), "%", "N m"),
        (
            "two units of one column",
            File { units: Some([vec!["s"], vec!["deg"; 6], vec!["Nm"; 6]].concat()), ..renamed("q_3", "q_3 [rad]") }
                .text(),
            "rad and deg",
            "one unit",
        ),
        (
            "two times",
            usual().with("timestamp", |k| format!("{}", 0.013 * k as f64)).text(),
            "`time`, `timestamp`",
            "t=NAME",
        ),
        ("steps of 0.15 ms or 150 ms", usual().timed(|t| format!("{:.0}", 15_000.0 * t)).text(), "ms or us", "t[us]"),
        (
            "a date",
            usual().timed(|t| format!("2026-11-25T10:00:{t:06.3}")).text(),
            "2026-11-25T10:00:00.000",
            "as a number",
        ),
        ("decimal commas between commas", File { comma: true, ..usual() }.text(), "26 fields", "semicolons"),
        ("points and commas", point, "both decimal points", "one of both"),
        ("thousands", File { separator: ";", ..usual() }.text().replacen(";0.", ";1.000,", 1), "1.000,", "thousands"),
        ("a spreadsheet", "PK\u{3}\u{4}...".to_owned(), "spreadsheet", "exported as CSV"),
        ("a web page", "<!DOCTYPE html><html></html>".to_owned(), "HTML", "CSV"),
        ("nothing", "\n\n".to_owned(), "empty", "header"),
        ("no rows", "time,q_1,tau_1\n".to_owned(), "no rows of numbers", "rows of numbers"),
        (
            "rows that never meet",
            {
                let mut file = usual();
                for (k, (_, values)) in file.columns.iter_mut().enumerate().skip(1) {
                    values.iter_mut().skip(usize::from(k > 6)).step_by(2).for_each(String::clear);
                }
                file.text()
            },
            "in the same row in none",
            "resample",
        ),
    ];
    for (name, text, found, expected) in cases {
        let error = Log::read(text.as_bytes(), "a.csv", &reading()).expect_err(name);
        assert!(error.found.contains(found), "{name}: {error:?}");
        assert!(error.expected.contains(expected), "{name}: {error:?}");
    }
}

#[test]
fn degrees_by_option_are_not_taken_twice() {
    let file = |name: &str| File::numbered("t", name, "tau_{}", 1).scaled(180.0 / std::f64::consts::PI, 1.0).text();
    let with = Reading { degrees: true, ..reading() };
    for name in ["q_{}", "q_{} [deg]"] {
        let log = Log::read(file(name).as_bytes(), "a.csv", &with).unwrap();
        assert!(differs(&log, 1.0) < 1e-6, "{name}");
    }
    let refused = Log::read(file("q_{} [rad]").as_bytes(), "a.csv", &with).unwrap_err();
    assert!(refused.found.contains("--degrees"), "{refused:?}");
}

#[test]
fn jitter_of_the_clock_is_kept() {
    let jitter = |k: usize| 0.01 * k as f64 + 0.002 * (7.0 * k as f64).sin();
    let mut file = File::usual();
    file.columns[0].1 = (0..200).map(|k| format!("{:.0}", 1e9 * (1.7e9 + jitter(k)))).collect();
    let (log, _) = file.read().unwrap();
    let worst = (0..200).map(|k| (log.time[k] - jitter(k)).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-6, "{worst}");
}
