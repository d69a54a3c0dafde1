//! Output of commands: answers as JSON or tables on stdout, messages on stderr, atomic replacement of files.

use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use asperity::sentence;
use asperity::study::folder_of;
use asperity_formats::check_writable;
use console::{Style, StyledObject, Term, style};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use textwrap::{Options, WordSplitter};

use crate::failure::{Failure, Kind};

/// Key of the warnings in every JSON object.
const WARNINGS_KEY: &str = "warnings";

/// Writes one message to stderr. Ignores a closed stderr.
pub(crate) fn print_message(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", wrapped(&coloured(message, StyledObject::for_stderr), &Term::stderr()));
}

/// Colours the first word of an error or a warning, where the output takes colours.
fn coloured<'a>(message: &'a str, of_output: fn(StyledObject<&'a str>) -> StyledObject<&'a str>) -> Cow<'a, str> {
    let first = message.find(": ").map_or("", |end| &message[..=end]);
    let style = match first {
        "error:" | "internal error:" | "problem:" => Style::new().red().bold(),
        "warning:" => Style::new().yellow().bold(),
        _ => return message.into(),
    };
    format!("{}{}", of_output(style.apply_to(first)), &message[first.len()..]).into()
}

/// Returns a sentence with the part that is the answer in bold type, where stdout takes it.
pub(crate) fn with_bold(sentence: &str, answer: &str) -> String {
    sentence.replacen(answer, &style(answer).bold().to_string(), 1)
}

/// Prints sentences to stdout, each on lines of its own.
pub(crate) fn print_sentences(sentences: &[String]) -> Result<(), Failure> {
    let lines = sentences.iter().map(|sentence| wrapped(&coloured(sentence, |text| text), &Term::stdout()) + "\n");
    print(&lines.collect::<String>())
}

/// Returns a text in lines that fit a terminal; unchanged elsewhere.
fn wrapped(text: &str, terminal: &Term) -> String {
    match terminal.size_checked().filter(|_| terminal.is_term()) {
        // Paths and flags stay whole, so that they can be copied.
        Some((_, columns)) => {
            let options = Options::new(usize::from(columns)).break_words(false);
            textwrap::fill(text, options.word_splitter(WordSplitter::NoHyphenation))
        }
        None => text.to_owned(),
    }
}

/// Warnings of the command, for the JSON object that it prints.
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Records a warning for the JSON object that the command prints.
pub(crate) fn record_warning(message: &str) {
    WARNINGS.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_owned());
}

