#!/usr/bin/env python3
"""Measures studies on HyperQueue and Slurm, each killed on the way, and writes the tables of docs/measured/scale.md.

    bench/scale/measure.py              prints the tables
    bench/scale/measure.py --write      writes them into the page, without the line that says what was measured
    cargo xtask measured --renew --page scale       does the same, and adds this line

1. One process runs the study bench/scale/study.toml.
2. HyperQueue runs it in 50 shards, with two workers of one core each. When a quarter of the shards has started, the cluster is killed with all
   that it runs. A new cluster runs all shards.
3. Slurm runs it in 50 shards, on one node with two cores. When a quarter has started, the node's slurmd and its steps are killed. When Slurm has
   noticed, slurmd is started again, and Slurm queues the lost shards again.
4. The shards of each engine are merged. Every file must have the same bytes as after step 1.
5. 1000 shards of 100 runs are merged.
6. One thread runs 1000 runs of the pick study. The plan for 1e9 picks is computed from all of these figures.

Needs: Slurm and munge from Debian (`apt-get install slurm-wlm munge`); exits with code 2 if they are missing. HyperQueue is installed from
requirements.txt into a virtual environment below target/, unless this Python has it. No other program should run meanwhile.

Slurm's daemons have a configuration of their own in a temporary folder, so that another Slurm of this machine is left alone. Only processes that this
script has started are killed. Their logs, and everything that the engines write, are in target/scale.
"""

import argparse
import filecmp
import math
import os
import platform
import pwd
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).absolute()
FOLDER = TARGET / "scale"
PAGE = ROOT / "docs/measured/scale.md"
PICK = ROOT / "scenes/studies/pick_payload_friction.toml"

SHARDS = 50
# Shards of the large merge, and runs of each.
MANY, EACH = 1000, 100
PICKS = 1000
# The plan: runs, and length of a shard in s.
PLAN, SHARD = 1e9, 1800
# Target for a million picks, core minutes.
TARGET_MINUTES = 70
# Longest wait for an engine, s.
PATIENCE = 300


@dataclass
class Cost:
    seconds: float
    # Processor time of all threads, s.
    processor: float
    # Most memory, MiB.
    memory: float


def say(text):
    print(f"scale: {text}", file=sys.stderr, flush=True)


def stop(text, code=1):
    say(text)
    sys.exit(code)


def wait(what, done, process, pause=0.02):
    """Waits until `done`, which it asks after each pause of so many seconds; fails if `process` ends before."""
    end = time.monotonic() + PATIENCE
    while not done():
        if process.poll() is not None:
            stop(f"waiting for {what}: {process.args[0]} has ended; the logs are in {FOLDER}")
        if time.monotonic() > end:
            stop(f"waited {PATIENCE} s for {what}; the logs are in {FOLDER}")
        time.sleep(pause)


