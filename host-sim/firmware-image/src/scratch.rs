//! Files that live as long as this program: sockets, key pages, lists.
//!
//! They are in a folder of this process, which is deleted with its last file. A program that is killed deletes nothing; so the first file of a later
//! program deletes the folders of processes that are dead.

use crate::process::folder_for_owner;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

/// Begin of a folder's name; the process id and a number follow.
const PREFIX: &str = "newtau-run-";

/// File in the folder that its owner keeps locked. The system unlocks it when the owner ends.
const LOCK: &str = "lock";

/// Age from which a folder without a lock belongs to nobody: its owner makes the lock at once.
const YOUNG: Duration = Duration::from_secs(60);

/// Most folders of processes that seem to have this process's number, as in another container.
const NAMES: u32 = 100;

/// Folder of this process, the number of files made in it, and of those that are there now.
struct Folder {
    path: PathBuf,
    _lock: File,
    made: u32,
    now: u32,
}

static FOLDER: Mutex<Option<Folder>> = Mutex::new(None);

/// A file name in this process's folder, which only its owner can enter; the file is deleted on drop.
#[derive(Debug)]
pub struct ScratchFile(PathBuf);

impl ScratchFile {
    /// A new name that ends with this one. Nothing is there yet.
    ///
    /// # Errors
    /// The folder cannot be made.
    pub fn new(name: &str) -> io::Result<Self> {
        let mut shared = FOLDER.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut folder = match shared.take() {
            Some(folder) => folder,
            None => {
                sweep(&std::env::temp_dir());
                own_folder()?
            }
        };
        (folder.made, folder.now) = (folder.made + 1, folder.now + 1);
        let file = Self(folder.path.join(format!("{}-{name}", folder.made)));
        *shared = Some(folder);
        Ok(file)
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for ScratchFile {
    fn drop(&mut self) {
        let mut shared = FOLDER.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        // It is not an error if the file was never made.
        fs::remove_file(&self.0).ok();
        if let Some(folder) = shared.as_mut() {
            folder.now -= 1;
            if folder.now == 0 {
                fs::remove_dir_all(&folder.path).ok();
                *shared = None;
            }
        }
    }
}

/// Makes and locks a folder of this process.
fn own_folder() -> io::Result<Folder> {
    for number in 0..NAMES {
        let path = std::env::temp_dir().join(format!("{PREFIX}{}-{number}", std::process::id()));
        match folder_for_owner(&path, false) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
            other => other?,
        }
        // The folder lets only its owner in.
        if let Ok(lock) = OpenOptions::new().write(true).create_new(true).open(path.join(LOCK))
            && lock.try_lock().is_ok()
        {
            return Ok(Folder { path, _lock: lock, made: 0, now: 0 });
        }
    }
    Err(io::Error::other(format!("no folder for temporary files in {}", std::env::temp_dir().display())))
}

/// Deletes this user's folders whose owners are dead.
fn sweep(temporary: &Path) {
    let Ok(entries) = fs::read_dir(temporary) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        let is_named = entry.file_name().to_str().is_some_and(|name| name.starts_with(PREFIX));
        let Ok(found) = fs::symlink_metadata(&path) else { continue };
        if !is_named || !found.is_dir() || !is_own(&found) {
            continue;
        }
        let is_dead = match File::open(path.join(LOCK)) {
            Ok(lock) => lock.try_lock().is_ok(),
            Err(_) => found.modified().ok().and_then(|time| time.elapsed().ok()).is_some_and(|age| age > YOUNG),
        };
        if is_dead {
            fs::remove_dir_all(&path).ok();
        }
    }
}

/// True if a file is this user's.
#[cfg(unix)]
fn is_own(found: &Metadata) -> bool {
    std::os::unix::fs::MetadataExt::uid(found) == rustix::process::geteuid().as_raw()
}

/// Windows has a folder for temporary files per user.
#[cfg(not(unix))]
const fn is_own(_: &Metadata) -> bool {
    true
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::{LOCK, PREFIX, ScratchFile, sweep};
    use std::fs::{self, File};

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
        let names = [format!("{PREFIX}1-0"), format!("{PREFIX}2-0"), format!("{PREFIX}3-0"), "newtau-other".to_owned()];
        let folders = names.map(|name| temporary.join(name));
        for folder in &folders {
            fs::create_dir_all(folder).unwrap();
            fs::write(folder.join("1-a.sock"), "x").unwrap();
        }
        let [dead, alive, beginning, other] = &folders;
        let locks = [dead, alive].map(|folder| File::create(folder.join(LOCK)).unwrap());
        locks[1].lock().unwrap();
        sweep(&temporary);
        assert_eq!([dead, alive, beginning, other].map(|folder| folder.exists()), [false, true, true, true]);
        drop(locks);
        sweep(&temporary);
        assert!(!alive.exists());
        fs::remove_dir_all(&temporary).unwrap();
    }
}
