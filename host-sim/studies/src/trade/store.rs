//! Stored measurements: a file of JSON lines, one per measurement, so that interrupted work can be resumed.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sim::failure::{Failure, in_file};
use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write as _;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Measurements by key.
#[derive(Debug)]
pub(crate) struct Store {
    known: HashMap<String, serde_json::Value>,
    file: Mutex<File>,
}

#[derive(Serialize, Deserialize)]
struct Line {
    key: String,
    value: serde_json::Value,
}

impl Store {
    /// Opens or creates the file; `fresh` discards its contents. An incomplete last line is dropped.
    pub(crate) fn open(path: &Path, fresh: bool) -> Result<Self, Failure> {
        let text = if fresh { String::new() } else { fs::read_to_string(path).unwrap_or_default() };
        let lines = text.lines().filter_map(|line| serde_json::from_str::<Line>(line).ok());
        let known: HashMap<_, _> = lines.map(|line| (line.key, line.value)).collect();
        // Keep only whole lines, because the next line must not follow an incomplete one.
        let whole = known.iter().map(|(key, value)| as_line(key, value)).collect::<String>();
        fs::write(path, whole).map_err(|error| in_file(path, &error))?;
        let file = OpenOptions::new().append(true).open(path).map_err(|error| in_file(path, &error))?;
        Ok(Self { known, file: Mutex::new(file) })
    }

    /// The stored measurement for a key.
    pub(crate) fn get<T: DeserializeOwned>(&self, key: &str) -> Option<T> {
        serde_json::from_value(self.known.get(key)?.clone()).ok()
    }

    /// Stores a measurement immediately.
    pub(crate) fn put<T: Serialize>(&self, key: &str, value: &T) -> Result<(), Failure> {
        let value = serde_json::to_value(value).map_err(|error| Failure::Output(error.into()))?;
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(as_line(key, &value).as_bytes()).map_err(Failure::Output)
    }
}

fn as_line(key: &str, value: &serde_json::Value) -> String {
    serde_json::json!({ "key": key, "value": value }).to_string() + "\n"
}

/// Hash of this executable, so that a rebuilt program reuses no measurement of an older one.
pub(crate) fn of_this_program() -> u64 {
    let program = std::env::current_exe().and_then(fs::read).unwrap_or_default();
    digest(&program)
}

/// Hash of a value.
pub(crate) fn digest(of: &(impl Hash + ?Sized)) -> u64 {
    let mut hasher = DefaultHasher::new();
    of.hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::Store;

    #[test]
    fn what_was_measured_is_known_after_a_line_was_cut_short() {
        let path = std::env::temp_dir().join(format!("store-{}.jsonl", std::process::id()));
        let store = Store::open(&path, true).unwrap();
        store.put("a", &1.5).unwrap();
        store.put("b", &[1, 2]).unwrap();
        drop(store);
        let mut text = std::fs::read_to_string(&path).unwrap();
        text.push_str("{\"key\":\"c\",\"va");
        std::fs::write(&path, text).unwrap();
        let store = Store::open(&path, false).unwrap();
        assert_eq!((store.get::<f64>("a"), store.get::<Vec<i32>>("b")), (Some(1.5), Some(vec![1, 2])));
        assert_eq!(store.get::<f64>("c"), None);
        store.put("c", &3.0).unwrap();
        assert_eq!(Store::open(&path, false).unwrap().get::<f64>("c"), Some(3.0));
        assert_eq!(Store::open(&path, true).unwrap().get::<f64>("a"), None);
        std::fs::remove_file(&path).unwrap();
    }
}
