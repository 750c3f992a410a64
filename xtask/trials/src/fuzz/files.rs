//! Properties of a file reader for any content, and of the files that it accepts.

use dynamics_core::control::{Command, Measurement, Reference, Sensed};
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Model, Scene, Trig};
use miette::{GraphicalReportHandler, GraphicalTheme};
use robot_compiler::{FileError, Robot, SceneFile, emit, with_dof};
use sim::run::simulate::desk;
use std::fmt::Debug;

/// Reads a text; returns `None` if the reader rejects it with a helpful error.
///
/// An accepted text must give the same result again with a comment appended at its end.
pub(crate) fn read<T: PartialEq + Debug>(
    text: &str,
    name: &str,
    remark: &str,
    reader: impl Fn(&str) -> Result<T, FileError>,
) -> Option<T> {
    match reader(text) {
        Ok(accepted) => {
            let again = reader(&format!("{text}\n{remark}")).unwrap_or_else(|error| panic!("only once: {error}"));
            assert!(accepted == again, "{accepted:?} became {again:?}");
            Some(accepted)
        }
        Err(error) => {
            check_error(&error, text, name);
            None
        }
    }
}

/// Checks that an error describes the problem, the expected content, and a location in the text or a field.
fn check_error(error: &FileError, text: &str, name: &str) {
    let mut report = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).render_report(&mut report, error).unwrap();
    assert!(!error.problem().is_empty() && !error.expected().is_empty(), "{report}");
    // The robot file of a scene has its own errors and locations.
    if error.file() != name {
        return;
    }
    let Some((line, column)) = error.line_column() else {
        assert!(!error.field().is_empty(), "nowhere: {report}");
        return;
    };
    let columns = text.split('\n').nth(line - 1).map(|line| line.chars().count());
    assert!(
        columns.is_some_and(|columns| (1..=columns + 1).contains(&column)),
        "{line}:{column} is not there: {report}"
    );
}

/// Checks an accepted robot: it has a model in both precisions, the model has torques, and it has a default scene.
pub(crate) fn check_robot(robot: &Robot) {
    assert!((1..=6).contains(&robot.dof()));
    for (index, joint) in robot.joints.iter().enumerate() {
        assert!(!robot.joints[..index].iter().any(|other| other.name == joint.name), "{} twice", joint.name);
        let (low, high) = joint.spec.limits.position;
        assert!(low < high, "{low} to {high}");
    }
    assert!(robot.model::<1>().is_ok() == (robot.dof() == 1), "a model of another robot");
    with_dof!(robot.dof(), N => {
        let dynamics = Dynamics::new(robot.model::<N>().unwrap().cast::<f32>(), Scene::free_space());
        let q = [0.0; N];
        let torque = dynamics.inverse_dynamics(&Libm.sin_cos_all(&q), &q, &q, &q, &Live::zero());
        // Without motion and gravity there is no torque.
        assert!(torque.iter().all(|tau| *tau == 0.0), "{torque:?}");
    });
    check_scene(&SceneFile::default_for(robot.clone()));
}

/// Checks an accepted scene: it can be hashed and written out as source, and its motion is finite. On that motion the controller gives torques within
/// their limits, or brakes.
pub(crate) fn check_scene(scene: &SceneFile) {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().unwrap();
        assert_eq!(scene.hash(&model), scene.hash(&model));
        assert!(!emit::arm_module(scene, &model).contains("f32::NAN"));
        check_motion(scene, &model);
    });
}

fn check_motion<const N: usize>(scene: &SceneFile, model: &Model<f64, N>) {
    let motion = scene.trajectory(model).unwrap();
    let duration = motion.duration();
    assert!(duration.is_finite() && duration >= 0.0, "{duration}");
    let mut controller = desk::<f32, N>(scene, model);
    let limits = controller.config().limits;
    for share in [0.0, 0.3, 0.5, 0.9, 1.0] {
        let reference = motion.sample(share * duration);
        let Reference { q, qd, qdd } = &reference;
        assert!(q.iter().chain(qd).chain(qdd).all(|x| x.is_finite()), "{reference:?} at {share}");
        let reference = reference.cast::<f32>();
        let measurement = Measurement { sensed: Sensed::State { q: reference.q, qd: reference.qd }, age_ticks: 0 };
        if let Command::Drive { torque, .. } = controller.tick(&reference, &measurement) {
            for (tau, limit) in torque.iter().zip(&limits) {
                assert!(tau.is_finite() && tau.abs() <= limit.torque, "{tau} of {}", limit.torque);
            }
        }
    }
}
