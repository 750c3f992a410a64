//! Files for viewers: the output of a run or a session is read back, here and by other programs.

use crate::program::{at_the_top, new, printed, told};
use crate::skipping::skipped;
use board::session::frame_log::{Entry, Log};
use dynamics_core::kinematics::tip_pose;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics as _, Trig as _};
use indicatif::ProgressBar;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use robot_compiler::scene::joints;
use robot_compiler::{Ends, Robot, SceneFile};
use serde::de::DeserializeOwned;
use serde_json::Value;
use sim::run::mcap_file::messages::{FrameTransforms, JointStates, LinkFrame, Message as _, Text, Tick, Time, finite};
use sim::run::mcap_file::reader::{Item, Reader};
use sim::run::mcap_file::run::{ModelTerms, write_to};
use sim::run::record::Record;
use sim::run::simulate::live_inputs;
use sim::run::simulation;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

const PICK: &str = "scenes/puma560_pick.toml";

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Runs a scene for this duration, s.
fn run_for<const N: usize>(scene: &str, duration: f64) -> (SceneFile, Record) {
    let mut scene = SceneFile::load(&Path::new("..").join(scene)).unwrap();
    scene.duration = Some(duration);
    let run = simulation::run(&scene, &AtomicBool::new(false), &ProgressBar::hidden()).unwrap();
    (scene, run.record)
}

fn written<const N: usize>(scene: &SceneFile, record: &Record) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_to::<N>(record, scene, &ModelTerms::new(scene).unwrap(), &mut bytes).unwrap();
    bytes
}

/// Messages of a topic.
fn messages<M: DeserializeOwned>(bytes: &[u8], topic: &str) -> Vec<(u64, M)> {
    let items = Reader::new(bytes).map(Result::unwrap);
    let of_topic = items.filter_map(|item| match item {
        Item::Message(raw) if raw.topic == topic => Some((raw.at, serde_json::from_slice(&raw.data).unwrap())),
        _ => None,
    });
    of_topic.collect()
}

#[test]
fn a_run_has_every_tick_with_the_numbers_of_its_record_and_the_same_bytes_again() {
    let (scene, record) = run_for::<6>(PICK, 0.3);
    let bytes = written::<6>(&scene, &record);
    assert_eq!(written::<6>(&scene, &record), bytes);
    let mut reader = Reader::new(&bytes);
    assert!(reader.all(|item| item.is_ok()) && reader.has_end() && reader.left_out() == 0);
    let (states, ticks) = (messages::<JointStates>(&bytes, "/joint_states"), messages::<Tick>(&bytes, "/newtau/tick"));
    assert_eq!((states.len(), ticks.len()), (300, 300));
    for (index, ((at, state), (_, tick))) in states.iter().zip(&ticks).enumerate() {
        assert_eq!((*at, tick.tick), (index as u64 * 1_000_000, index as u64));
        assert_eq!((state.timestamp, tick.timestamp), (Time::from_nanos(*at), Time::from_nanos(*at)));
        for ((sample, state), joint) in record.tick(index).iter().zip(&state.joints).zip(&tick.joints) {
            assert_eq!((state.position, state.velocity), (finite(sample.q), finite(sample.qd)));
            assert_eq!((state.effort, joint.torque), (finite(sample.torque), finite(sample.torque)));
            assert_eq!((joint.reference, joint.position), (finite(sample.q_reference), finite(sample.q)));
            assert_eq!(joint.limits, sample.limits.bits());
        }
    }
}

#[test]
fn terms_of_a_tick_add_up_to_the_inverse_dynamics_at_its_reference() {
    let (scene, record) = run_for::<6>(PICK, 0.5);
    let model = scene.robot.model::<6>().unwrap();
    let dynamics = Dynamics::new(model, scene.scene(&model));
    let motion = scene.trajectory(&model).unwrap();
    let ticks = messages::<Tick>(&written::<6>(&scene, &record), "/newtau/tick");
    let mut largest: f64 = 0.0;
    for (index, (at, tick)) in ticks.iter().enumerate() {
        let reference = motion.sample(*at as f64 * 1e-9);
        let turn = Libm.sin_cos_all(&reference.q);
        let live = live_inputs(&scene, &model);
        let torque = dynamics.inverse_dynamics(&turn, &reference.q, &reference.qd, &reference.qdd, &live);
        for (joint, torque) in tick.joints.iter().zip(torque) {
            let terms = joint.terms.unwrap();
            let sum = terms.inertia + terms.velocity + terms.gravity;
            assert!((sum - torque).abs() < 1e-9, "tick {index}: {terms:?}, {torque}");
            largest = largest.max(terms.velocity.abs());
        }
    }
    assert!(largest > 0.1, "a motion in which every term acts: {largest}");
}

