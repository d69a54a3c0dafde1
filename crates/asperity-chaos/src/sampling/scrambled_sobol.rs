//! Sobol' points with Owen's nested uniform scrambling.
//!
//! Dimension 0 is the van der Corput sequence; each further dimension has its own primitive polynomial over GF(2), taken
//! in order of degree. The free initial direction numbers are chosen dimension by dimension: of some candidates the one
//! whose two-dimensional projections with the nearest earlier dimensions have the smallest t-values. Any choice gives a
//! digital sequence with perfectly stratified one-dimensional projections; the choice only improves the pairs.
//!
//! # References
//! Sobol', *USSR Comput. Math. Math. Phys.* **7** (1967) 86, <https://doi.org/10.1016/0041-5553(67)90144-9>.
//! Owen, *J. Complexity* **14** (1998) 466, <https://doi.org/10.1006/jcom.1998.0487>.
//! Joe & Kuo, *SIAM J. Sci. Comput.* **30** (2008) 2635, <https://doi.org/10.1137/070709359> (the criterion on pairs).

use std::sync::{Mutex, PoisonError};

use rand::Rng;

use super::permutation::hash;
use asperity_base::random::stream;

/// Binary digits of a coordinate, and of a sample index.
const DIGITS: usize = 32;
/// Highest degree of a primitive polynomial.
const MAX_POLYNOMIAL_DEGREE: u32 = 14;
/// Dimensions that polynomials up to [`MAX_POLYNOMIAL_DEGREE`] can serve.
pub(super) const MAX_DIMENSIONS: usize = 1867;
/// Candidates of initial direction numbers per dimension.
const CANDIDATES: u64 = 16;
/// Earlier dimensions with which a candidate is compared.
const NEIGHBOURS: usize = 16;
/// log₂ of the numbers of points at which t-values are compared.
const COMPARED_LOG2_POINTS: [usize; 4] = [4, 6, 8, 10];

/// Generator matrices found so far: the choice for a dimension depends on those before it, but on no seed.
static MATRICES: Mutex<Vec<Matrix>> = Mutex::new(Vec::new());

/// A generator matrix over GF(2), twice.
#[derive(Debug, Clone)]
struct Matrix {
    /// Bit 31−i of column k is the element (i, k).
    columns: [u32; DIGITS],
    /// Bit k of row i is the element (i, k).
    rows: [u32; DIGITS],
}

/// The first 2³² points of a scrambled sequence.
#[derive(Debug, Clone)]
pub(super) struct ScrambledSobol {
    columns: Vec<[u32; DIGITS]>,
    keys: Vec<u64>,
}

impl ScrambledSobol {
    /// The sequence of `dimensions` ≤ [`MAX_DIMENSIONS`] coordinates, scrambled by (seed, stage).
    pub(super) fn new(seed: u64, stage: &str, dimensions: usize) -> Self {
        let keys = (0..dimensions as u64).map(|dimension| stream(seed, stage, dimension).next_u64()).collect();
        Self { columns: generator_columns(dimensions), keys }
    }

    /// The leading 32 binary digits of a coordinate of point `index`, scrambled.
    pub(super) fn digits(&self, index: u32, dimension: usize) -> u32 {
        scramble(self.unscrambled(index, dimension), self.keys[dimension])
    }

    fn unscrambled(&self, index: u32, dimension: usize) -> u32 {
        let columns = &self.columns[dimension];
        (0..DIGITS).filter(|k| index >> k & 1 == 1).fold(0, |x, k| x ^ columns[k])
    }
}

/// Flips each digit by a keyed bit of all digits before it.
fn scramble(x: u32, key: u64) -> u32 {
    (0..DIGITS).fold(0, |scrambled, digit| {
        // The node of the binary tree that the digits before this one lead to.
        let node = (1_u64 << digit) | (u64::from(x) >> (DIGITS - digit));
        let flip = (hash(key, node) >> 63) as u32;
        let position = DIGITS - 1 - digit;
        scrambled | (((x >> position & 1) ^ flip) << position)
    })
}

/// The columns of the generator matrices: bit 31−i of column k is the matrix element (i, k).
fn generator_columns(dimensions: usize) -> Vec<[u32; DIGITS]> {
    assert!(dimensions <= MAX_DIMENSIONS, "{dimensions} dimensions; the polynomials serve {MAX_DIMENSIONS}");
    // Matrices are appended whole, so a thread that panicked has left good ones.
    let mut matrices = MATRICES.lock().unwrap_or_else(PoisonError::into_inner);
    extend(&mut matrices, dimensions);
    matrices[..dimensions].iter().map(|matrix| matrix.columns).collect()
}

