//! Loops over the cells of a slab.

use super::hardness::{Hardness, load};
use super::sums::{Advance, Direction, Products, Summary};
use crate::projection::{Extent, may_move, within};
use asperity_base::wide::Kernel;

/// Number of partial sums side by side. With few terms, this many hide the latency of an addition.
const LANES: usize = 16;
const FEW_LANES: usize = 8;
/// Number of chunks that are summed in single precision before they are added in double precision.
const CHUNKS_OF_BLOCK: usize = 64;

// Sums go through the lists chunk by chunk with arrays as accumulators, also of the hardness. The compiler vectorises loops
// of this form, without any branch.

/// Writes a chunk back to a list.
#[inline(always)]
fn store<T: Copy, const L: usize>(list: &mut [T], chunk: usize, values: [T; L]) {
    let (chunks, rest) = list.as_chunks_mut::<L>();
    if let Some(chunk) = chunks.get_mut(chunk) {
        *chunk = values;
    } else {
        rest.copy_from_slice(&values[..rest.len()]);
    }
}

/// Adds a multiple of the displacements of a row to `far`, and counts the values below `bound` afterwards.
pub(super) struct Drift;

impl<'a> Kernel<(&'a mut [f32], &'a [f32], f32, f32)> for Drift {
    type Output = u32;

    #[inline(always)]
    fn run((far, values, factor, bound): (&'a mut [f32], &'a [f32], f32, f32)) -> u32 {
        let mut below = [0_u32; LANES];
        let ((far, rest), (values, rest_of_values)) = (far.as_chunks_mut::<LANES>(), values.as_chunks::<LANES>());
        for (far, values) in far.iter_mut().zip(values) {
            for lane in 0..LANES {
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

/// Counts the values below a bound.
pub(super) struct Below;

impl<'a> Kernel<(&'a [f32], f32)> for Below {
    type Output = u32;

    #[inline(always)]
    fn run((far, bound): (&'a [f32], f32)) -> u32 {
        far.iter().map(|far| u32::from(*far < bound)).sum()
    }
}

/// Applies a step, see [`Slab::advance`](super::Slab::advance), and returns whether a pressure changed.
pub(super) struct Go;

impl<'a, C: Hardness> Kernel<(&'a mut [f64], &'a mut [f64], &'a mut [f32], [&'a [f64]; 1], &'a [f32], Advance, C)>
    for Go
{
    type Output = bool;

    #[inline(always)]
    fn run(
        (p, v, step, [trial], image, advance, hardness): (
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
        let (v, step, trial, image) = (&mut v[..n], &mut step[..n], &trial[..n], &image[..n]);
        let h = hardness.pa();
        let (along, factor) = (length * unit_m, 1.0 / unit_pa);
        let mut moved = 0_u64;
        for i in 0..n {
            v[i] += along * f64::from(image[i]);
            let before = p[i];
            // The step was computed as (bound − p), so a whole step reaches the bound up to rounding.
            let lands = (length >= 1.0) & (trial[i] == h - before);
            let after = within(before + length * trial[i], h);
            let after = if lands { h } else { after };
            moved |= after.to_bits() ^ before.to_bits();
            p[i] = after;
            step[i] = (factor * trial[i]) as f32;
        }
        moved != 0
    }
}

/// Computes a [`Summary`]; cells with v below `bound` are near contact.
pub(super) struct Summarise;

impl<'a, C: Hardness> Kernel<(&'a [f64], &'a [f64], f64, C)> for Summarise {
    type Output = Summary;

    #[inline(always)]
    fn run((p, v, bound, hardness): (&'a [f64], &'a [f64], f64, C)) -> Summary {
        const L: usize = LANES;
        let (mut pressure, mut free, mut free_v) = ([0.0; L], [0.0; L], [0.0; L]);
        let (mut between_v, mut between, mut idle, mut least) = ([0.0; L], [0.0; L], [0.0; L], [f64::INFINITY; L]);
        for chunk in 0..p.len().div_ceil(L) {
            let (p, v, h): ([f64; L], [f64; L], [f64; L]) =
                (load(p, chunk, 0.0), load(v, chunk, f64::MAX), hardness.lanes());
            for i in 0..L {
                let below = !C::YIELD || p[i] < h[i];
                let own = if below { p[i] } else { 0.0 };
                let one = if own > 0.0 { 1.0 } else { 0.0 };
                if C::YIELD {
                    pressure[i] += p[i];
                }
                free[i] += own;
                free_v[i] += own * v[i];
                between_v[i] += one * v[i];
                between[i] += one;
                // Beyond the end of the list v is the largest number.
                idle[i] += if (p[i] <= 0.0) & (v[i] >= bound) & (v[i] < f64::MAX) { 1.0 } else { 0.0 };
                let own = if below { v[i] } else { f64::INFINITY };
                least[i] = if own < least[i] { own } else { least[i] };
            }
        }
        let sum = |lanes: [f64; L]| lanes.iter().sum::<f64>();
        let free = sum(free);
        let least_v = least.into_iter().fold(f64::INFINITY, f64::min);
        Summary {
            pressure: if C::YIELD { sum(pressure) } else { free },
            free,
            free_v: sum(free_v),
            between_v: sum(between_v),
            between: sum(between),
            idle: sum(idle),
            least_v: if least_v < f64::MAX { least_v } else { f64::INFINITY },
            ..Summary::default()
        }
    }
}

/// Returns the sum of v − λ over the v below λ, or above it, and their number.
pub(super) struct Beyond<const ABOVE: bool>;

impl<'a, const ABOVE: bool> Kernel<(&'a [f64], f64)> for Beyond<ABOVE> {
    type Output = [f64; 2];

    #[inline(always)]
    fn run((list, lambda): (&'a [f64], f64)) -> [f64; 2] {
        let (mut sums, mut count) = ([0.0; LANES], [0.0; LANES]);
        for chunk in 0..list.len().div_ceil(LANES) {
            let v: [f64; LANES] = load(list, chunk, lambda);
            for i in 0..LANES {
                let g = v[i] - lambda;
                let counts = if ABOVE { g > 0.0 } else { g < 0.0 };
                sums[i] += if counts { g } else { 0.0 };
                count[i] += if counts { 1.0 } else { 0.0 };
            }
        }
        [sums.iter().sum(), count.iter().sum()]
    }
}

/// Moves the v of the cells on a bound to the front of `out`, which is as long as v, and returns their number.
pub(super) struct OnBound<const FULL: bool>;

impl<'a, C: Hardness, const FULL: bool> Kernel<(&'a mut [f64], &'a [f64], &'a [f64], C)> for OnBound<FULL> {
    type Output = usize;

    #[inline(always)]
    fn run((out, p, v, hardness): (&'a mut [f64], &'a [f64], &'a [f64], C)) -> usize {
        let mut count = 0;
        for (p, v) in p.iter().zip(v) {
            if let Some(out) = out.get_mut(count) {
                *out = *v;
            }
            count += usize::from(if FULL { *p >= hardness.pa() } else { *p <= 0.0 });
        }
        count
    }
}

/// Computes the gradient v − λ, over a unit, of the cells that may move, or of all, zero elsewhere; and 1 for these
/// cells, 0 elsewhere.
pub(super) struct Gradient;

impl<'a, C: Hardness> Kernel<(&'a mut [f32], &'a mut [f32], [&'a [f64]; 2], [f64; 2], bool, C)> for Gradient {
    type Output = ();

    #[inline(always)]
    fn run(
        (gradient, moves, [p, v], [lambda, factor], all, hardness): (
            &'a mut [f32],
            &'a mut [f32],
            [&'a [f64]; 2],
            [f64; 2],
            bool,
            C,
        ),
    ) {
        let n = p.len();
        let (gradient, moves, v) = (&mut gradient[..n], &mut moves[..n], &v[..n]);
        for i in 0..n {
            let g = v[i] - lambda;
            let member = all | may_move(p[i], g, hardness.pa());
            gradient[i] = if member { (factor * g) as f32 } else { 0.0 };
            moves[i] = if member { 1.0 } else { 0.0 };
        }
    }
}

/// Sums products of gradient, preconditioned gradient, step and image, over their units, for the cells that may move.
pub(super) struct Multiply;

impl<'a> Kernel<[&'a [f32]; 5]> for Multiply {
    type Output = Products;

    #[inline(always)]
    fn run(lists: [&'a [f32]; 5]) -> Products {
        const L: usize = FEW_LANES;
        const TERMS: usize = 10;
        let chunks = lists[0].len().div_ceil(L);
        let mut totals = [0.0_f64; TERMS];
        let mut first = 0;
        while first < chunks {
            let last = (first + CHUNKS_OF_BLOCK).min(chunks);
            let [mut members, mut g1, mut z1, mut s1, mut w1] = [[0.0_f32; L]; 5];
            let [mut gg, mut gz, mut gs, mut sw, mut zw] = [[0.0_f32; L]; 5];
            for chunk in first..last {
                // Each list is loaded separately: the closure of a map over the lists would not be inlined.
                let moves: [f32; L] = load(lists[0], chunk, 0.0);
                let gradient: [f32; L] = load(lists[1], chunk, 0.0);
                let preconditioned: [f32; L] = load(lists[2], chunk, 0.0);
                let step: [f32; L] = load(lists[3], chunk, 0.0);
                let image: [f32; L] = load(lists[4], chunk, 0.0);
                for i in 0..L {
                    let (m, g) = (moves[i], gradient[i]);
                    let (z, s, w) = (m * preconditioned[i], m * step[i], m * image[i]);
                    members[i] += m;
                    g1[i] += g;
                    z1[i] += z;
                    s1[i] += s;
                    w1[i] += w;
                    gg[i] += g * g;
                    gz[i] += g * z;
                    gs[i] += g * s;
                    sw[i] += s * w;
                    zw[i] += z * w;
                }
            }
            let sums = [members, g1, z1, s1, w1, gg, gz, gs, sw, zw];
            for (total, lanes) in totals.iter_mut().zip(sums) {
                *total += lanes.iter().map(|sum| f64::from(*sum)).sum::<f64>();
            }
            first = last;
        }
        let [members, g, z, s, w, gg, gz, gs, sw, zw] = totals;
        Products { members, g, z, s, w, gg, gz, gs, sw, zw }
    }
}

/// Writes the trial pressure in a direction into `trial`; see [`Slab::propose`](super::Slab::propose).
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
            let fixed = if before > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
            trial[i] = if moves[i] > 0.0 { free } else { fixed };
        }
    }
}