/// Returns the warnings of the command so far.
pub(crate) fn warnings() -> Vec<String> {
    WARNINGS.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Results in the order of display. Keys end with their SI unit; an undefined number is null.
#[derive(Debug, Clone, Default)]
pub(crate) struct Answer(Vec<(String, Value)>);

impl Answer {
    /// Adds one result.
    pub(crate) fn with(mut self, key: &str, value: impl Into<Value>) -> Self {
        self.0.push((key.to_owned(), value.into()));
        self
    }

    /// Returns the fields of a library result, in their order.
    pub(crate) fn new(result: &impl Serialize) -> Result<Self, Failure> {
        let text = serde_json::to_string(result);
        text.and_then(|text| serde_json::from_str(&text)).map_err(|e| Failure::new(Kind::Runtime, e.to_string()))
    }

    /// Adds the results of another answer.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.0.extend(other.0);
        self
    }

    /// Returns the answer without the result `key`.
    pub(crate) fn without(mut self, key: &str) -> Self {
        self.0.retain(|(own, _)| own != key);
        self
    }

    /// Replaces the undefined results among `keys` by the reason, for a table.
    pub(crate) fn with_reason(mut self, keys: &[&str], reason: &str) -> Self {
        let undefined = self.0.iter_mut().filter(|(key, value)| value.is_null() && keys.contains(&key.as_str()));
        undefined.for_each(|(_, value)| *value = reason.into());
        self
    }

    /// Merges answers with the same keys: each key gets the list of its values.
    pub(crate) fn lists(answers: &[Self]) -> Self {
        let keys = answers.first().map_or(&[][..], |first| &first.0);
        let values = |place: usize| answers.iter().map(|answer| answer.0[place].1.clone()).collect::<Vec<Value>>();
        Self(keys.iter().enumerate().map(|(place, (key, _))| (key.clone(), values(place).into())).collect())
    }

    /// Returns the answer with its own warnings and the `recorded` ones as the last result. Drops a recorded warning
    /// that repeats an own one after the name of a file.
    fn with_warnings(&self, recorded: &[String]) -> Self {
        let own = self.0.iter().find(|(key, _)| key == WARNINGS_KEY).and_then(|(_, value)| value.as_array());
        let mut warnings: Vec<Value> = own.cloned().unwrap_or_default();
        let is_new = |warning: &&String| {
            let repeats = |own: &Value| own.as_str().is_some_and(|own| warning.ends_with(own));
            !own.is_some_and(|own| own.iter().any(repeats))
        };
        warnings.extend(recorded.iter().filter(is_new).map(|warning| Value::from(warning.as_str())));
        self.clone().without(WARNINGS_KEY).with(WARNINGS_KEY, warnings)
    }

    /// Returns the answer with the warnings of the command so far, as printed in JSON.
    pub(crate) fn as_object(&self) -> Self {
        self.with_warnings(&warnings())
    }

    /// Returns the keys and values, without the warnings of the command.
    pub(crate) fn entries(&self) -> &[(String, Value)] {
        &self.0
    }

    /// Prints the answer to stdout: one JSON object with the warnings of the command, or an aligned table with units.
    pub(crate) fn print(&self, json: bool) -> Result<(), Failure> {
        let text = if json {
            let object =
                serde_json::to_string(&self.as_object()).map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
            format!("{object}\n")
        } else {
            self.table()
        };
        print(&text)
    }

    /// Formats the answer as a table; a line shows a result with its interval.
    fn table(&self) -> String {
        let of = |key: &str| self.0.iter().find(|(own, _)| own == key).map(|(_, value)| value);
        let companion = |key: &str| {
            let endings = ["_interval", "_se", "_within_std", "_between_std"];
            let owner = endings.iter().find_map(|ending| key.strip_suffix(ending));
            owner.is_some_and(|owner| of(owner).is_some() && of(&format!("{owner}_interval")).is_some())
        };
        let rows: Vec<(String, String)> = self
            .0
            .iter()
            .filter(|(key, _)| !companion(key))
            .map(|(key, value)| {
                let (label, text) = row(key, value);
                let Some(Value::Array(ends)) = of(&format!("{key}_interval")) else { return (label, text) };
                let ends: Vec<String> = ends.iter().map(|end| row(key, end).1).collect();
                let spread = |ending: &str| of(&format!("{key}_{ending}_std")).filter(|value| !value.is_null());
                let spread = match (spread("within"), spread("between")) {
                    (Some(within), Some(between)) => {
                        format!("; ± {} within a scan, ± {} between scans", row(key, within).1, row(key, between).1)
                    }
                    _ => String::new(),
                };
                (label, format!("{text}  (95 %: {}{spread})", ends.join(" to ")))
            })
            .collect();
        let width = rows.iter().map(|(label, _)| label.chars().count()).max().unwrap_or(0);
        rows.iter().fold(String::new(), |mut text, (label, value)| {
            let _ = writeln!(text, "{label:width$}  {value}");
            text
        })
    }
}

impl Failure {
    /// Prints `answer` with `converged: false` if the computation did not converge, and returns the failure.
    pub(crate) fn print(self, answer: Answer, json: bool) -> Result<Self, Self> {
        if self.kind() == Kind::NotConverged {
            answer.with("converged", false).print(json)?;
        }
        Ok(self)
    }
}

impl Serialize for Answer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(key, value)| (key, value)))
    }
}

impl<'de> Deserialize<'de> for Answer {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        /// Visitor that keeps the order of the keys.
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Answer;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Answer, A::Error> {
                let mut answer = Answer::default();
                while let Some(entry) = map.next_entry()? {
                    answer.0.push(entry);
                }
                Ok(answer)
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

/// Writes text to stdout. A closed stdout (`| head`) is no error.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Failure::io(Kind::Runtime, "stdout", &e)),
        _ => Ok(()),
    }
}

/// Formats rows of text in aligned columns, one line each.
pub(crate) fn columns<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..N).map(width).collect();
    rows.iter().fold(String::new(), |mut text, row| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}"));
        let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join("  ").trim_end());
        text
    })
}

