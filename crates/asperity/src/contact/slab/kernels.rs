//! The loops over the cells of a slab.

use super::{Advance, Caps, Direction, Extent, Products, Summary, within};
use crate::contact::projection::may_move;
use crate::wide::Kernel;

/// Partial sums kept side by side.
const LANES: usize = 8;
/// Chunks of cells that are summed in single precision before they are added in double.
const CHUNKS_OF_BLOCK: usize = 64;

/// Adds to `far` a multiple of the displacements of a row, and counts what is below `bound` then.
pub(super) struct Drift;

impl<'a> Kernel<(&'a mut [f32], &'a [f32], f32, f32)> for Drift {
    type Output = u32;

    #[inline(always)]
    fn run((far, values, factor, bound): (&'a mut [f32], &'a [f32], f32, f32)) -> u32 {
        let mut below = [0_u32; 2 * LANES];
        let ((far, rest), (values, rest_of_values)) =
            (far.as_chunks_mut::<{ 2 * LANES }>(), values.as_chunks::<{ 2 * LANES }>());
        for (far, values) in far.iter_mut().zip(values) {
            for lane in 0..2 * LANES {
                far[lane] += factor * values[lane];
                below[lane] += u32::from(far[lane] < bound);
            }
        }
        for (far, value) in rest.iter_mut().zip(rest_of_values) {
            *far += factor * value;
            below[0] += u32::from(*far < bound);
        }
        below.iter().sum()
    }
}

/// Counts what is below a bound.
pub(super) struct Below;

impl<'a> Kernel<(&'a [f32], f32)> for Below {
    type Output = u32;

    #[inline(always)]
    fn run((far, bound): (&'a [f32], f32)) -> u32 {
        far.iter().map(|far| u32::from(*far < bound)).sum()
    }
}

/// Goes a step: see [`Slab::advance`](super::Slab::advance). Whether a pressure changed.
pub(super) struct Go;

impl<'a, C: Caps> Kernel<(&'a mut [f64], &'a mut [f64], &'a mut [f32], [&'a [f64]; 1], &'a [f32], Advance, C)> for Go {
    type Output = bool;

    #[inline(always)]
    fn run(
        (p, v, step, [trial], image, advance, caps): (
            &'a mut [f64],
            &'a mut [f64],
            &'a mut [f32],
            [&'a [f64]; 1],
            &'a [f32],
            Advance,
            C,
        ),
    ) -> bool {
        let Advance { length, unit_pa, unit_m, .. } = advance;
        let n = p.len();
        let (v, step, trial, image, caps) = (&mut v[..n], &mut step[..n], &trial[..n], &image[..n], caps.head(n));
        let (along, factor) = (length * unit_m, 1.0 / unit_pa);
        let mut moved = 0_u64;
        for i in 0..n {
            v[i] += along * f64::from(image[i]);
            let (before, upper) = (p[i], caps.at(i));
            // The step was formed as (bound − p), so that a whole one lands on the bound up to rounding.
            let lands = (length >= 1.0) & (trial[i] == upper - before);
            let after = within(before + length * trial[i], upper);
            let after = if lands { upper } else { after };
            moved |= after.to_bits() ^ before.to_bits();
            p[i] = after;
            step[i] = (factor * trial[i]) as f32;
        }
        moved != 0
    }
}

/// See [`Summary`]; `bound` is that of cells near contact.
pub(super) struct Summarise;

impl<'a, C: Caps> Kernel<(&'a [f64], &'a [f64], f64, C)> for Summarise {
    type Output = Summary;

