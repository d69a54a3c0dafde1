//! Sets of multi-indices, which select the products of polynomials in an expansion.

use std::collections::HashMap;

use thiserror::Error;

/// Maximum number of multi-indices in a set, and of variables.
pub const MAX_TERMS: usize = 1 << 20;

/// Relative excess over the border of a q-norm set that counts as rounding.
const BORDER_TOLERANCE: f64 = 1e-10;

/// Reason why a set could not be created.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MultiIndexError {
    /// There are no variables.
    #[error("an expansion needs at least one variable")]
    NoVariables,
    /// The set would be too large.
    #[error("total degree {degree} in {variables} variables has more than {limit} terms")]
    TooManyTerms {
        /// Number of variables.
        variables: usize,
        /// Total degree.
        degree: usize,
        /// Largest number of terms.
        limit: usize,
    },
    /// There are too many variables.
    #[error("{variables} variables; at most {limit} are possible")]
    TooManyVariables {
        /// Number of variables.
        variables: usize,
        /// Largest number of variables.
        limit: usize,
    },
    /// The exponent of a q-norm is outside (0, 1].
    #[error("the exponent of the q-norm is {q}; it must lie in (0, 1]")]
    QNorm {
        /// The exponent.
        q: f64,
    },
    /// The number of degree limits differs from the number of variables.
    #[error("{limits} limits of degrees for {variables} variables")]
    DegreeLimits {
        /// Limits given.
        limits: usize,
        /// Number of variables.
        variables: usize,
    },
    /// The first multi-index of a list is not 0.
    #[error("the first multi-index must be that of the constant, without any variable")]
    ConstantNotFirst,
    /// A multi-index lists its variables out of order, an unknown variable, or a variable with degree 0.
    #[error(
        "multi-index {term} holds variable {variable} with degree {degree}; variables must increase, lie below \
         {variables} and have positive degrees"
    )]
    Factor {
        /// Position in the list.
        term: usize,
        /// The variable.
        variable: usize,
        /// Its degree.
        degree: usize,
        /// Number of variables.
        variables: usize,
    },
    /// A multi-index occurs twice in a list.
    #[error("multi-index {term} is the same as multi-index {earlier}")]
    Repeated {
        /// Position in the list.
        term: usize,
        /// Where it occurred first.
        earlier: usize,
    },
}

/// A variable and its degree α_i > 0 in a multi-index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Factor {
    /// Index i of the variable.
    pub variable: u32,
    /// Degree α_i.
    pub degree: u16,
}

/// Conditions that all multi-indices of a set meet.
///
/// # References
/// Blatman & Sudret, *J. Comput. Phys.* **230** (2011) 2345, <https://doi.org/10.1016/j.jcp.2010.12.021>.
#[derive(Debug, Clone, PartialEq)]
pub struct Truncation {
    /// Degree p: (Σ α_i^q)^{1/q} ≤ p.
    pub degree: usize,
    /// Exponent q in (0, 1]. 1 is the total degree; smaller values leave out interactions of high degree.
    pub q: f64,
    /// Maximum number of variables in one term; `None` for no limit.
    pub interaction_order: Option<usize>,
    /// Largest degree of each variable; `None` for no limits.
    pub degree_limits: Option<Vec<usize>>,
}

impl Truncation {
    /// Creates the truncation Σ α_i ≤ `degree`.
    pub fn total_degree(degree: usize) -> Self {
        Self { degree, q: 1.0, interaction_order: None, degree_limits: None }
    }
}

/// List of distinct multi-indices α of n variables, starting with 0. Its memory is proportional to the number of
/// non-zero α_i.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MultiIndexSet {
    variables: usize,
    degree: usize,
    largest_power: usize,
    /// Non-zero entries of all terms, and the end of each term's entries.
    factors: Vec<Factor>,
    ends: Vec<usize>,
    /// Position of each term without its last factor, if it occurs earlier in the list.
    parents: Vec<Option<u32>>,
}

impl MultiIndexSet {
    /// Creates the set of all multi-indices with |α| = Σα_i ≤ p, graded: by |α|, then by falling α₁, α₂, … It has
    /// C(n+p, p) elements.
    ///
    /// # Errors
    /// There are no variables, or there are more than 2²⁰ terms or variables.
    pub fn total_degree(variables: usize, degree: usize) -> Result<Self, MultiIndexError> {
        if variables > 0 && number_of_terms(variables, degree).is_none_or(|n| n > MAX_TERMS) {
            return Err(MultiIndexError::TooManyTerms { variables, degree, limit: MAX_TERMS });
        }
        Self::truncated(variables, &Truncation::total_degree(degree))
    }