/// Units by the ending of a key, longest first, and whether they take prefixes (µm, MPa).
const UNITS: &[(&str, &str, bool)] = &[
    ("_rad_per_m", "rad/m", false),
    ("_m_per_pa", "m/Pa", false),
    ("_pa_per_m", "Pa/m", true),
    ("_n_per_m", "N/m", true),
    ("_s_per_m", "s/m", false),
    ("_rad", "rad", false),
    ("_pa", "Pa", true),
    ("_m2", "m²", false),
    ("_m", "m", true),
    ("_n", "N", true),
    ("_j", "J", true),
];

/// Labels of results whose key alone is ambiguous.
const LABELS: &[(&str, &str)] = &[
    ("correlation_length_x_m", "correlation length x (1/e)"),
    ("correlation_length_y_m", "correlation length y (1/e)"),
    ("covariance_length_x_m", "covariance length x (of the model)"),
    ("covariance_length_y_m", "covariance length y (of the model)"),
    ("covariance_decay_length_x_m", "covariance length x (1/e)"),
    ("covariance_decay_length_y_m", "covariance length y (1/e)"),
    ("largest_cluster_fraction", "largest cluster (of the contact)"),
    ("contact_stiffness_pa_per_m", "contact stiffness over area"),
    ("persson_contact_fraction", "contact fraction (Persson)"),
    ("persson_plastic_fraction", "plastic fraction (Persson)"),
    ("bgt_contact_fraction", "contact fraction (Bush, Gibson, Thomas)"),
];

/// Returns name and value of a result for a table.
pub(crate) fn row(key: &str, value: &Value) -> (String, String) {
    let (name, unit, prefixed) = UNITS
        .iter()
        .find_map(|(ending, unit, prefixed)| Some((key.strip_suffix(ending)?, *unit, *prefixed)))
        .unwrap_or((key, "", false));
    let label = LABELS.iter().find(|(own, _)| *own == key).map(|(_, label)| (*label).to_owned());
    (label.unwrap_or_else(|| name.replace('_', " ")), shown(value, unit, prefixed))
}

/// Significant digits of a number in a table.
const DIGITS: i32 = 6;

fn shown(value: &Value, unit: &str, prefixed: bool) -> String {
    match value {
        Value::Null => "undefined".to_owned(),
        Value::Bool(true) => "yes".to_owned(),
        Value::Bool(false) => "no".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => {
            let x = number.as_f64().unwrap_or(f64::NAN);
            let (scaled, prefix) = if prefixed { sentence::prefixed(x, DIGITS) } else { (x, "") };
            let separator = if unit.is_empty() { "" } else { " " };
            format!("{}{separator}{prefix}{unit}", sentence::significant(scaled, DIGITS))
        }
        Value::Number(number) => format!("{number} {unit}").trim_end().to_owned(),
        // A list takes one line per element; the elements of a nested list are columns.
        Value::Array(items) => items.iter().fold(format!("{} values", items.len()), |text, item| match item {
            Value::Array(parts) => {
                let columns: Vec<String> = parts.iter().map(|part| format!("{:>12}", shown(part, "", false))).collect();
                format!("{text}\n  {}", columns.join(" "))
            }
            item => format!("{text}\n  {:>12}", shown(item, unit, prefixed)),
        }),
        Value::Object(_) => value.to_string(),
    }
}

/// Fails if a file cannot be written or is one of the `inputs`. Commands call it before they compute. `argument` names
/// the flag.
pub(crate) fn check_target(argument: &str, path: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    let refuse = |reason: &str| Err(Failure::usage(format!("{argument} {}: {reason}", path.display())));
    if path.is_dir() {
        return refuse("this is a folder; give a file");
    }
    if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return refuse("this is no regular file; give a regular file");
    }
    if path.file_name().is_none() {
        return refuse("this names no file; give a file name");
    }
    if !folder_of(path).is_dir() {
        return refuse(&format!("the folder {} does not exist", folder_of(path).display()));
    }
    if let Ok(target) = path.canonicalize()
        && inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == target))
    {
        return refuse("this file is an input and would be overwritten; choose another");
    }
    check_writable(folder_of(path)).map_err(|e| write_failure(path, &e))
}

/// Returns the verb for the message about a file, "replaced" or "wrote". Call it before writing.
pub(crate) fn write_verb(path: &Path) -> &'static str {
    if path.exists() { "replaced" } else { "wrote" }
}