    #[inline(always)]
    fn run((p, v, bound, caps): (&'a [f64], &'a [f64], f64, C)) -> Summary {
        let n = p.len();
        let (v, caps) = (&v[..n], caps.head(n));
        let mut sums = [[0.0; LANES]; 6];
        let mut least = [f64::INFINITY; LANES];
        let mut add = |lane: usize, p: f64, v: f64, upper: f64| {
            let (below, loaded) = (p < upper, p > 0.0);
            let free = if below { p } else { 0.0 };
            let between = below & loaded;
            sums[0][lane] += p;
            sums[1][lane] += free;
            sums[2][lane] += free * v;
            sums[3][lane] += if between { v } else { 0.0 };
            sums[4][lane] += if between { 1.0 } else { 0.0 };
            sums[5][lane] += if !loaded & (v >= bound) { 1.0 } else { 0.0 };
            least[lane] = if below & (v < least[lane]) { v } else { least[lane] };
        };
        for chunk in 0..n / LANES {
            for lane in 0..LANES {
                let i = chunk * LANES + lane;
                add(lane, p[i], v[i], caps.at(i));
            }
        }
        for i in n - n % LANES..n {
            add(i % LANES, p[i], v[i], caps.at(i));
        }
        let [pressure, free, free_v, between_v, between, idle] = sums.map(|lanes| lanes.iter().sum());
        let least_v = least.into_iter().fold(f64::INFINITY, f64::min);
        Summary { pressure, free, free_v, between_v, between, idle, least_v, ..Summary::default() }
    }
}

/// Moves the v of those cells on a bound to the front of `out`, which is as long as v, and returns how many they are.
pub(super) struct OnBound<const FULL: bool>;

impl<'a, C: Caps, const FULL: bool> Kernel<(&'a mut [f64], &'a [f64], &'a [f64], C)> for OnBound<FULL> {
    type Output = usize;

    #[inline(always)]
    fn run((out, p, v, caps): (&'a mut [f64], &'a [f64], &'a [f64], C)) -> usize {
        let mut count = 0;
        for (i, (p, v)) in p.iter().zip(v).enumerate() {
            if let Some(out) = out.get_mut(count) {
                *out = *v;
            }
            count += usize::from(if FULL { *p >= caps.at(i) } else { *p <= 0.0 });
        }
        count
    }
}

/// The gradient v − λ over a unit of the cells that may move, or of all, zero elsewhere; and 1 for these cells, 0 elsewhere.
pub(super) struct Gradient;

impl<'a, C: Caps> Kernel<(&'a mut [f32], &'a mut [f32], [&'a [f64]; 2], [f64; 2], bool, C)> for Gradient {
    type Output = ();

    #[inline(always)]
    fn run(
        (gradient, moves, [p, v], [lambda, factor], all, caps): (
            &'a mut [f32],
            &'a mut [f32],
            [&'a [f64]; 2],
            [f64; 2],
            bool,
            C,
        ),
    ) {
        let n = p.len();
        let (gradient, moves, v, caps) = (&mut gradient[..n], &mut moves[..n], &v[..n], caps.head(n));
        for i in 0..n {
            let g = v[i] - lambda;
            let member = all | may_move(p[i], g, caps.at(i));
            gradient[i] = if member { (factor * g) as f32 } else { 0.0 };
            moves[i] = if member { 1.0 } else { 0.0 };
        }
    }
}

/// Sums over the cells that may move, of gradient, preconditioned gradient, step and image over their units.
pub(super) struct Multiply;

impl<'a> Kernel<[&'a [f32]; 5]> for Multiply {
    type Output = Products;

