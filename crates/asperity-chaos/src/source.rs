//! Expansions as source code: a C function, or a Python one for NumPy arrays.
//!
//! Both hold a test: germs and the values that this library gives there.

use std::fmt::{Display, Write};

use thiserror::Error;

use super::{Expansion, Factor, Family};

/// Points of the test.
const TEST_POINTS: usize = 5;

/// Why no source was written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SourceError {
    /// The function's name is none in C or Python.
    #[error(
        "{name:?} is no name for a function: letters, digits and _ make one, not a digit first, not capitals alone, no reserved word"
    )]
    Name {
        /// The name.
        name: String,
    },
    /// A coefficient is not finite.
    #[error("the coefficient of term {term} is {coefficient}, not a finite number")]
    NotFinite {
        /// Position of the term.
        term: usize,
        /// Its coefficient.
        coefficient: f64,
    },
}

/// Words that one of the languages keeps for itself, and what the written code uses.
const RESERVED: &[&str] = &[
    "and",
    "as",
    "assert",
    "async",
    "auto",
    "await",
    "break",
    "case",
    "char",
    "class",
    "const",
    "continue",
    "def",
    "default",
    "del",
    "do",
    "double",
    "elif",
    "else",
    "enum",
    "except",
    "extern",
    "finally",
    "float",
    "for",
    "from",
    "global",
    "goto",
    "if",
    "import",
    "in",
    "inline",
    "int",
    "is",
    "lambda",
    "long",
    "main",
    "nonlocal",
    "not",
    "np",
    "numpy",
    "or",
    "pass",
    "raise",
    "register",
    "restrict",
    "return",
    "short",
    "signed",
    "sizeof",
    "static",
    "struct",
    "switch",
    "try",
    "typedef",
    "union",
    "unsigned",
    "void",
    "volatile",
    "while",
    "with",
    "yield",
    "printf",
    "range",
    "enumerate",
    "zip",
    "len",
    "print",
    "_",
];

impl Expansion {
    /// C99 without any library: `double name(const double *xi)`. Compiled with `-D<NAME>_TEST` it is a program that compares
    /// the function with values of this library, prints those it finds, and returns 0 when all agree to 10⁻¹².
    ///
    /// The function keeps (degree + 1) doubles for each variable on its stack.
    ///
    /// # Errors
    /// A name that is no identifier, or a coefficient that is not finite.
    pub fn c_source(&self, name: &str) -> Result<String, SourceError> {
        let parts = Parts::new(self, name)?;
        let mut text = format!("/* {}\n", parts.heading(" * "));
        let _ = write!(
            text,
            " *\n * With -D{upper}_TEST this is a program that compares the function with known values.\n */\n\
             #define VARIABLES {variables}\n#define TERMS {terms}\n#define DEGREE {degree}\n\n\
             /* b_n of b_(n+1) psi_(n+1) = x psi_n - b_n psi_(n-1), for Hermite (0) and Legendre (1) polynomials. */\n\
             static const double recurrence[2][DEGREE + 1] = {{\n{hermite},\n{legendre}}};\n\
             static const unsigned char family[VARIABLES] = {families};\n\
             /* Of each term the end of its factors, the factors psi_degree(xi[variable]), and the coefficient. */\n\
             static const int end[TERMS] = {ends};\nstatic const int variable[] = {variable};\n\
             static const int degree[] = {powers};\nstatic const double coefficient[TERMS] = {coefficients};\n\n",
            upper = name.to_uppercase(),
            variables = parts.families.len(),
            terms = parts.terms.len(),
            degree = parts.degree,
            hermite = braces(parts.recurrence(Family::Hermite)),
            legendre = braces(parts.recurrence(Family::Legendre)),
            families = braces(parts.families.iter().map(|family| u8::from(*family == Family::Legendre))),
            ends = braces(parts.ends()),
            // C has no arrays without elements.
            variable = braces(parts.factors().map(|factor| factor.variable).chain([0])),
            powers = braces(parts.factors().map(|factor| factor.degree).chain([0])),
            coefficients = braces(parts.terms.iter().map(|(_, c)| Number(*c))),
        );
        let _ = write!(text, "double {name}(const double *xi)\n{C_FUNCTION}\n#ifdef {}_TEST\n", name.to_uppercase());
        let points = parts.test.iter().map(|(germ, _)| braces(germ.iter().map(|x| Number(*x))));
        let _ = write!(
            text,
            "#include <stdio.h>\n\nstatic const double germs[{TEST_POINTS}][VARIABLES] = {};\n\
             static const double values[{TEST_POINTS}] = {};\n\nint main(void)\n{}#endif\n",
            braces(points),
            braces(parts.test.iter().map(|(_, value)| Number(*value))),
            C_MAIN
                .replace("POINTS", &TEST_POINTS.to_string())
                .replace("FUNCTION", name)
                .replace("SCALE", &parts.scale()),
        );
        Ok(text)
    }

