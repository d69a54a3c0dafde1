//! Expansions as JSON: everything that is needed to evaluate them, in full precision.
//!
//! ```json
//! {"format": "asperity polynomial chaos expansion", "version": 1, "families": ["hermite", "legendre"],
//!  "terms": [[], [[0, 1]], [[0, 2], [1, 1]]], "coefficients": [2.0, 1.0, 0.5]}
//! ```
//!
//! There is one family for each variable. A term is the list of its variables (the first is 0) with their degrees.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{Basis, BasisError, Expansion, Factor, Family, MultiIndexError, MultiIndexSet};

const FORMAT: &str = "asperity polynomial chaos expansion";
const VERSION: u64 = 1;

/// Why an expansion could not be read or written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ExpansionFileError {
    /// This is no JSON, or fields are missing, unknown or of another type.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// The file holds something else.
    #[error("the format is {found:?}; an expansion has {FORMAT:?}")]
    Format {
        /// The format named.
        found: String,
    },
    /// The file is of another version.
    #[error("version {found} of the format of expansions; this program reads version {VERSION}")]
    Version {
        /// The version named.
        found: u64,
    },
    /// A family is unknown.
    #[error("variable {variable} has polynomials {name:?}; known are \"hermite\" and \"legendre\"")]
    Family {
        /// Index of the variable.
        variable: usize,
        /// The name found.
        name: String,
    },
    /// The terms are no set of multi-indices.
    #[error(transparent)]
    Terms(#[from] MultiIndexError),
    /// Families and variables differ in number.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// Coefficients and terms differ in number.
    #[error("{coefficients} coefficients for {terms} terms")]
    Coefficients {
        /// Coefficients found.
        coefficients: usize,
        /// Terms found.
        terms: usize,
    },
    /// A coefficient is not finite, which JSON has no number for.
    #[error("the coefficient of term {term} is {coefficient}, not a finite number")]
    NotFinite {
        /// Position of the term.
        term: usize,
        /// Its coefficient.
        coefficient: f64,
    },
}

impl From<serde_json::Error> for ExpansionFileError {
    fn from(error: serde_json::Error) -> Self {
        let full = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let message = full.strip_suffix(&place).unwrap_or(&full).to_owned();
        Self::Syntax { line: error.line(), column: error.column(), message }
    }
}

/// What says how to read the rest.
#[derive(Deserialize)]
struct Heading {
    format: String,
    version: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    format: String,
    version: u64,
    families: Vec<String>,
    terms: Vec<Vec<(u32, u16)>>,
    coefficients: Vec<f64>,
}

impl Expansion {
    /// The expansion as JSON; [`Expansion::from_json`] gives back equal bits.
    ///
    /// # Errors
    /// A coefficient that is not finite.
    pub fn to_json(&self) -> Result<String, ExpansionFileError> {
        if let Some(term) = self.coefficients().iter().position(|c| !c.is_finite()) {
            return Err(ExpansionFileError::NotFinite { term, coefficient: self.coefficients()[term] });
        }
        let sparse = |factors: &[Factor]| factors.iter().map(|factor| (factor.variable, factor.degree)).collect();
        let content = Content {
            format: FORMAT.to_owned(),
            version: VERSION,
            families: self.basis().families().iter().map(|family| family.name().to_owned()).collect(),
            terms: self.basis().set().iter().map(sparse).collect(),
            coefficients: self.coefficients().to_vec(),
        };
        Ok(serde_json::to_string(&content)?)
    }

