//! Sobol' points with Owen's nested uniform scrambling.
//!
//! Dimension 0 is the van der Corput sequence. The other dimensions use the primitive polynomials and initial direction
//! numbers of Joe and Kuo's table for criterion D(6), which keeps the t-values of two-dimensional projections small.
//!
//! # References
//! Sobol', *USSR Comput. Math. Math. Phys.* **7** (1967) 86, <https://doi.org/10.1016/0041-5553(67)90144-9>.
//! Owen, *J. Complexity* **14** (1998) 466, <https://doi.org/10.1006/jcom.1998.0487>.
//! Joe & Kuo, *SIAM J. Sci. Comput.* **30** (2008) 2635, <https://doi.org/10.1137/070709359>.

use rand::Rng;

use asperity_base::random::{hash, stream};

/// Number of binary digits of a coordinate, and of a sample index.
const DIGITS: usize = 32;
/// Number of dimensions: those of [`TABLE`] and the van der Corput sequence.
pub(super) const MAX_DIMENSIONS: usize = 1867;
/// Primitive polynomials and initial direction numbers. The first lines of the table describe its format.
const TABLE: &str = include_str!("joe_kuo.txt");

/// First 2³² points of a scrambled sequence.
#[derive(Debug, Clone)]
pub(super) struct ScrambledSobol {
    columns: Vec<[u32; DIGITS]>,
    keys: Vec<u64>,
}

impl ScrambledSobol {
    /// Creates the sequence of `dimensions` ≤ [`MAX_DIMENSIONS`] coordinates, scrambled by (seed, stage).
    pub(super) fn new(seed: u64, stage: &str, dimensions: usize) -> Self {
        let keys = (0..dimensions as u64).map(|dimension| stream(seed, stage, dimension).next_u64()).collect();
        Self { columns: generator_columns(dimensions), keys }
    }

    /// Returns the leading 32 binary digits of a coordinate of point `index`, scrambled.
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
        // Node of the binary tree for the digits before this one.
        let node = (1_u64 << digit) | (u64::from(x) >> (DIGITS - digit));
        let flip = (hash(key, node) >> 63) as u32;
        let position = DIGITS - 1 - digit;
        scrambled | (((x >> position & 1) ^ flip) << position)
    })
}

/// Returns the columns of the generator matrices: bit 31−i of column k is the matrix element (i, k).
fn generator_columns(dimensions: usize) -> Vec<[u32; DIGITS]> {
    assert!(dimensions <= MAX_DIMENSIONS, "{dimensions} dimensions; the table has {MAX_DIMENSIONS}");
    let van_der_corput = std::array::from_fn(|k| 1 << (DIGITS - 1 - k));
    let rows = TABLE.lines().filter(|line| !line.starts_with('#'));
    let packed = rows.filter_map(|row| u128::from_str_radix(row, 16).ok());
    std::iter::once(van_der_corput).chain(packed.map(columns_of)).take(dimensions).collect()
}

