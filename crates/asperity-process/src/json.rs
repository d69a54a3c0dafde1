//! Fitted process as a JSON file.

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use thiserror::Error;

use super::{CorrelationShape, FittedCorrelation, FittedProcess, Origin, OriginKind, ProcessError};

/// Value of the field `format`.
const FORMAT: &str = "asperity friction process";
/// Version of the format; there are no earlier ones.
const VERSION: u64 = 1;

/// Error of reading a fitted process.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ProcessFileError {
    /// The text is not JSON.
    #[error("not JSON: {message}")]
    Syntax {
        /// Message of the parser, with line and column.
        message: String,
    },
    /// The JSON has another format.
    #[error("not a friction process: `format` is {found}, wanted \"{FORMAT}\"")]
    Format {
        /// Value of `format`.
        found: String,
    },
    /// The file has another version.
    #[error("friction process of version {found}; supported: version {VERSION}")]
    Version {
        /// Value of `version`.
        found: String,
    },
    /// A field is missing, unknown or has an invalid value.
    #[error("{}{message}", field.as_ref().map_or(String::new(), |field| format!("`{field}`: ")))]
    Field {
        /// Name of the field, or of the object in which one is missing; `None` for the whole file.
        field: Option<String>,
        /// What was found and what was expected.
        message: String,
    },
    /// The values are not a valid process.
    #[error(transparent)]
    Process(#[from] ProcessError),
}

/// Content of the file.
#[derive(Serialize)]
struct Document<'a> {
    format: &'a str,
    version: u64,
    #[serde(flatten)]
    process: &'a FittedProcess,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CorrelationDocument {
    model: CorrelationName,
    #[serde(skip_serializing_if = "Option::is_none")]
    nu: Option<f64>,
    length_m: f64,
    length_m_interval: Option<[f64; 2]>,
    window_m: Option<f64>,
    length_without_window_m: Option<f64>,
}

/// [`CorrelationShape`] without its parameters.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum CorrelationName {
    Exponential,
    SquaredExponential,
    Matern,
    WindowedExponential,
}

impl From<FittedCorrelation> for CorrelationDocument {
    fn from(correlation: FittedCorrelation) -> Self {
        let (model, nu) = match correlation.shape {
            CorrelationShape::Exponential => (CorrelationName::Exponential, None),
            CorrelationShape::SquaredExponential => (CorrelationName::SquaredExponential, None),
            CorrelationShape::Matern { nu } => (CorrelationName::Matern, Some(nu)),
            CorrelationShape::WindowedExponential { .. } => (CorrelationName::WindowedExponential, None),
        };
        Self {
            model,
            nu,
            length_m: correlation.length_m,
            length_m_interval: correlation.length_interval_m,
            window_m: correlation.window_m,
            length_without_window_m: correlation.length_without_window_m,
        }
    }
}

impl TryFrom<CorrelationDocument> for FittedCorrelation {
    type Error = String;

    fn try_from(document: CorrelationDocument) -> Result<Self, String> {
        let needed =
            |value: Option<f64>, name: &str| value.ok_or_else(|| format!("this model requires `correlation.{name}`"));
        let shape = match document.model {
            CorrelationName::Exponential => CorrelationShape::Exponential,
            CorrelationName::SquaredExponential => CorrelationShape::SquaredExponential,
            CorrelationName::Matern => CorrelationShape::Matern { nu: needed(document.nu, "nu")? },
            CorrelationName::WindowedExponential => {
                CorrelationShape::WindowedExponential { window: needed(document.window_m, "window_m")? }
            }
        };
        Ok(Self {
            shape,
            length_m: document.length_m,
            length_interval_m: document.length_m_interval,
            window_m: document.window_m,
            length_without_window_m: document.length_without_window_m,
        })
    }
}

impl FittedProcess {
    /// Returns indented JSON with a final newline, which reads back to the same bits.
    ///
    /// # Errors
    /// Fails like [`FittedProcess::check`].
    pub fn to_json(&self) -> Result<String, ProcessError> {
        self.check()?;
        let document = Document { format: FORMAT, version: VERSION, process: self };
        // The document contains numbers, names and texts only, which JSON can represent.
        let text = serde_json::to_string_pretty(&document).unwrap_or_default();
        Ok(text + "\n")
    }

    /// Reads a process from JSON, written by [`FittedProcess::to_json`] or by hand.
    ///
    /// # Errors
    /// Fails if the text is not JSON or has another format or version, if a field is missing, unknown or invalid (the
    /// error names it), or if the values are not a valid process.
    pub fn from_json(text: &str) -> Result<Self, ProcessFileError> {
        let mut value: Value =
            serde_json::from_str(text).map_err(|error| ProcessFileError::Syntax { message: error.to_string() })?;
        match value.get("format") {
            Some(Value::String(format)) if format == FORMAT => {}
            other => return Err(ProcessFileError::Format { found: shown(other) }),
        }
        match value.get("version") {
            Some(version) if version.as_u64() == Some(VERSION) => {}
            other => return Err(ProcessFileError::Version { found: shown(other) }),
        }
        // A list would pass for an object.
        for name in ["correlation", "origin"] {
            if let Some(found) = value.get(name).filter(|value| !value.is_object() && !value.is_null()) {
                let message = format!("found {}, expected an object or null", shown(Some(found)));
                return Err(ProcessFileError::Field { field: Some(name.into()), message });
            }
        }
        if let Some(object) = value.as_object_mut() {
            object.retain(|name, _| name != "format" && name != "version");
        }
        let process: Self = serde_path_to_error::deserialize(value).map_err(|error| {
            let field = error.path().iter().next().map(|_| error.path().to_string());
            ProcessFileError::Field { field, message: error.into_inner().to_string() }
        })?;
        process.check()?;
        Ok(process)
    }
}

