//! Writes every target's examples into `corpus/TARGET/`, from which `cargo fuzz` starts.

use std::fs;
use std::path::Path;

fn main() -> std::io::Result<()> {
    for target in trials::fuzz::TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target.name);
        fs::create_dir_all(&folder)?;
        for (index, example) in (target.examples)().iter().enumerate() {
            fs::write(folder.join(format!("example{index:03}")), example)?;
        }
        println!("{}", folder.display());
    }
    Ok(())
}