#[test]
fn frames_are_links_of_the_urdf_and_lead_to_the_tip_of_the_model() {
    let (scene, record) = run_for::<6>(PICK, 0.3);
    let bytes = written::<6>(&scene, &record);
    let description = messages::<Text>(&bytes, "/robot_description");
    assert_eq!((description.len(), description[0].0), (1, 0));
    let urdf = Robot::from_urdf_str(&description[0].1.data, "file.urdf", Ends::default()).unwrap();
    assert_eq!(urdf.dof(), 6);
    let model = scene.robot.model::<6>().unwrap();
    let all = messages::<FrameTransforms>(&bytes, "/tf");
    assert_eq!(all.len(), 30, "a hundred a second");
    for (at, FrameTransforms { transforms }) in all {
        let mut parent = "base".to_owned();
        let tip = transforms.iter().fold(Isometry3::identity(), |place, it| {
            assert_eq!(it.parent_frame_id, parent);
            assert!(description[0].1.data.contains(&format!("<link name=\"{}\"", it.child_frame_id)));
            parent.clone_from(&it.child_frame_id);
            let turn = Quaternion::new(it.rotation.w, it.rotation.x, it.rotation.y, it.rotation.z);
            assert!((turn.norm() - 1.0).abs() < 1e-12);
            let shift = Translation3::new(it.translation.x, it.translation.y, it.translation.z);
            place * Isometry3::from_parts(shift, UnitQuaternion::from_quaternion(turn))
        });
        let samples = record.tick((at / 1_000_000) as usize);
        let q = joints(&samples.iter().map(|sample| sample.q).collect::<Vec<_>>());
        let wanted = tip_pose(&model, &Libm.sin_cos_all(&q), &q);
        assert!((tip.translation.vector - wanted.translation).amax() < 1e-12);
        assert!((tip.rotation.to_rotation_matrix().matrix() - wanted.rotation).amax() < 1e-12);
    }
}

/// A schema without its descriptions.
fn bare(mut schema: Value) -> Value {
    match &mut schema {
        Value::Object(fields) => {
            fields.remove("$comment");
            // A property may have this name too; only a description is a text.
            if fields.get("description").is_some_and(Value::is_string) {
                fields.remove("description");
            }
            for (_, field) in fields.iter_mut() {
                *field = bare(field.take());
            }
        }
        Value::Array(list) => list.iter_mut().for_each(|item| *item = bare(item.take())),
        _ => {}
    }
    schema
}

#[test]
fn schemas_under_foxglove_s_names_are_foxglove_s() {
    let official = |name: &str| {
        let path = Path::new("tests/viewers/foxglove").join(format!("{name}.json"));
        bare(serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap())
    };
    assert_eq!(bare(FrameTransforms::schema()), official("FrameTransforms"));
    assert_eq!(bare(JointStates::schema()), official("JointStates"));
    let names = [FrameTransforms::SCHEMA, JointStates::SCHEMA, Text::SCHEMA, Tick::SCHEMA, LinkFrame::SCHEMA];
    let named = ["foxglove.FrameTransforms", "foxglove.JointStates", "std_msgs/String", "newtau.Tick", "newtau.Frame"];
    assert_eq!(names, named);
}

#[test]
fn numbers_that_json_has_no_word_for_are_left_out() {
    let (scene, mut record) = run_for::<6>(PICK, 0.002);
    let mut samples: [_; 6] = record.tick(1).try_into().unwrap();
    (samples[0].q, samples[1].qd, samples[2].torque) = (f64::NAN, f64::INFINITY, f64::NEG_INFINITY);
    record.push(0.02, samples, None);
    let bytes = written::<6>(&scene, &record);
    let (_, last) = messages::<JointStates>(&bytes, "/joint_states").pop().unwrap();
    let found: Vec<_> = last.joints[..3].iter().map(|joint| (joint.position, joint.velocity, joint.effort)).collect();
    assert_eq!((found[0].0, found[1].1, found[2].2), (None, None, None));
    assert!(found[0].1.is_some() && found[1].0.is_some() && found[2].0.is_some());
    assert_eq!(messages::<FrameTransforms>(&bytes, "/tf").len(), 1, "no frames of an arm that is nowhere");
}