    /// A Python module for NumPy with `name(xi)`: an array of shape `[…, variables]` in, one of shape `[…]` out. Run as a
    /// program it compares the function with values of this library.
    ///
    /// # Errors
    /// As [`Expansion::c_source`].
    pub fn python_source(&self, name: &str) -> Result<String, SourceError> {
        let parts = Parts::new(self, name)?;
        let terms = parts.terms.iter().map(|(factors, _)| {
            brackets(factors.iter().map(|factor| format!("({}, {})", factor.variable, factor.degree)))
        });
        let points = parts.test.iter().map(|(germ, _)| brackets(germ.iter().map(|x| Number(*x))));
        let mut text = format!("\"\"\"{}\"\"\"\n\nimport numpy as np\n\n", parts.heading(""));
        let _ = write!(
            text,
            "VARIABLES = {variables}\n# The polynomials of each variable, 0 Hermite and 1 Legendre, and their largest degree.\n\
             FAMILIES = {families}\nDEGREES = {degrees}\n\
             # b_n of b_(n+1) psi_(n+1) = x psi_n - b_n psi_(n-1).\nRECURRENCE = [{hermite}, {legendre}]\n\
             # (variable, degree) of the factors of each term, and the coefficients.\nTERMS = {terms}\n\
             COEFFICIENTS = {coefficients}\n\n\ndef {name}(xi):\n{PYTHON_FUNCTION}\n\nif __name__ == \"__main__\":\n\
             \x20   GERMS = {points}\n    VALUES = {values}\n{main}",
            variables = parts.families.len(),
            families = brackets(parts.families.iter().map(|family| u8::from(*family == Family::Legendre))),
            degrees = brackets(parts.degrees()),
            hermite = brackets(parts.recurrence(Family::Hermite)),
            legendre = brackets(parts.recurrence(Family::Legendre)),
            terms = brackets(terms),
            coefficients = brackets(parts.terms.iter().map(|(_, c)| Number(*c))),
            points = brackets(points),
            values = brackets(parts.test.iter().map(|(_, value)| Number(*value))),
            main = PYTHON_MAIN.replace("FUNCTION", name).replace("SCALE", &parts.scale()),
        );
        Ok(text)
    }
}

const C_FUNCTION: &str = "{
    double psi[VARIABLES][DEGREE + 1];
    double sum = 0.0;
    int v, n, term, factor = 0;
    for (v = 0; v < VARIABLES; v++) {
        const double *b = recurrence[family[v]];
        psi[v][0] = 1.0;
        for (n = 0; n < DEGREE; n++)
            psi[v][n + 1] = (xi[v] * psi[v][n] - (n > 0 ? b[n] * psi[v][n - 1] : 0.0)) / b[n + 1];
    }
    for (term = 0; term < TERMS; term++) {
        double product = coefficient[term];
        for (; factor < end[term]; factor++)
            product *= psi[variable[factor]][degree[factor]];
        sum += product;
    }
    return sum;
}
";

const C_MAIN: &str = "{
    int point, wrong = 0;
    for (point = 0; point < POINTS; point++) {
        double found = FUNCTION(germs[point]);
        double error = found > values[point] ? found - values[point] : values[point] - found;
        printf(\"%.17g\\n\", found);
        wrong += !(error <= 1e-12 * SCALE);
    }
    return wrong > 0;
}
";

