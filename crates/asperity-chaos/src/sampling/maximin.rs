//! Maximin Latin hypercubes.

use rand::Rng;

use asperity_base::random::Stream;

/// Maximum number of samples; the table of distances then has two million entries.
pub(super) const MAX_SAMPLES: usize = 2000;
/// Number of exchanges tried per sample, and in total.
const EXCHANGES_PER_SAMPLE: usize = 100;
const MAX_EXCHANGES: usize = 20_000;

/// Returns the strata of each sample in each dimension, sample by sample: a random Latin hypercube after the exchanges
/// that reduce φ = Σ_{i<j} d_ij^{−16}.
pub(super) fn maximin_strata(samples: usize, dimensions: usize, stream: &mut Stream) -> Vec<u16> {
    assert!(samples <= MAX_SAMPLES, "{samples} samples; the table of distances is made for {MAX_SAMPLES}");
    let mut search = Search::new(samples, dimensions, stream);
    // All hypercubes in one dimension are equivalent, and one or two points cannot be improved.
    if dimensions > 1 && samples > 2 {
        for _ in 0..MAX_EXCHANGES.min(EXCHANGES_PER_SAMPLE * samples) {
            let dimension = below(dimensions, stream);
            let near = search.nearest[below(2, stream)];
            let other = (near + 1 + below(samples - 1, stream)) % samples;
            search.exchange(near, other, dimension);
        }
    }
    search.strata
}

/// Returns an integer below `n`, uniform up to one part in 2⁵⁰.
fn below(n: usize, stream: &mut Stream) -> usize {
    ((u128::from(stream.next_u64()) * n as u128) >> 64) as usize
}

struct Search {
    samples: usize,
    dimensions: usize,
    strata: Vec<u16>,
    /// Squared distances in strata: a full matrix with infinity on its diagonal.
    squares: Vec<f64>,
    /// Smallest entry of each row.
    least: Vec<f64>,
    /// Pair of points with the smallest distance.
    nearest: [usize; 2],
    /// New squared distances of the two points of an exchange.
    trial: [Vec<f64>; 2],
}

impl Search {
    fn new(samples: usize, dimensions: usize, stream: &mut Stream) -> Self {
        let mut strata = vec![0; samples * dimensions];
        let mut order: Vec<u16> = (0..samples as u16).collect();
        for dimension in 0..dimensions {
            for i in (1..samples).rev() {
                order.swap(i, below(i + 1, stream));
            }
            for (sample, &stratum) in order.iter().enumerate() {
                strata[sample * dimensions + dimension] = stratum;
            }
        }
        let mut squares = vec![f64::INFINITY; samples * samples];
        for i in 0..samples {
            for j in 0..i {
                let (a, b) = (&strata[i * dimensions..][..dimensions], &strata[j * dimensions..][..dimensions]);
                let square = a.iter().zip(b).map(|(&a, &b)| f64::from(a.abs_diff(b)).powi(2)).sum();
                squares[i * samples + j] = square;
                squares[j * samples + i] = square;
            }
        }
        let trial = [vec![0.0; samples], vec![0.0; samples]];
        let least = squares.chunks_exact(samples).map(least_of).collect();
        let mut search = Self { samples, dimensions, strata, squares, least, nearest: [0; 2], trial };
        search.find_nearest();
        search
    }

    fn find_nearest(&mut self) {
        let first = position_of_least(&self.least);
        self.nearest = [first, position_of_least(&self.squares[first * self.samples..][..self.samples])];
    }

    /// Exchanges the strata of points a and b in one dimension if this reduces φ.
    fn exchange(&mut self, a: usize, b: usize, dimension: usize) {
        let n = self.samples;
        let stratum = |sample: usize| f64::from(self.strata[sample * self.dimensions + dimension]);
        let (of_a, of_b) = (stratum(a), stratum(b));
        let mut change = 0.0;
        for j in 0..n {
            let (own, x) = ((j == a) | (j == b), stratum(j));
            let moved = (of_b - x).powi(2) - (of_a - x).powi(2);
            let (before_a, before_b) = (self.squares[a * n + j], self.squares[b * n + j]);
            // The distance between the two points does not change.
            let moved = if own { 0.0 } else { moved };
            let (after_a, after_b) = (before_a + moved, before_b - moved);
            (self.trial[0][j], self.trial[1][j]) = (after_a, after_b);
            change += energy(after_a) - energy(before_a) + energy(after_b) - energy(before_b);
        }
        if change >= 0.0 {
            return;
        }
        self.strata.swap(a * self.dimensions + dimension, b * self.dimensions + dimension);
        for (point, row) in [a, b].into_iter().zip(&self.trial) {
            for (j, &square) in row.iter().enumerate() {
                let before = std::mem::replace(&mut self.squares[j * n + point], square);
                self.squares[point * n + j] = square;
                if square < self.least[j] {
                    self.least[j] = square;
                } else if before == self.least[j] {
                    self.least[j] = least_of(&self.squares[j * n..][..n]);
                }
            }
            self.least[point] = least_of(row);
        }
        self.find_nearest();
    }
}

fn least_of(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn position_of_least(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, i| if values[i] < values[best] { i } else { best })
}

/// Returns d^{−16} from a squared distance.
fn energy(square: f64) -> f64 {
    let inverse = 1.0 / square;
    let second = inverse * inverse;
    let fourth = second * second;
    fourth * fourth
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::stream;

    #[test]
    fn distances_follow_the_exchanges() {
        let mut draws = stream(2, "test", 0);
        let mut search = Search::new(30, 3, &mut draws);
        let phi = |search: &Search| {
            (1..30)
                .flat_map(|i| (0..i).map(move |j| (i, j)))
                .map(|(i, j)| energy(search.squares[i * 30 + j]))
                .sum::<f64>()
        };
        let mut last = phi(&search);
        for _ in 0..200 {
            let (a, dimension) = (search.nearest[0], below(3, &mut draws));
            search.exchange(a, (a + 1 + below(29, &mut draws)) % 30, dimension);
            let now = phi(&search);
            assert!(now <= last);
            last = now;
        }
        let strata = |i: usize| &search.strata[3 * i..3 * i + 3];
        for i in 0..30 {
            for j in 0..30 {
                let square: f64 =
                    strata(i).iter().zip(strata(j)).map(|(&a, &b)| f64::from(a.abs_diff(b)).powi(2)).sum();
                assert_eq!(search.squares[30 * i + j], if i == j { f64::INFINITY } else { square });
            }
        }
        let nearest = search.squares[30 * search.nearest[0] + search.nearest[1]];
        assert_eq!(nearest, search.squares.iter().copied().fold(f64::INFINITY, f64::min));
    }
}