    #[inline(always)]
    fn run([moves, gradient, preconditioned, step, image]: [&'a [f32]; 5]) -> Products {
        const TERMS: usize = 10;
        let n = moves.len();
        let lists = [moves, &gradient[..n], &preconditioned[..n], &step[..n], &image[..n]];
        let mut totals = [0.0_f64; TERMS];
        let term = |[m, g, z, s, w]: [f32; 5]| {
            let (z, s, w) = (m * z, m * s, m * w);
            [m, g, z, s, w, g * g, g * z, g * s, s * w, z * w]
        };
        let chunks = n / LANES;
        let mut first = 0;
        while first < chunks {
            let last = (first + CHUNKS_OF_BLOCK).min(chunks);
            let mut lanes = [[0.0_f32; LANES]; TERMS];
            for chunk in first..last {
                let heads = lists.map(|list| &list[chunk * LANES..][..LANES]);
                for lane in 0..LANES {
                    let terms = term(heads.map(|head| head[lane]));
                    for k in 0..TERMS {
                        lanes[k][lane] += terms[k];
                    }
                }
            }
            for k in 0..TERMS {
                totals[k] += lanes[k].iter().map(|sum| f64::from(*sum)).sum::<f64>();
            }
            first = last;
        }
        for i in chunks * LANES..n {
            let terms = term(lists.map(|list| list[i]));
            for k in 0..TERMS {
                totals[k] += f64::from(terms[k]);
            }
        }
        let [members, g, z, s, w, gg, gz, gs, sw, zw] = totals;
        Products { members, g, z, s, w, gg, gz, gs, sw, zw }
    }
}

/// Puts the pressure on trial in a direction into `trial`: see [`Slab::propose`](super::Slab::propose).
pub(super) struct Propose;

impl<'a> Kernel<(&'a mut [f64], &'a [f64], [&'a [f32]; 4], Direction)> for Propose {
    type Output = ();

    #[inline(always)]
    fn run(
        (trial, p, [moves, gradient, preconditioned, step], direction): (
            &'a mut [f64],
            &'a [f64],
            [&'a [f32]; 4],
            Direction,
        ),
    ) {
        let n = trial.len();
        let (p, moves, g, z, s) = (&p[..n], &moves[..n], &gradient[..n], &preconditioned[..n], &step[..n]);
        let Direction { pressure, step, preconditioned, gradient, constant } = direction;
        for i in 0..n {
            let before = p[i];
            let way = step * f64::from(s[i]) + preconditioned * f64::from(z[i]) + gradient * f64::from(g[i]);
            let free = before + pressure * before + way + constant;
            let held = if before > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
            trial[i] = if moves[i] > 0.0 { free } else { held };
        }
    }
}

/// See [`Extent`]; infinite values do not count.
pub(super) struct Span;

impl<'a, C: Caps> Kernel<(&'a [f64], C)> for Span {
    type Output = Extent;

    #[inline(always)]
    fn run((trial, caps): (&'a [f64], C)) -> Extent {
        let n = trial.len();
        let caps = caps.head(n);
        let (mut least, mut largest) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        let (mut members, mut capacity, mut ceiling) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut count = |lane: usize, t: f64, upper: f64| {
            let moves = t.abs() < f64::INFINITY;
            least[lane] = if moves & (t < least[lane]) { t } else { least[lane] };
            largest[lane] = if moves & (t > largest[lane]) { t } else { largest[lane] };
            members[lane] += if moves { 1.0 } else { 0.0 };
            if C::YIELD {
                capacity[lane] += if moves { upper } else { 0.0 };
                ceiling[lane] = if moves & (upper > ceiling[lane]) { upper } else { ceiling[lane] };
            }
        };
        for chunk in 0..n / LANES {
            for lane in 0..LANES {
                let i = chunk * LANES + lane;
                count(lane, trial[i], caps.at(i));
            }
        }
        for i in n - n % LANES..n {
            count(i % LANES, trial[i], caps.at(i));
        }
        Extent {
            least: least.into_iter().fold(f64::INFINITY, f64::min),
            largest: largest.into_iter().fold(f64::NEG_INFINITY, f64::max),
            members: members.iter().sum::<f64>() as usize,
            capacity: if C::YIELD { capacity.iter().sum() } else { f64::INFINITY },
            ceiling: if C::YIELD { ceiling.into_iter().fold(0.0, f64::max) } else { f64::INFINITY },
        }
    }
}

/// Sum of trial values, shifted and within the bounds, and the number of them that follow a shift.
pub(super) struct Shifted;

impl<'a, C: Caps> Kernel<(&'a [f64], f64, C)> for Shifted {
    type Output = [f64; 2];