    /// Creates the set of all multi-indices that a truncation admits, in the order of [`MultiIndexSet::total_degree`].
    ///
    /// On the border of a q-norm set, rounding has no effect: α belongs to the set if Σ α_i^q ≤ p^q (1 + 10⁻¹⁰).
    ///
    /// # Errors
    /// There are no variables, more than 2²⁰ terms or variables, q is outside (0, 1], or the number of limits is wrong.
    pub fn truncated(variables: usize, truncation: &Truncation) -> Result<Self, MultiIndexError> {
        let &Truncation { degree, q, interaction_order, ref degree_limits } = truncation;
        check_variables(variables)?;
        if !(q > 0.0 && q <= 1.0) {
            return Err(MultiIndexError::QNorm { q });
        }
        if let Some(limits) = degree_limits
            && limits.len() != variables
        {
            return Err(MultiIndexError::DegreeLimits { limits: limits.len(), variables });
        }
        let too_many = MultiIndexError::TooManyTerms { variables, degree, limit: MAX_TERMS };
        let Ok(top) = u16::try_from(degree) else { return Err(too_many) };
        let capped = |limit: usize| u16::try_from(limit).unwrap_or(u16::MAX);
        let limits: Vec<u16> = match degree_limits {
            Some(limits) => limits.iter().map(|&limit| capped(limit)).collect(),
            None => vec![top; variables],
        };
        let mut reach = vec![0_usize; variables + 1];
        for variable in (0..variables).rev() {
            reach[variable] = reach[variable + 1] + usize::from(limits[variable]);
        }
        let mut growth = Growth {
            widest: usize::from(limits.iter().copied().max().unwrap_or(0)),
            reach,
            limits,
            powers: (0..=degree).map(|d| (d as f64).powf(q)).collect(),
            bound: (degree as f64).powf(q) * (1.0 + BORDER_TOLERANCE),
            order: interaction_order.unwrap_or(variables),
            row: Vec::new(),
            factors: Vec::new(),
            ends: vec![0],
        };
        for total in 1..=top {
            growth.append(0, total, 0.0);
            if growth.ends.len() > MAX_TERMS {
                return Err(too_many);
            }
        }
        Ok(Self::assembled(variables, growth.factors, growth.ends))
    }

    /// Creates a set from a list of multi-indices.
    ///
    /// Each multi-index lists its variables in increasing order with positive degrees. The first must be the constant
    /// (an empty list). Divisors of a term need not be in the list.
    ///
    /// # Errors
    /// There are no variables, more than 2²⁰ terms or variables, the first term is not the constant, a term is
    /// repeated, or factors are out of order.
    pub fn from_factors<T: AsRef<[Factor]>>(
        variables: usize,
        terms: impl IntoIterator<Item = T>,
    ) -> Result<Self, MultiIndexError> {
        check_variables(variables)?;
        let (mut factors, mut ends) = (Vec::new(), Vec::new());
        for (term, list) in terms.into_iter().enumerate() {
            let list = list.as_ref();
            if term == 0 && !list.is_empty() {
                return Err(MultiIndexError::ConstantNotFirst);
            }
            if term >= MAX_TERMS {
                let degree = degree_of(list);
                return Err(MultiIndexError::TooManyTerms { variables, degree, limit: MAX_TERMS });
            }
            for (k, &Factor { variable, degree }) in list.iter().enumerate() {
                let (here, degree) = (variable as usize, usize::from(degree));
                if here >= variables || degree == 0 || (k > 0 && list[k - 1].variable >= variable) {
                    return Err(MultiIndexError::Factor { term, variable: here, degree, variables });
                }
            }
            factors.extend_from_slice(list);
            ends.push(factors.len());
        }
        if ends.is_empty() {
            return Err(MultiIndexError::ConstantNotFirst);
        }
        let set = Self::assembled(variables, factors, ends);
        let mut first_at = HashMap::with_capacity(set.len());
        for term in 0..set.len() {
            if let Some(earlier) = first_at.insert(set.factors(term), term) {
                return Err(MultiIndexError::Repeated { term, earlier });
            }
        }
        Ok(set)
    }

    fn assembled(variables: usize, factors: Vec<Factor>, ends: Vec<usize>) -> Self {
        let mut set = Self { variables, degree: 0, largest_power: 0, factors, ends, parents: Vec::new() };
        let mut position: HashMap<&[Factor], u32> = HashMap::with_capacity(set.len());
        let mut parents = Vec::with_capacity(set.len());
        for term in 0..set.len() {
            let factors = set.factors(term);
            parents.push(factors.split_last().and_then(|(_, before)| position.get(before).copied()));
            position.entry(factors).or_insert(term as u32);
        }
        set.parents = parents;
        set.degree = (0..set.len()).map(|term| degree_of(set.factors(term))).max().unwrap_or(0);
        set.largest_power = set.factors.iter().map(|factor| usize::from(factor.degree)).max().unwrap_or(0);
        set
    }