/// The file of a long run is written in pieces: the memory use does not grow with it.
#[cfg(target_os = "linux")]
#[test]
fn memory_for_a_long_run_s_file_does_not_grow_with_the_file() {
    struct Count(usize);
    impl std::io::Write for Count {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0 += bytes.len();
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let peak = || {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find(|line| line.starts_with("VmHWM")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<usize>().unwrap() * 1024
    };
    let (scene, short) = run_for::<2>("scenes/planar2r_swing.toml", 1.0);
    let mut long = Record::new(short.joints().to_vec(), 100_000);
    for tick in 0..100_000 {
        let samples: [_; 2] = short.tick(tick % short.ticks()).try_into().unwrap();
        long.push(tick as f64 * 1e-3, samples, None);
    }
    let terms = ModelTerms::<2>::new(&scene).unwrap();
    let before = peak();
    let mut count = Count(0);
    write_to(&long, &scene, &terms, &mut count).unwrap();
    let grown = peak() - before;
    assert!(count.0 > 60 << 20, "{} bytes", count.0);
    assert!(grown < 12 << 20, "{grown} bytes for a file of {}", count.0);
}

const SCRIPT: &str = "home\nconfirm\narm\njog elbow 0.2 0.5\nwait\njog shoulder 0.3 1\nwait\npress\nwait 0.1\n";

/// A dry run with a record; the same dry run gives the same record again.
fn recorded(name: &str) -> PathBuf {
    let (record, code) = recorded_by(SCRIPT, name);
    assert_eq!(code, 3, "the emergency stop ends it");
    record
}

/// The record of a script, and the exit code.
fn recorded_by(commands: &str, name: &str) -> (PathBuf, i32) {
    let (script, record) = (file(&format!("{name}.txt")), file(name));
    std::fs::write(&script, commands).unwrap();
    let mut connect = at_the_top();
    connect.args(["connect", "scenes/planar2r_swing.toml", "--target", "desk", "--script"]).arg(&script);
    let (code, _, error) = told(connect.arg("--record").arg(new(&record)).output().unwrap());
    assert_eq!(error, "");
    (record, code)
}

fn entries(bytes: Vec<u8>) -> Vec<Entry> {
    Log::new(bytes).unwrap().entries().collect::<Result<_, _>>().unwrap()
}

#[test]
fn a_session_for_viewers_has_the_same_frames_replays_and_shows_the_arm() {
    let (plain, mcap) = (recorded("viewers.log"), recorded("viewers.MCAP"));
    let bytes = std::fs::read(&mcap).unwrap();
    let logs = [std::fs::read(&plain).unwrap(), bytes.clone()].map(|bytes| Log::new(bytes).unwrap());
    assert_eq!((&logs[0].head, logs[0].cut()), (&logs[1].head, logs[1].cut()));
    assert!(logs[1].has_end());
    let all = entries(bytes.clone());
    assert_eq!(entries(std::fs::read(&plain).unwrap()), all);
    let replayed =
        [&plain, &mcap].map(|path| printed(at_the_top().args(["connect", "replay"]).arg(path).output().unwrap()));
    assert_eq!(replayed[0], replayed[1]);
    assert!(replayed[1].ends_with(" ticks compared, 0 differ\n"), "{}", replayed[1]);

    let (states, ticks) = (messages::<JointStates>(&bytes, "/joint_states"), messages::<Tick>(&bytes, "/newtau/tick"));
    assert_eq!(states.len(), ticks.len());
    let driven = states.iter().filter(|(_, state)| state.joints.iter().all(|joint| joint.effort.is_some())).count();
    assert!(driven > 1400, "{driven}");
    let positions = |name: &str| {
        let all = states.iter().flat_map(|(_, state)| state.joints.iter().filter(|joint| joint.name == name));
        all.filter_map(|joint| joint.position).fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)))
    };
    let (lowest, highest) = positions("elbow");
    assert!(highest - lowest > 0.19, "{lowest} to {highest}");
    let last = &ticks.last().unwrap().1;
    assert_eq!((last.fault, last.state), (9, Some(5)));
    assert!(last.fault_text.as_ref().unwrap().starts_with("fault 9: emergency stop"), "{last:?}");
    assert_eq!(messages::<Text>(&bytes, "/robot_description").len(), 1);
}

