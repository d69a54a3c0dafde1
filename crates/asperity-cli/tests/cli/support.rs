//! Runs of the real program, and access to its output.

use std::fs;
use std::path::{Path, PathBuf};
#[cfg(target_os = "linux")]
use std::process::Child;
use std::process::{Command, Output, Stdio};
#[cfg(target_os = "linux")]
use std::time::{Duration, Instant};

use asperity_formats::{Scan, write_npy};
use ndarray::Array2;
use serde_json::Value;
use tempfile::TempDir;

/// Name of the manifest in each folder that the program writes.
pub(crate) const MANIFEST: &str = ".asperity-manifest";

/// The paper's friction law; periods and displacements of its tests come from a high-precision solver.
pub(crate) const PAPER: &str = "--static-friction 0.1 --stribeck 4.2 --belt-velocity 0.003";

/// Exit code and output of a finished program.
#[derive(Debug)]
pub(crate) struct Finished {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Runs `asperity` with the given arguments in the folder `at`.
pub(crate) fn asperity_in<S: AsRef<str>>(at: &Path, arguments: &[S]) -> Finished {
    let output = Command::new(env!("CARGO_BIN_EXE_asperity"))
        .args(arguments.iter().map(AsRef::as_ref))
        .current_dir(at)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    output.into()
}

impl From<Output> for Finished {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// A running process; killed if the test fails.
#[cfg(target_os = "linux")]
pub(crate) struct Started(Option<Child>);

#[cfg(target_os = "linux")]
impl Started {
    fn id(&self) -> u32 {
        self.0.as_ref().unwrap().id()
    }
}

#[cfg(target_os = "linux")]
impl Drop for Started {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
        }
    }
}

/// Starts `asperity` and captures its output.
#[cfg(target_os = "linux")]
pub(crate) fn start_in(at: &Path, line: &str) -> Started {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asperity"));
    command.args(line.split_whitespace());
    start(at, command)
}

/// Starts a command and captures its output.
#[cfg(target_os = "linux")]
pub(crate) fn start(at: &Path, mut command: Command) -> Started {
    let child =
        command.current_dir(at).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    Started(Some(child))
}

/// Waits until `condition` holds.
#[cfg(target_os = "linux")]
pub(crate) fn wait_until(what: &str, condition: impl Fn() -> bool) {
    let began = Instant::now();
    while !condition() {
        assert!(began.elapsed() < Duration::from_secs(60), "{what} did not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sends a signal, such as `-TERM`.
#[cfg(target_os = "linux")]
pub(crate) fn send(signal: &str, started: &Started) {
    assert!(Command::new("kill").args([signal, &started.id().to_string()]).status().unwrap().success());
}

/// Waits until `asperity` exits.
#[cfg(target_os = "linux")]
pub(crate) fn wait_for(mut started: Started) -> Finished {
    started.0.take().unwrap().wait_with_output().unwrap().into()
}

/// Runs `asperity`, interrupts it, and measures the time until it exits.
#[cfg(target_os = "linux")]
pub(crate) fn run_and_interrupt(at: &Path, line: &str) -> (Finished, Duration) {
    run_and_signal(at, line, "-INT")
}

/// Runs `asperity`, sends it a signal, and measures the time until it exits.
#[cfg(target_os = "linux")]
pub(crate) fn run_and_signal(at: &Path, line: &str, signal: &str) -> (Finished, Duration) {
    const SIGINT_BIT: u64 = 1 << 1;
    let child = start_in(at, line);
    let listens = || {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        u64::from_str_radix(caught.trim(), 16).unwrap() & SIGINT_BIT != 0
    };
    wait_until("the handler of Ctrl-C", listens);
    // Time to read the input and to start.
    std::thread::sleep(Duration::from_millis(500));
    let asked = Instant::now();
    send(signal, &child);
    (wait_for(child), asked.elapsed())
}

/// Runs `asperity` with one line of arguments, separated by spaces.
pub(crate) fn asperity(line: &str) -> Finished {
    run_in(Path::new("."), line)
}

/// Runs `asperity` in the folder `at` with one line of arguments, separated by spaces.
pub(crate) fn run_in(at: &Path, line: &str) -> Finished {
    asperity_in(at, &line.split_whitespace().collect::<Vec<_>>())
}

impl Finished {
    /// Asserts the exit code and returns the JSON object on stdout.
    pub(crate) fn json(&self, code: i32) -> Value {
        assert_eq!(self.code, code, "{self:?}");
        let value: Value = serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"));
        assert!(value.is_object(), "{self:?}");
        value
    }

    /// Asserts the exit code, an empty stdout, no panic, and a message that contains all `words`.
    pub(crate) fn refuses(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, code, "{self:?}");
        assert!(self.stdout.is_empty(), "stdout must stay empty: {self:?}");
        for word in words {
            assert!(self.stderr.contains(word), "`{word}` is missing: {self:?}");
        }
        for word in ["panicked", "RUST_BACKTRACE", "internal error", "Err(", "Some("] {
            assert!(!self.stderr.contains(word), "`{word}` in the message: {self:?}");
        }
    }
}

/// Returns a number of a JSON object.
pub(crate) fn number(json: &Value, key: &str) -> f64 {
    json[key].as_f64().unwrap_or_else(|| panic!("`{key}` is no number in {json}"))
}

/// Returns the keys of a JSON object, in alphabetical order.
pub(crate) fn keys(json: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

/// Asserts that two numbers agree to a relative tolerance.
pub(crate) fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance * wanted.abs(), "{found} is not {wanted} within {tolerance}");
}

/// Writes heights in metre as an NPY file and returns its path.
pub(crate) fn npy(folder: &Path, name: &str, heights_m: Array2<f64>) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, write_npy(&Scan::new(heights_m, None))).unwrap();
    path
}

/// Returns the sorted names in a folder that the program wrote, without its manifest, which must exist.
pub(crate) fn written(folder: &Path) -> Vec<String> {
    let mut names = listing(folder);
    assert_eq!(names.remove(0), MANIFEST);
    names
}

/// Name of the folder of stored blocks beside runs.
pub(crate) const BLOCKS: &str = ".asperity-blocks";

/// Returns the sorted names in a folder, without that of stored blocks, which every run may leave.
pub(crate) fn listing(folder: &Path) -> Vec<String> {
    let mut names = whole_listing(folder);
    names.retain(|name| name != BLOCKS);
    names
}

/// Returns the sorted names in a folder.
pub(crate) fn whole_listing(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Returns a folder with a study as `study.toml`.
pub(crate) fn folder_with_study(text: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("study.toml"), text).unwrap();
    folder
}

/// Returns the JSON object in a file.
pub(crate) fn json_of(file: &Path) -> Value {
    serde_json::from_slice(&fs::read(file).unwrap()).unwrap()
}
