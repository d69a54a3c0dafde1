use super::super::{Unbounded, Yielding};
use super::*;
use asperity_base::random;
use asperity_base::wide::wide;

const HARDNESS: f64 = 1.5;

/// Returns multiples of 1/8 between −4 and 4, whose sums and products are exact in any order.
fn eighths(seed: u64, count: usize) -> Vec<f64> {
    let normal = random::standard_normal(&mut random::stream(seed, "eighths", 0), count);
    normal.into_iter().map(|z| (8.0 * z).round().clamp(-32.0, 32.0) / 8.0).collect()
}

/// Returns pressures within the bounds, many of them on a bound.
fn pressures(seed: u64, count: usize, bound: f64) -> Vec<f64> {
    eighths(seed, count).into_iter().map(|z| z.clamp(0.0, bound)).collect()
}

fn single(values: &[f64]) -> Vec<f32> {
    values.iter().map(|value| *value as f32).collect()
}

fn count(n: usize, holds: impl Fn(usize) -> bool) -> f64 {
    (0..n).filter(|i| holds(*i)).count() as f64
}

fn sum(n: usize, term: impl Fn(usize) -> f64) -> f64 {
    (0..n).map(term).sum()
}

/// Compares the loops that know a hardness with their definitions.
fn check<C: Hardness>(hardness: C, bound: f64, n: usize) {
    let (p, v, t) = (pressures(1, n, bound), eighths(2, n), eighths(3, n));
    let found = wide::<Summarise, _>((&*p, &*v, 0.5, hardness));
    let below = |i: usize| p[i] < bound;
    let between = |i: usize| below(i) && p[i] > 0.0;
    assert_eq!(found.pressure, sum(n, |i| p[i]));
    assert_eq!(found.free, sum(n, |i| if below(i) { p[i] } else { 0.0 }));
    assert_eq!(found.free_v, sum(n, |i| if below(i) { p[i] * v[i] } else { 0.0 }));
    assert_eq!(found.between_v, sum(n, |i| if between(i) { v[i] } else { 0.0 }));
    assert_eq!(found.between, count(n, between));
    assert_eq!(found.idle, count(n, |i| p[i] == 0.0 && v[i] >= 0.5));
    assert_eq!(found.least_v, (0..n).filter(|i| below(*i)).map(|i| v[i]).fold(f64::INFINITY, f64::min));

    // Some cells may not move: their trial values are infinite.
    let trial: Vec<f64> = t.iter().map(|t| if *t > 1.0 { f64::INFINITY.copysign(*t - 1.5) } else { *t }).collect();
    let finite: Vec<f64> = trial.iter().copied().filter(|t| t.is_finite()).collect();
    let found = wide::<Span, _>((&*trial, hardness));
    assert_eq!(found.least, finite.iter().copied().fold(f64::INFINITY, f64::min));
    assert_eq!(found.largest, finite.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    assert_eq!(found.members, finite.len());
    let capacity = if C::YIELD { HARDNESS * finite.len() as f64 } else { f64::INFINITY };
    assert_eq!((found.capacity, found.largest_hardness), (capacity, bound));

    // The shift moves some values exactly onto a bound, where they follow it no further.
    let within = |value: f64| value.clamp(0.0, bound);
    let found = wide::<Shifted, _>((&*t, 0.25, hardness));
    assert_eq!(found[0], sum(n, |i| within(t[i] + 0.25)));
    assert_eq!(found[1], count(n, |i| t[i] + 0.25 > 0.0 && t[i] + 0.25 < bound));

    let mut step = trial.clone();
    let g = single(&eighths(4, n));
    let shifted = |value: f64, h: f64| super::within(value + 0.25, h.min(4.0));
    let found = wide::<Cut, _>((&mut *step, &*p, &*g, 0.25, shifted, hardness));
    let wanted: Vec<f64> = trial.iter().zip(&p).map(|(t, p)| (t + 0.25).clamp(0.0, bound.min(4.0)) - p).collect();
    assert_eq!(step, wanted);
    assert_eq!(found.slope, sum(n, |i| f64::from(g[i]) * wanted[i]));
    assert_eq!(found.square, sum(n, |i| wanted[i] * wanted[i]));
    assert_eq!(found.largest, wanted.iter().fold(0.0, |largest, step| step.abs().max(largest)));
    assert_eq!(found.cut, count(n, |i| trial[i].is_finite() && (trial[i] + 0.25 < 0.0 || trial[i] + 0.25 > bound)));

    let room = |i: usize| match step[i] {
        0.0 => f64::INFINITY,
        step if step > 0.0 => (bound - p[i]) / step,
        step => -p[i] / step,
    };
    assert_eq!(wide::<Room, _>((&*p, &*step, hardness)), (0..n).map(room).fold(f64::INFINITY, f64::min));

    for all in [false, true] {
        let (mut gradient, mut moves) = (vec![0.0; n], vec![0.0; n]);
        wide::<Gradient, _>((&mut *gradient, &mut *moves, [&*p, &*v], [0.5, 2.0], all, hardness));
        for i in 0..n {
            // A cell on a bound moves only away from it.
            let g = v[i] - 0.5;
            let free = (p[i] > 0.0 || g < 0.0) && (p[i] < bound || g > 0.0);
            assert_eq!(f64::from(gradient[i]), if all || free { 2.0 * g } else { 0.0 });
            assert_eq!(moves[i], if all || free { 1.0 } else { 0.0 });
        }
    }

    let mut out = vec![f64::NAN; n];
    let empty = wide::<OnBound<false>, _>((&mut *out, &*p, &*v, hardness));
    assert_eq!(out[..empty], *(0..n).filter(|i| p[*i] == 0.0).map(|i| v[i]).collect::<Vec<_>>());
    let full = wide::<OnBound<true>, _>((&mut *out, &*p, &*v, hardness));
    assert_eq!(out[..full], *(0..n).filter(|i| p[*i] >= bound).map(|i| v[i]).collect::<Vec<_>>());
}

#[test]
fn loops_equal_their_definitions() {
    for n in [1, 15, 16, 37, 1100] {
        check(Unbounded, f64::INFINITY, n);
        check(Yielding(HARDNESS), HARDNESS, n);
        let lists = [eighths(4, n), eighths(5, n), eighths(6, n), eighths(7, n)];
        let moves: Vec<f64> = eighths(8, n).into_iter().map(|z| f64::from(u8::from(z > -0.5))).collect();
        let [g, z, s, w] = &lists;
        let g: Vec<f64> = g.iter().zip(&moves).map(|(g, m)| g * m).collect();
        let of = [&moves, &g, z, s, w].map(|list| single(list));
        let found = wide::<Multiply, _>([&*of[0], &*of[1], &*of[2], &*of[3], &*of[4]]);
        let total = |a: &[f64], b: &[f64]| sum(n, |i| moves[i] * a[i] * b[i]);
        let one = vec![1.0; n];
        let singles = [found.members, found.g, found.z, found.s, found.w];
        assert_eq!(singles, [total(&one, &one), total(&g, &one), total(z, &one), total(s, &one), total(w, &one)]);
        let products = [found.gg, found.gz, found.gs, found.sw, found.zw];
        assert_eq!(products, [total(&g, &g), total(&g, z), total(&g, s), total(s, w), total(z, w)]);

        let found = wide::<Beyond<true>, _>((&**z, 0.25));
        assert_eq!(found, [sum(n, |i| (z[i] - 0.25).max(0.0)), count(n, |i| z[i] > 0.25)]);
        let found = wide::<Beyond<false>, _>((&**z, 0.25));
        assert_eq!(found, [sum(n, |i| (z[i] - 0.25).min(0.0)), count(n, |i| z[i] < 0.25)]);
        assert_eq!(wide::<Largest, _>(&*of[2]), of[2].iter().fold(0.0, |largest, z| z.abs().max(largest)));
        assert_eq!(f64::from(wide::<Below, _>((&*of[2], 0.25))), count(n, |i| z[i] < 0.25));
        let mut far = of[3].clone();
        let below = wide::<Drift, _>((&mut *far, &*of[4], 2.0, 0.25));
        assert!(far.iter().enumerate().all(|(i, far)| f64::from(*far) == s[i] + 2.0 * w[i]));
        assert_eq!(f64::from(below), count(n, |i| s[i] + 2.0 * w[i] < 0.25));
    }
}
