//! Files by which other programs of the same user find the sessions that run on this computer.
//!
//! A session `PID` has two files in a folder that only the user can read: `PID.json`, and `PID.lock`, which is locked while the session runs. So a
//! program that was killed leaves no session behind.

use firmware_image::process::folder_for_owner;
use serde::{Deserialize, Serialize};
use std::fs::{self, File, TryLockError};
use std::io::{self, Write as _};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// Version of the file and of the lines of a connection.
const VERSION: u32 = 1;

/// A session that runs on this computer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SessionFile {
    /// Version of this file and of the lines of a connection.
    pub newtau: u32,
    /// Number of the process.
    pub pid: u32,
    /// Path of the scene.
    pub scene: String,
    /// The session's socket.
    pub address: SocketAddr,
    /// The token that a connection sends first.
    pub token: String,
}

impl SessionFile {
    /// The session of this process.
    #[must_use]
    pub fn of_this_process(scene: &Path, address: SocketAddr, token: String) -> Self {
        Self { newtau: VERSION, pid: std::process::id(), scene: scene.display().to_string(), address, token }
    }
}

/// The files of a session of this process. They are removed when this is dropped.
#[derive(Debug)]
pub struct Announced {
    file: PathBuf,
    lock: PathBuf,
    _locked: File,
}

/// Folders in which sessions of this user may be, this process's own first: a session and `newtau stop` may have been started with another environment.
#[must_use]
pub fn folders() -> Vec<PathBuf> {
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|path| path.is_absolute());
    let user = user();
    let mut all: Vec<PathBuf> = runtime.map(|path| path.join("newtau")).into_iter().collect();
    if cfg!(unix) && Path::new("/run/user").join(&user).is_dir() {
        all.push(Path::new("/run/user").join(&user).join("newtau"));
    }
    all.push(std::env::temp_dir().join(format!("newtau-{user}")));
    if cfg!(unix) {
        all.push(PathBuf::from(format!("/tmp/newtau-{user}")));
    }
    let mut unique = Vec::new();
    all.into_iter().for_each(|path| {
        if !unique.contains(&path) {
            unique.push(path)
        }
    });
    unique
}

/// Folder of the sessions of this process.
#[must_use]
pub fn folder() -> PathBuf {
    folders().swap_remove(0)
}

#[cfg(unix)]
fn user() -> String {
    rustix::process::geteuid().as_raw().to_string()
}

/// Other systems have a folder of temporary files for each user.
#[cfg(not(unix))]
fn user() -> String {
    "sessions".into()
}

/// Makes the folder, and checks that nobody else can read it.
fn private(folder: &Path) -> io::Result<()> {
    folder_for_owner(folder, true)?;
    is_private(folder)
}

/// Checks that the folder is this user's, and that nobody else can read it.
fn is_private(folder: &Path) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        let found = fs::symlink_metadata(folder)?;
        let own = found.is_dir() && found.uid() == rustix::process::geteuid().as_raw() && found.mode() & 0o077 == 0;
        if !own {
            let text = format!("{}: expected a folder of this user that nobody else can read", folder.display());
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, text));
        }
    }
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}