/// Returns the columns of one dimension.
///
/// The initial numbers m₁ … m_s are odd with m_k < 2^k; the others follow from Sobol's recurrence m_k = 2a₁m_{k−1} ⊕ …
/// ⊕ 2^s m_{k−s} ⊕ m_{k−s}.
///
/// `packed` has the s + 1 coefficients of the polynomial in its highest bits, then the k − 1 free bits of each m_k.
fn columns_of(packed: u128) -> [u32; DIGITS] {
    let last_bit = packed.ilog2() as usize;
    let degree = (1..DIGITS).find(|s| s * (s + 1) / 2 >= last_bit).unwrap_or(DIGITS);
    let polynomial = (packed >> (last_bit - degree)) as u32;
    let mut columns = [0_u32; DIGITS];
    for k in 0..DIGITS {
        columns[k] = if k < degree {
            let free = (packed >> (last_bit - degree - k * (k + 1) / 2)) as u32 & ((1 << k) - 1);
            (free << 1 | 1) << (DIGITS - 1 - k)
        } else {
            let last = columns[k - degree];
            (1..degree)
                .filter(|j| polynomial >> (degree - j) & 1 == 1)
                .fold(last ^ (last >> degree), |x, j| x ^ columns[k - j])
        };
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the rows of the generator matrix: bit k of row i is the matrix element (i, k).
    fn transposed(columns: &[u32; DIGITS]) -> [u32; DIGITS] {
        std::array::from_fn(|i| (0..DIGITS).fold(0, |row, k| row | ((columns[k] >> (DIGITS - 1 - i) & 1) << k)))
    }

    /// Returns the quality parameter t of the first 2^m points in two dimensions: every elementary box of volume
    /// 2^{t−m} contains exactly 2^t points.
    ///
    /// For each number of leading rows of `a`, the leading rows of `b` that are independent of them and of each other
    /// are counted. The smallest total is m − t. The search ends at the first dependent row of `a`.
    fn pair_t_value(a: &[u32; DIGITS], b: &[u32; DIGITS], m: usize) -> usize {
        let mask = (1_u32 << m) - 1;
        let mut of_a = Echelon::default();
        let mut independent = m;
        for from_a in 0..m {
            if from_a > 0 && !of_a.insert(a[from_a - 1] & mask) {
                return m - independent.min(from_a - 1);
            }
            // More rows of b than the current minimum requires cannot reduce it.
            let enough = independent.saturating_sub(from_a).min(m - from_a);
            let mut both = of_a;
            let from_b = (0..enough).take_while(|&i| both.insert(b[i] & mask)).count();
            independent = independent.min(from_a + from_b);
        }
        m - independent
    }

    /// Independent vectors over GF(2), indexed by their leading bits.
    #[derive(Clone, Copy, Default)]
    struct Echelon {
        by_leading_bit: [u32; 16],
    }

    impl Echelon {
        /// Adds a vector of at most 16 bits; returns false if it depends on the previous ones.
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

    /// Returns all primitive polynomials of one degree over GF(2), in increasing order.
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

    /// Returns m₁ … m_s of a dimension of degree s.
    fn initial_numbers(columns: &[u32; DIGITS], degree: usize) -> Vec<u32> {
        (0..degree).map(|k| columns[k] >> (DIGITS - 1 - k)).collect()
    }

    #[test]
    fn the_table_starts_as_published() {
        // Dimensions 2 to 20 of new-joe-kuo-6.21201, as printed on the authors' page.
        let published: [&[u32]; 19] = [
            &[1],
            &[1, 3],
            &[1, 3, 1],
            &[1, 1, 1],
            &[1, 1, 3, 3],
            &[1, 3, 5, 13],
            &[1, 1, 5, 5, 17],
            &[1, 1, 5, 5, 5],
            &[1, 1, 7, 11, 19],
            &[1, 1, 5, 1, 1],
            &[1, 1, 1, 3, 11],
            &[1, 3, 5, 5, 31],
            &[1, 3, 3, 9, 7, 49],
            &[1, 1, 1, 15, 21, 21],
            &[1, 3, 1, 13, 27, 49],
            &[1, 1, 1, 15, 7, 5],
            &[1, 3, 1, 15, 13, 25],
            &[1, 1, 5, 5, 19, 61],
            &[1, 3, 7, 11, 23, 15, 103],
        ];
        for (columns, numbers) in generator_columns(20)[1..].iter().zip(published) {
            assert_eq!(initial_numbers(columns, numbers.len()), numbers);
        }
    }

    #[test]
    fn each_dimension_has_the_next_primitive_polynomial() {
        let rows = TABLE.lines().filter(|line| !line.starts_with('#'));
        let found = rows.map(|row| {
            let packed = u128::from_str_radix(row, 16).unwrap();
            let degree = (1..).find(|s| s * (s + 1) / 2 == packed.ilog2()).unwrap();
            (packed >> (packed.ilog2() - degree)) as u32
        });
        let wanted: Vec<u32> = (1..=14).flat_map(primitive_polynomials).collect();
        assert_eq!(found.collect::<Vec<_>>(), wanted);
        assert_eq!(wanted.len() + 1, MAX_DIMENSIONS);
    }

    #[test]
    fn the_number_of_primitive_polynomials_is_that_of_theory() {
        // φ(2^s − 1)/s for s = 1 … 14.
        let counts: Vec<usize> = (1..=14).map(|s| primitive_polynomials(s).count()).collect();
        assert_eq!(counts, [1, 1, 2, 2, 6, 6, 18, 16, 48, 60, 176, 144, 630, 756]);
        assert_eq!(primitive_polynomials(3).collect::<Vec<_>>(), [0b1011, 0b1101]);
    }

    #[test]
    fn the_first_two_dimensions_are_a_perfect_net() {
        // Sobol's dimensions 0 and 1 have t = 0 for any initial numbers.
        let rows: Vec<_> = generator_columns(2).iter().map(transposed).collect();
        for m in 1..=14 {
            assert_eq!(pair_t_value(&rows[0], &rows[1], m), 0, "m = {m}");
        }
    }

    #[test]
    fn the_t_value_agrees_with_counting_points_in_boxes() {
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
    fn pairs_of_early_dimensions_have_small_t_values() {
        // Computed from SciPy's copy of the table by an independent program: at most 6 at 2^10 points. Random initial
        // numbers have up to 9.
        let rows: Vec<_> = generator_columns(50).iter().map(transposed).collect();
        let pairs = (1..rows.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        let largest = pairs.map(|(i, j)| pair_t_value(&rows[i], &rows[j], 10)).max();
        assert_eq!(largest, Some(6));
    }

    #[test]
    fn every_matrix_is_upper_triangular_with_a_unit_diagonal() {
        // Each dyadic prefix is then a permutation of its strata in all dimensions.
        for columns in generator_columns(MAX_DIMENSIONS) {
            for (k, column) in columns.iter().enumerate() {
                assert_eq!(column.trailing_zeros() as usize, DIGITS - 1 - k);
            }
        }
    }

    #[test]
    fn scrambling_keeps_which_points_fraction_leading_digits() {
        for (x, y) in [(0x1234_5678_u32, 0x1234_5679_u32), (0xffff_0000, 0xff00_0000), (0, u32::MAX)] {
            let shared = |a: u32, b: u32| (a ^ b).leading_zeros();
            assert_eq!(shared(scramble(x, 77), scramble(y, 77)), shared(x, y));
        }
    }
}