/// Computes an [`Extent`]; infinite values do not count.
pub(super) struct Span;

impl<'a, C: Hardness> Kernel<(&'a [f64], C)> for Span {
    type Output = Extent;

    #[inline(always)]
    fn run((trial, hardness): (&'a [f64], C)) -> Extent {
        const L: usize = LANES;
        let (mut least, mut largest, mut members) = ([f64::INFINITY; L], [f64::NEG_INFINITY; L], [0.0; L]);
        let (mut capacity, mut largest_hardness) = ([0.0; L], [0.0; L]);
        for chunk in 0..trial.len().div_ceil(L) {
            let (t, h): ([f64; L], [f64; L]) = (load(trial, chunk, f64::INFINITY), hardness.lanes());
            for i in 0..L {
                let moves = t[i].abs() < f64::INFINITY;
                let (low, high) = if moves { (t[i], t[i]) } else { (f64::INFINITY, f64::NEG_INFINITY) };
                least[i] = if low < least[i] { low } else { least[i] };
                largest[i] = if high > largest[i] { high } else { largest[i] };
                members[i] += if moves { 1.0 } else { 0.0 };
                if C::YIELD {
                    let own = if moves { h[i] } else { 0.0 };
                    capacity[i] += own;
                    largest_hardness[i] = if own > largest_hardness[i] { own } else { largest_hardness[i] };
                }
            }
        }
        Extent {
            least: least.into_iter().fold(f64::INFINITY, f64::min),
            largest: largest.into_iter().fold(f64::NEG_INFINITY, f64::max),
            members: members.iter().sum::<f64>() as usize,
            capacity: if C::YIELD { capacity.iter().sum() } else { f64::INFINITY },
            largest_hardness: if C::YIELD { largest_hardness.into_iter().fold(0.0, f64::max) } else { f64::INFINITY },
        }
    }
}

/// Returns the sum of the trial values, shifted and within the bounds, and the number of cells that follow a shift.
pub(super) struct Shifted;

impl<'a, C: Hardness> Kernel<(&'a [f64], f64, C)> for Shifted {
    type Output = [f64; 2];

