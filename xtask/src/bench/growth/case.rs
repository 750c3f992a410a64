//! One timed run of the program: its robot, scene and study, its time and its peak memory.

use crate::process::root;
use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use toml_edit::{DocumentMut, Item, value};

/// The arm whose first joints are used. It has no friction, so every motion takes the same number of steps.
const ROBOT: &str = "robots/ur5.toml";
pub(super) const JOINTS_MAX: usize = 6;

/// Poses at the start and in the middle of the motion, rad. It ends at its start.
const POSES: [[f64; JOINTS_MAX]; 2] = [[0.0, -1.57, 1.2, -1.2, -1.57, 0.0], [0.8, -1.2, 1.5, -1.8, -1.2, 0.5]];

/// Part of the motion that is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Motion {
    /// All of it, back and forth.
    Whole,
    /// A short run, for a sweep with many runs.
    Beginning,
}

impl Motion {
    /// Simulated time, s.
    pub(super) fn seconds(self) -> f64 {
        match self {
            Self::Whole => 2.0,
            Self::Beginning => 0.05,
        }
    }
}

/// One run of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Case {
    /// Number of joints.
    pub(super) joints: usize,
    /// Integration steps per control tick.
    pub(super) steps: u32,
    pub(super) motion: Motion,
    /// Number of runs of a sweep; `None` for one run alone.
    pub(super) runs: Option<u32>,
    /// Number of threads of a sweep.
    pub(super) threads: u32,
}

/// Time, s, and peak memory, MB.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) seconds: f64,
    pub(super) peak: Option<f64>,
}

impl Default for Best {
    fn default() -> Self {
        Self { seconds: f64::INFINITY, peak: None }
    }
}

impl Best {
    /// Keeps the shorter time and the larger memory.
    pub(super) fn improve(&mut self, once: &Self) {
        self.seconds = self.seconds.min(once.seconds);
        self.peak = self.peak.into_iter().chain(once.peak).reduce(f64::max);
    }
}

impl Case {
    /// Name of the scene; cases that differ only in runs or threads share it.
    fn scene(&self) -> String {
        format!("{}-joints-{}-steps-{:?}", self.joints, self.steps, self.motion).to_lowercase()
    }

    /// Name of the folder for results.
    pub(super) fn name(&self) -> String {
        let runs = self.runs.map_or("alone".to_owned(), |runs| format!("{runs}-runs-{}-threads", self.threads));
        format!("{}-{runs}", self.scene())
    }

    /// Writes robot, scene and study into a folder.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let scene = self.scene();
        let pose = |pose: [f64; JOINTS_MAX]| format!("{:?}", &pose[..self.joints]);
        let [start, middle] = POSES.map(pose);
        let (duration, half) = (self.motion.seconds(), 0.5 * Motion::Whole.seconds());
        let step = 1e-3 / f64::from(self.steps);
        let text = format!(
            "name = \"{scene}\"\nrobot = \"{scene}-robot.toml\"\nduration = {duration:?}\n\
             [control]\nrate = 1000.0\nnatural_frequency = 30.0\n\
             [motion]\nkind = \"quintic\"\npoints = [{{ q = {start} }}, {{ q = {middle}, duration = {half:?} }}, \
             {{ q = {start}, duration = {half:?} }}]\n\
             [plant]\nintegrator = \"runge-kutta\"\nstep = {step:?}\n"
        );
        let study = format!(
            "name = \"growth\"\nscene = \"{scene}.toml\"\n[runs]\ncount = 1\nseed = 1\n[[vary]]\nkey = \"robot.joint.*.mass\"\n\
             uniform = [0.95, 1.05]\nrelative = \"factor\"\n[[metric]]\nname = \"tracking_max\"\n"
        );
        let files = [("-robot", first_joints(self.joints)?), ("", text), ("-study", study)];
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        files.iter().try_for_each(|(kind, text)| {
            let path = folder.join(format!("{scene}{kind}.toml"));
            fs::write(&path, text).with_context(|| path.display().to_string())
        })
    }

    /// Runs the program once.
    pub(super) fn once(&self, folder: &Path, mut program: Command) -> Result<Best> {
        let out = folder.join(self.name());
        fs::remove_dir_all(&out).ok();
        match self.runs {
            None => program.arg("run").arg(self.file(folder, "")).args(["--json", "--no-report"]),
            Some(runs) => program.arg("sweep").arg(self.file(folder, "-study")).args([
                "--quiet",
                "--runs",
                &runs.to_string(),
                "--jobs",
                &self.threads.to_string(),
            ]),
        };
        let began = Instant::now();
        let child = program.arg("--out").arg(&out).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        let child = child.with_context(|| format!("cannot start {program:?}"))?;
        let process = child.id();
        let memory = std::thread::spawn(move || peak_until_end(process));
        let done = child.wait_with_output()?;
        let whole = began.elapsed().as_secs_f64();
        ensure!(done.status.success(), "{}: {}", self.name(), String::from_utf8_lossy(&done.stderr));
        let seconds = match self.runs {
            Some(_) => whole,
            // The loop alone, without the start of the program.
            None => {
                let summary: Value = serde_json::from_slice(&done.stdout)?;
                let factor = summary.get("realtime_factor").and_then(Value::as_f64);
                self.motion.seconds() / factor.with_context(|| format!("{}: no `realtime_factor`", self.name()))?
            }
        };
        Ok(Best { seconds, peak: memory.join().ok().flatten() })
    }

    fn file(&self, folder: &Path, kind: &str) -> PathBuf {
        folder.join(format!("{}{kind}.toml", self.scene()))
    }
}

