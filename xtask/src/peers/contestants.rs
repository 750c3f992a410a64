//! The contestants and their builds.

use super::build::{self, Job};
use super::harness::{ARMS, folder, source};
use super::install::{self, CLANG};
use crate::process::{cargo, root, run, target_directory};
use crate::toolchain::{self, Toolchain};
use crate::workspace::Workspace;
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};

/// The computed quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Computation {
    /// Torques from angles, velocities and accelerations; sine and cosine included.
    Inverse,
    /// The same with sine and cosine given.
    Kernel,
    /// On the chip: the peer's kernel after our sine and cosine.
    KernelAfterOurTrig,
    /// Same as `Inverse`, but many states in one call, so that a compiler or a library can use vector instructions.
    Many,
    /// Accelerations from angles, velocities and torques.
    Forward,
}

/// Author of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Family {
    Pinocchio,
    Kdl,
    Dynibo,
    CasADi,
    CppADCodeGen,
    Generic,
    Exact,
    Regrouped,
    RegroupedLibm,
}

impl Family {
    /// Name in the tables.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Pinocchio => "Pinocchio",
            Self::Kdl => "KDL",
            Self::Dynibo => "dynibo",
            Self::CasADi => "Pinocchio, CasADi, C",
            Self::CppADCodeGen => "Pinocchio, CppADCodeGen, C",
            Self::Generic => "ours: recursion",
            Self::Exact => "ours: exact kernel",
            Self::Regrouped => "ours: regrouped kernel",
            Self::RegroupedLibm => "ours: regrouped kernel, libm's sine and cosine",
        }
    }
}

/// The generators of C, with their names in file names and in preprocessor switches.
pub(super) const GENERATORS: [(Family, &str, &str); 2] =
    [(Family::CasADi, "casadi", "CASADI"), (Family::CppADCodeGen, "cppadcg", "CPPADCG")];

/// Functions written by a generator, and the switch of `generated.c` for each.
pub(super) const GENERATED: [(Computation, &str, &str); 4] = [
    (Computation::Inverse, "inverse", ""),
    (Computation::Many, "inverse", "-DMANY"),
    (Computation::Kernel, "kernel", "-DKERNEL"),
    (Computation::Forward, "forward", "-DFORWARD"),
];

/// C++ compiler of the same version.
const CLANG_CPP: &str = "clang++-19";

/// Builds: name, C compiler, C++ compiler, options. Without `NDEBUG`, Eigen and Pinocchio check their arguments in every call, which slowed
/// Pinocchio's recursion from 357 to 496 ns. None of the three is the fastest for all contestants.
pub(super) const COMPILERS: [(&str, &str, &str, &str); 3] = [
    ("gcc, fast-math", "gcc", "g++", "-O3 -march=native -ffast-math -DNDEBUG"),
    ("clang 14, fast-math", "clang", "clang++", "-O3 -march=native -ffast-math -DNDEBUG"),
    ("clang 19, fast-math", CLANG, CLANG_CPP, "-O3 -march=native -ffast-math -DNDEBUG"),
];

const LIBRARY: &str = "-w -shared -fPIC -fvisibility=hidden";

/// Options that Pinocchio's own build requires of users of its headers. Its variants need joint types that the short
/// collection in `arm.hpp` does not have.
const PINOCCHIO: &str = "-std=c++17 -DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 \
    -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS -DBOOST_FUSION_INVOKE_MAX_ARITY=12 \
    -DBOOST_VARIANT_USE_RELAXED_GET_BY_DEFAULT";

/// A contestant on the desk.
#[derive(Clone, Debug)]
pub(super) struct Contestant {
    pub(super) family: Family,
    pub(super) task: Computation,
    /// Compiler and options, for the report.
    pub(super) build: &'static str,
    pub(super) library: PathBuf,
    pub(super) symbol: String,
}