/// Replaces a file atomically: a reader sees the old or the new content, never a mixture.
pub(crate) fn replace_file(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Failure> {
    asperity_formats::replace_file(path, write).map_err(|e| write_failure(path, &e))
}

/// Returns the error of a file or folder that could not be written.
pub(crate) fn write_failure(path: &Path, error: &io::Error) -> Failure {
    let what = format!("cannot write {}", path.display());
    if error.kind() == io::ErrorKind::NotFound && folder_of(path).is_dir() {
        // `/proc` returns this error.
        return Failure::new(Kind::Resources, format!("{what}: nothing can be created in this folder"));
    }
    Failure::io(Kind::Runtime, what, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_undefined_number_is_null_in_json_and_undefined_in_the_table() {
        let answer = Answer::default().with("period", f64::NAN).with("limit_cycle", false);
        assert_eq!(serde_json::to_string(&answer).unwrap(), r#"{"period":null,"limit_cycle":false}"#);
        assert_eq!(answer.table(), "period       undefined\nlimit cycle  no\n");
    }

    #[test]
    fn keys_keep_their_order_and_numbers_their_bits() {
        let answer = Answer::default().with("b", 0.1 + 0.2).with("a", 6.372_163_483_739_709);
        assert_eq!(serde_json::to_string(&answer).unwrap(), r#"{"b":0.30000000000000004,"a":6.372163483739709}"#);
    }

    #[test]
    fn a_json_object_ends_with_its_warnings_each_once() {
        let recorded = ["a.npy: one".to_owned(), "two".to_owned(), "three".to_owned()];
        let json = |answer: Answer| serde_json::to_string(&answer.with_warnings(&recorded)).unwrap();
        assert_eq!(json(Answer::default().with("a", 1)), r#"{"a":1,"warnings":["a.npy: one","two","three"]}"#);
        let own = Answer::default().with("warnings", vec!["one", "two"]).with("a", 1);
        assert_eq!(json(own), r#"{"a":1,"warnings":["one","two","three"]}"#);
        let none = Answer::default().with_warnings(&[]);
        assert_eq!(serde_json::to_string(&none).unwrap(), r#"{"warnings":[]}"#);
    }

    #[test]
    fn the_table_shows_units_with_prefixes() {
        let show = |key, x: f64| row(key, &Value::from(x));
        assert_eq!(show("Sq_m", 1.25e-6), ("Sq".into(), "1.25 µm".into()));
        assert_eq!(show("mean_pressure_pa", 20e6), ("mean pressure".into(), "20 MPa".into()));
        assert_eq!(show("load_n", -2500.0), ("load".into(), "-2.5 kN".into()));
        assert_eq!(show("mean_compliance_m_per_pa", 5e-15), ("mean compliance".into(), "5.00000e-15 m/Pa".into()));
        assert_eq!(show("contact_stiffness_n_per_m", 2e7), ("contact stiffness".into(), "20 MN/m".into()));
        assert_eq!(show("elastic_energy_j", 3e-6), ("elastic energy".into(), "3 µJ".into()));
        assert_eq!(show("gap_m", 0.0), ("gap".into(), "0 m".into()));
        assert_eq!(show("Ssk", -1.0 / 3.0), ("Ssk".into(), "-0.333333".into()));
        assert_eq!(row("nx", &Value::from(128)), ("nx".into(), "128".into()));
        assert_eq!(show("correlation_length_x_m", 2e-5), ("correlation length x (1/e)".into(), "20 µm".into()));
        assert_eq!(show("friction_correlation_length_m", 2e-5).0, "friction correlation length");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_or_a_socket_is_no_target() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for path in [Path::new("/dev/null"), &socket, folder.path()] {
            assert_eq!(check_target("--out", path, &[]).unwrap_err().kind(), Kind::Usage, "{}", path.display());
        }
        let file = folder.path().join("file");
        check_target("--out", &file, &[&file]).unwrap();
        assert_eq!(write_verb(&file), "wrote");
        fs::write(&file, "old").unwrap();
        check_target("--out", &file, &[]).unwrap();
        assert_eq!(write_verb(&file), "replaced");
        let refused = check_target("--out", &file, &[folder.path(), &file]).unwrap_err();
        assert!(refused.message().contains("is an input"), "{refused}");
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.npz");
        replace_file(&path, |file| file.write_all(b"old")).unwrap();
        let failed = replace_file(&path, |file| {
            file.write_all(b"half of the n")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), Kind::Resources);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
