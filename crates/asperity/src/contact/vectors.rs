//! Sums over cells, written so that the compiler may use vector registers.

/// Partial sums kept side by side.
const LANES: usize = 4;

/// Sums of the K terms that `term` makes of each pair.
pub(super) fn sums<const K: usize>(a: &[f64], b: &[f64], term: impl Fn(f64, f64) -> [f64; K]) -> [f64; K] {
    let mut lanes = [[0.0; LANES]; K];
    let (chunks_a, chunks_b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let mut total = [0.0; K];
    for (a, b) in chunks_a.remainder().iter().zip(chunks_b.remainder()) {
        let terms = term(*a, *b);
        for k in 0..K {
            total[k] += terms[k];
        }
    }
    for (a, b) in chunks_a.zip(chunks_b) {
        for lane in 0..LANES {
            let terms = term(a[lane], b[lane]);
            for k in 0..K {
                lanes[k][lane] += terms[k];
            }
        }
    }
    for k in 0..K {
        total[k] += lanes[k].iter().sum::<f64>();
    }
    total
}

/// The least b among the pairs whose a is below `upper`; infinity if there is none.
pub(super) fn least_below(a: &[f64], b: &[f64], upper: f64) -> f64 {
    let mut lanes = [f64::INFINITY; LANES];
    let (chunks_a, chunks_b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    for (a, b) in chunks_a.remainder().iter().zip(chunks_b.remainder()) {
        lanes[0] = if *a < upper && *b < lanes[0] { *b } else { lanes[0] };
    }
    for (a, b) in chunks_a.zip(chunks_b) {
        for lane in 0..LANES {
            let candidate = if a[lane] < upper { b[lane] } else { f64::INFINITY };
            lanes[lane] = if candidate < lanes[lane] { candidate } else { lanes[lane] };
        }
    }
    lanes.into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    #[test]
    fn sums_and_extremes_are_those_of_the_plain_loops() {
        for n in [0, 1, 3, 4, 5, 31, 64] {
            let mut stream = random::stream(1, "vectors", n as u64);
            let (a, b) = (random::standard_normal(&mut stream, n), random::standard_normal(&mut stream, n));
            let plain: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            let [product, sum] = sums(&a, &b, |a, b| [a * b, a]);
            assert!((product - plain).abs() < 1e-13 && (sum - a.iter().sum::<f64>()).abs() < 1e-13);
            let least = a.iter().zip(&b).filter(|(a, _)| **a < 0.3).map(|(_, b)| *b).fold(f64::INFINITY, f64::min);
            assert_eq!(least_below(&a, &b, 0.3), least);
        }
    }
}
