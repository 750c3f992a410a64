//! An arm's URDF, frames and joints as messages.

use super::messages::{FrameTransform, FrameTransforms, JointState, JointStates, Quaternion, Text, Time, Xyz, finite};
use super::writer::{Channel, Writer};
use nalgebra::{Rotation3, UnitQuaternion};
use robot_compiler::Robot;
use robot_compiler::emit::urdf::{LinkTree, urdf};
use std::io::{self, Write};

/// Shortest time between two messages of frames, ns: a viewer needs no more than 100 a second.
const FRAME_STEP: u64 = 10_000_000;

/// Channels of an arm, and the data for its messages.
#[derive(Debug)]
pub struct ArmChannels {
    tree: LinkTree,
    names: Vec<String>,
    frames: Channel<FrameTransforms>,
    joints: Channel<JointStates>,
    /// Time of the next message of frames, ns.
    next_frames: u64,
}

impl ArmChannels {
    /// Adds the channels of an arm to a file, and writes its URDF.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new<W: Write>(file: &mut Writer<W>, robot: &Robot) -> io::Result<Self> {
        let description = file.channel::<Text>("/robot_description")?;
        file.write(&description, 0, &Text { data: urdf(robot) })?;
        Ok(Self {
            tree: LinkTree::new(robot),
            names: robot.joints.iter().map(|joint| joint.name.clone()).collect(),
            frames: file.channel("/tf")?,
            joints: file.channel("/joint_states")?,
            next_frames: 0,
        })
    }

    /// Names of the joints, base first.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Writes the arm's state at a time, ns: positions, velocities and torques of its joints. An empty list means unknown.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write<W: Write>(
        &mut self,
        file: &mut Writer<W>,
        at: u64,
        q: &[f64],
        qd: &[f64],
        torque: &[f64],
    ) -> io::Result<()> {
        let timestamp = Time::from_nanos(at);
        let of = |values: &[f64], joint: usize| values.get(joint).copied().and_then(finite);
        let joints = self.names.iter().enumerate().map(|(i, name)| JointState {
            name: name.clone(),
            position: of(q, i),
            velocity: of(qd, i),
            effort: of(torque, i),
        });
        file.write(&self.joints, at, &JointStates { timestamp, joints: joints.collect() })?;
        let whole = q.len() == self.names.len() && q.iter().all(|x| x.is_finite());
        if at >= self.next_frames && whole {
            self.next_frames = at + FRAME_STEP;
            file.write(&self.frames, at, &frames(&self.tree, timestamp, q))?;
        }
        Ok(())
    }
}

/// Frames of all joints at these positions (rad or m).
#[must_use]
pub fn frames(tree: &LinkTree, timestamp: Time, q: &[f64]) -> FrameTransforms {
    // The fixed joint of the tip has no position.
    let all = tree.joints.iter().zip(q.iter().copied().chain(std::iter::repeat(0.0)));
    let transforms = all.map(|(joint, q)| {
        let place = joint.place(q);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(place.rotation));
        FrameTransform {
            timestamp,
            parent_frame_id: joint.parent.clone(),
            child_frame_id: joint.child.clone(),
            translation: Xyz { x: place.translation.x, y: place.translation.y, z: place.translation.z },
            rotation: Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w },
        }
    });
    FrameTransforms { transforms: transforms.collect() }
}