    /// Returns the set of the terms at the given positions, in that order.
    ///
    /// # Errors
    /// See [`MultiIndexSet::from_factors`]: the first position must be 0, and positions must be distinct.
    ///
    /// # Panics
    /// If a position lies beyond the set.
    pub fn select(&self, positions: &[usize]) -> Result<Self, MultiIndexError> {
        Self::from_factors(self.variables, positions.iter().map(|&term| self.factors(term)))
    }

    /// Returns the number of variables.
    pub fn variables(&self) -> usize {
        self.variables
    }

    /// Returns the largest total degree |α| of the terms.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Returns the largest degree α_i of a variable in any term.
    pub fn largest_power(&self) -> usize {
        self.largest_power
    }

    /// Returns the number of multi-indices.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns false: a set always contains the constant.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Returns the variables of one term with their degrees, in increasing order of the variables; empty for the
    /// constant.
    pub fn factors(&self, term: usize) -> &[Factor] {
        let from = if term == 0 { 0 } else { self.ends[term - 1] };
        &self.factors[from..self.ends[term]]
    }

    /// Returns the degrees (α₁, …, α_n) of one term.
    pub fn at(&self, term: usize) -> Vec<u16> {
        let mut row = vec![0; self.variables];
        for factor in self.factors(term) {
            row[factor.variable as usize] = factor.degree;
        }
        row
    }

    /// Returns the factors of all multi-indices in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[Factor]> {
        (0..self.len()).map(|term| self.factors(term))
    }

    /// Returns the position of a term without its last factor, if that comes earlier in the list.
    pub(crate) fn parent(&self, term: usize) -> Option<usize> {
        self.parents[term].map(|parent| parent as usize)
    }
}

/// Returns the number of terms C(n+p, p), or `None` on overflow.
pub fn number_of_terms(variables: usize, degree: usize) -> Option<usize> {
    // The smaller of both counts the factors: overflow ends the product after at most some thirty of them.
    let (few, many) = (variables.min(degree), variables.max(degree));
    (1..=few).try_fold(1_usize, |count, k| count.checked_mul(many.checked_add(k)?).map(|c| c / k))
}

fn check_variables(variables: usize) -> Result<(), MultiIndexError> {
    match variables {
        0 => Err(MultiIndexError::NoVariables),
        1..=MAX_TERMS => Ok(()),
        _ => Err(MultiIndexError::TooManyVariables { variables, limit: MAX_TERMS }),
    }
}

fn degree_of(factors: &[Factor]) -> usize {
    factors.iter().map(|factor| usize::from(factor.degree)).sum()
}

/// Set under construction, one total degree after the other.
struct Growth {
    /// Largest degree of each variable, of any variable, and the summed limits of all variables from each one on.
    limits: Vec<u16>,
    widest: usize,
    reach: Vec<usize>,
    /// d^q.
    powers: Vec<f64>,
    /// Largest admitted Σ α_i^q.
    bound: f64,
    /// Maximum number of factors of a term.
    order: usize,
    /// Factors chosen so far.
    row: Vec<Factor>,
    factors: Vec<Factor>,
    ends: Vec<usize>,
}

impl Growth {
    /// Appends all terms that extend the chosen factors by variables from `first` on with degrees that sum to `rest`,
    /// larger leading degrees first. `used` is Σ α_i^q of the chosen factors.
    fn append(&mut self, first: usize, rest: u16, used: f64) {
        let wanted = usize::from(rest);
        let free = self.order - self.row.len();
        // A single variable adds the least of all extensions because d^q is concave.
        let too_much = used + self.powers[wanted] > self.bound;
        if too_much || wanted > free.saturating_mul(self.widest) {
            return;
        }
        for variable in first..self.limits.len() {
            if wanted > self.reach[variable] {
                return;
            }
            for degree in (1..=rest.min(self.limits[variable])).rev() {
                let used = used + self.powers[usize::from(degree)];
                self.row.push(Factor { variable: variable as u32, degree });
                if degree < rest {
                    self.append(variable + 1, rest - degree, used);
                } else if used <= self.bound {
                    self.factors.extend_from_slice(&self.row);
                    self.ends.push(self.factors.len());
                }
                self.row.pop();
                if self.ends.len() > MAX_TERMS {
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
