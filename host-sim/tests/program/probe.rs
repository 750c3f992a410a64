//! A scripted probe-rs.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses its part")]

use super::new;
use std::ffi::OsString;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

/// A new folder of this name.
pub fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("probe").join(name);
    std::fs::create_dir_all(new(&path)).unwrap();
    path
}

/// A tool that records its arguments, one line per call, and then does what the script specifies.
pub struct FakeProbe {
    folder: PathBuf,
}

impl FakeProbe {
    pub fn new(test: &str, script: &str) -> Self {
        let folder = folder(test);
        let path = folder.join("probe-rs");
        let calls = folder.join("calls");
        std::fs::write(&path, format!("#!/bin/sh\necho \"$@\" >> '{}'\n{script}\n", calls.display())).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        Self { folder }
    }

    /// A `PATH` with this tool first; compilers and shells follow as usual.
    pub fn path(&self) -> OsString {
        let others = std::env::var_os("PATH").unwrap();
        let folders = std::iter::once(self.folder.clone()).chain(std::env::split_paths(&others));
        std::env::join_paths(folders).unwrap()
    }

    /// The tool itself.
    pub fn program(&self) -> PathBuf {
        self.folder.join("probe-rs")
    }

    /// Its calls so far.
    pub fn calls(&self) -> Vec<String> {
        let text = std::fs::read_to_string(self.folder.join("calls")).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }
}

/// A `PATH` without any probe-rs.
pub fn path_without_probe() -> OsString {
    let all = std::env::var_os("PATH").unwrap();
    std::env::join_paths(std::env::split_paths(&all).filter(|folder| !folder.join("probe-rs").exists())).unwrap()
}