def measured(command, **options):
    """Runs a command; returns its cost. Its memory is at least that of this Python, 15 MiB, because it begins as a copy of it."""
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, **options)
    try:
        _, status, used = os.wait4(process.pid, 0)
    except BaseException:
        kill(process.pid)
        raise
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        stop(f"exit code {process.returncode}: {' '.join(map(str, command))}")
    return Cost(time.monotonic() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def kill(process):
    """Kills a process and all processes below it. Each is stopped first, so that it starts no other meanwhile."""
    try:
        os.kill(process, signal.SIGSTOP)
        children = [int(child) for file in Path(f"/proc/{process}/task").glob("*/children") for child in file.read_text().split()]
        for child in children:
            kill(child)
        os.kill(process, signal.SIGKILL)
    except (ProcessLookupError, FileNotFoundError):
        pass  # It has ended by itself.


def submit(program, runs, engine):
    """Writes an engine's folder."""
    folder = FOLDER / engine
    command = [program, "sweep", HERE / "study.toml", "--quiet", "--runs", str(runs), "--submit", engine, "--shards", str(SHARDS)]
    subprocess.run([*command, "--out", folder], check=True, stdout=subprocess.DEVNULL)
    return folder


def one_process(program, submitted):
    """Runs the study of an engine's folder."""
    # The report contains paths: here they are those of a merge in the engine's folder.
    shard = FOLDER / "shards/1"
    shard.mkdir(parents=True)
    for file in submitted.glob("*.toml"):
        shutil.copy(file, shard)
    return measured([program, "sweep", "shards/1/study.toml", "--quiet", "--out", "whole"], cwd=FOLDER)


def started(folder):
    """Number of shards that have begun to write."""
    return len(list(folder.glob("shards/*/manifest.json")))


def wait_for_a_quarter(folder, process):
    wait("a quarter of the shards", lambda: started(folder) >= math.ceil(SHARDS / 4), process)


def check_killed(folder):
    count = started(folder)
    if count >= SHARDS:
        stop("all shards had started before the kill: use more --runs")
    say(f"killed after {count} of {SHARDS} shards had started")


def compare(folder):
    """Merges an engine's shards, and compares every file with the output of one process."""
    if subprocess.run([folder / "merge.sh"], stdout=subprocess.DEVNULL).returncode:
        stop(f"the shards cannot be merged; their logs are in {folder / 'logs'}")
    one, merged = FOLDER / "whole", folder / "whole"
    files = sorted(path.relative_to(one) for path in one.rglob("*") if path.is_file())
    others = sorted(path.relative_to(merged) for path in merged.rglob("*") if path.is_file())
    if files != others:
        stop(f"{folder.name}: files {others}, expected {files}")
    for file in files:
        if not filecmp.cmp(one / file, merged / file, shallow=False):
            stop(f"{folder.name}: {file} differs from that of one process")
    say(f"{folder.name}: {len(files)} files, same bytes")


def python_with_hyperqueue():
    """A Python that has the version of HyperQueue in requirements.txt."""
    requirements = HERE / "requirements.txt"
    show = "from importlib.metadata import version; print('hyperqueue==' + version('hyperqueue'))"

    def has(python):
        # -I: this folder has a hyperqueue.py.
        found = subprocess.run([python, "-I", "-c", show], capture_output=True, text=True)
        return found.returncode == 0 and found.stdout.strip() in requirements.read_text().splitlines()

    environment = TARGET / "scale-venv"
    python = environment / "bin/python"
    for known in [sys.executable, python]:
        if Path(known).exists() and has(known):
            return known
    say(f"installing HyperQueue into {environment}")
    subprocess.run([sys.executable, "-m", "venv", "--clear", environment], check=True)
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--requirement", requirements], check=True)
    return python


def hyperqueue(folder, python):
    """Runs the shards on a cluster that is killed, and then on a new one. Returns the seconds of both."""
    command = [python, HERE / "hyperqueue.py", folder, str(SHARDS), "2"]
    with open(FOLDER / "hyperqueue.log", "w") as log, tempfile.TemporaryDirectory(prefix="scale-") as temporary:
        options = dict(stdout=log, stderr=log, env={**os.environ, "TMPDIR": temporary})
        start = time.monotonic()
        cluster = subprocess.Popen(command, **options)
        try:
            wait_for_a_quarter(folder, cluster)
        finally:
            kill(cluster.pid)
            cluster.wait()
        check_killed(folder)
        cluster = subprocess.Popen(command, **options)
        try:
            if cluster.wait():
                stop(f"HyperQueue failed; its log is {log.name}")
        finally:
            kill(cluster.pid)
        return time.monotonic() - start


class Slurm:
    """A Slurm of one node with two cores. Its daemons run in the foreground, as children of this script."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.daemons = {}
        os.environ["SLURM_CONF"] = str(self.folder / "slurm.conf")

    def __enter__(self):
        at = self.folder
        for name in ["state", "spool"]:
            (at / name).mkdir()
        (at / "key").write_bytes(os.urandom(1024))
        (at / "key").chmod(0o400)
        host = platform.node().split(".")[0]
        user = pwd.getpwuid(os.getuid()).pw_name
        # Slurm gives a silent node up after five seconds.
        (at / "slurm.conf").write_text(f"""\
ClusterName=scale
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={at}/socket
SlurmctldPort=26817
SlurmdPort=26818
StateSaveLocation={at}/state
SlurmdSpoolDir={at}/spool
SlurmctldPidFile={at}/slurmctld.pid
SlurmdPidFile={at}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SlurmdTimeout=5
ReturnToService=2
JobRequeue=1
MpiDefault=none
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
""")
        try:
            files = [f"--{name}-file={at}/munge.{name}" for name in ["log", "pid", "seed"]]
            # --force: munge would refuse a folder of its own.
            self.start("munged", "--foreground", "--force", f"--socket={at}/socket", f"--key-file={at}/key", *files)
            wait("munge", (at / "socket").exists, self.daemons["munged"])
            self.start("slurmctld", "-D", "-c")
            self.start_node()
            self.wait("Slurm's node", lambda state: state == "idle", "sinfo", "-h", "-o", "%T")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self.kill_node()
        for name in ["slurmctld", "munged"]:
            if daemon := self.daemons.pop(name, None):
                kill(daemon.pid)
                daemon.wait()

    def start(self, name, *arguments):
        with open(FOLDER / f"{name}.log", "a") as log:
            self.daemons[name] = subprocess.Popen([daemon(name), *arguments], stdin=subprocess.DEVNULL, stdout=log, stderr=log)

    def start_node(self):
        self.start("slurmd", "-D")

    def kill_node(self):
        """Kills slurmd and its steps, as a power failure does."""
        if node := self.daemons.pop("slurmd", None):
            os.kill(node.pid, signal.SIGSTOP)
            # Steps leave their daemon. They are known by the folder of this Slurm in their environment.
            for process in [int(path.name) for path in Path("/proc").glob("[0-9]*")]:
                try:
                    step = Path(f"/proc/{process}/comm").read_text().startswith("slurmstepd")
                    if step and str(self.folder).encode() in Path(f"/proc/{process}/environ").read_bytes():
                        kill(process)
                except (ProcessLookupError, FileNotFoundError):
                    pass  # It has ended meanwhile.
            kill(node.pid)
            node.wait()

    def wait(self, what, done, *command):
        """Waits until the output of one of Slurm's commands is as it should be; fails if the daemon that was started last ends before."""

        def answered():
            answer = subprocess.run(command, capture_output=True, text=True)
            return answer.returncode == 0 and done(answer.stdout.strip())

        wait(what, answered, list(self.daemons.values())[-1], 0.1)


def daemon(name):
    """Path of a daemon, which Debian puts where only root's PATH finds it; none if it is missing."""
    return shutil.which(name, path=f"/usr/sbin:{os.environ['PATH']}")


def slurm(folder):
    """Runs the shards as an array of jobs, kills the node on the way, and starts it again. Returns the seconds of all of that."""
    with tempfile.TemporaryDirectory(prefix="scale-") as temporary, Slurm(temporary) as cluster:
        start = time.monotonic()
        subprocess.run(["sbatch", "submit.sbatch"], check=True, cwd=folder, stdout=subprocess.DEVNULL)
        wait_for_a_quarter(folder, cluster.daemons["slurmctld"])
        cluster.kill_node()
        check_killed(folder)
        cluster.wait("Slurm to notice the kill", lambda state: state.startswith("down"), "sinfo", "-h", "-o", "%T")
        cluster.start_node()
        cluster.wait("the shards", lambda queue: not queue, "squeue", "-h")
        return time.monotonic() - start


def merge(program):
    """Merges very many shards."""
    many = FOLDER / "many"
    for shard in range(1, MANY + 1):
        sweep = [program, "sweep", HERE / "study.toml", "--quiet", "--jobs", "1", "--runs", str(MANY * EACH)]
        subprocess.run([*sweep, "--shard", f"{shard}/{MANY}", "--out", many / "shards" / str(shard)], check=True)
    return measured([program, "sweep", "merge", many / "shards", "--quiet", "--out", many / "whole"])


def pick(program):
    """Runs the pick study in one thread."""
    return measured([program, "sweep", PICK, "--quiet", "--jobs", "1", "--runs", str(PICKS), "--out", FOLDER / "pick"])


def table_bytes(folder):
    return (FOLDER / folder / "runs.csv").stat().st_size


def table(head, rows):
    return "\n".join([f"| what | {head} |", "|---|---|", *(f"| {what} | {value} |" for what, value in rows)])


def tables(runs, one, on_hyperqueue, on_slurm, merged, picked):
    """The tables of the page."""
    pick_seconds = picked.processor / PICKS
    row = table_bytes("pick") / PICKS
    measured_rows = [
        (f"{runs} runs of two rods, one process", f"{one.seconds:.1f} s; {one.memory:.0f} MiB at most"),
        (f"the same on HyperQueue: {SHARDS} shards, the cluster killed on the way", f"{on_hyperqueue:.1f} s; same bytes"),
        (f"the same on Slurm: {SHARDS} shards, the node killed on the way", f"{on_slurm:.1f} s; same bytes"),
        (f"merge of {MANY} shards of {EACH} runs, with its results", f"{merged.seconds:.1f} s; {merged.memory:.0f} MiB at most"),
        ("a row of the table of two rods", f"{table_bytes('whole') / runs:.0f} bytes"),
        (f"a pick of 2.1 s at 1 kHz, in {PICKS} runs", f"{1e3 * pick_seconds:.2f} ms of a core"),
        ("a row of the table of picks", f"{row:.0f} bytes"),
        (
            f"a million picks (target: {TARGET_MINUTES} core minutes)",
            f"{1e6 * pick_seconds / 60:.0f} core minutes; {picked.memory:.0f} MiB at most",
        ),
    ]
    hours = PLAN * pick_seconds / 3600
    shards = math.ceil(PLAN * pick_seconds / SHARD)
    # The time of a merge is proportional to its bytes.
    merge_hours = PLAN * row * merged.seconds / table_bytes("many/whole") / 3600
    planned_rows = [
        ("core hours", f"{hours:.0f}"),
        ("on 1,000 cores", f"{hours / 1000:.1f} h"),
        (
            "shards of half an hour, one core each",
            f"{shards}, each {PLAN / shards:.0f} runs and {PLAN / shards * row / 1e6:.0f} MB",
        ),
        ("the table", f"{PLAN * row / 1e9:.0f} GB"),
        ("its merge, in one thread, one shard in memory", f"{merge_hours:.1f} h"),
        ("a kill costs", "one block, about half a second"),
        (
            "what breaks first",
            "the merge, which is one thread and two passes over the table; then Slurm's MaxArraySize (1,001 unless raised)",
        ),
    ]
    plan = "A plan for 1e9 picks, from these figures (nobody has run it):"
    return "\n\n".join([table("measured", measured_rows), plan, table("planned", planned_rows)])


def write(text):
    """Puts a text between the markers of the page."""
    begin, end = "<!-- measured: scale -->", "<!-- end measured: scale -->"
    head, rest = PAGE.read_text().split(begin)
    PAGE.write_text(f"{head}{begin}\n\n{text}\n\n{end}{rest.split(end)[1]}")
    say(f"written to {PAGE.relative_to(ROOT)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write the tables into the page")
    parser.add_argument("--runs", type=int, default=100_000, help="runs of the study on the engines (default: 100000)")
    parser.add_argument("--program", type=Path, help="this newtau; without it, it is built")
    options = parser.parse_args()

    missing = [name for name in ["munged", "slurmctld", "slurmd", "sbatch", "sinfo", "squeue"] if not daemon(name)]
    if missing:
        stop(f"{', '.join(missing)} missing: install Slurm from Debian, `apt-get install slurm-wlm munge`", 2)
    python = python_with_hyperqueue()
    program = options.program
    if program is None:
        subprocess.run(["cargo", "build", "--release", "--locked", "--package", "host-sim"], check=True, cwd=ROOT)
        program = TARGET / "release/newtau"
    program = program.absolute()
    # Ended by a signal, the script still ends what it has started.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)

    folders = {engine: submit(program, options.runs, engine) for engine in ["hyperqueue", "slurm"]}
    say(f"{options.runs} runs in one process")
    one = one_process(program, folders["hyperqueue"])
    say(f"{SHARDS} shards on HyperQueue")
    on_hyperqueue = hyperqueue(folders["hyperqueue"], python)
    compare(folders["hyperqueue"])
    say(f"{SHARDS} shards on Slurm")
    on_slurm = slurm(folders["slurm"])
    compare(folders["slurm"])
    say(f"a merge of {MANY} shards")
    merged = merge(program)
    say(f"{PICKS} picks")
    picked = pick(program)
    text = tables(options.runs, one, on_hyperqueue, on_slurm, merged, picked)
    print(text)
    if options.write:
        write(text)


if __name__ == "__main__":
    main()
