//! Sets of multi-indices: which products of polynomials an expansion holds.

use thiserror::Error;

/// Largest number of multi-indices in a set.
pub const MAX_TERMS: usize = 1 << 20;

/// Why a set could not be made.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
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
}

/// One multi-index as the product of an earlier one and a power of a later variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Step {
    /// Position of the multi-index without its last variable.
    pub(crate) parent: usize,
    /// The last variable with a non-zero degree.
    pub(crate) variable: usize,
    /// Its degree.
    pub(crate) degree: usize,
}

/// All multi-indices α of n variables with |α| = Σα_i ≤ p, graded: by |α|, then by falling α₁, α₂, …
///
/// Their number is C(n+p, p). The first is 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MultiIndexSet {
    variables: usize,
    degree: usize,
    /// Degrees, row by row.
    degrees: Vec<u16>,
    steps: Vec<Step>,
}

impl MultiIndexSet {
    /// The set of total degree `degree` in `variables` variables.
    ///
    /// # Errors
    /// No variables, or more than 2²⁰ terms.
    pub fn total_degree(variables: usize, degree: usize) -> Result<Self, MultiIndexError> {
        if variables == 0 {
            return Err(MultiIndexError::NoVariables);
        }
        let too_many = || MultiIndexError::TooManyTerms { variables, degree, limit: MAX_TERMS };
        let terms = number_of_terms(variables, degree).filter(|&n| n <= MAX_TERMS).ok_or_else(too_many)?;
        let mut degrees = Vec::with_capacity(terms * variables);
        let mut row = vec![0_u16; variables];
        for total in 0..=degree {
            let total = u16::try_from(total).map_err(|_| too_many())?;
            append(&mut degrees, &mut row, 0, total);
        }
        let steps = steps(variables, &degrees);
        Ok(Self { variables, degree, degrees, steps })
    }

    /// Number of variables.
    pub fn variables(&self) -> usize {
        self.variables
    }

    /// Total degree p.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of multi-indices.
    pub fn len(&self) -> usize {
        self.degrees.len() / self.variables
    }

    /// Whether the set is empty: never, it holds the constant.
    pub fn is_empty(&self) -> bool {
        self.degrees.is_empty()
    }

    /// The degrees (α₁, …, α_n) of one term.
    pub fn at(&self, term: usize) -> &[u16] {
        &self.degrees[term * self.variables..(term + 1) * self.variables]
    }

    /// All multi-indices in order.
    pub fn iter(&self) -> impl Iterator<Item = &[u16]> {
        self.degrees.chunks_exact(self.variables)
    }

    /// How each multi-index after the first follows from an earlier one.
    pub(crate) fn steps(&self) -> &[Step] {
        &self.steps
    }
}

/// C(n+p, p), or nothing when it overflows.
pub fn number_of_terms(variables: usize, degree: usize) -> Option<usize> {
    (1..=degree).try_fold(1_usize, |count, k| count.checked_mul(variables.checked_add(k)?).map(|c| c / k))
}

/// Appends all rows whose entries from `variable` on sum to `rest`, the larger leading entries first.
fn append(degrees: &mut Vec<u16>, row: &mut [u16], variable: usize, rest: u16) {
    if variable + 1 == row.len() {
        row[variable] = rest;
        degrees.extend_from_slice(row);
        return;
    }
    for here in (0..=rest).rev() {
        row[variable] = here;
        append(degrees, row, variable + 1, rest - here);
    }
}

fn steps(variables: usize, degrees: &[u16]) -> Vec<Step> {
    let position: std::collections::HashMap<&[u16], usize> =
        degrees.chunks_exact(variables).enumerate().map(|(term, alpha)| (alpha, term)).collect();
    let mut parent = vec![0_u16; variables];
    degrees
        .chunks_exact(variables)
        .filter_map(|alpha| {
            let variable = alpha.iter().rposition(|&d| d > 0)?;
            parent.copy_from_slice(alpha);
            parent[variable] = 0;
            Some(Step { parent: *position.get(parent.as_slice())?, variable, degree: usize::from(alpha[variable]) })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn total_degree_three_in_eight_variables_has_the_papers_165_terms() {
        assert_eq!(MultiIndexSet::total_degree(8, 3).unwrap().len(), 165);
        assert_eq!(MultiIndexSet::total_degree(3, 8).unwrap().len(), 165);
    }

    #[test]
    fn the_order_is_graded_and_fixed() {
        let set = MultiIndexSet::total_degree(2, 2).unwrap();
        let rows: Vec<&[u16]> = set.iter().collect();
        assert_eq!(rows, [&[0, 0][..], &[1, 0], &[0, 1], &[2, 0], &[1, 1], &[0, 2]]);
    }

    #[test]
    fn each_term_occurs_once_and_follows_from_an_earlier_one() {
        let set = MultiIndexSet::total_degree(5, 4).unwrap();
        let distinct: std::collections::HashSet<&[u16]> = set.iter().collect();
        assert_eq!(distinct.len(), set.len());
        assert_eq!(Some(set.len()), number_of_terms(5, 4));
        assert_eq!(set.steps().len(), set.len() - 1);
        for (term, step) in set.steps().iter().enumerate() {
            let mut rebuilt = set.at(step.parent).to_vec();
            rebuilt[step.variable] += step.degree as u16;
            assert!(step.parent <= term);
            assert_eq!(rebuilt, set.at(term + 1));
        }
    }

    #[test]
    fn a_set_that_is_too_large_is_refused() {
        let error = MultiIndexSet::total_degree(1000, 10).unwrap_err();
        assert_eq!(error, MultiIndexError::TooManyTerms { variables: 1000, degree: 10, limit: 1 << 20 });
        assert!(MultiIndexSet::total_degree(usize::MAX, 3).is_err());
        assert_eq!(MultiIndexSet::total_degree(0, 3), Err(MultiIndexError::NoVariables));
    }
}
