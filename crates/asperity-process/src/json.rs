//! Fitted process as a JSON file.

use serde::Serialize;
use serde_json::{Map, Value};
use thiserror::Error;

use super::{CorrelationShape, FittedCorrelation, FittedProcess, Generator, Origin, OriginKind, ProcessError};
use asperity_base::distribution::Marginal;

/// Value of the field `format`.
const FORMAT: &str = "asperity friction process";
/// Version of the format; there are no earlier ones.
const VERSION: u64 = 1;

/// Error of reading a fitted process.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ProcessFileError {
    /// The text is not JSON.
    #[error("line {line}, column {column}: not JSON: {message}")]
    Syntax {
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
        /// Message of the parser.
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
    /// A required field is missing.
    #[error("`{field}` is missing; wanted {wanted}")]
    Missing {
        /// Name of the field.
        field: String,
        /// Expected value.
        wanted: &'static str,
    },
    /// A field is unknown.
    #[error("`{field}` is not a field of a friction process; known fields: {known}")]
    Unknown {
        /// Name of the field.
        field: String,
        /// Known fields of the object.
        known: String,
    },
    /// A field has an invalid value.
    #[error("`{field}` is {found}; wanted {wanted}")]
    Value {
        /// Name of the field.
        field: String,
        /// Value found.
        found: String,
        /// Expected value.
        wanted: &'static str,
    },
    /// The values are not a valid process.
    #[error(transparent)]
    Process(#[from] ProcessError),
}

/// Content of the file, in the order of writing.
#[derive(Serialize)]
struct Document<'a> {
    format: &'static str,
    version: u64,
    mean: f64,
    mean_interval: Option<[f64; 2]>,
    std: f64,
    std_interval: Option<[f64; 2]>,
    marginal: Option<&'a Marginal>,
    correlation: Option<CorrelationDocument>,
    #[serde(skip_serializing_if = "Option::is_none")]
    generator: Option<Generator>,
    stribeck_s_per_m: Option<f64>,
    averaged_over_m: Option<[f64; 2]>,
    mean_pressure_pa: Option<f64>,
    origin: OriginDocument<'a>,
}

#[derive(Serialize)]
struct CorrelationDocument {
    model: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    nu: Option<f64>,
    length_m: f64,
    length_m_interval: Option<[f64; 2]>,
    window_m: Option<f64>,
    length_without_window_m: Option<f64>,
}

#[derive(Serialize)]
struct OriginDocument<'a> {
    kind: &'static str,
    description: &'a str,
}

