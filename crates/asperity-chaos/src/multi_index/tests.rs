use std::collections::HashSet;

use super::*;

fn rows(set: &MultiIndexSet) -> Vec<Vec<u16>> {
    (0..set.len()).map(|term| set.at(term)).collect()
}

/// Returns all rows with degrees up to `degree` that satisfy `belongs`.
fn brute(variables: usize, degree: u16, belongs: impl Fn(&[u16]) -> bool) -> HashSet<Vec<u16>> {
    let side = usize::from(degree) + 1;
    (0..side.pow(variables as u32))
        .map(|code| (0..variables).map(|i| (code / side.pow(i as u32) % side) as u16).collect::<Vec<u16>>())
        .filter(|row| belongs(row))
        .collect()
}

#[test]
fn total_degree_three_in_eight_variables_has_the_papers_165_terms() {
    assert_eq!(MultiIndexSet::total_degree(8, 3).unwrap().len(), 165);
    assert_eq!(MultiIndexSet::total_degree(3, 8).unwrap().len(), 165);
    // Without a loop over the degree.
    assert_eq!(number_of_terms(1, usize::MAX - 1), Some(usize::MAX));
    assert_eq!(number_of_terms(usize::MAX - 1, 1), Some(usize::MAX));
    assert_eq!(number_of_terms(2, usize::MAX / 2), None);
}

#[test]
fn the_order_is_graded_and_fixed() {
    let set = MultiIndexSet::total_degree(2, 2).unwrap();
    assert_eq!(rows(&set), [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]);
}

#[test]
fn each_term_occurs_once_and_follows_from_an_earlier_one() {
    let set = MultiIndexSet::total_degree(5, 4).unwrap();
    let distinct: HashSet<Vec<u16>> = rows(&set).into_iter().collect();
    assert_eq!(distinct, brute(5, 4, |row| row.iter().sum::<u16>() <= 4));
    assert_eq!(Some(set.len()), number_of_terms(5, 4));
    assert_eq!(distinct.len(), set.len());
    for term in 1..set.len() {
        let parent = set.parent(term).unwrap();
        assert!(parent < term);
        assert_eq!(set.factors(parent), &set.factors(term)[..set.factors(term).len() - 1]);
    }
}

#[test]
fn truncations_contain_the_indices_of_their_definitions() {
    for (q, order, limits) in [
        (0.5, None, None),
        (0.75, None, None),
        (0.75, Some(2), None),
        (1.0, Some(2), None),
        (1.0, Some(0), None),
        (0.4, Some(1), None),
        (1.0, None, Some(vec![1, 5, 0, 3])),
        (0.75, Some(2), Some(vec![1, 9, 0, 3])),
    ] {
        let truncation =
            Truncation { q, interaction_order: order, degree_limits: limits.clone(), ..Truncation::total_degree(5) };
        let set = MultiIndexSet::truncated(4, &truncation).unwrap();
        let wanted = brute(4, 5, |row| {
            let norm = row.iter().map(|&d| f64::from(d).powf(q)).sum::<f64>().powf(1.0 / q);
            let active = row.iter().filter(|&&d| d > 0).count();
            let within = limits.as_ref().is_none_or(|l| row.iter().zip(l).all(|(&d, &l)| usize::from(d) <= l));
            norm <= 5.0 + 1e-9 && order.is_none_or(|r| active <= r) && within
        });
        let found = rows(&set);
        assert_eq!(found.len(), wanted.len(), "{truncation:?}");
        assert_eq!(found.iter().cloned().collect::<HashSet<_>>(), wanted, "{truncation:?}");
        assert!(found.is_sorted_by_key(|row| row.iter().sum::<u16>()));
    }
}

#[test]
fn multi_indices_on_the_border_of_a_q_norm_belong_to_the_set() {
    let holds = |q: f64, degree: usize, row: &[u16]| {
        let truncation = Truncation { q, ..Truncation::total_degree(degree) };
        rows(&MultiIndexSet::truncated(row.len(), &truncation).unwrap()).iter().any(|found| found == row)
    };
    // Powers of one variable lie on the border for every q, although (5^¾)^{4/3} > 5 in double precision.
    for q in [0.3, 0.5, 0.6, 0.75, 0.9, 1.0] {
        for degree in 1..=20_u16 {
            assert!(holds(q, usize::from(degree), &[0, degree]), "q {q}, degree {degree}");
        }
    }
    // (1 + 1)² = 4, (√4 + √1)² = 9, (1 + 1 + 1)² = 9.
    assert!(holds(0.5, 4, &[1, 1]) && holds(0.5, 9, &[4, 1]) && holds(0.5, 9, &[1, 1, 1]));
    assert!(!holds(0.5, 3, &[1, 1]) && !holds(0.5, 9, &[4, 2]) && !holds(0.5, 8, &[4, 1]));
    // q = ¾, p = 5: 3^¾ + 1 = 3.28 ≤ 5^¾ = 3.34 < 2·2^¾ = 3.36.
    assert!(holds(0.75, 5, &[3, 1]) && holds(0.75, 5, &[1, 1, 1]) && !holds(0.75, 5, &[2, 2]));
}