/// Reads an origin; a process without one is stated by the user.
pub(super) fn origin<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Origin, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or_else(stated))
}

/// Returns the origin of a process that states none.
pub(super) fn stated() -> Origin {
    Origin { kind: OriginKind::Stated, description: String::new() }
}

/// Returns a value as a short text.
fn shown(value: Option<&Value>) -> String {
    const MOST: usize = 60;
    let Some(value) = value else { return "absent".into() };
    let text = value.to_string();
    if text.chars().count() <= MOST { text } else { text.chars().take(MOST).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::super::Generator;
    use super::super::fitted::tests::fitted;
    use super::*;
    use asperity_base::choice::Choice;
    use asperity_base::distribution::Marginal;

    const SHAPES: [CorrelationShape; 4] = [
        CorrelationShape::Exponential,
        CorrelationShape::SquaredExponential,
        CorrelationShape::Matern { nu: 1.7 },
        CorrelationShape::WindowedExponential { window: 75e-6 },
    ];

    #[test]
    fn a_process_reads_back_from_its_file_bit_by_bit() {
        for shape in SHAPES {
            let process = fitted(shape);
            let text = process.to_json().unwrap();
            assert_eq!(FittedProcess::from_json(&text).unwrap(), process);
            assert_eq!(FittedProcess::from_json(&text).unwrap().to_json().unwrap(), text);
        }
        for generator in
            [Generator::Autoregressive, Generator::Spectral { harmonics: 9 }, Generator::Jacobi, Generator::Renewal]
        {
            let made = FittedProcess { generator: Some(generator), ..fitted(SHAPES[0]) };
            let text = made.to_json().unwrap();
            assert!(text.contains(&format!("\"{}\"", generator.name())), "{text}");
            assert_eq!(FittedProcess::from_json(&text).unwrap(), made);
        }
        assert!(!fitted(SHAPES[0]).to_json().unwrap().contains("generator"));
        let steady = FittedProcess { std: 0.0, marginal: None, correlation: None, ..fitted(SHAPES[0]) };
        assert_eq!(FittedProcess::from_json(&steady.to_json().unwrap()).unwrap(), steady);
        let marginal = Marginal::empirical(vec![0.1, 0.2, 0.1 + 0.2]).unwrap();
        let measured = FittedProcess { marginal: Some(marginal), ..fitted(SHAPES[0]) };
        assert_eq!(FittedProcess::from_json(&measured.to_json().unwrap()).unwrap(), measured);
    }

    #[test]
    fn optional_fields_may_be_omitted() {
        let text = r#"{"format": "asperity friction process", "version": 1, "mean": 0.2, "std": 0.01,
            "marginal": {"normal": {"mean": 0.0, "std": 1.0}}, "correlation": {"model": "exponential", "length_m": 1e-4}}"#;
        let process = FittedProcess::from_json(text).unwrap();
        assert_eq!((process.mean_interval, process.origin.kind), (None, OriginKind::Stated));
    }

    #[test]
    fn errors_name_the_field_the_value_found_and_the_value_wanted() {
        let text = fitted(CorrelationShape::Matern { nu: 1.7 }).to_json().unwrap();
        for (from, to, words) in [
            ("\"version\": 1", "\"version\": 2", &["version 2", "version 1"][..]),
            ("\"version\": 1,", "", &["version absent"]),
            ("asperity friction process", "a letter", &["a letter", "asperity friction process"]),
            ("\"mean\": 0.21", "\"mean\": \"0.21\"", &["`mean`", "\"0.21\"", "expected f64"]),
            ("\"mean\": 0.21", "\"mean\": -0.21", &["mean", "-0.21", "positive"]),
            ("\"mean\": 0.21,", "", &["missing field `mean`"]),
            ("\"mean\": 0.21", "\"maen\": 0.21", &["`maen`", "expected one of", "`mean`"]),
            ("\"length_m\": ", "\"length_um\": ", &["`correlation.length_um`", "`length_m`"]),
            ("\"nu\": 1.7", "\"nu\": 0", &["smoothness", "(0, 100]"]),
            ("\"nu\": 1.7,", "", &["`correlation.nu`", "requires"]),
            ("\"matern\"", "\"matern52\"", &["`correlation.model`", "matern52", "windowed_exponential"]),
            ("\"record\"", "\"dream\"", &["`origin.kind`", "dream", "`record`"]),
            ("\"beta\"", "\"bета\"", &["`marginal", "`beta`"]),
            ("\"a\": 2.1", "\"a\": -2.1", &["beta: a is -2.1"]),
            ("\"std_interval\": null", "\"std_interval\": [1, 0]", &["std_interval", "the lower first"]),
            ("\"std_interval\": null", "\"std_interval\": [1]", &["`std_interval", "invalid length 1"]),
            ("\"std_interval\": null", "\"std_interval\": [1, 2, 3]", &["`std_interval", "invalid length 3"]),
            ("\"origin\": {", "\"origin\": [1], \"mean\": {", &["`origin`", "[1]", "an object"]),
            ("\"mean\": 0.21", "\"generator\": \"wiener\", \"mean\": 0.21", &["`generator`", "wiener", "renewal"]),
            ("\"mean\": 0.21", "\"generator\": \"jacobi\", \"mean\": 0.21", &["jacobi", "matern", "spectral"]),
            ("{", "", &["line 2", "not JSON"]),
        ] {
            assert!(text.contains(from), "{from} in {text}");
            let error = FittedProcess::from_json(&text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{from} → {to}: {error}");
        }
        for text in ["", "[]", "3", "{}", "null"] {
            assert!(FittedProcess::from_json(text).is_err(), "{text}");
        }
    }
}