    #[inline(always)]
    fn run((trial, shift, hardness): (&'a [f64], f64, C)) -> [f64; 2] {
        const L: usize = LANES;
        let (mut sums, mut follow) = ([0.0; L], [0.0; L]);
        for chunk in 0..trial.len().div_ceil(L) {
            let (t, h): ([f64; L], [f64; L]) = (load(trial, chunk, f64::NEG_INFINITY), hardness.lanes());
            for i in 0..L {
                let value = t[i] + shift;
                sums[i] += within(value, h[i]);
                follow[i] += if (value > 0.0) & (value < h[i]) { 1.0 } else { 0.0 };
            }
        }
        [sums.iter().sum(), follow.iter().sum()]
    }
}

/// Properties of a step, computed by [`Cut`]: the slope over the gradient's unit, the squared norm, the largest size,
/// and the number of clipped cells.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Step {
    pub(crate) slope: f64,
    pub(crate) square: f64,
    pub(crate) largest: f64,
    pub(crate) cut: f64,
}

impl Step {
    /// Combines the properties for two sets of cells.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            slope: self.slope + other.slope,
            square: self.square + other.square,
            largest: self.largest.max(other.largest),
            cut: self.cut + other.cut,
        }
    }
}

/// Replaces `trial` by the step from `p` to the trial value that `shifted` moves within the bounds.
pub(super) struct Cut;

