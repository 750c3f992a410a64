//! List of all measured blocks: page, command and artefacts.

use super::artefact::Artefact::{self, Files, Kernels, Log, Printed, Programs};

/// A block of a page of docs/measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredBlock {
    /// File name of the page, without its extension.
    pub(super) page: &'static str,
    /// The block's name in its marker lines.
    pub(super) name: &'static str,
    /// The command that writes the block; otherwise, a description of the manual measurement.
    pub(super) command: &'static str,
    pub(super) artefacts: &'static [Artefact],
}

impl MeasuredBlock {
    /// Path of the page in the project.
    pub(super) fn path(&self) -> String {
        format!("docs/measured/{}.md", self.page)
    }

    /// True if `name` is the name of the page or of the block.
    pub(super) fn is_called(&self, name: &str) -> bool {
        [self.page, self.name].contains(&name)
    }

    /// Page and block, for messages.
    pub(super) fn place(&self) -> String {
        format!("{}, block `{}`", self.path(), self.name)
    }
}

/// Sources that run on the chip in addition to the emitted arm: from the core, the controller and the safety state machine.
const CHIP: Artefact = Files(
    "sources of the chip",
    &[
        "dynamics-core/src/control.rs",
        "dynamics-core/src/control",
        "dynamics-core/src/drive.rs",
        "dynamics-core/src/drive",
        "dynamics-core/src/dynamics",
        "dynamics-core/src/geometry.rs",
        "dynamics-core/src/inertia.rs",
        "dynamics-core/src/joint.rs",
        "dynamics-core/src/model.rs",
        "dynamics-core/src/safety.rs",
        "dynamics-core/src/safety",
        "dynamics-core/src/scalar.rs",
        "dynamics-core/src/scene.rs",
        "dynamics-core/src/trig.rs",
        "dynamics-core/src/trig",
        "link/src",
        "link/session/src",
        "link/joint-io/src",
        "firmware/src",
        "firmware/tick.x",
        "firmware/coupled.x",
        "firmware/memory",
    ],
);
const ESTIMATOR: Artefact =
    Files("sources of the cycle estimate", &["xtask/image/src/cycles", "xtask/image/src/decode"]);
const PICK: Artefact = Programs(&["puma560_pick"]);
const CAMPAIGNS: Artefact = Programs(&["campaign/encoders", "campaign/states", "campaign/yam"]);
const PEERS: Artefact = Files("sources of the peers' harness", &["bench/peers"]);
const MUJOCO: Artefact = Files("sources of MuJoCo's side", &["bench/simulators"]);
const BATCH: Artefact =
    Files("sources of the batch", &["bench/batch/src", "dynamics-core/src/trig", "dynamics-core/src/dynamics"]);
const SHARDS: Artefact = Files(
    "sources of the shards",
    &["host-sim/studies/src/sweep/store", "host-sim/studies/src/sweep/submit.rs", "bench/scale"],
);

const ARMS: &[Artefact] = &[Log("yam_move"), Log("rebot_move"), Log("yam_split")];
const BUDGET: &[Artefact] = &[Programs(&[]), CHIP, ESTIMATOR];
const CORES: &[Artefact] = &[
    Kernels,
    Files(
        "sources of the program for every core",
        &[
            "xtask/cores/src",
            "xtask/src/cores/table.rs",
            "dynamics-core/src/control",
            "dynamics-core/src/trig.rs",
            "dynamics-core/src/trig",
        ],
    ),
];
const CYCLES: &[Artefact] = &[Kernels, ESTIMATOR];
const GROWN: &[Artefact] = &[Log("ur5_wave"), Files("sources of the growth", &["xtask/src/bench/growth/case.rs"])];
const SIMULATED: &[Artefact] = &[Log("puma560_pick"), MUJOCO];

const BENCH: &str = "cargo xtask bench";
const BUDGET_COMMAND: &str = "cargo xtask budget --flood --write";
const CYCLE_COMMAND: &str = "cargo xtask cycles --write";
const ARM_COMMAND: &str = "cargo xtask bench --arms";
const GROWTH: &str = "cargo xtask bench --growth --all --write";
const SIMULATORS: &str = "cargo xtask bench --simulators";

const fn block(
    page: &'static str,
    name: &'static str,
    command: &'static str,
    artefacts: &'static [Artefact],
) -> MeasuredBlock {
    MeasuredBlock { page, name, command, artefacts }
}