/// The robot file with its first joints only.
fn first_joints(count: usize) -> Result<String> {
    let path = root().join(ROBOT);
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let mut robot: DocumentMut = text.parse().with_context(|| path.display().to_string())?;
    robot["name"] = value(format!("UR5, joints 1 to {count}"));
    let joints = robot.get_mut("joint").and_then(Item::as_array_of_tables_mut);
    let joints = joints.with_context(|| format!("{ROBOT}: no tables `joint`"))?;
    ensure!((1..=joints.len()).contains(&count), "{ROBOT}: expected 1 to {} joints, found {count}", joints.len());
    while joints.len() > count {
        joints.remove(joints.len() - 1);
    }
    Ok(robot.to_string())
}

/// Peak memory of a process, MB, observed until it ends. `None` if the operating system does not report it.
fn peak_until_end(process: u32) -> Option<f64> {
    let mut peak = None;
    while let Some(kilobytes) = peak_now(&fs::read_to_string(format!("/proc/{process}/status")).ok()?) {
        peak = Some(kilobytes / 1024.0);
        std::thread::sleep(Duration::from_millis(2));
    }
    peak
}

/// Peak memory in the text of `/proc/PROCESS/status`, kB. A process that has ended has none.
fn peak_now(status: &str) -> Option<f64> {
    status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix("kB")?.trim().parse().ok())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::{Best, first_joints, peak_now};

    #[test]
    fn a_chain_has_the_first_joints_of_the_arm() {
        let robot = first_joints(2).unwrap();
        assert_eq!(robot.matches("[[joint]]").count(), 2);
        assert!(robot.contains("\"shoulder_lift\"") && !robot.contains("\"elbow\""), "{robot}");
        for count in [0, 7] {
            let error = first_joints(count).unwrap_err().to_string();
            assert!(error.contains("expected 1 to 6 joints") && error.contains("ur5.toml"), "{error}");
        }
    }

    #[test]
    fn the_shortest_time_and_the_largest_memory_count() {
        let mut best = Best::default();
        for (seconds, peak) in [(3.0, Some(7.0)), (2.0, None), (4.0, Some(9.0))] {
            best.improve(&Best { seconds, peak });
        }
        assert_eq!((best.seconds, best.peak), (2.0, Some(9.0)));
    }

    #[test]
    fn the_peak_memory_is_read_from_the_status_of_a_process() {
        assert_eq!(peak_now("Name:\tnewtau\nVmPeak:\t  90000 kB\nVmHWM:\t   18780 kB\nVmRSS:\t 5 kB\n"), Some(18780.0));
        assert_eq!(peak_now("Name:\tnewtau\nState:\tZ (zombie)\n"), None);
    }
}
