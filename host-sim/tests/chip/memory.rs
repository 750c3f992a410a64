//! Memory of the control tick: its code in static RAM, its stack and data in the memory that is coupled to the core, and buffers of a DMA in neither.

use board::chip::build_firmware;
use firmware_image::{Board, Build};
use object::{Object as _, ObjectSection as _, ObjectSymbol as _};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

const FLASH: Range<u64> = 0x0800_0000..0x0900_0000;
const COUPLED: Range<u64> = 0x1000_0000..0x1001_0000;
const SRAM: Range<u64> = 0x2000_0000..0x2002_0000;

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name).canonicalize().unwrap()
}

/// Addresses of a program's functions, variables and linker symbols, and of its sections.
struct Addresses {
    symbols: Vec<(String, u64)>,
    functions: Vec<(String, u64)>,
    sections: BTreeMap<String, Range<u64>>,
}

impl Addresses {
    fn of(elf: &Path) -> Self {
        let bytes = std::fs::read(elf).unwrap();
        let file = object::File::parse(&*bytes).unwrap();
        // The linker's veneers between the memories have the names of their destinations.
        let named = |s: object::Symbol<'_, '_>| (s.name().unwrap_or_default().to_owned(), s.address());
        let symbols = file.symbols().filter(|s| !s.name().unwrap_or_default().contains("Thunk")).map(named).collect();
        let code = |s: &object::Symbol<'_, '_>| s.kind() == object::SymbolKind::Text && s.size() > 0;
        let functions = file.symbols().filter(code).map(named).filter(|(name, _)| !name.contains("Thunk")).collect();
        let sections = file.sections().map(|s| (s.name().unwrap().to_owned(), s.address()..s.address() + s.size()));
        Self { symbols, functions, sections: sections.collect() }
    }

    /// Addresses of all symbols whose name contains a text.
    fn named(&self, text: &str) -> Vec<u64> {
        addresses(&self.symbols, text)
    }

    /// Addresses of all functions whose name contains a text.
    fn functions(&self, text: &str) -> Vec<u64> {
        addresses(&self.functions, text)
    }
}

fn addresses(all: &[(String, u64)], text: &str) -> Vec<u64> {
    let found: Vec<_> = all.iter().filter(|(name, _)| name.contains(text)).map(|(_, at)| *at).collect();
    assert!(!found.is_empty(), "nothing has {text} in its name");
    found
}

#[test]
fn the_whole_tick_runs_from_ram_and_its_data_are_where_the_coupled_memory_would_be() {
    let program = Addresses::of(&build_firmware(&scene("puma560_pick.toml")).unwrap());
    for code in ["TIM3", "dynamics_core", "newtau_session", "memcpy"] {
        let wrong: Vec<_> = program.functions(code).into_iter().filter(|at| FLASH.contains(at)).collect();
        assert!(wrong.is_empty(), "{code} in flash: {wrong:x?}");
    }
    let [start, end] = ["_coupled_start", "_coupled_end"].map(|name| program.named(name)[0]);
    let places = program.named("local_init_places");
    assert!(places.iter().all(|at| (start..end).contains(at)), "{places:x?}");
    assert!((start..=end).contains(&program.named("_stack_start")[0]));
    // A negative control: what serves the link stays in flash.
    assert!(program.functions("newtau_link").iter().any(|at| FLASH.contains(at)));
}

#[test]
fn on_a_chip_with_coupled_memory_stack_and_data_are_in_it_and_buffers_of_a_dma_are_not() {
    for (board, name) in [(Board::F405Can, "mit6_wave"), (Board::G474Fdcan, "mit6_fd_wave")] {
        let scene = scene(&format!("examples/{name}.toml"));
        let program = Addresses::of(&Build::of(&scene, board).run().unwrap());
        let coupled = &program.sections[".coupled"];
        assert!(COUPLED.contains(&coupled.start) && coupled.end <= COUPLED.end, "{name}: {coupled:x?}");
        assert!(program.named("_stack_end")[0] == COUPLED.start, "{name}: nothing lies below the stack");
        assert!(SRAM.contains(&program.sections[".tick"].start), "{name}");
        // Unlike the emulated chip's, this program has initialised data before the code, and the code begins at a multiple of 256 bytes.
        let [start, end, original] =
            ["__tick_start", "__tick_end", "__tick_original"].map(|name| program.named(name)[0]);
        let (data, flash) = (program.named("__sdata")[0], program.named("__sidata")[0]);
        assert!(start > data && start % 256 == 0 && end % 256 == 0, "{name}: {data:x} {start:x}..{end:x}");
        assert_eq!(original - flash, start - data, "{name}: the start-up code copies the code from elsewhere");
        for buffer in ["RECEIVED", "TO_SEND"] {
            assert!(program.named(buffer).iter().all(|at| SRAM.contains(at)), "{name}: {buffer}");
        }
    }
}
