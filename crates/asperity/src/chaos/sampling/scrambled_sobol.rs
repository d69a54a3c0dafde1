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

use rand::Rng;

use super::permutation::hash;
use crate::random::stream;

/// Binary digits of a coordinate, and of a sample index.
const DIGITS: usize = 32;
/// Highest degree of a primitive polynomial.
const MAX_POLYNOMIAL_DEGREE: u32 = 12;
/// Dimensions that polynomials up to [`MAX_POLYNOMIAL_DEGREE`] can serve.
pub(super) const MAX_DIMENSIONS: usize = 481;
/// Candidates of initial direction numbers per dimension.
const CANDIDATES: u64 = 16;
/// Earlier dimensions with which a candidate is compared.
const NEIGHBOURS: usize = 16;
/// log₂ of the numbers of points at which t-values are compared.
const COMPARED_LOG2_POINTS: [usize; 4] = [4, 6, 8, 10];

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
    let mut columns: Vec<[u32; DIGITS]> = Vec::with_capacity(dimensions);
    let mut rows: Vec<[u32; DIGITS]> = Vec::with_capacity(dimensions);
    let van_der_corput: [u32; DIGITS] = std::array::from_fn(|k| 1 << (DIGITS - 1 - k));
    columns.push(van_der_corput);
    rows.push(transposed(&van_der_corput));
    for polynomial in (1..=MAX_POLYNOMIAL_DEGREE).flat_map(primitive_polynomials).take(dimensions.saturating_sub(1)) {
        let dimension = columns.len();
        let first_neighbour = dimension.saturating_sub(NEIGHBOURS);
        let mut best: Option<(usize, [u32; DIGITS], [u32; DIGITS])> = None;
        for candidate in 0..CANDIDATES {
            let trial = columns_of(polynomial, hash(dimension as u64, candidate));
            let trial_rows = transposed(&trial);
            let cost = rows[first_neighbour..]
                .iter()
                .flat_map(|neighbour| COMPARED_LOG2_POINTS.map(|m| pair_t_value(&trial_rows, neighbour, m).pow(2)))
                .sum();
            if best.as_ref().is_none_or(|(least, _, _)| cost < *least) {
                best = Some((cost, trial, trial_rows));
            }
        }
        if let Some((_, trial, trial_rows)) = best {
            columns.push(trial);
            rows.push(trial_rows);
        }
    }
    columns.truncate(dimensions);
    columns
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
fn pair_t_value(a: &[u32; DIGITS], b: &[u32; DIGITS], m: usize) -> usize {
    let mask = (1_u32 << m) - 1;
    let mut basis_a: Vec<u32> = Vec::with_capacity(m);
    let mut independent = m;
    for from_a in 0..m {
        if from_a > 0 && !insert(&mut basis_a, a[from_a - 1] & mask) {
            return m - independent.min(from_a - 1);
        }
        let mut basis = basis_a.clone();
        let from_b = (0..m - from_a).take_while(|&i| insert(&mut basis, b[i] & mask)).count();
        independent = independent.min(from_a + from_b);
    }
    m - independent
}

/// Adds a vector to a basis kept reduced by leading bit; false when it depends on the basis.
fn insert(basis: &mut Vec<u32>, mut vector: u32) -> bool {
    for &element in basis.iter() {
        vector = vector.min(vector ^ element);
    }
    if vector == 0 {
        return false;
    }
    let place = basis.partition_point(|&element| element > vector);
    basis.insert(place, vector);
    true
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
        // φ(2^s − 1)/s for s = 1 … 12.
        let counts: Vec<usize> = (1..=MAX_POLYNOMIAL_DEGREE).map(|s| primitive_polynomials(s).count()).collect();
        assert_eq!(counts, [1, 1, 2, 2, 6, 6, 18, 16, 48, 60, 176, 144]);
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
    fn scrambling_keeps_which_points_share_leading_digits() {
        for (x, y) in [(0x1234_5678_u32, 0x1234_5679_u32), (0xffff_0000, 0xff00_0000), (0, u32::MAX)] {
            let shared = |a: u32, b: u32| (a ^ b).leading_zeros();
            assert_eq!(shared(scramble(x, 77), scramble(y, 77)), shared(x, y));
        }
    }
}