/// Our builds: the crate `bench-peers` with default options, for this machine's processor, and for the chip; and dynibo's contestant.
pub(super) struct Ours {
    desk: [(&'static str, PathBuf); 2],
    pub(super) chip: PathBuf,
    dynibo: PathBuf,
}

impl Ours {
    /// Builds all of them.
    pub(super) fn build() -> Result<Self> {
        let desk = |flags: &str, target: PathBuf| -> Result<PathBuf> {
            let mut cargo = Workspace::Bench.cargo(["rustc", "--quiet", "--locked", "--package", "bench-peers"]);
            // One codegen unit, to match the C compiler's view of the peers: the profile of the chip's programs.
            cargo.args(["--profile", "firmware", "--crate-type", "cdylib"]).env("CARGO_TARGET_DIR", &target);
            run(cargo.env_remove("CARGO_ENCODED_RUSTFLAGS").env("RUSTFLAGS", flags))?;
            let library = target.join("firmware/libbench_peers.so");
            if library.is_file() { Ok(library) } else { bail!("cargo left no {}", library.display()) }
        };
        let ordinary = desk("", target_directory())?;
        let native = desk("-C target-cpu=native", folder().join("native"))?;
        let mut cargo = Toolchain::find_or_install()?.cargo("rustc");
        cargo.args(["--manifest-path", Workspace::Bench.manifest()]);
        cargo.args(["--quiet", "--locked", "--package", "bench-peers", "--crate-type", "staticlib"]);
        // In a firmware a kernel has one caller and is inlined, and a C compiler inlines the peers' static functions. Here the kernel has two
        // callers, so the threshold is raised.
        cargo.args(["--", "-Cllvm-args=-inline-threshold=10000"]);
        let chip = toolchain::build(&mut cargo, toolchain::product("libbench_peers.a"))?;
        Ok(Self { desk: [(NATIVE, native), (ORDINARY, ordinary)], chip, dynibo: dynibo()? })
    }

    /// The library that supplies states and reference torques.
    pub(super) fn reference(&self, arm: &str) -> Contestant {
        self.contestant(Family::Generic, Computation::Inverse, 0, format!("{arm}_generic"))
    }

    /// All our contestants.
    fn contestants(&self, arm: &str) -> Vec<Contestant> {
        let names = [
            (Family::Generic, Computation::Inverse, "generic"),
            (Family::Generic, Computation::Kernel, "generic_kernel"),
            (Family::Exact, Computation::Inverse, "exact"),
            (Family::Exact, Computation::Kernel, "exact_kernel"),
            (Family::Regrouped, Computation::Inverse, "regrouped"),
            (Family::Regrouped, Computation::Kernel, "regrouped_kernel"),
            (Family::RegroupedLibm, Computation::Inverse, "regrouped_libm"),
            (Family::Regrouped, Computation::Many, "batch"),
            (Family::Regrouped, Computation::Forward, "forward"),
            (Family::Generic, Computation::Forward, "generic_forward"),
        ];
        let both = |(family, task, name)| {
            (0..self.desk.len()).map(move |build| self.contestant(family, task, build, format!("{arm}_{name}")))
        };
        names.into_iter().flat_map(both).collect()
    }

    fn contestant(&self, family: Family, task: Computation, build: usize, symbol: String) -> Contestant {
        let (build, library) = &self.desk[build];
        Contestant { family, task, build, library: library.clone(), symbol }
    }
}

/// Builds dynibo's contestant for this machine's processor, with link-time optimisation across its packages.
fn dynibo() -> Result<PathBuf> {
    let target = folder().join("dynibo");
    let mut cargo = cargo(["build", "--quiet", "--locked", "--release", "--manifest-path"]);
    cargo.arg(source("dynibo/Cargo.toml")).arg("--target-dir").arg(&target);
    run(cargo.env_remove("CARGO_ENCODED_RUSTFLAGS").env("RUSTFLAGS", "-C target-cpu=native"))?;
    let library = target.join("release/libbench_peers_dynibo.so");
    if library.is_file() { Ok(library) } else { bail!("cargo left no {}", library.display()) }
}

/// Our build for this machine's processor, like the peers' builds.
const NATIVE: &str = "rustc, native";

/// Our build for any processor of this architecture.
pub(super) const ORDINARY: &str = "rustc";

/// Generates the arms' numbers from the robot files, the generators' C code, and the libraries that load the model at run time.
pub(super) fn generate(python: &Path) -> Result<()> {
    let site = install::site_packages(python)?;
    let prefix = site.join("cmeel.prefix");
    let flags = |job: Job| {
        let include = prefix.join("include");
        let job = job.words(PINOCCHIO).with("-w").with("-isystem").with(&include);
        job.with("-isystem").with(include.join("eigen3"))
    };
    let linked = |job: Job, folder: &Path, libraries: &str| {
        let path = folder.display();
        job.with(format!("-L{path}")).with(format!("-Wl,-rpath,{path}")).words(libraries)
    };
    let library = prefix.join("lib");
    let mut jobs = Vec::new();
    // clang rejects one of CppAD's default arguments.
    let job = flags(Job::new("g++", folder().join("generate_cppadcg")).words("-O0"));
    let job = job.with(source("generate_cppadcg.cpp")).output();
    jobs.push(linked(job, &library, "-lboost_serialization -lcppad_lib -ldl"));
    let job = flags(Job::new("clang++", folder().join("generate_casadi")).words("-O0"));
    let job = job.with("-isystem").with(site.join("casadi/include")).with(source("generate_casadi.cpp")).output();
    jobs.push(linked(linked(job, &site.join("casadi"), "-lcasadi"), &library, "-lboost_serialization"));
    for (index, (_, _, compiler, options)) in COMPILERS.into_iter().enumerate() {
        let job = flags(Job::new(compiler, model_at_run_time("pinocchio", index)).words(options).words(LIBRARY));
        let job = job.with(source("pinocchio.cpp")).output();
        jobs.push(linked(job, &library, "-lboost_serialization"));
        let job = Job::new(compiler, model_at_run_time("kdl", index)).words(options).words(LIBRARY);
        let job = job.words("-isystem /usr/include/eigen3").with(source("kdl.cpp"));
        jobs.push(job.output().words("-lorocos-kdl"));
    }
    for arm in ARMS {
        let file = root().join("robots").join(arm).with_extension("toml");
        let job = Job::new(python, numbers(arm)).with("-B").with(source("arm.py")).with(&file);
        jobs.push(job.with(numbers(arm)));
    }
    build::all("generators, Pinocchio, KDL", jobs)?;

    let mut jobs = Vec::new();
    for arm in ARMS {
        for (_, name, _) in GENERATORS {
            let program = folder().join(format!("generate_{name}"));
            let last = generated(arm, name, "forward", "f32");
            let job = Job::new(&program, last).with(numbers(arm));
            jobs.push(job.with(folder().join(arm)));
        }
    }
    std::fs::create_dir_all(folder())?;
    for arm in ARMS {
        std::fs::create_dir_all(folder().join(arm))?;
    }
    build::all("generated C", jobs)?;

    let mut jobs = Vec::new();
    for arm in ARMS {
        for (_, name, switch) in GENERATORS {
            for (task, function, switches) in GENERATED {
                for (index, (_, compiler, _, options)) in COMPILERS.into_iter().enumerate() {
                    let text = generated(arm, name, function, "f64");
                    let job = Job::new(compiler, compiled(arm, name, task, index)).words(options).words(LIBRARY);
                    let job = job.words(switches).words("-DENTRY=run").with(format!("-D{switch}"));
                    let job = job.with(format!("-DSOURCE={:?}", text.display().to_string()));
                    jobs.push(job.with(source("generated.c")).output().words("-lm"));
                }
            }
        }
    }
    build::all("contestants", jobs)
}

/// All contestants, ours first.
pub(super) fn all(arm: &str, ours: &Ours) -> Vec<Contestant> {
    let mut all = ours.contestants(arm);
    for (index, (build, ..)) in COMPILERS.into_iter().enumerate() {
        let mut push = |family, task, library: PathBuf, symbol: &str| {
            all.push(Contestant { family, task, build, library, symbol: symbol.to_owned() });
        };
        push(Family::Pinocchio, Computation::Inverse, model_at_run_time("pinocchio", index), "inverse");
        push(Family::Pinocchio, Computation::Forward, model_at_run_time("pinocchio", index), "forward");
        push(Family::Pinocchio, Computation::Forward, model_at_run_time("pinocchio", index), "forward_world");
        push(Family::Kdl, Computation::Inverse, model_at_run_time("kdl", index), "inverse");
        for (family, name, _) in GENERATORS {
            for (task, ..) in GENERATED {
                push(family, task, compiled(arm, name, task, index), "run");
            }
        }
    }
    for (task, symbol) in [(Computation::Inverse, "inverse"), (Computation::Forward, "forward")] {
        all.push(Contestant {
            family: Family::Dynibo,
            task,
            build: NATIVE,
            library: ours.dynibo.clone(),
            symbol: symbol.to_owned(),
        });
    }
    all
}

/// The arm's numbers, as written by `arm.py`.
pub(super) fn numbers(arm: &str) -> PathBuf {
    folder().join(arm).with_extension("arm")
}

/// C source from a generator.
pub(super) fn generated(arm: &str, generator: &str, function: &str, real: &str) -> PathBuf {
    folder().join(arm).join(format!("{generator}_{function}_{real}.c"))
}

fn compiled(arm: &str, generator: &str, task: Computation, compiler: usize) -> PathBuf {
    folder().join(arm).join(format!("{generator}_{task:?}_{compiler}.so"))
}

fn model_at_run_time(peer: &str, compiler: usize) -> PathBuf {
    folder().join(format!("{peer}_{compiler}.so"))
}