/// Appends matrices until there are as many as `dimensions`.
fn extend(matrices: &mut Vec<Matrix>, dimensions: usize) {
    if matrices.len() >= dimensions {
        return;
    }
    if matrices.is_empty() {
        matrices.push(Matrix::new(std::array::from_fn(|k| 1 << (DIGITS - 1 - k))));
    }
    let polynomials = (1..=MAX_POLYNOMIAL_DEGREE).flat_map(primitive_polynomials);
    for polynomial in polynomials.take(dimensions - 1).skip(matrices.len() - 1) {
        let dimension = matrices.len();
        let neighbours = &matrices[dimension.saturating_sub(NEIGHBOURS)..];
        let mut best: Option<(usize, Matrix)> = None;
        for candidate in 0..CANDIDATES {
            let trial = Matrix::new(columns_of(polynomial, hash(dimension as u64, candidate)));
            let least = best.as_ref().map_or(usize::MAX, |(least, _)| *least);
            // No sum of squares gets smaller again: what has reached the least so far is no better.
            let mut pairs = neighbours.iter().flat_map(|near| COMPARED_LOG2_POINTS.map(|m| (near, m)));
            let cost = pairs.try_fold(0, |cost, (near, m)| {
                let cost = cost + pair_t_value(&trial.rows, &near.rows, m).pow(2);
                (cost < least).then_some(cost)
            });
            if let Some(cost) = cost {
                best = Some((cost, trial));
            }
        }
        matrices.extend(best.map(|(_, matrix)| matrix));
    }
}

impl Matrix {
    fn new(columns: [u32; DIGITS]) -> Self {
        Self { columns, rows: transposed(&columns) }
    }
}

/// Columns of one dimension: initial numbers m₁ … m_s odd with m_k < 2^k, drawn from `key`, then Sobol's recurrence
/// m_k = 2a₁m_{k−1} ⊕ … ⊕ 2^s m_{k−s} ⊕ m_{k−s}. The polynomial is stored with bit i as the coefficient of x^i.
fn columns_of(polynomial: u32, key: u64) -> [u32; DIGITS] {
    let degree = (u32::BITS - 1 - polynomial.leading_zeros()) as usize;
    let mut columns = [0_u32; DIGITS];
    for k in 0..DIGITS {
        columns[k] = if k < degree {
            let odd = (hash(key, k as u64) >> (63 - k)) as u32 | 1;
            odd << (DIGITS - 1 - k)
        } else {
            let last = columns[k - degree];
            (1..degree)
                .filter(|j| polynomial >> (degree - j) & 1 == 1)
                .fold(last ^ (last >> degree), |x, j| x ^ columns[k - j])
        };
    }
    columns
}

/// Rows of the generator matrix: bit k of row i is the matrix element (i, k).
fn transposed(columns: &[u32; DIGITS]) -> [u32; DIGITS] {
    std::array::from_fn(|i| (0..DIGITS).fold(0, |row, k| row | ((columns[k] >> (DIGITS - 1 - i) & 1) << k)))
}

/// The quality parameter t of the first 2^m points in two dimensions: every elementary box of volume 2^{t−m} holds
/// exactly 2^t of them.
///
/// For each number of leading rows of `a` those of `b` are counted that are independent of them and of each other. The
/// least total is m − t. Whether `from_a` rows of `a` alone are independent ends the search.
fn pair_t_value(a: &[u32; DIGITS], b: &[u32; DIGITS], m: usize) -> usize {
    let mask = (1_u32 << m) - 1;
    let mut of_a = Echelon::default();
    let mut independent = m;
    for from_a in 0..m {
        if from_a > 0 && !of_a.insert(a[from_a - 1] & mask) {
            return m - independent.min(from_a - 1);
        }
        // More rows of b than the least so far needs cannot lower it.
        let enough = independent.saturating_sub(from_a).min(m - from_a);
        let mut both = of_a;
        let from_b = (0..enough).take_while(|&i| both.insert(b[i] & mask)).count();
        independent = independent.min(from_a + from_b);
    }
    m - independent
}

/// Independent vectors over GF(2), by their leading bits.
#[derive(Clone, Copy, Default)]
struct Echelon {
    by_leading_bit: [u32; 16],
}

impl Echelon {
    /// Adds a vector of at most 16 bits; false when it depends on those before.
    #[inline]
    fn insert(&mut self, mut vector: u32) -> bool {
        while vector != 0 {
            let place = &mut self.by_leading_bit[(vector.ilog2() & 15) as usize];
            if *place == 0 {
                *place = vector;
                return true;
            }
            vector ^= *place;
        }
        false
    }
}