#[test]
fn identify_and_motion_read_a_session_for_viewers_as_they_read_the_other() {
    let answers = [recorded("heard.log"), recorded("heard.mcap")].map(|record| {
        let commands: [&[&str]; 2] = [
            &["identify", "robots/planar2r.toml", "--plain-friction", "--json", "--log"],
            &["model", "motion", "--scene", "scenes/planar2r_swing.toml"],
        ];
        commands.map(|arguments| told(at_the_top().args(arguments).arg(&record).output().unwrap()))
    });
    for (plain, mcap) in answers[0].iter().zip(&answers[1]) {
        let unnamed = |text: &str| text.replace("heard.log", "FILE").replace("heard.mcap", "FILE");
        assert_eq!((plain.0, unnamed(&plain.1), unnamed(&plain.2)), (mcap.0, unnamed(&mcap.1), unnamed(&mcap.2)));
    }
    let (code, out, error) = &answers[1][0];
    // The arm matches its file, so a model may be rejected as no better: code, message and verdict agree.
    let grade = serde_json::from_str::<Value>(out).unwrap()["verdict"]["grade"].as_str().unwrap().to_owned();
    assert_eq!((*code == 0, error.is_empty()), (grade == "trusted", grade == "trusted"), "{code} {grade} {error}");
    assert!(matches!(*code, 0 | 3), "{code} {error}");
    // In a dry run the statuses contain no readings, from which a path would be made.
    assert!(answers[1][1].2.contains("0 samples of the joints"), "{}", answers[1][1].2);
}

#[test]
fn a_session_that_was_cut_anywhere_keeps_every_whole_chunk_and_says_what_is_left_out() {
    let bytes = std::fs::read(recorded("cut.mcap")).unwrap();
    let all = entries(bytes.clone());
    let (mut kept, mut chunks) = (0, std::collections::BTreeSet::new());
    let places = (0..200).chain((200..bytes.len()).step_by(bytes.len() / 50)).chain(bytes.len() - 40..bytes.len());
    for end in places {
        let Ok(log) = Log::new(bytes[..end].to_vec()) else {
            assert!(kept == 0, "{end}: what was whole before is whole now");
            continue;
        };
        let found: Vec<Entry> = log.entries().collect::<Result<_, _>>().unwrap();
        assert!(found.len() >= kept && found[..] == all[..found.len()], "{end}");
        assert!(log.cut() < end);
        kept = found.len();
        chunks.insert(kept);
    }
    // A chunk a second.
    assert!(kept == all.len() && chunks.len() >= 3, "{chunks:?}");
    let cut = file("cut_off.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let text = printed(at_the_top().args(["connect", "replay"]).arg(&cut).output().unwrap());
    assert!(text.contains(" ticks compared, 0 differ\nthe record ends within an entry: its last "), "{text}");
    // Cut exactly where a chunk ends: no bytes are left out, and the end record is missing.
    let log = Log::new(bytes[..bytes.len() * 2 / 3].to_vec()).unwrap();
    std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3 - log.cut()]).unwrap();
    let text = printed(at_the_top().args(["connect", "replay"]).arg(&cut).output().unwrap());
    assert!(text.ends_with("the record was not closed: its last second may be missing\n"), "{text}");
}

