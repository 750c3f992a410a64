//! The cores and their emulators.

/// A core on which the program runs.
pub(super) struct Core {
    /// Its name on the command line.
    pub(super) name: &'static str,
    /// Its name on the page.
    pub(super) title: &'static str,
    /// The compiler's target.
    pub(super) target: &'static str,
    /// Flags for the compiler.
    pub(super) flags: &'static str,
    /// Features of the program beside `bare`.
    pub(super) features: &'static [&'static str],
    pub(super) emulator: Emulator,
    /// C compiler with its flags, and its Debian package.
    pub(super) c: Option<(&'static str, &'static str)>,
    /// One of the three cores that every test run tries.
    pub(super) quick: bool,
}

/// The emulator of a core.
pub(super) enum Emulator {
    /// A WebAssembly module in Node.js.
    Node,
    /// A machine of QEMU: program, Debian package, arguments, and memory as address and length of code and data.
    Qemu { program: &'static str, package: &'static str, arguments: &'static str, memory: &'static str },
}

const fn arm(arguments: &'static str, memory: &'static str) -> Emulator {
    Emulator::Qemu { program: "qemu-system-arm", package: "qemu-system-arm", arguments, memory }
}

const fn riscv(program: &'static str) -> Emulator {
    Emulator::Qemu {
        program,
        package: "qemu-system-misc",
        arguments: "-M virt -bios none",
        memory: "0x80000000 4M 0x80400000 4M",
    }
}

const M7: &str = "-C target-cpu=cortex-m7";
const M33: &str = "-C target-cpu=cortex-m33";
// Vectorised loops of the M-profile vector extension flush subnormal numbers to zero.
const M55: &str = "-C target-cpu=cortex-m55 -C target-feature=-mve.fp";
const M_FLOAT: &str = "thumbv7em-none-eabihf";

pub(super) const CORES: &[Core] = &[
    Core {
        name: "cortex-m0",
        title: "Cortex-M0, no FPU",
        target: "thumbv6m-none-eabi",
        flags: "",
        features: &["soft"],
        emulator: arm("-M microbit", "0x0 256K 0x20000000 16K"),
        c: Some(("arm-none-eabi-gcc -O2 -mcpu=cortex-m0 -mthumb -mfloat-abi=soft", "gcc-arm-none-eabi")),
        quick: true,
    },
    Core {
        name: "cortex-m3",
        title: "Cortex-M3, no FPU",
        target: "thumbv7m-none-eabi",
        flags: "",
        features: &["soft"],
        emulator: arm("-M mps2-an385", "0x0 4M 0x20000000 4M"),
        c: Some(("arm-none-eabi-gcc -O2 -mcpu=cortex-m3 -mthumb -mfloat-abi=soft", "gcc-arm-none-eabi")),
        quick: false,
    },
    Core {
        name: "cortex-m4f",
        title: "Cortex-M4F",
        target: M_FLOAT,
        flags: "-C target-cpu=cortex-m4",
        features: &[],
        emulator: arm("-M netduinoplus2", "0x08000000 1M 0x20000000 128K"),
        c: Some((
            "arm-none-eabi-gcc -O2 -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16",
            "gcc-arm-none-eabi",
        )),
        quick: true,
    },
    Core {
        name: "cortex-m7",
        title: "Cortex-M7, FPU with f64",
        target: M_FLOAT,
        flags: M7,
        features: &["double"],
        emulator: arm("-M mps2-an500", "0x0 4M 0x20000000 4M"),
        c: Some(("arm-none-eabi-gcc -O2 -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16", "gcc-arm-none-eabi")),
        quick: false,
    },
    Core {
        name: "cortex-m33",
        title: "Cortex-M33",
        target: "thumbv8m.main-none-eabihf",
        flags: M33,
        features: &[],
        emulator: arm("-M mps2-an505", "0x10000000 4M 0x38000000 2M"),
        c: Some((
            "arm-none-eabi-gcc -O2 -mcpu=cortex-m33 -mthumb -mfloat-abi=hard -mfpu=fpv5-sp-d16",
            "gcc-arm-none-eabi",
        )),
        quick: false,
    },
    Core {
        name: "cortex-m55",
        title: "Cortex-M55 without vectorised loops",
        target: "thumbv8m.main-none-eabihf",
        flags: M55,
        features: &[],
        emulator: arm("-M mps3-an547", "0x10000000 512K 0x30000000 512K"),
        c: Some(("arm-none-eabi-gcc -O2 -mcpu=cortex-m55+nomve.fp -mthumb -mfloat-abi=hard", "gcc-arm-none-eabi")),
        quick: false,
    },
    Core {
        name: "riscv32imafc",
        title: "RISC-V 32 (IMAFC)",
        target: "riscv32imafc-unknown-none-elf",
        flags: "",
        features: &[],
        emulator: riscv("qemu-system-riscv32"),
        c: Some(("riscv64-unknown-elf-gcc -O2 -march=rv32imafc -mabi=ilp32f", "gcc-riscv64-unknown-elf")),
        quick: true,
    },
    Core {
        name: "riscv32imc",
        title: "RISC-V 32 (IMC), no FPU",
        target: "riscv32imc-unknown-none-elf",
        flags: "",
        features: &["soft"],
        emulator: riscv("qemu-system-riscv32"),
        c: Some(("riscv64-unknown-elf-gcc -O2 -march=rv32imc -mabi=ilp32", "gcc-riscv64-unknown-elf")),
        quick: false,
    },
    Core {
        name: "riscv64gc",
        title: "RISC-V 64 (GC)",
        target: "riscv64gc-unknown-none-elf",
        flags: "",
        features: &["double"],
        emulator: riscv("qemu-system-riscv64"),
        c: Some(("riscv64-unknown-elf-gcc -O2 -march=rv64gc -mabi=lp64d -mcmodel=medany", "gcc-riscv64-unknown-elf")),
        quick: false,
    },
    Core {
        name: "aarch64",
        title: "Cortex-A53 (AArch64)",
        target: "aarch64-unknown-none",
        flags: "",
        features: &["double"],
        emulator: Emulator::Qemu {
            program: "qemu-system-aarch64",
            package: "qemu-system-arm",
            arguments: "-M virt -cpu cortex-a53 -nic none",
            memory: "0x40080000 4M 0x41000000 4M",
        },
        c: Some(("aarch64-linux-gnu-gcc -O2", "gcc-aarch64-linux-gnu")),
        quick: false,
    },
    Core {
        name: "wasm32",
        title: "WebAssembly",
        target: "wasm32-unknown-unknown",
        flags: "",
        features: &[],
        emulator: Emulator::Node,
        c: None,
        quick: false,
    },
    Core {
        name: "wasm32-simd",
        title: "WebAssembly with simd128",
        target: "wasm32-unknown-unknown",
        flags: "-C target-feature=+simd128",
        features: &[],
        emulator: Emulator::Node,
        c: None,
        quick: false,
    },
];
