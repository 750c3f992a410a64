//! A Slurm of one node, with daemons of its own that end with the task.

use super::engines::{descendants, kill};
use super::work::Work;
use crate::process::{output, run as finish, which};
use anyhow::{Context as _, Result, ensure};
use firmware_image::install;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Debian's packages, with their daemons.
pub(super) fn install() -> Result<()> {
    let missing: Vec<&str> = [("slurmctld", "slurm-wlm"), ("munged", "munge")]
        .into_iter()
        .filter(|(program, _)| which(program).is_none() && !Path::new("/usr/sbin").join(program).exists())
        .map(|(_, package)| package)
        .collect();
    if missing.is_empty() { Ok(()) } else { install::apt(&missing) }
}

/// The daemons; dropped, they end.
struct Cluster {
    folder: PathBuf,
    daemons: Vec<Child>,
}

/// Does the shards as an array job, kills the node with all that runs on it on the way, and starts the node again. Returns the seconds of
/// all that.
pub(super) fn run(work: &Work) -> Result<f64> {
    let folder = work.submit("slurm")?;
    let mut cluster = Cluster::start(&work.folder.join("slurm-daemons"))?;
    let start = Instant::now();
    finish(cluster.command("sbatch").current_dir(&folder).arg("submit.sbatch").stdout(Stdio::null()))?;
    wait("a quarter of the shards to begin", || work.begun("slurm") >= work.shards as usize / 4)?;
    cluster.kill_node(work.shards)?;
    wait("Slurm to see that its node is lost", || {
        cluster.said("sinfo", &["-h", "-o", "%T"]).is_some_and(|state| state.contains("down"))
    })?;
    eprintln!("scale: Slurm's node killed and given up; it is started again");
    cluster.start_node()?;
    wait("the queue to be empty", || cluster.said("squeue", &["-h"]).is_some_and(|queue| queue.is_empty()))?;
    Ok(start.elapsed().as_secs_f64())
}

/// Waits for what other programs do.
fn wait(what: &str, mut done: impl FnMut() -> bool) -> Result<()> {
    let start = Instant::now();
    while !done() {
        ensure!(start.elapsed() < Duration::from_secs(300), "waited for {what} for five minutes");
        sleep(Duration::from_millis(100));
    }
    Ok(())
}

impl Cluster {
    fn start(folder: &Path) -> Result<Self> {
        for name in ["state", "spool", "munge"] {
            fs::create_dir_all(folder.join(name))?;
        }
        let folder = folder.canonicalize()?;
        let host = output(Command::new("hostname").arg("-s")).context("this machine has no name")?;
        let at = |name: &str| folder.join(name).display().to_string();
        fs::write(folder.join("slurm.conf"), configuration(&host, &at))?;
        let mut cluster = Self { folder: folder.clone(), daemons: Vec::new() };
        let key = folder.join("munge/key");
        fs::write(&key, random(1024)?)?;
        finish(Command::new("chmod").args(["400", &at("munge/key")]))?;
        let places = ["socket", "key-file", "log-file", "pid-file", "seed-file"]
            .map(|option| format!("--{option}={}", at(&format!("munge/{}", option.trim_end_matches("-file")))));
        // Not as its own user and in no folder of the system: munge would refuse.
        cluster.daemon(
            "munged",
            &[&["--foreground", "--force"], places.each_ref().map(String::as_str).as_slice()].concat(),
        )?;
        wait("munge", || folder.join("munge/socket").exists())?;
        cluster.daemon("slurmctld", &["-D", "-c"])?;
        cluster.start_node()?;
        let idle = |cluster: &Self| cluster.said("sinfo", &["-h", "-o", "%T"]).is_some_and(|state| state == "idle");
        wait("Slurm's node", || idle(&cluster))?;
        Ok(cluster)
    }

    fn command(&self, program: &str) -> Command {
        let below = Path::new("/usr/sbin").join(program);
        let mut command = Command::new(if below.exists() { below } else { program.into() });
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    fn said(&self, program: &str, arguments: &[&str]) -> Option<String> {
        output(self.command(program).args(arguments))
    }

    /// Starts a daemon in the foreground: it is this task's child.
    fn daemon(&mut self, program: &str, arguments: &[&str]) -> Result<()> {
        let log = fs::File::create(self.folder.join(format!("{program}.log")))?;
        let mut command = self.command(program);
        command.args(arguments).stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
        self.daemons.push(command.spawn().with_context(|| format!("{program} does not start"))?);
        Ok(())
    }

    fn start_node(&mut self) -> Result<()> {
        self.daemon("slurmd", &["-D"])
    }

    /// Kills the node's daemon and the steps that it runs, as a power failure does.
    fn kill_node(&mut self, shards: u64) -> Result<()> {
        let Some(mut node) = self.daemons.pop() else { return Ok(()) };
        // Steps leave their daemon: they are known by the configuration that they carry.
        let steps: Vec<u32> = processes("slurmstepd", &self.folder);
        let below: Vec<u32> = steps.iter().flat_map(|step| descendants(*step)).collect();
        ensure!(!steps.is_empty(), "no shard of {shards} was running when the node was to be killed");
        node.kill()?;
        node.wait()?;
        steps.into_iter().chain(below).for_each(kill);
        Ok(())
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        self.daemons.iter_mut().rev().for_each(|daemon| {
            daemon.kill().ok();
            daemon.wait().ok();
        });
    }
}

/// Processes of this name whose environment names a folder, so that those of another Slurm are left alone.
fn processes(name: &str, folder: &Path) -> Vec<u32> {
    let ours = |process: &u32| {
        let read = |file: &str| fs::read(format!("/proc/{process}/{file}")).unwrap_or_default();
        let mine = |bytes: &[u8]| String::from_utf8_lossy(bytes).contains(&*folder.to_string_lossy());
        read("comm").starts_with(name.as_bytes()) && (mine(&read("environ")) || mine(&read("cmdline")))
    };
    let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).filter(ours).collect()
}

fn random(count: usize) -> Result<Vec<u8>> {
    use std::io::Read as _;
    let mut bytes = vec![0; count];
    fs::File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Ports of its own, and a node that is given up after five seconds.
fn configuration(host: &str, at: &dyn Fn(&str) -> String) -> String {
    let user = output(Command::new("id").arg("-un")).unwrap_or_else(|| "root".to_owned());
    [
        "ClusterName=scale".to_owned(),
        format!("SlurmctldHost={host}(127.0.0.1)"),
        format!("SlurmUser={user}"),
        format!("SlurmdUser={user}"),
        "AuthType=auth/munge".to_owned(),
        format!("AuthInfo=socket={}", at("munge/socket")),
        "SlurmctldPort=26817".to_owned(),
        "SlurmdPort=26818".to_owned(),
        format!("StateSaveLocation={}", at("state")),
        format!("SlurmdSpoolDir={}", at("spool")),
        format!("SlurmctldPidFile={}", at("slurmctld.pid")),
        format!("SlurmdPidFile={}", at("slurmd.pid")),
        "ProctrackType=proctrack/linuxproc".to_owned(),
        "TaskPlugin=task/none".to_owned(),
        "SelectType=select/cons_tres".to_owned(),
        "SelectTypeParameters=CR_CPU".to_owned(),
        "SchedulerParameters=sched_interval=1,batch_sched_delay=0".to_owned(),
        "SlurmdTimeout=5".to_owned(),
        "ReturnToService=2".to_owned(),
        "JobRequeue=1".to_owned(),
        "MaxArraySize=2000".to_owned(),
        "MpiDefault=none".to_owned(),
        format!("NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN"),
        "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n".to_owned(),
    ]
    .join("\n")
}