    /// The expansion that [`Expansion::to_json`] wrote.
    ///
    /// # Errors
    /// Another format or version, anything unknown or missing, and contents that contradict each other.
    pub fn from_json(text: &str) -> Result<Self, ExpansionFileError> {
        let Heading { format, version } = serde_json::from_str(text)?;
        if format != FORMAT {
            return Err(ExpansionFileError::Format { found: format });
        }
        if version != VERSION {
            return Err(ExpansionFileError::Version { found: version });
        }
        let Content { families, terms, coefficients, .. } = serde_json::from_str(text)?;
        let family = |(variable, name): (usize, String)| {
            Family::from_name(&name).ok_or(ExpansionFileError::Family { variable, name })
        };
        let families: Vec<Family> = families.into_iter().enumerate().map(family).collect::<Result<_, _>>()?;
        let factors = |term: Vec<(u32, u16)>| -> Vec<Factor> {
            term.into_iter().map(|(variable, degree)| Factor { variable, degree }).collect()
        };
        let set = MultiIndexSet::from_factors(families.len(), terms.into_iter().map(factors))?;
        if coefficients.len() != set.len() {
            let (coefficients, terms) = (coefficients.len(), set.len());
            return Err(ExpansionFileError::Coefficients { coefficients, terms });
        }
        Ok(Self::new(Basis::new(set, families)?, coefficients))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Expansion {
        let set = MultiIndexSet::from_rows(3, [[0, 0, 0], [2, 0, 1], [0, 5, 0], [0, 0, 1]]).unwrap();
        let basis = Basis::new(set, vec![Family::Hermite, Family::Legendre, Family::Hermite]).unwrap();
        Expansion::new(basis, vec![0.1 + 0.2, -1e-310, std::f64::consts::PI * 1e200, -0.0])
    }

    #[test]
    fn reading_gives_back_equal_bits() {
        let (written, read) = (example(), Expansion::from_json(&example().to_json().unwrap()).unwrap());
        assert_eq!(read, written);
        let bits = |expansion: &Expansion| expansion.coefficients().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read), bits(&written));
    }

    #[test]
    fn the_text_is_what_the_documentation_shows() {
        let text = r#"{"format": "asperity polynomial chaos expansion", "version": 1, "families": ["hermite", "legendre"],
            "terms": [[], [[0, 1]], [[0, 2], [1, 1]]], "coefficients": [2.0, 1.0, 0.5]}"#;
        let expansion = Expansion::from_json(text).unwrap();
        // 2 + x + ½ (x² − 1)/√2 · √3 y.
        let wanted = 2.0 + 1.5 + 0.5 * 1.25 / 2.0_f64.sqrt() * 3.0_f64.sqrt() * 0.4;
        assert!((expansion.evaluate(&[1.5, 0.4]) - wanted).abs() < 1e-14);
        assert_eq!(expansion.to_json().unwrap().split_whitespace().count(), 4);
    }

    #[test]
    fn what_is_unknown_or_inconsistent_is_an_error() {
        let text = example().to_json().unwrap();
        let error = |from: &str, to: &str| {
            assert!(text.contains(from), "{from} is not in {text}");
            Expansion::from_json(&text.replacen(from, to, 1)).unwrap_err()
        };
        assert_eq!(error("\"version\":1", "\"version\":2"), ExpansionFileError::Version { found: 2 });
        assert!(matches!(error("asperity poly", "poly"), ExpansionFileError::Format { .. }));
        assert_eq!(error("legendre", "laguerre"), ExpansionFileError::Family { variable: 1, name: "laguerre".into() });
        assert_eq!(error("[[],", "["), ExpansionFileError::Terms(MultiIndexError::ConstantNotFirst));
        let repeated = MultiIndexError::Repeated { term: 3, earlier: 2 };
        assert_eq!(error("[[2,1]]", "[[1,5]]"), ExpansionFileError::Terms(repeated));
        assert!(matches!(error("[[1,5]]", "[[3,5]]"), ExpansionFileError::Terms(MultiIndexError::Factor { .. })));
        assert!(matches!(error("[[1,5]]", "[[-1,5]]"), ExpansionFileError::Syntax { line: 1, .. }));
        assert_eq!(error(",-0.0", ""), ExpansionFileError::Coefficients { coefficients: 3, terms: 4 });
        assert!(matches!(error("-0.0", "null"), ExpansionFileError::Syntax { .. }));
        assert!(matches!(error("{", "{\"typo\":1,"), ExpansionFileError::Syntax { .. }));
        assert!(matches!(error("\"version\":1,", ""), ExpansionFileError::Syntax { .. }));
        assert!(matches!(Expansion::from_json("{"), Err(ExpansionFileError::Syntax { line: 1, column: 1, .. })));
        assert!(matches!(Expansion::from_json("{} {}"), Err(ExpansionFileError::Syntax { .. })));
    }

    #[test]
    fn a_coefficient_that_is_not_finite_cannot_be_written() {
        let expansion = Expansion::new(Basis::hermite(1, 1).unwrap(), vec![0.0, f64::INFINITY]);
        let wanted = ExpansionFileError::NotFinite { term: 1, coefficient: f64::INFINITY };
        assert_eq!(expansion.to_json(), Err(wanted));
    }
}
