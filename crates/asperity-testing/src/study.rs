//! Texts of study files for tests.

use std::fmt;

/// Line of `[pressure]` with all methods, so that they are compared with a reference.
pub const METHODS: &str = "methods = ['monte_carlo', 'latin_hypercube', 'sobol', 'polynomial_chaos', 'polynomial_chaos_log', \
                           'polynomial_chaos_local', 'default']";

/// Sections that many studies share. The stated friction is a part of `[vibration]`.
const SECTIONS: [(&str, &str, &str); 6] = [
    (
        "surface",
        "surface",
        "covariance = \"exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\ncorrelation_length = \"20 um\"",
    ),
    ("material", "material", "youngs_modulus = \"210 GPa\"\nhardness = \"2 GPa\"\nshear_strength = \"385 MPa\""),
    ("pressure", "pressure", "size = [\"100 um\", \"100 um\"]\npoints = [16, 16]\npercentile = 50.0"),
    (
        "friction",
        "friction",
        "strip = [\"1600 um\", \"50 um\"]\npoints = [256, 8]\nwindow = \"100 um\"\nrealisations = 8",
    ),
    (
        "vibration",
        "vibration",
        "mass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.17\nnormal_force = \"2.5 kN\"\n\
         nominal_area = \"833 mm^2\"\ndimensionless_belt_velocity = 0.003",
    ),
    (
        "stated friction",
        "vibration",
        "static_friction = 0.1\nfriction_std = 0.001\nfriction_correlation_length = \"250 um\"\n\
         friction_marginal = \"beta:2.1,5\"",
    ),
];

/// Text of a study file. `[vibration]` is the machine of the paper.
#[derive(Debug, Clone)]
pub struct StudyText {
    seed: u64,
    /// Sections in order, each with its lines `key = value`.
    sections: Vec<(&'static str, Vec<String>)>,
}

impl StudyText {
    /// Returns a study of these sections, among which `stated friction` adds to `[vibration]`.
    ///
    /// # Panics
    ///
    /// Panics if there is no such section.
    pub fn new(seed: u64, names: &[&'static str]) -> Self {
        names.iter().fold(Self { seed, sections: Vec::new() }, |study, wanted| {
            let Some((_, section, lines)) = SECTIONS.iter().find(|(name, ..)| name == wanted) else {
                panic!("no section {wanted}")
            };
            study.with(section, lines)
        })
    }

    /// Adds lines `key = value` to a section, or replaces those of the same key.
    #[must_use]
    pub fn with(mut self, section: &'static str, lines: &str) -> Self {
        let place = self.sections.iter().position(|(name, _)| *name == section).unwrap_or_else(|| {
            self.sections.push((section, Vec::new()));
            self.sections.len() - 1
        });
        let own = &mut self.sections[place].1;
        for line in lines.lines() {
            match own.iter_mut().find(|known| key(known) == key(line)) {
                Some(known) => line.clone_into(known),
                None => own.push(line.to_owned()),
            }
        }
        self
    }

    /// Removes keys of a section.
    ///
    /// # Panics
    ///
    /// Panics if the section has no such key.
    #[must_use]
    pub fn without(mut self, section: &str, keys: &[&str]) -> Self {
        for wanted in keys {
            let sections = self.sections.iter_mut().filter(|(name, _)| *name == section);
            let removed: usize =
                sections.map(|(_, lines)| lines.extract_if(.., |line| key(line) == *wanted).count()).sum();
            assert_eq!(removed, 1, "[{section}] {wanted}");
        }
        self
    }
}

fn key(line: &str) -> &str {
    line.split_once('=').map_or(line, |(key, _)| key).trim()
}

impl fmt::Display for StudyText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "seed = {}", self.seed)?;
        self.sections.iter().try_for_each(|(name, lines)| writeln!(f, "[{name}]\n{}", lines.join("\n")))
    }
}
