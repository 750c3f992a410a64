//! Files that live as long as this program: sockets, key pages, lists.
//!
//! They are in a folder of this process, which is deleted with its last file. A program that is killed deletes nothing; so the first file of a later
//! program deletes the folders of processes that are dead.

use rustix::process::{Pid, geteuid, test_kill_process};
use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Begin of a folder's name; the process id follows.
const PREFIX: &str = "newtau-run-";

/// Files of this process: made so far, and there now.
struct Count {
    made: u32,
    now: u32,
}

static COUNT: Mutex<Count> = Mutex::new(Count { made: 0, now: 0 });

/// A file name in this process's folder, which only its owner can enter; the file is deleted on drop.
#[derive(Debug)]
pub struct ScratchFile(PathBuf);

impl ScratchFile {
    /// A new name that ends with this one. Nothing is there yet.
    ///
    /// # Errors
    /// The folder cannot be made, or belongs to another user.
    pub fn new(name: &str) -> io::Result<Self> {
        let mut count = COUNT.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let folder = folder(std::process::id());
        if count.made == 0 {
            sweep(&std::env::temp_dir());
            // Left over from a killed process with the same id.
            fs::remove_dir_all(&folder).ok();
        }
        match DirBuilder::new().mode(0o700).create(&folder) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            other => other?,
        }
        let found = fs::symlink_metadata(&folder)?;
        if !found.is_dir() || found.uid() != geteuid().as_raw() || found.mode() & 0o077 != 0 {
            return Err(io::Error::other(format!("{}: not a folder of this user alone", folder.display())));
        }
        (count.made, count.now) = (count.made + 1, count.now + 1);
        Ok(Self(folder.join(format!("{}-{name}", count.made))))
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for ScratchFile {
    fn drop(&mut self) {
        let mut count = COUNT.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        // It is not an error if the file was never made.
        fs::remove_file(&self.0).ok();
        count.now -= 1;
        if count.now == 0 {
            fs::remove_dir(folder(std::process::id())).ok();
        }
    }
}

fn folder(process: u32) -> PathBuf {
    std::env::temp_dir().join(format!("{PREFIX}{process}"))
}

/// Deletes this user's folders of dead processes.
fn sweep(temporary: &Path) {
    let Ok(entries) = fs::read_dir(temporary) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let process = name.to_str().and_then(|name| name.strip_prefix(PREFIX)?.parse().ok()).and_then(Pid::from_raw);
        let is_ours =
            fs::symlink_metadata(entry.path()).is_ok_and(|found| found.is_dir() && found.uid() == geteuid().as_raw());
        // Any other answer means that the process is there.
        if is_ours && process.is_some_and(|process| test_kill_process(process) == Err(rustix::io::Errno::SRCH)) {
            fs::remove_dir_all(entry.path()).ok();
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::{PREFIX, ScratchFile, sweep};
    use std::fs;
    use std::process::Command;

    #[test]
    fn files_and_their_folder_are_deleted_and_folders_of_dead_processes_are_swept() {
        let (first, second) = (ScratchFile::new("a.sock").unwrap(), ScratchFile::new("a.sock").unwrap());
        let folder = first.path().parent().unwrap().to_owned();
        assert!(folder.is_dir() && first.path() != second.path());
        fs::write(second.path(), "x").unwrap();
        drop(first);
        assert!(second.path().is_file());
        drop(second);
        assert!(!folder.exists());

        let temporary = std::env::temp_dir().join(format!("newtau-test-sweep-{}", std::process::id()));
        let dead = {
            let mut child = Command::new("true").spawn().unwrap();
            let process = child.id();
            child.wait().unwrap();
            process
        };
        let [dead, alive] = [dead, std::process::id()].map(|process| temporary.join(format!("{PREFIX}{process}")));
        let other = temporary.join("newtau-run-notes");
        for folder in [&dead, &alive, &other] {
            fs::create_dir_all(folder).unwrap();
            fs::write(folder.join("1-a.sock"), "x").unwrap();
        }
        sweep(&temporary);
        assert_eq!([&dead, &alive, &other].map(|folder| folder.exists()), [false, true, true]);
        fs::remove_dir_all(&temporary).unwrap();
    }
}
