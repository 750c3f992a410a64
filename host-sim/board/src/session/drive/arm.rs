//! Session and drives of a scene, for any number of joints.

use super::bus_rates::AdapterLoad;
use super::control::{self, Ends, Shown};
use super::device::DriveDevice;
use super::lateness::TickTimes;
use crate::can::adapter::Adapter;
use crate::can::adapter_name::{AdapterError, AdapterName};
use crate::can::host_bus::HostBus;
use crate::can::motors::round_trip;
use crate::can::settings;
use crate::can::simulated::SimulatedArm;
use crate::real_time::period;
use crate::session::dry_run::desk_session;
use crate::session::operate::Presses;
use dynamics_core::drive::MitDrive;
use dynamics_core::safety::SafeAction;
use joint_io::can::{BUSES, CanJoints};
use joint_io::{JointIo, NoPin};
use robot_compiler::drive::Protocol;
use robot_compiler::{SceneFile, conflict_on_one_bus, with_dof};
use sim::failure::Failure;
use sim::with_drive_type;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread;

/// Frames that wait between operator and control thread. The thread drops its own if the operator does not read them.
const FRAMES: usize = 1024;

/// A scene's drives, by the adapters that they are at.
pub struct Wiring {
    protocol: Protocol,
    drives: Vec<MitDrive>,
    adapters: Vec<AdapterName>,
    loads: Vec<AdapterLoad>,
}

impl Wiring {
    /// Drives at these adapters, bus 1 first. A single adapter has all drives, whatever their bus in the robot file. `without_timeout` accepts drives
    /// that may keep their last torque if this program dies.
    ///
    /// # Errors
    /// [`Failure::Input`]: what this computer cannot drive, or not at the scene's rate.
    pub fn new(scene: &SceneFile, adapters: &[AdapterName], without_timeout: bool) -> Result<Self, Failure> {
        let wrong = |why: String| Err(Failure::Input(miette::miette!("{why}")));
        let robot = scene.robot.path.display();
        let mut drives = scene.mit_drives();
        let (Some(protocol), true) = (scene.protocol(), drives.len() == scene.robot.dof()) else {
            return wrong(format!(
                "{robot}: [joint.drive]: expected a drive on CAN at every joint (docs/reference/robot-file.md): `newtau connect` reaches boards with other drives"
            ));
        };
        if scene.safety.safe_action == SafeAction::Brake {
            return wrong(
                "safety.safe_action: found \"brake\", expected \"damped-stop\" or \"off\": this computer has no line that engages brakes".into(),
            );
        }
        if let Some(joint) = drives.iter().position(|drive| drive.data_rate.is_some()) {
            return wrong(format!(
                "{robot}: joint {}: drive.data_rate: expected no such key: CAN FD is not available at a computer's adapters yet",
                joint + 1
            ));
        }
        if let Some(twice) =
            adapters.iter().enumerate().find_map(|(at, name)| adapters[..at].contains(name).then_some(name))
        {
            return wrong(format!(
                "--can {twice}: given twice; expected an adapter for each bus, or one for all drives"
            ));
        }
        let shared = |at: usize, name: &AdapterName| adapters[..at].iter().any(|other| other.is_same_adapter(name));
        if let Some((_, name)) = adapters.iter().enumerate().find(|(at, name)| shared(*at, name)) {
            return wrong(format!(
                "--can {name}: another channel of this adapter is named too; expected one channel of an adapter with gs_usb in a program; on Linux, its \
                 driver's interfaces are both: `--can can0 --can can1`"
            ));
        }
        if adapters.len() > BUSES {
            return wrong(format!("--can: found {} adapters, expected at most {BUSES}", adapters.len()));
        }
        if adapters.len() > 1 && adapters.contains(&AdapterName::Simulated) {
            return wrong("--can simulated: expected no other adapter: the whole arm is simulated".into());
        }
        if let [name] = adapters {
            drives.iter_mut().for_each(|drive| drive.bus = 0);
            if let Some(why) = conflict_on_one_bus(&scene.robot) {
                return wrong(format!("{robot}: {why}: they cannot share {name}; expected an adapter for each bus"));
            }
        }
        if let Some(joint) = drives.iter().position(|drive| usize::from(drive.bus) >= adapters.len()) {
            let bus = drives.get(joint).map_or(0, |drive| drive.bus) + 1;
            return wrong(format!(
                "{robot}: joint {}: drive.bus = {bus}: expected an adapter for each bus, `--can BUS1 --can BUS2`, or one for all; found {}",
                joint + 1,
                adapters.len()
            ));
        }
        if !without_timeout && let Some(joint) = drives.iter().position(|drive| drive.timeout == 0) {
            return wrong(format!(
                "{robot}: joint {}: this kind of drive has no timeout that can be read or set: if this program dies, it may keep its last torque; \
                 expected a drive with a timeout, a board (`newtau connect`), or `--without-timeout` and an emergency stop in your hand",
                joint + 1
            ));
        }
        let identifier = protocol.facts().identifier;
        let loads: Vec<_> = (0_u8..)
            .zip(adapters)
            .map(|(bus, name)| AdapterLoad::new(name.clone(), &drives, bus, identifier, scene.control.rate))
            .collect();
        if let Some(why) = loads.iter().find_map(|load| load.check().err()) {
            return wrong(format!("{}: {why}", scene.path.display()));
        }
        Ok(Self { protocol, drives, adapters: adapters.to_vec(), loads })
    }

    /// Load of each adapter.
    #[must_use]
    pub fn loads(&self) -> &[AdapterLoad] {
        &self.loads
    }

