//! The loops over the cells of a slab.

use super::{Direction, Extent, Lists, within};
use crate::contact::projection::may_move;
use crate::wide::Kernel;

/// Cells that are looked at together for whether one of them is near contact.
const GROUP: usize = 8;

/// Adds to `lists` those cells of a row that carry pressure or whose v is below `bound`.
pub(super) struct TakeUp;

impl<'a, H: Fn(usize) -> (f64, f64)> Kernel<(&'a mut Lists, &'a [f64], &'a [f64], f64, H)> for TakeUp {
    type Output = ();

    #[inline(always)]
    fn run((lists, p, v, bound, history): (&'a mut Lists, &'a [f64], &'a [f64], f64, H)) {
        let is_near = |p: f64, v: f64| (p > 0.0) | (v < bound);
        let ((groups_p, rest_p), (groups_v, rest_v)) = (p.as_chunks::<GROUP>(), v.as_chunks::<GROUP>());
        for (group, (p, v)) in groups_p.iter().zip(groups_v).enumerate() {
            let mut count = 0;
            for i in 0..GROUP {
                count += u32::from(is_near(p[i], v[i]));
            }
            let first = group * GROUP;
            if count == GROUP as u32 {
                let (mut step, mut image) = ([0.0; GROUP], [0.0; GROUP]);
                for i in 0..GROUP {
                    (step[i], image[i]) = history(first + i);
                }
                lists.columns.extend_from_slice(&std::array::from_fn::<u32, GROUP, _>(|i| (first + i) as u32));
                lists.p.extend_from_slice(p);
                lists.v.extend_from_slice(v);
                lists.step.extend_from_slice(&step);
                lists.image.extend_from_slice(&image);
            } else if count > 0 {
                for i in (0..GROUP).filter(|i| is_near(p[*i], v[*i])) {
                    lists.push(first + i, p[i], v[i], history(first + i));
                }
            }
        }
        let first = p.len() - rest_p.len();
        for (i, (p, v)) in rest_p.iter().zip(rest_v).enumerate().filter(|(_, (p, v))| is_near(**p, **v)) {
            lists.push(first + i, *p, *v, history(first + i));
        }
    }
}

/// Puts the pressure on trial in a direction into `trial`: see [`Slab::propose`].
pub(super) struct Propose;

impl<'a> Kernel<(&'a mut [f64], [&'a [f64]; 4], Direction, f64, f64, bool)> for Propose {
    type Output = ();

    #[inline(always)]
    fn run(
        (trial, [p, v, s, z], direction, lambda, upper, all): (
            &'a mut [f64],
            [&'a [f64]; 4],
            Direction,
            f64,
            f64,
            bool,
        ),
    ) {
        let Direction { pressure, step, preconditioned, gradient, constant } = direction;
        for ((((t, p), v), s), z) in trial.iter_mut().zip(p).zip(v).zip(s).zip(z) {
            let g = v - lambda;
            let free = p + pressure * p + step * s + preconditioned * z + gradient * g + constant;
            let held = if *p > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
            *t = if all | may_move(*p, g, upper) { free } else { held };
        }
    }
}

/// See [`Extent`]; infinite values do not count.
pub(super) struct Span;

impl<'a> Kernel<&'a [f64]> for Span {
    type Output = Extent;

    #[inline(always)]
    fn run(trial: &'a [f64]) -> Extent {
        const LANES: usize = 8;
        let (mut least, mut largest) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        let mut members = [0.0; LANES];
        let mut count = |lane: usize, t: f64| {
            let moves = t.abs() < f64::INFINITY;
            least[lane] = if moves & (t < least[lane]) { t } else { least[lane] };
            largest[lane] = if moves & (t > largest[lane]) { t } else { largest[lane] };
            members[lane] += if moves { 1.0 } else { 0.0 };
        };
        let (chunks, rest) = trial.as_chunks::<LANES>();
        for chunk in chunks {
            for lane in 0..LANES {
                count(lane, chunk[lane]);
            }
        }
        for t in rest {
            count(0, *t);
        }
        Extent {
            least: least.into_iter().fold(f64::INFINITY, f64::min),
            largest: largest.into_iter().fold(f64::NEG_INFINITY, f64::max),
            members: members.iter().sum::<f64>() as usize,
        }
    }
}

/// Makes `trial` the step from `p` to it, shifted and within the bounds.
pub(super) struct Cut;

impl<'a> Kernel<(&'a mut [f64], &'a [f64], f64, f64)> for Cut {
    type Output = ();

    #[inline(always)]
    fn run((trial, p, shift, upper): (&'a mut [f64], &'a [f64], f64, f64)) {
        trial.iter_mut().zip(p).for_each(|(t, p)| *t = within(*t + shift, upper) - p);
    }
}

/// Adds `length` times a displacement in a unit to `v`.
pub(super) struct Add;

impl<'a> Kernel<(&'a mut [f64], &'a [f32], f64, f64)> for Add {
    type Output = ();

    #[inline(always)]
    fn run((v, values, length, unit_m): (&'a mut [f64], &'a [f32], f64, f64)) {
        v.iter_mut().zip(values).for_each(|(v, value)| *v += length * (unit_m * f64::from(*value)));
    }
}