/// All primitive polynomials of one degree over GF(2), in increasing order.
fn primitive_polynomials(degree: u32) -> impl Iterator<Item = u32> {
    let order = (1_u32 << degree) - 1;
    let divisors: Vec<u32> =
        (2..=order).filter(|q| order.is_multiple_of(*q) && (2..*q).all(|r| !q.is_multiple_of(r))).collect();
    ((1_u32 << degree) + 1..1_u32 << (degree + 1)).step_by(2).filter(move |&polynomial| {
        power_of_x(order, polynomial, degree) == 1
            && divisors.iter().all(|q| power_of_x(order / q, polynomial, degree) != 1)
    })
}

/// x^exponent modulo a polynomial over GF(2).
fn power_of_x(exponent: u32, polynomial: u32, degree: u32) -> u32 {
    let reduce = |value: u32| if value >> degree & 1 == 1 { value ^ polynomial } else { value };
    let multiply = |a: u32, b: u32| {
        (0..degree).rev().fold(0, |product, bit| reduce(product << 1) ^ if b >> bit & 1 == 1 { a } else { 0 })
    };
    let x = reduce(2);
    (0..u32::BITS - exponent.leading_zeros()).rev().fold(1, |power, bit| {
        let square = multiply(power, power);
        if exponent >> bit & 1 == 1 { multiply(square, x) } else { square }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_primitive_polynomials_is_that_of_theory() {
        // φ(2^s − 1)/s for s = 1 … 14.
        let counts: Vec<usize> = (1..=MAX_POLYNOMIAL_DEGREE).map(|s| primitive_polynomials(s).count()).collect();
        assert_eq!(counts, [1, 1, 2, 2, 6, 6, 18, 16, 48, 60, 176, 144, 630, 756]);
        assert_eq!(counts.iter().sum::<usize>() + 1, MAX_DIMENSIONS);
        assert_eq!(primitive_polynomials(3).collect::<Vec<_>>(), [0b1011, 0b1101]);
    }

    #[test]
    fn the_first_two_dimensions_are_a_perfect_net() {
        // Sobol's dimensions 0 and 1 have t = 0 whatever the initial numbers.
        let rows: Vec<_> = generator_columns(2).iter().map(transposed).collect();
        for m in 1..=14 {
            assert_eq!(pair_t_value(&rows[0], &rows[1], m), 0, "m = {m}");
        }
    }

    #[test]
    fn the_t_value_is_what_counting_points_in_boxes_says() {
        let sobol = ScrambledSobol::new(1, "test", 9);
        let m = 6;
        for (first, second) in [(0, 1), (1, 4), (3, 8), (6, 7)] {
            let t = pair_t_value(&transposed(&sobol.columns[first]), &transposed(&sobol.columns[second]), m);
            let is_net = |t: usize| {
                (0..=m - t).all(|from_first| {
                    let from_second = m - t - from_first;
                    let mut counts = vec![0_usize; 1 << (m - t)];
                    for index in 0..1_u32 << m {
                        let leading = |dimension: usize, digits: usize| {
                            (u64::from(sobol.digits(index, dimension)) >> (DIGITS - digits)) as usize
                        };
                        counts[leading(first, from_first) << from_second | leading(second, from_second)] += 1;
                    }
                    counts.iter().all(|&count| count == 1 << t)
                })
            };
            assert!(is_net(t), "dimensions {first}, {second}: not a ({t}, {m}, 2)-net");
            assert!(t == 0 || !is_net(t - 1), "dimensions {first}, {second}: t = {t} is not the least");
        }
    }

    #[test]
    fn matrices_do_not_depend_on_how_many_are_asked_for_at_a_time() {
        let (mut at_once, mut by_and_by) = (Vec::new(), Vec::new());
        extend(&mut at_once, 60);
        for dimensions in [1, 2, 3, 17, 17, 5, 60] {
            extend(&mut by_and_by, dimensions);
        }
        let columns = |matrices: &[Matrix]| matrices.iter().map(|matrix| matrix.columns).collect::<Vec<_>>();
        assert_eq!(columns(&at_once), columns(&by_and_by));
        assert_eq!(generator_columns(60), columns(&at_once));
    }

    #[test]
    fn every_matrix_is_upper_triangular_with_a_unit_diagonal() {
        // That makes each dyadic prefix a permutation of its strata, in all dimensions.
        for columns in generator_columns(MAX_DIMENSIONS) {
            for (k, column) in columns.iter().enumerate() {
                assert_eq!(column.trailing_zeros() as usize, DIGITS - 1 - k);
            }
        }
    }

    #[test]
    fn scrambling_keeps_which_points_share_leading_digits() {
        for (x, y) in [(0x1234_5678_u32, 0x1234_5679_u32), (0xffff_0000, 0xff00_0000), (0, u32::MAX)] {
            let shared = |a: u32, b: u32| (a ^ b).leading_zeros();
            assert_eq!(shared(scramble(x, 77), scramble(y, 77)), shared(x, y));
        }
    }
}
