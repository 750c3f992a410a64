//! Bad logs are rejected, with file, line and column.

use crate::arms::load;
use crate::made::{Making, log, text};
use identification::log::{BadLog, Log, Reading};

fn reading() -> Reading {
    let names = load("yam.toml").names;
    let n = names.len();
    Reading {
        joints: names,
        turns: vec![true; n],
        limits: vec![(-3.2, 3.7); n],
        torque: vec![20.0; n],
        degrees: false,
        per_ampere: None,
        tick_rate: None,
        may_rest: false,
        ..Reading::default()
    }
}

fn good() -> Vec<Vec<String>> {
    let known = load("yam.toml");
    text(&log(&known, &known.parameters, &Making { duration: 4.0, ..Making::default() }))
}

fn read(rows: &[Vec<String>]) -> Result<Log, BadLog> {
    let text: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    Log::read(text.join("\n").as_bytes(), "bad.csv", &reading())
}

/// Index of a column.
fn column(name: &str) -> usize {
    good()[0].iter().position(|known| known == name).unwrap()
}

fn set(rows: &mut [Vec<String>], name: &str, value: impl Fn(usize, f64) -> f64) {
    let place = column(name);
    for (k, row) in rows.iter_mut().enumerate().skip(1) {
        let x: f64 = row[place].parse().unwrap();
        row[place] = format!("{:.7}", value(k, x));
    }
}

#[test]
fn a_good_log_is_read() {
    let log = read(&good()).unwrap();
    assert_eq!((log.q.len(), log.tau.len(), log.time.len()), (6, 6, 400));
    assert!((log.rate() - 100.0).abs() < 1e-6);
}

#[test]
fn usual_names_of_columns_are_understood() {
    for [time, q, tau] in
        [["t", "q", "tau"], ["Time [s]", "position_", "effort_"], ["timestamp", "actual_q_", "torque"]]
    {
        let mut rows = good();
        rows[0] = rows[0].iter().map(|name| name.replace("time", time).replace("q_", q).replace("tau_", tau)).collect();
        assert!(read(&rows).is_ok(), "{:?}: {:?}", rows[0], read(&rows));
    }
    let mut rows = good();
    for (joint, name) in reading().joints.iter().enumerate() {
        rows[0][1 + joint] = format!("{name}_position");
    }
    assert!(read(&rows).is_ok());
}

type Spoil = fn(&mut Vec<Vec<String>>);

#[test]
fn bad_logs_are_refused_with_line_and_column() {
    let cases: [(&str, Spoil, &str, &str); 15] = [
        ("time back", |rows| set(rows, "time", |k, t| if k == 50 { t - 0.1 } else { t }), "line 51, time", "after"),
        ("three samples a second", |rows| set(rows, "time", |_, t| 30.0 * t), "time", "step of"),
        ("a gap", |rows| set(rows, "time", |k, t| if k > 200 { t + 3.0 } else { t }), "line 202, time", "gap"),
        ("degrees", |rows| set(rows, "q_2", |_, q| q.to_degrees()), "q_2", "outside"),
        ("never moves", |rows| set(rows, "q_3", |_, _| 0.5), "q_3", "never moves"),
        ("three samples", |rows| rows.truncate(4), "whole file", "3 samples"),
        ("clipped", |rows| set(rows, "tau_2", |_, x| x.clamp(-1.0, 1.0)), "tau_2", "clipped"),
        ("NaN", |rows| rows[30][9] = "NaN".to_owned(), "line 31, tau_3", "NaN"),
        ("a hole", |rows| rows[30][2] = String::new(), "line 31, q_2", "nothing"),
        ("a word", |rows| rows[30][0] = "noon".to_owned(), "line 31, time", "noon"),
        ("a short row", |rows| rows[60].truncate(5), "line 61, q_5", "nothing"),
        ("no such column", |rows| rows[0][4] = "elbow".to_owned() + "_colour", "line 1", "columns"),
        ("twice", |rows| rows[0][4] = "q_2".to_owned(), "line 1", "twice"),
        ("no torque", |rows| set(rows, "tau_1", |_, _| 0.0), "tau_1", "zero in every row"),
        ("millinewtons", |rows| set(rows, "tau_2", |_, x| 1000.0 * x), "tau_2", "torque limit"),
    ];
    for (name, spoil, place, found) in cases {
        let mut rows = good();
        spoil(&mut rows);
        let error = read(&rows).expect_err(name);
        assert!(error.place.contains(place) && error.found.contains(found), "{name}: {error:?}");
        assert!(error.to_string().starts_with("bad.csv: ") && !error.expected.is_empty(), "{name}: {error}");
    }
}

#[test]
fn exchanged_velocities_and_other_units_of_velocity_are_named() {
    let with = |factor: f64, exchange: bool| {
        let mut rows = good();
        let log = read(&rows).unwrap();
        for joint in 0..6 {
            let from = if exchange && joint < 2 { 1 - joint } else { joint };
            let qd = identification::filter::derivative(&log.q[from], 100.0);
            rows[0].push(format!("qd_{}", joint + 1));
            for (row, qd) in rows[1..].iter_mut().zip(qd) {
                row.push(format!("{:.7}", factor * qd));
            }
        }
        rows
    };
    assert!(read(&with(1.0, false)).is_ok());
    let exchanged = read(&with(1.0, true)).unwrap_err();
    assert!(exchanged.place.contains("qd_") && exchanged.expected.contains("exchanged"), "{exchanged:?}");
    let degrees = read(&with(57.3, false)).unwrap_err();
    assert!(degrees.found.contains("times the position's change"), "{degrees:?}");
    assert!(degrees.expected.contains("velocity in deg/s and position in rad?"), "{degrees:?}");
}

#[test]
fn rows_without_a_reading_at_the_ends_of_a_record_are_left_out() {
    let mut rows = good();
    for row in &mut rows[1..20] {
        row[7..].iter_mut().for_each(String::clear);
    }
    assert_eq!(read(&rows).unwrap().time.len(), 381);
}

#[test]
fn currents_need_a_torque_per_ampere() {
    let mut rows = good();
    rows[0] = rows[0].iter().map(|name| name.replace("tau_", "current_")).collect();
    let refused = read(&rows).unwrap_err();
    assert!(refused.expected.contains("--torque-per-ampere"), "{refused:?}");
    let text: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    let with = Reading { per_ampere: Some(vec![2.0; 6]), ..reading() };
    let log = Log::read(text.join("\n").as_bytes(), "amperes.csv", &with).unwrap();
    assert!((log.tau[1][7] - 2.0 * read(&good()).unwrap().tau[1][7]).abs() < 1e-9 && log.from_current);
}