const PYTHON_FUNCTION: &str = "    \"\"\"Values at points xi, an array whose last axis is that of the variables.\"\"\"
    xi = np.asarray(xi, dtype=float)
    if xi.shape[-1] != VARIABLES:
        raise ValueError(f\"{xi.shape[-1]} variables given, {VARIABLES} wanted\")
    psi = []
    for v, (family, degree) in enumerate(zip(FAMILIES, DEGREES)):
        x, b = xi[..., v], RECURRENCE[family]
        row = [np.ones_like(x)]
        for n in range(degree):
            before = b[n] * row[n - 1] if n > 0 else 0.0
            row.append((x * row[n] - before) / b[n + 1])
        psi.append(row)
    total = np.zeros(xi.shape[:-1])
    for factors, coefficient in zip(TERMS, COEFFICIENTS):
        product = coefficient
        for v, n in factors:
            product = product * psi[v][n]
        total = total + product
    return total
";

const PYTHON_MAIN: &str = "    found = FUNCTION(np.array(GERMS))
    for value in found:
        print(f\"{value:.17g}\")
    if not np.all(np.abs(found - np.array(VALUES)) <= 1e-12 * SCALE):
        raise SystemExit(1)
";

/// What both languages are told.
struct Parts<'a> {
    name: &'a str,
    families: &'a [Family],
    degree: usize,
    /// Terms with coefficients other than zero, and the constant.
    terms: Vec<(&'a [Factor], f64)>,
    mean: f64,
    std: f64,
    test: Vec<(Vec<f64>, f64)>,
}

impl<'a> Parts<'a> {
    fn new(expansion: &'a Expansion, name: &'a str) -> Result<Self, SourceError> {
        let letters = name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let digit_first = name.bytes().next().is_none_or(|byte| byte.is_ascii_digit());
        let taken = ["recurrence", "family", "end", "variable", "degree", "coefficient", "germs", "values"];
        let loud = name == name.to_uppercase();
        if !letters || digit_first || loud || RESERVED.contains(&name) || taken.contains(&name) {
            return Err(SourceError::Name { name: name.to_owned() });
        }
        if let Some(term) = expansion.coefficients().iter().position(|c| !c.is_finite()) {
            return Err(SourceError::NotFinite { term, coefficient: expansion.coefficients()[term] });
        }
        let all = expansion.basis().set().iter().zip(expansion.coefficients().iter().copied());
        let terms: Vec<_> = all.filter(|(factors, c)| factors.is_empty() || *c != 0.0).collect();
        let degree = terms.iter().flat_map(|(factors, _)| *factors).map(|f| usize::from(f.degree)).max().unwrap_or(0);
        let families = expansion.basis().families();
        let test = (0..TEST_POINTS).map(|point| {
            let germ = test_germ(families, point);
            let value = expansion.evaluate(&germ);
            (germ, value)
        });
        Ok(Self {
            name,
            families,
            degree,
            terms,
            mean: expansion.mean(),
            std: expansion.variance().sqrt(),
            test: test.collect(),
        })
    }

    /// Lines that say what the function is; all after the first begin with `prefix`.
    fn heading(&self, prefix: &str) -> String {
        let of = |family: Family| {
            let named: Vec<String> =
                (0..self.families.len()).filter(|v| self.families[*v] == family).map(|v| v.to_string()).collect();
            let lines: Vec<String> = named.chunks(20).map(|line| line.join(" ")).collect();
            if named.is_empty() { "none".to_owned() } else { lines.join(&format!("\n{prefix}    ")) }
        };
        [
            format!(
                "{}(xi): a polynomial chaos expansion, written by asperity {}.",
                self.name,
                env!("CARGO_PKG_VERSION")
            ),
            String::new(),
            "f(xi) = sum of coefficient * product of psi_degree(xi[variable]) over all terms.".to_owned(),
            format!("The {} variables xi are independent:", self.families.len()),
            "- standard normal, psi_n = He_n/sqrt(n!) with the Hermite polynomials of probability theory:".to_owned(),
            format!("    {}", of(Family::Hermite)),
            "- uniform on [-1, 1], psi_n = sqrt(2 n + 1) P_n with the Legendre polynomials:".to_owned(),
            format!("    {}", of(Family::Legendre)),
            format!("Then f has mean {:?} and standard deviation {:?}.", self.mean, self.std),
        ]
        .join(&format!("\n{prefix}"))
        .lines()
        .map(|line| format!("{}\n", line.trim_end()))
        .collect::<String>()
        .trim_end()
        .to_owned()
    }

    fn factors(&self) -> impl Iterator<Item = Factor> {
        self.terms.iter().flat_map(|(factors, _)| factors.iter().copied())
    }

    fn ends(&self) -> impl Iterator<Item = usize> {
        self.terms.iter().scan(0, |end, (factors, _)| {
            *end += factors.len();
            Some(*end)
        })
    }

    /// Largest degree of each variable.
    fn degrees(&self) -> Vec<u16> {
        let mut degrees = vec![0; self.families.len()];
        for factor in self.factors() {
            let degree = &mut degrees[factor.variable as usize];
            *degree = factor.degree.max(*degree);
        }
        degrees
    }

    /// b_0 = 0, b_1, … of a family.
    fn recurrence(&self, family: Family) -> Vec<Number> {
        (0..=self.degree).map(|n| Number(if n == 0 { 0.0 } else { family.recurrence(n) })).collect()
    }

    /// Largest value of the test, which rounding errors are compared with.
    fn scale(&self) -> String {
        Number(self.test.iter().map(|(_, value)| value.abs()).fold(f64::MIN_POSITIVE, f64::max)).to_string()
    }
}

/// A germ for the test: multiples of the golden ratio modulo 1 as probabilities.
fn test_germ(families: &[Family], point: usize) -> Vec<f64> {
    let probability = |variable: usize| ((point + 1) as f64 * (variable + 1) as f64 * 0.618_033_988_749_895).fract();
    families.iter().enumerate().map(|(v, family)| family.from_unit(probability(v).clamp(0.01, 0.99))).collect()
}

/// Written so that reading gives back equal bits.
struct Number(f64);

impl Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

fn braces<T: Display>(items: impl IntoIterator<Item = T>) -> String {
    format!("{{{}}}", wrapped(items))
}

fn brackets<T: Display>(items: impl IntoIterator<Item = T>) -> String {
    format!("[{}]", wrapped(items))
}

/// Items with commas between them, in lines of about a hundred characters.
fn wrapped<T: Display>(items: impl IntoIterator<Item = T>) -> String {
    let (mut text, mut line) = (String::new(), 0);
    for (position, item) in items.into_iter().enumerate() {
        let item = item.to_string();
        if position > 0 {
            text.push(',');
            text.push(if line > 90 { '\n' } else { ' ' });
            line = if line > 90 { 0 } else { line + 2 };
        }
        line += item.len();
        text.push_str(&item);
    }
    text
}

#[cfg(test)]
mod tests;