fn create(path: &Path) -> io::Result<File> {
    let mut options = fs::OpenOptions::new();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

impl Announced {
    /// Writes the files of a session.
    ///
    /// # Errors
    /// They cannot be written, or others could read them.
    pub fn new(session: &SessionFile, folder: &Path) -> io::Result<Self> {
        private(folder)?;
        let of = |end: &str| folder.join(format!("{}.{end}", session.pid));
        let (file, lock, partial) = (of("json"), of("lock"), of("partial"));
        // Locked before the session can be seen, and seen only when it is complete.
        let locked = create(&lock)?;
        locked.try_lock().map_err(io::Error::from)?;
        let mut written = create(&partial)?;
        serde_json::to_writer(&mut written, session)?;
        written.flush()?;
        fs::rename(&partial, &file)?;
        Ok(Self { file, lock, _locked: locked })
    }
}

impl Drop for Announced {
    fn drop(&mut self) {
        // Files that stay are recognised by their lock.
        fs::remove_file(&self.file).ok();
        fs::remove_file(&self.lock).ok();
    }
}

/// True if the session with this lock file runs.
fn runs(lock: &Path) -> io::Result<bool> {
    match File::open(lock) {
        // Shared, so that two programs that look do not take each other for a session.
        Ok(file) => match file.try_lock_shared() {
            Ok(()) => Ok(false),
            Err(TryLockError::WouldBlock) => Ok(true),
            Err(TryLockError::Error(error)) => Err(error),
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// The sessions that run, the lowest process number first, and the files that cannot be read, with the reason. Files of programs that were killed are
/// removed.
///
/// # Errors
/// The folder cannot be read.
pub fn running(folder: &Path) -> io::Result<(Vec<SessionFile>, Vec<String>)> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok((Vec::new(), Vec::new())),
        Err(error) => return Err(error),
    };
    // What another user has put there is no session of this one.
    is_private(folder)?;
    let (mut sessions, mut unread) = (Vec::new(), Vec::new());
    for entry in entries {
        let path = entry?.path();
        let is_number = path.file_stem().is_some_and(|stem| stem.to_string_lossy().parse::<u32>().is_ok());
        if !is_number || path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let lock = path.with_extension("lock");
        let read = runs(&lock).and_then(|runs| match runs {
            true => Ok(Some(serde_json::from_slice(&fs::read(&path)?)?)),
            false => Ok(None),
        });
        match read {
            Ok(Some(session)) => sessions.push(session),
            Ok(None) => {
                fs::remove_file(&path).ok();
                fs::remove_file(&lock).ok();
            }
            Err(error) => unread.push(format!("{}: {error}", path.display())),
        }
    }
    sessions.sort_by_key(|session: &SessionFile| session.pid);
    Ok((sessions, unread))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    use super::{Announced, SessionFile, running};
    use std::fs;
    use std::path::{Path, PathBuf};

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("newtau-test-{}-{name}", std::process::id()));
        fs::remove_dir_all(&folder).ok();
        folder
    }

    fn session(pid: u32) -> SessionFile {
        let address = ([127, 0, 0, 1], 4711).into();
        SessionFile { pid, ..SessionFile::of_this_process(Path::new("arm.toml"), address, "secret".into()) }
    }

    #[test]
    fn a_session_is_found_while_it_runs_and_files_of_a_killed_program_are_removed() {
        let folder = folder("found");
        assert_eq!(running(&folder).unwrap(), (vec![], vec![]), "no folder yet");
        let (second, first) =
            (Announced::new(&session(8), &folder).unwrap(), Announced::new(&session(7), &folder).unwrap());
        // The lock is bound to the open file, so another handle of the same process sees it too.
        assert_eq!(running(&folder).unwrap(), (vec![session(7), session(8)], vec![]));
        drop(second);
        assert_eq!(running(&folder).unwrap().0, [session(7)]);
        // As after `kill -9`: the files are there, the lock is not.
        let (json, lock) = (folder.join("9.json"), folder.join("9.lock"));
        fs::write(&json, serde_json::to_string(&session(9)).unwrap()).unwrap();
        fs::write(&lock, "").unwrap();
        assert_eq!(running(&folder).unwrap().0, [session(7)]);
        assert!(!json.exists() && !lock.exists());
        drop(first);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
        fs::remove_dir(&folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_others_can_read_is_refused_and_files_are_private() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = folder("private");
        let announced = Announced::new(&session(7), &folder).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!((mode(&folder), mode(&folder.join("7.json"))), (0o700, 0o600));
        drop(announced);
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
        let refused = Announced::new(&session(7), &folder).unwrap_err();
        assert!(refused.to_string().contains("nobody else can read"), "{refused}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