impl FittedProcess {
    /// Returns indented JSON with a final newline, which reads back to the same bits.
    ///
    /// # Errors
    /// Fails like [`FittedProcess::check`].
    pub fn to_json(&self) -> Result<String, ProcessError> {
        self.check()?;
        let correlation = self.correlation.as_ref().map(|correlation| CorrelationDocument {
            model: correlation.shape.name(),
            nu: match correlation.shape {
                CorrelationShape::Matern { nu } => Some(nu),
                _ => None,
            },
            length_m: correlation.length_m,
            length_m_interval: correlation.length_interval_m,
            window_m: correlation.window_m,
            length_without_window_m: correlation.length_without_window_m,
        });
        let document = Document {
            format: FORMAT,
            version: VERSION,
            mean: self.mean,
            mean_interval: self.mean_interval,
            std: self.std,
            std_interval: self.std_interval,
            marginal: self.marginal.as_ref(),
            correlation,
            generator: self.generator,
            stribeck_s_per_m: self.stribeck_s_per_m,
            averaged_over_m: self.averaged_over_m,
            mean_pressure_pa: self.mean_pressure_pa,
            origin: OriginDocument { kind: self.origin.kind.name(), description: &self.origin.description },
        };
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
        let value: Value = serde_json::from_str(text).map_err(|error| {
            let message = error.to_string();
            let message = message.split(" at line ").next().unwrap_or_default().to_owned();
            ProcessFileError::Syntax { line: error.line(), column: error.column(), message }
        })?;
        let fields = Fields { place: "", fields: value.as_object() };
        match fields.get("format") {
            Some(Value::String(format)) if format == FORMAT => {}
            other => return Err(ProcessFileError::Format { found: shown(other) }),
        }
        match fields.get("version") {
            Some(version) if version.as_u64() == Some(VERSION) => {}
            other => return Err(ProcessFileError::Version { found: shown(other) }),
        }
        fields.only(&[
            "format",
            "version",
            "mean",
            "mean_interval",
            "std",
            "std_interval",
            "marginal",
            "correlation",
            "generator",
            "stribeck_s_per_m",
            "averaged_over_m",
            "mean_pressure_pa",
            "origin",
        ])?;
        let marginal = match fields.get("marginal") {
            None | Some(Value::Null) => None,
            Some(marginal) => Some(serde_json::from_value::<Marginal>(marginal.clone()).map_err(|error| {
                ProcessFileError::Value { field: "marginal".into(), found: error.to_string(), wanted: DISTRIBUTION }
            })?),
        };
        let generator = fields
            .present("generator")
            .map(|value| {
                let wanted = GENERATOR;
                serde_json::from_value(value.clone()).map_err(|_| fields.wrong("generator", shown(Some(value)), wanted))
            })
            .transpose()?;
        let process = Self {
            mean: fields.number("mean")?,
            mean_interval: fields.optional_pair("mean_interval")?,
            std: fields.number("std")?,
            std_interval: fields.optional_pair("std_interval")?,
            marginal,
            correlation: fields.object("correlation")?.map(|fields| correlation(&fields)).transpose()?,
            generator,
            stribeck_s_per_m: fields.optional_number("stribeck_s_per_m")?,
            averaged_over_m: fields.optional_pair("averaged_over_m")?,
            mean_pressure_pa: fields.optional_number("mean_pressure_pa")?,
            origin: match fields.object("origin")? {
                Some(fields) => origin(&fields)?,
                None => Origin { kind: OriginKind::Stated, description: String::new() },
            },
        };
        process.check()?;
        Ok(process)
    }
}

const DISTRIBUTION: &str =
    "a distribution with its parameters, such as {\"beta\": {\"a\": 2.1, \"b\": 5.0, \"low\": 0.1, \"high\": 0.3}}";

const GENERATOR: &str = "\"autoregressive\", {\"spectral\": {\"harmonics\": 256}}, \"jacobi\", \"renewal\" or null";

fn correlation(fields: &Fields<'_>) -> Result<FittedCorrelation, ProcessFileError> {
    fields.only(&["model", "nu", "length_m", "length_m_interval", "window_m", "length_without_window_m"])?;
    let window_m = fields.optional_number("window_m")?;
    let wanted = "exponential, squared_exponential, matern or windowed_exponential";
    let shape = match fields.text("model", wanted)? {
        "exponential" => CorrelationShape::Exponential,
        "squared_exponential" => CorrelationShape::SquaredExponential,
        "matern" => CorrelationShape::Matern { nu: fields.number("nu")? },
        "windowed_exponential" => CorrelationShape::WindowedExponential { window: fields.number("window_m")? },
        other => return Err(fields.wrong("model", format!("\"{other}\""), wanted)),
    };
    Ok(FittedCorrelation {
        shape,
        length_m: fields.number("length_m")?,
        length_interval_m: fields.optional_pair("length_m_interval")?,
        window_m,
        length_without_window_m: fields.optional_number("length_without_window_m")?,
    })
}

fn origin(fields: &Fields<'_>) -> Result<Origin, ProcessFileError> {
    fields.only(&["kind", "description"])?;
    let wanted = "study, record or stated";
    let name = fields.text("kind", wanted)?;
    let kind = name.parse::<OriginKind>().ok();
    Ok(Origin {
        kind: kind.ok_or_else(|| fields.wrong("kind", format!("\"{name}\""), wanted))?,
        description: fields.text("description", "a text")?.to_owned(),
    })
}

/// Fields of one object, with its place in the file for messages.
struct Fields<'a> {
    place: &'static str,
    fields: Option<&'a Map<String, Value>>,
}

