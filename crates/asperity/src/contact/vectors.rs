//! Sums over cells, written so that the compiler may use vector registers.

use crate::wide::{Kernel, wide};

/// Partial sums kept side by side: of few terms as many as hide the time an addition takes, of many as registers hold.
const LANES: usize = 16;
const FEW_LANES: usize = 4;

/// Sums of the K terms that `term` makes of each pair.
#[inline(always)]
pub(super) fn sums<const K: usize>(a: &[f64], b: &[f64], term: impl Fn(f64, f64) -> [f64; K]) -> [f64; K] {
    assert_eq!(a.len(), b.len(), "lists of different lengths");
    wide::<Sums<LANES>, _>(([a, b], |[a, b]: [f64; 2]| term(a, b)))
}

/// Sums of the K terms that `term` makes of the values at the same place of N lists.
///
/// # Panics
/// If the lists differ in length.
#[inline(always)]
pub(super) fn sums_of<const N: usize, const K: usize>(
    lists: [&[f64]; N],
    term: impl Fn([f64; N]) -> [f64; K],
) -> [f64; K] {
    let n = lists[0].len();
    assert!(lists.iter().all(|list| list.len() == n), "lists of different lengths");
    wide::<Sums<FEW_LANES>, _>((lists, term))
}

/// The loop of [`sums_of`].
struct Sums<const LANES: usize>;

impl<'a, const LANES: usize, const N: usize, const K: usize, T: Fn([f64; N]) -> [f64; K]> Kernel<([&'a [f64]; N], T)>
    for Sums<LANES>
{
    type Output = [f64; K];

    #[inline(always)]
    fn run((lists, term): ([&'a [f64]; N], T)) -> [f64; K] {
        let n = lists[0].len();
        let mut lanes = [[0.0; LANES]; K];
        let heads = lists.map(|list| list.as_chunks::<LANES>().0);
        for chunk in 0..n / LANES {
            for lane in 0..LANES {
                let terms = term(heads.map(|head| head[chunk][lane]));
                for k in 0..K {
                    lanes[k][lane] += terms[k];
                }
            }
        }
        for i in n - n % LANES..n {
            let terms = term(lists.map(|list| list[i]));
            for k in 0..K {
                lanes[k][i % LANES] += terms[k];
            }
        }
        lanes.map(|lanes| lanes.iter().sum())
    }
}

/// The least b among the pairs whose a is below `upper`; infinity if there is none.
pub(super) fn least_below(a: &[f64], b: &[f64], upper: f64) -> f64 {
    least(a, b, |a, b| if a < upper { b } else { f64::INFINITY })
}

/// The least of what `value` makes of each pair; infinity if there is none.
#[inline(always)]
pub(super) fn least(a: &[f64], b: &[f64], value: impl Fn(f64, f64) -> f64) -> f64 {
    wide::<Least, _>((a, b, value))
}

/// The loop of [`least`].
struct Least;

impl<'a, F: Fn(f64, f64) -> f64> Kernel<(&'a [f64], &'a [f64], F)> for Least {
    type Output = f64;

    #[inline(always)]
    fn run((a, b, value): (&'a [f64], &'a [f64], F)) -> f64 {
        let mut lanes = [f64::INFINITY; LANES];
        let ((chunks_a, rest_a), (chunks_b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
        for (a, b) in chunks_a.iter().zip(chunks_b) {
            for lane in 0..LANES {
                let value = value(a[lane], b[lane]);
                lanes[lane] = if value < lanes[lane] { value } else { lanes[lane] };
            }
        }
        for (a, b) in rest_a.iter().zip(rest_b) {
            let value = value(*a, *b);
            lanes[0] = if value < lanes[0] { value } else { lanes[0] };
        }
        lanes.into_iter().fold(f64::INFINITY, f64::min)
    }
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