impl<'a, C: Hardness, F: Fn(f64, f64) -> f64> Kernel<(&'a mut [f64], &'a [f64], &'a [f32], f64, F, C)> for Cut {
    type Output = Step;

    #[inline(always)]
    fn run((trial, p, gradient, shift, shifted, hardness): (&'a mut [f64], &'a [f64], &'a [f32], f64, F, C)) -> Step {
        const L: usize = LANES;
        let (mut slope, mut square, mut cut, mut largest) = ([0.0; L], [0.0; L], [0.0; L], [0.0; L]);
        for chunk in 0..trial.len().div_ceil(L) {
            let mut t: [f64; L] = load(trial, chunk, f64::NEG_INFINITY);
            let (p, g): ([f64; L], [f32; L]) = (load(p, chunk, 0.0), load(gradient, chunk, 0.0));
            let h: [f64; L] = hardness.lanes();
            for i in 0..L {
                let value = t[i] + shift;
                let outside = (t[i].abs() < f64::INFINITY) & ((value < 0.0) | (value > h[i]));
                let step = shifted(t[i], h[i]) - p[i];
                slope[i] += f64::from(g[i]) * step;
                square[i] += step * step;
                cut[i] += if outside { 1.0 } else { 0.0 };
                largest[i] = if step.abs() > largest[i] { step.abs() } else { largest[i] };
                t[i] = step;
            }
            store(trial, chunk, t);
        }
        let sum = |lanes: [f64; L]| lanes.iter().sum::<f64>();
        let largest = largest.into_iter().fold(0.0, f64::max);
        Step { slope: sum(slope), square: sum(square), largest, cut: sum(cut) }
    }
}

/// Returns the largest multiple of the step from `p` that stays within the bounds.
pub(super) struct Room;

impl<'a, C: Hardness> Kernel<(&'a [f64], &'a [f64], C)> for Room {
    type Output = f64;

    #[inline(always)]
    fn run((p, step, hardness): (&'a [f64], &'a [f64], C)) -> f64 {
        const L: usize = LANES;
        let mut least = [f64::INFINITY; L];
        for chunk in 0..p.len().div_ceil(L) {
            let (p, step): ([f64; L], [f64; L]) = (load(p, chunk, 0.0), load(step, chunk, 0.0));
            let h: [f64; L] = hardness.lanes();
            for i in 0..L {
                let way = if step[i] > 0.0 { h[i] - p[i] } else { p[i] };
                let room = if step[i] == 0.0 { f64::INFINITY } else { way / step[i].abs() };
                least[i] = if room < least[i] { room } else { least[i] };
            }
        }
        least.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Returns the largest absolute value.
pub(super) struct Largest;

impl<'a> Kernel<&'a [f32]> for Largest {
    type Output = f32;

    #[inline(always)]
    fn run(values: &'a [f32]) -> f32 {
        let mut largest = [0.0_f32; LANES];
        for chunk in 0..values.len().div_ceil(LANES) {
            let values: [f32; LANES] = load(values, chunk, 0.0);
            for i in 0..LANES {
                largest[i] = if values[i].abs() > largest[i] { values[i].abs() } else { largest[i] };
            }
        }
        largest.into_iter().fold(0.0, f32::max)
    }
}

#[cfg(test)]
mod tests;