impl<'a> Fields<'a> {
    fn get(&self, field: &str) -> Option<&'a Value> {
        self.fields.and_then(|fields| fields.get(field))
    }

    fn name(&self, field: &str) -> String {
        if self.place.is_empty() { field.to_owned() } else { format!("{}.{field}", self.place) }
    }

    fn wrong(&self, field: &str, found: String, wanted: &'static str) -> ProcessFileError {
        ProcessFileError::Value { field: self.name(field), found, wanted }
    }

    fn only(&self, known: &[&str]) -> Result<(), ProcessFileError> {
        let unknown = self.fields.into_iter().flat_map(Map::keys).find(|field| !known.contains(&field.as_str()));
        unknown
            .map_or(Ok(()), |field| Err(ProcessFileError::Unknown { field: self.name(field), known: known.join(", ") }))
    }

    /// Returns the value of a required field.
    fn required(&self, field: &str, wanted: &'static str) -> Result<&'a Value, ProcessFileError> {
        self.get(field).ok_or_else(|| ProcessFileError::Missing { field: self.name(field), wanted })
    }

    fn number(&self, field: &str) -> Result<f64, ProcessFileError> {
        let value = self.required(field, "a number")?;
        value.as_f64().ok_or_else(|| self.wrong(field, shown(Some(value)), "a number"))
    }

    fn text(&self, field: &str, wanted: &'static str) -> Result<&'a str, ProcessFileError> {
        let value = self.required(field, wanted)?;
        value.as_str().ok_or_else(|| self.wrong(field, shown(Some(value)), wanted))
    }

    fn present(&self, field: &str) -> Option<&'a Value> {
        self.get(field).filter(|value| !value.is_null())
    }

    fn optional_number(&self, field: &str) -> Result<Option<f64>, ProcessFileError> {
        self.present(field).map(|_| self.number(field)).transpose()
    }

    fn optional_pair(&self, field: &str) -> Result<Option<[f64; 2]>, ProcessFileError> {
        let Some(value) = self.present(field) else { return Ok(None) };
        let ends: Option<Vec<f64>> = value.as_array().and_then(|ends| ends.iter().map(Value::as_f64).collect());
        match ends.as_deref() {
            Some(&[low, high]) => Ok(Some([low, high])),
            _ => Err(self.wrong(field, shown(Some(value)), "two numbers or null")),
        }
    }

    fn object(&self, field: &'static str) -> Result<Option<Self>, ProcessFileError> {
        let Some(value) = self.present(field) else { return Ok(None) };
        let fields = value.as_object();
        if fields.is_none() {
            return Err(self.wrong(field, shown(Some(value)), "an object or null"));
        }
        Ok(Some(Self { place: field, fields }))
    }
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
    use super::super::fitted::tests::fitted;
    use super::*;
    use asperity_base::choice::Choice;

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
            ("\"mean\": 0.21", "\"mean\": \"0.21\"", &["`mean`", "\"0.21\"", "a number"]),
            ("\"mean\": 0.21", "\"mean\": -0.21", &["mean", "-0.21", "positive"]),
            ("\"mean\": 0.21,", "", &["`mean` is missing"]),
            ("\"mean\": 0.21", "\"maen\": 0.21", &["`maen`", "known fields", "mean"]),
            ("\"length_m\": ", "\"length_um\": ", &["`correlation.length_um`", "length_m"]),
            ("\"nu\": 1.7", "\"nu\": 0", &["smoothness", "(0, 100]"]),
            ("\"nu\": 1.7,", "", &["`correlation.nu` is missing"]),
            ("\"matern\"", "\"matern52\"", &["`correlation.model`", "matern52", "windowed_exponential"]),
            ("\"record\"", "\"dream\"", &["`origin.kind`", "dream", "study, record or stated"]),
            ("\"beta\"", "\"bета\"", &["`marginal`", "beta"]),
            ("\"a\": 2.1", "\"a\": -2.1", &["beta: a is -2.1"]),
            ("\"std_interval\": null", "\"std_interval\": [1, 0]", &["std_interval", "the lower first"]),
            ("\"std_interval\": null", "\"std_interval\": [1]", &["`std_interval`", "two numbers or null"]),
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