/// A flipped byte is either detected by a checksum, or in data that the reader ignores. It never gives a different frame, and never crashes the
/// program.
#[test]
fn a_session_with_any_byte_flipped_is_refused_or_read_as_it_was() {
    let bytes = std::fs::read(recorded_by("home\nconfirm\n", "flipped.mcap").0).unwrap();
    let all = entries(bytes.clone());
    let mut refused = 0;
    for (at, mask) in (0..bytes.len()).flat_map(|at| [0x01, 0x80, 0xff].map(|mask| (at, mask))) {
        let mut bytes = bytes.clone();
        bytes[at] ^= mask;
        match Log::new(bytes) {
            Ok(log) => {
                let found: Vec<Entry> = log.entries().map(Result::unwrap).collect();
                assert!(found.len() <= all.len() && found[..] == all[..found.len()], "{at}");
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused > bytes.len(), "{refused} of {} bytes, three times", bytes.len());
}

#[test]
fn files_that_are_no_record_are_bad_input_and_say_what_they_are() {
    let run = file("run.mcap");
    let (scene, record) = run_for::<2>("scenes/planar2r_swing.toml", 0.01);
    let bytes = written::<2>(&scene, &record);
    std::fs::write(&run, &bytes).unwrap();
    let (magic, short) = (file("magic.mcap"), file("short.mcap"));
    std::fs::write(&magic, &bytes[..8]).unwrap();
    std::fs::write(&short, &bytes[..5]).unwrap();
    for (path, problem) in [
        (&run, "an MCAP file without newtau.session; expected one that `connect --record` wrote"),
        (&magic, "the file ends within its head, at byte 8"),
        (&short, "byte 0: no record of a session; expected a file that begins with NEWTAULG, or an MCAP file"),
    ] {
        let (code, out, error) = told(at_the_top().args(["connect", "replay"]).arg(path).output().unwrap());
        assert_eq!((code, out.as_str()), (2, ""));
        assert!(error.contains(&format!("{}: {problem}", path.display())), "{error}");
    }
    let identify = at_the_top().args(["identify", "robots/planar2r.toml", "--log"]).arg(&run).output().unwrap();
    let (code, _, error) = told(identify);
    assert_eq!(code, 2);
    assert!(error.contains("10 samples"), "{error}");
}

#[test]
fn the_folder_of_an_mcap_file_is_made_before_the_run_and_one_that_cannot_be_ends_it_there() {
    let out = file("mcap_folder");
    std::fs::remove_dir_all(&out).ok();
    let run = |to: &Path| {
        let mut command = at_the_top();
        command.args(["run", PICK, "--duration", "0.01", "--quiet", "--no-report", "--mcap"]).arg(to);
        told(command.arg("--out").arg(&out).output().unwrap())
    };
    // A file exists at the path of the folder.
    let (code, _, error) = run(&Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml/x.mcap"));
    assert_eq!(code, 1);
    assert!(error.contains("Cargo.toml") && !out.join("log.csv").exists(), "{error}");
    let (code, _, error) = run(&out.join("new/and_newer/x.mcap"));
    assert!(code == 0 && out.join("new/and_newer/x.mcap").is_file(), "{error}");
}

/// A Python with the packages of `tests/viewers/requirements.txt`, which `cargo xtask test` sets up.
fn python() -> Option<String> {
    let python = std::env::var("NEWTAU_VIEWERS_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let imports = Command::new(&python).args(["-c", "import mcap, jsonschema"]).output();
    let there = imports.is_ok_and(|output| output.status.success());
    if !there {
        skipped("no Python with mcap and jsonschema: tests/viewers/requirements.txt");
    }
    there.then_some(python)
}

#[test]
fn other_programs_read_the_files_by_their_schemas_and_find_the_urdf_s_frames() {
    let Some(python) = python() else { return };
    let (planar, puma) = (file("checked_2.mcap"), file("checked_6.mcap"));
    let (scene, record) = run_for::<2>("scenes/planar2r_swing.toml", 0.2);
    std::fs::write(&planar, written::<2>(&scene, &record)).unwrap();
    let (scene, record) = run_for::<6>(PICK, 0.2);
    std::fs::write(&puma, written::<6>(&scene, &record)).unwrap();
    for (path, topics) in [(planar, 4), (puma, 4), (recorded("checked.mcap"), 5)] {
        let checked = Command::new(&python)
            .args(["tests/viewers/check.py", "tests/viewers/foxglove"])
            .arg(&path)
            .output()
            .unwrap();
        let found: Value = serde_json::from_str(&printed(checked)).unwrap();
        assert_eq!(found["official"].as_array().unwrap().len(), 2);
        assert_eq!(found["messages"].as_object().unwrap().len(), topics, "{found}");
        assert!(found["worst"].as_f64().unwrap() < 1e-12, "{found}");
    }
}