/// All blocks, page by page.
pub(super) const BLOCKS: &[MeasuredBlock] = &[
    block("arms", "arms", ARM_COMMAND, ARMS),
    block("arms", "arms, torque from outside", ARM_COMMAND, ARMS),
    block(
        "batch",
        "batch",
        "cargo bench --manifest-path bench/Cargo.toml -p dynamics-batch, once for each -C target-cpu",
        &[BATCH],
    ),
    block("bound", "bound", "cargo newtau choose bound robots/*.toml --write docs/measured/bound.md", BOUND),
    block("budget", "budget", BUDGET_COMMAND, BUDGET),
    block("budget", "tick start", BUDGET_COMMAND, FLOOD),
    block("budget", "link", "cargo xtask budget --link --write", &[PICK, CHIP, ESTIMATOR]),
    block("calibration", "calibration", "the programs of others, by hand: the page says how", &[ESTIMATOR]),
    block("campaign", "campaign, desk", "cargo xtask campaign --runs 10000 --write", &[Printed("campaign --runs 700")]),
    block("campaign", "campaign, drives", "cargo xtask campaign --target drives --runs 10000 --write", DRIVES),
    block("campaign", "campaign, qemu", "cargo xtask campaign --target qemu --runs 700 --write", QEMU),
    block("cores", "cores", "cargo xtask cores --write", CORES),
    block("cores", "C", "cargo xtask cores --write", CORES),
    block("cycles", "cycles", CYCLE_COMMAND, CYCLES),
    block("cycles", "cycles by class", CYCLE_COMMAND, CYCLES),
    block("growth", "growth", GROWTH, GROWN),
    block("growth", "growth, values", GROWTH, GROWN),
    block("kernels", "machine", BENCH, &[Kernels]),
    block("kernels", "chip", BENCH, &[Kernels]),
    block("kernels", "spills", BENCH, &[Kernels]),
    block("kernels", "terms", BENCH, &[Kernels]),
    block("kernels", "gravity", BENCH, &[Kernels]),
    block("kernels", "desk", BENCH, &[Kernels]),
    block("kernels", "callgrind", BENCH, &[Kernels]),
    block("kernels", "compiler", BENCH, &[Kernels]),
    block("peers", "peers", "cargo xtask bench --peers", &[Kernels, PEERS]),
    block("report", "report", "cargo xtask report --time", &[Log("puma560_pick")]),
    block("scale", "scale", "bench/scale/measure.py --write", &[SHARDS]),
    block("simulators", "simulators", SIMULATORS, SIMULATED),
    block("simulators", "simulators, equal error", SIMULATORS, SIMULATED),
    block("simulators", "simulators, cost by time and runs", SIMULATORS, SIMULATED),
    block("simulators", "simulators, agreement", SIMULATORS, SIMULATED),
    block("studies", "pick_payload_friction", study::PICK, study::PICKED),
    block("studies", "yam_teach_masses", study::MASSES, study::TAUGHT),
    block("studies", "delay_stiffness", study::DELAY, study::DELAYED),
    block("trade_puma560_pick", "trade, puma560_pick", TRADE, &[PICK, CHIP, ESTIMATOR, Log("puma560_pick")]),
    block("tuning", "tuning", "cargo xtask budget --tuning --write", &[PICK, CHIP, ESTIMATOR]),
];

const FLOOD: &[Artefact] = &[Programs(&["puma560_collision"]), CHIP];
const DRIVES: &[Artefact] = &[Printed("campaign --target drives --runs 700")];
const QEMU: &[Artefact] = &[CAMPAIGNS, CHIP, Files("sources of the campaign", &["xtask/trials/src/campaign"])];
const BOUND: &[Artefact] = &[Printed("choose bound robots/scara.toml --samples 100 --boxes 20")];

/// The command of docs/trade.md.
const TRADE: &str = "cargo newtau choose trade scenes/puma560_pick.toml --write docs/measured/trade_puma560_pick.md \
    --trig polynomial,polynomial-5,polynomial-3,table --every 1,4:hold,4:extrapolate --kernel exact,regrouped";

mod study {
    use super::{Artefact, Printed};

    pub(super) const PICK: &str = "cargo newtau sweep scenes/studies/pick_payload_friction.toml --write";
    pub(super) const MASSES: &str = "cargo newtau sweep scenes/studies/yam_teach_masses.toml --write";
    pub(super) const DELAY: &str = "cargo newtau sweep scenes/studies/delay_stiffness.toml --write";
    pub(super) const PICKED: &[Artefact] = &[Printed("sweep scenes/studies/pick_payload_friction.toml --runs 32")];
    pub(super) const TAUGHT: &[Artefact] = &[Printed("sweep scenes/studies/yam_teach_masses.toml --runs 32")];
    pub(super) const DELAYED: &[Artefact] = &[Printed("sweep scenes/studies/delay_stiffness.toml")];
}