#[test]
fn sets_of_many_variables_are_small() {
    assert_eq!(MultiIndexSet::total_degree(100, 2).unwrap().len(), 5151);
    assert_eq!(MultiIndexSet::total_degree(101, 2).unwrap().len(), 5253);
    let linear = MultiIndexSet::total_degree(1000, 1).unwrap();
    assert_eq!((linear.len(), linear.factors.len()), (1001, 1000));
    let pairs = Truncation { interaction_order: Some(1), ..Truncation::total_degree(4) };
    assert_eq!(MultiIndexSet::truncated(10_000, &pairs).unwrap().len(), 40_001);
}

#[test]
fn a_list_need_not_be_downward_closed() {
    let set = MultiIndexSet::from_rows(3, [[0, 0, 0], [2, 1, 3], [0, 1, 0]]).unwrap();
    assert_eq!((set.len(), set.degree(), set.largest_power()), (3, 6, 3));
    assert_eq!((set.at(1), set.parent(1), set.parent(2)), (vec![2, 1, 3], None, Some(0)));
    let chosen = MultiIndexSet::total_degree(3, 2).unwrap().select(&[0, 4, 2]).unwrap();
    assert_eq!(rows(&chosen), [[0, 0, 0], [2, 0, 0], [0, 1, 0]]);
}

#[test]
fn lists_that_are_no_sets_are_refused() {
    let factor = |variable, degree| Factor { variable, degree };
    let list = |terms: &[Vec<Factor>]| MultiIndexSet::from_factors(2, terms).unwrap_err();
    assert_eq!(list(&[]), MultiIndexError::ConstantNotFirst);
    assert_eq!(list(&[vec![factor(0, 1)]]), MultiIndexError::ConstantNotFirst);
    let x = vec![factor(0, 1)];
    assert_eq!(list(&[vec![], x.clone(), x]), MultiIndexError::Repeated { term: 2, earlier: 1 });
    for (bad, variable, degree) in [
        (vec![factor(2, 1)], 2, 1),
        (vec![factor(1, 0)], 1, 0),
        (vec![factor(1, 1), factor(0, 2)], 0, 2),
        (vec![factor(1, 1), factor(1, 2)], 1, 2),
    ] {
        assert_eq!(list(&[vec![], bad]), MultiIndexError::Factor { term: 1, variable, degree, variables: 2 });
    }
}

#[test]
fn impossible_sets_are_refused() {
    let error = MultiIndexSet::total_degree(1000, 10).unwrap_err();
    assert_eq!(error, MultiIndexError::TooManyTerms { variables: 1000, degree: 10, limit: 1 << 20 });
    assert!(MultiIndexSet::total_degree(usize::MAX, 3).is_err());
    assert!(MultiIndexSet::total_degree(usize::MAX, 0).is_err());
    assert!(MultiIndexSet::total_degree(1, 70_000).is_err());
    assert_eq!(MultiIndexSet::total_degree(0, 3), Err(MultiIndexError::NoVariables));
    let pairs = Truncation { interaction_order: Some(2), ..Truncation::total_degree(3) };
    assert!(matches!(MultiIndexSet::truncated(2000, &pairs), Err(MultiIndexError::TooManyTerms { .. })));
    for q in [0.0, -1.0, 1.1, f64::NAN] {
        let truncation = Truncation { q, ..Truncation::total_degree(2) };
        assert!(matches!(MultiIndexSet::truncated(2, &truncation), Err(MultiIndexError::QNorm { .. })));
    }
    let limits = Truncation { degree_limits: Some(vec![1]), ..Truncation::total_degree(2) };
    let wanted = MultiIndexError::DegreeLimits { limits: 1, variables: 2 };
    assert_eq!(MultiIndexSet::truncated(2, &limits), Err(wanted));
}

impl MultiIndexSet {
    /// Creates a set from all degrees (α₁, …, α_n) of each multi-index; see [`MultiIndexSet::from_factors`].
    pub(crate) fn from_rows<R: AsRef<[u16]>>(
        variables: usize,
        rows: impl IntoIterator<Item = R>,
    ) -> Result<Self, MultiIndexError> {
        let sparse = |row: R| -> Vec<Factor> {
            let with_position = (0_u32..).zip(row.as_ref());
            with_position.filter(|(_, d)| **d > 0).map(|(variable, &degree)| Factor { variable, degree }).collect()
        };
        Self::from_factors(variables, rows.into_iter().map(sparse))
    }
}