    #[inline(always)]
    fn run((trial, shift, caps): (&'a [f64], f64, C)) -> [f64; 2] {
        let n = trial.len();
        let caps = caps.head(n);
        let (mut sums, mut follow) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
        let mut add = |lane: usize, t: f64, upper: f64| {
            let value = t + shift;
            sums[lane] += within(value, upper);
            follow[lane] += if (value > 0.0) & (value < upper) { 1.0 } else { 0.0 };
        };
        for chunk in 0..n / (2 * LANES) {
            for lane in 0..2 * LANES {
                let i = chunk * 2 * LANES + lane;
                add(lane, trial[i], caps.at(i));
            }
        }
        for i in n - n % (2 * LANES)..n {
            add(i % (2 * LANES), trial[i], caps.at(i));
        }
        [sums.iter().sum(), follow.iter().sum()]
    }
}

/// What [`Cut`] finds: the slope over the gradient's unit, the squared norm and the largest size of the step, and the number
/// of cells that a bound cut.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::contact) struct Step {
    pub(in crate::contact) slope: f64,
    pub(in crate::contact) square: f64,
    pub(in crate::contact) largest: f64,
    pub(in crate::contact) cut: f64,
}

impl Step {
    /// That of more cells.
    pub(in crate::contact) fn with(self, other: Self) -> Self {
        Self {
            slope: self.slope + other.slope,
            square: self.square + other.square,
            largest: self.largest.max(other.largest),
            cut: self.cut + other.cut,
        }
    }
}

/// Makes `trial` the step from `p` to what `shifted` makes of it within the bounds.
pub(super) struct Cut;

impl<'a, C: Caps, F: Fn(f64, f64) -> f64> Kernel<(&'a mut [f64], &'a [f64], &'a [f32], f64, F, C)> for Cut {
    type Output = Step;

    #[inline(always)]
    fn run(
        (trial, p, gradient, shift, shifted, caps): (&'a mut [f64], &'a [f64], &'a [f32], f64, F, C),
    ) -> Step {
        let n = trial.len();
        let (p, gradient, caps) = (&p[..n], &gradient[..n], caps.head(n));
        let mut sums = [[0.0; LANES]; 3];
        let mut largest = [0.0; LANES];
        let mut cut = |lane: usize, t: &mut f64, p: f64, g: f32, upper: f64| {
            let value = *t + shift;
            let outside = (t.abs() < f64::INFINITY) & ((value < 0.0) | (value > upper));
            let step = shifted(*t, upper) - p;
            sums[0][lane] += f64::from(g) * step;
            sums[1][lane] += step * step;
            sums[2][lane] += if outside { 1.0 } else { 0.0 };
            largest[lane] = if step.abs() > largest[lane] { step.abs() } else { largest[lane] };
            *t = step;
        };
        for chunk in 0..n / LANES {
            for lane in 0..LANES {
                let i = chunk * LANES + lane;
                cut(lane, &mut trial[i], p[i], gradient[i], caps.at(i));
            }
        }
        for i in n - n % LANES..n {
            cut(i % LANES, &mut trial[i], p[i], gradient[i], caps.at(i));
        }
        let [slope, square, cut] = sums.map(|lanes| lanes.iter().sum());
        Step { slope, square, largest: largest.into_iter().fold(0.0, f64::max), cut }
    }
}

/// The largest size of a value.
pub(super) struct Largest;

impl<'a> Kernel<&'a [f32]> for Largest {
    type Output = f32;

    #[inline(always)]
    fn run(values: &'a [f32]) -> f32 {
        let mut lanes = [0.0_f32; 2 * LANES];
        let (chunks, rest) = values.as_chunks::<{ 2 * LANES }>();
        for chunk in chunks {
            for lane in 0..2 * LANES {
                lanes[lane] = if chunk[lane].abs() > lanes[lane] { chunk[lane].abs() } else { lanes[lane] };
            }
        }
        rest.iter().chain(&lanes).fold(0.0, |largest: f32, value| largest.max(value.abs()))
    }
}