    /// Opens the adapters, and starts the control thread. No drive is enabled before the operator arms.
    ///
    /// # Errors
    /// [`Failure::Target`]: an adapter cannot be opened. [`Failure::Input`]: the scene is not possible.
    pub fn start(&self, scene: &SceneFile, presses: Presses) -> Result<DriveDevice, Failure> {
        self.start_at(self.open(scene)?, scene, presses)
    }

    /// Starts the control thread with drives at these buses.
    pub(crate) fn start_at(
        &self,
        buses: [HostBus; BUSES],
        scene: &SceneFile,
        presses: Presses,
    ) -> Result<DriveDevice, Failure> {
        with_dof!(scene.robot.dof(), N => self.start_joints::<N>(buses, scene, presses))
    }

    fn start_joints<const N: usize>(
        &self,
        buses: [HostBus; BUSES],
        scene: &SceneFile,
        presses: Presses,
    ) -> Result<DriveDevice, Failure> {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let drives = <[MitDrive; N]>::try_from(self.drives.clone())
            .map_err(|drives| Failure::Input(miette::miette!("{} drives for {N} joints", drives.len())))?;
        // There is no line to brakes.
        let joints: Box<dyn JointIo<N> + Send> = with_drive_type!(self.protocol, K => Box::new(CanJoints::<K, _, _, _, _, N>::new(buses.into(), NoPin, drives)));
        let session = desk_session(scene, &model);
        let period = period(scene.control.rate);
        let times = TickTimes::new().map_err(|error| Failure::Target(miette::miette!("{error}")))?;
        let shown = Arc::new(Shown::new(times));
        let ((to_board, from_host), (to_host, from_board)) = (sync_channel(FRAMES), sync_channel(FRAMES));
        let (ends, seen) = (Ends { from_host, to_host }, Arc::clone(&shown));
        let thread = thread::Builder::new()
            .name("control".into())
            // A session of six joints with its buffers is larger than the stack of a thread may be elsewhere.
            .stack_size(16 << 20)
            .spawn(move || control::run(session, joints, period, &ends, &seen))
            .map_err(|error| Failure::Target(miette::miette!("no control thread: {error}")))?;
        Ok(DriveDevice::new((to_board, from_board), thread, shown, presses))
    }

    /// The joints at this adapter, counted from 0, and their drives.
    fn drives_at<'a>(&'a self, name: &AdapterName) -> impl Iterator<Item = (usize, MitDrive)> + 'a {
        let bus = self.adapters.iter().position(|other| other == name).unwrap_or(0);
        self.drives.iter().copied().enumerate().filter(move |(_, drive)| usize::from(drive.bus) == bus)
    }

    /// Checks that frames mean to the motors what the robot file says.
    ///
    /// # Errors
    /// [`Failure::Input`]: a motor has another setting. [`Failure::Target`]: it does not answer.
    pub(crate) fn check_settings(
        &self,
        adapter: &mut dyn Adapter,
        name: &AdapterName,
        scene: &SceneFile,
    ) -> Result<(), Failure> {
        let found = settings::check(adapter, self.protocol, self.drives_at(name))
            .map_err(|error| Failure::Target(miette::miette!("{name}: {error}")))?
            .unwrap_or_default();
        if found.is_empty() {
            return Ok(());
        }
        let lines: Vec<String> = found.iter().map(ToString::to_string).collect();
        let robot = scene.robot.path.display();
        let report = miette::miette!(
            help = settings::advice(&found),
            "{name}: motors do not fit {robot}, nothing was enabled:\n{}",
            lines.join("\n")
        );
        let is_silent = found.iter().any(|it| it.mismatch == settings::Mismatch::Silent);
        Err(if is_silent { Failure::Target(report) } else { Failure::Input(report) })
    }

    /// Checks that a drive's answer arrives within a tick. Frames are not numbered: replies that are always a tick late would look punctual.
    fn check_delay(&self, adapter: &mut dyn Adapter, name: &AdapterName, scene: &SceneFile) -> Result<(), Failure> {
        let drives: Vec<MitDrive> = self.drives_at(name).map(|(_, drive)| drive).collect();
        let longest = round_trip(adapter, self.protocol, &drives)
            .map_err(|error| Failure::Target(miette::miette!("{name}: {error}")))?;
        match longest {
            Some(time) if time > period(scene.control.rate) => Err(Failure::Target(miette::miette!(
                help = "a lower `control.rate`; for a serial chip, `setserial PORT low_latency`; nothing else on this computer that takes the processor",
                "{name}: a drive's answer took {:.1} ms, and a tick has {:.1} ms",
                time.as_secs_f64() * 1e3,
                1e3 / scene.control.rate
            ))),
            _ => Ok(()),
        }
    }

    fn open(&self, scene: &SceneFile) -> Result<[HostBus; BUSES], Failure> {
        let mut buses = [const { HostBus::none() }; BUSES];
        let simulated = match self.adapters.contains(&AdapterName::Simulated) {
            true => Some(SimulatedArm::new(scene)?),
            false => None,
        };
        for (bus, name) in buses.iter_mut().zip(&self.adapters) {
            let mut adapter: Box<dyn Adapter> = match (name, &simulated) {
                (AdapterName::Simulated, Some(arm)) => Box::new(arm.adapter()),
                _ => name.open().map_err(unopened)?,
            };
            self.check_delay(adapter.as_mut(), name, scene)?;
            self.check_settings(adapter.as_mut(), name, scene)?;
            *bus = HostBus::new(adapter);
        }
        Ok(buses)
    }
}

fn unopened(error: AdapterError) -> Failure {
    Failure::Target(miette::miette!(help = error.advice(), "{error}"))
}
