//! Cells near contact, slab of rows by slab of rows.
//!
//! Most cells of a rough contact are out of contact and stay so. What concerns the others is kept in lists over them alone,
//! one set for each slab of [`ROWS_OF_SLAB`] rows, so that slabs can be shared among threads; sums are added slab by slab in
//! order, whoever made them.

mod kernels;

use std::ops::Range;

use rayon::prelude::*;

use self::kernels::{Add, Cut, Propose, Span, TakeUp};
use crate::contact::projection::{Shift, may_move};
use crate::contact::vectors::{least, sums, sums_of};
use crate::fourier::ROWS_OF_SLAB;
use crate::wide::wide;

/// Cells of a grid from which its slabs are worth sharing among threads.
const SHARED_FROM: usize = 1 << 16;

/// The cells of a slab that carry pressure or may soon do, in row order.
#[derive(Debug, Clone, Default)]
pub(super) struct Slab {
    /// Where the cells of a row begin in the lists, with the end of the last row.
    starts: [u32; ROWS_OF_SLAB + 1],
    columns: Vec<u32>,
    /// Pressure.
    pub(super) p: Vec<f64>,
    /// S p − z.
    pub(super) v: Vec<f64>,
    /// The last step and its image under S; zero for cells that were not near contact then.
    pub(super) step: Vec<f64>,
    pub(super) image: Vec<f64>,
    /// The preconditioned gradient.
    pub(super) preconditioned: Vec<f64>,
    /// The pressure on trial, not yet within the bounds; for cells that may not move an infinity beyond the bound that they
    /// are on. After [`Slab::restrict`] the step to it.
    pub(super) trial: Vec<f64>,
    /// Of the cells on the lower and on the upper bound: v.
    open: Vec<f64>,
    full: Vec<f64>,
    /// Sum of v over the cells between the bounds, and their number.
    between: [f64; 2],
    /// The next lists, in the making.
    next: Lists,
    /// Scratch: the step in a row of the grid.
    row: Vec<f64>,
}

/// Lists in the making.
#[derive(Debug, Clone, Default)]
struct Lists {
    starts: [u32; ROWS_OF_SLAB + 1],
    columns: Vec<u32>,
    p: Vec<f64>,
    v: Vec<f64>,
    step: Vec<f64>,
    image: Vec<f64>,
}

impl Lists {
    fn clear(&mut self) {
        self.starts = [0; ROWS_OF_SLAB + 1];
        self.columns.clear();
        for list in [&mut self.p, &mut self.v, &mut self.step, &mut self.image] {
            list.clear();
        }
    }

    fn push(&mut self, column: usize, p: f64, v: f64, (step, image): (f64, f64)) {
        self.columns.push(column as u32);
        self.p.push(p);
        self.v.push(v);
        self.step.push(step);
        self.image.push(image);
    }

    /// Takes up those cells of a row that carry pressure or whose v is below `bound`, with their step and its image.
    fn take_up(&mut self, row: usize, p: &[f64], v: &[f64], bound: f64, history: impl Fn(usize) -> (f64, f64)) {
        wide::<TakeUp, _>((self, p, v, bound, history));
        self.starts[row + 1..].fill(self.columns.len() as u32);
    }
}

/// Sums over the cells that may move: their number, and products of pressure p, gradient g, preconditioned gradient z, last
/// step s and its image w.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Products {
    pub(super) members: f64,
    pub(super) g: f64,
    pub(super) z: f64,
    pub(super) s: f64,
    pub(super) w: f64,
    pub(super) gg: f64,
    pub(super) gz: f64,
    pub(super) gs: f64,
    pub(super) sw: f64,
    pub(super) zw: f64,
    pub(super) pw: f64,
    pub(super) pg: f64,
    /// All cells near contact that are at the upper bound.
    pub(super) at_upper: f64,
}

impl Products {
    /// The sums over more cells.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            members: self.members + other.members,
            g: self.g + other.g,
            z: self.z + other.z,
            s: self.s + other.s,
            w: self.w + other.w,
            gg: self.gg + other.gg,
            gz: self.gz + other.gz,
            gs: self.gs + other.gs,
            sw: self.sw + other.sw,
            zw: self.zw + other.zw,
            pw: self.pw + other.pw,
            pg: self.pg + other.pg,
            at_upper: self.at_upper + other.at_upper,
        }
    }
}

/// The trial p + `pressure`·p + `step`·s + `preconditioned`·z + `gradient`·g + `constant`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Direction {
    pub(super) pressure: f64,
    pub(super) step: f64,
    pub(super) preconditioned: f64,
    pub(super) gradient: f64,
    pub(super) constant: f64,
}

/// A trial before it is brought within the bounds: over the cells that may move.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) least: f64,
    pub(super) largest: f64,
    pub(super) members: usize,
}

impl Extent {
    pub(super) const NONE: Self = Self { least: f64::INFINITY, largest: f64::NEG_INFINITY, members: 0 };

    /// That of more cells.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            largest: self.largest.max(other.largest),
            members: self.members + other.members,
        }
    }
}

/// Where the rows of a slab end up after a step.
pub(super) struct Rows<'s> {
    pub(super) slab: &'s mut Slab,
    pub(super) p: &'s mut [f64],
    pub(super) v: &'s mut [f64],
    pub(super) moved: bool,
}

impl Slab {
    /// Where the cells of a row of the grid stand in the lists.
    fn cells(&self, row: usize) -> Range<usize> {
        let row = row % ROWS_OF_SLAB;
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    /// Replaces the lists by those in the making.
    fn turn(&mut self) {
        let Self { starts, columns, p, v, step, image, next, .. } = self;
        *starts = next.starts;
        std::mem::swap(columns, &mut next.columns);
        std::mem::swap(p, &mut next.p);
        std::mem::swap(v, &mut next.v);
        std::mem::swap(step, &mut next.step);
        std::mem::swap(image, &mut next.image);
    }

    /// Looks for the cells near contact among all: those with pressure, and those whose v is below `bound`.
    fn look(&mut self, p: &[f64], v: &[f64], bound: f64) {
        self.next.clear();
        let width = self.row.len();
        for (row, (p, v)) in p.chunks_exact(width).zip(v.chunks_exact(width)).enumerate() {
            let known = self.cells(row);
            let Self { columns, step, image, next, .. } = self;
            next.take_up(row, p, v, bound, |column| {
                let found = columns[known.clone()].binary_search(&(column as u32));
                found.map_or((0.0, 0.0), |i| (step[known.start + i], image[known.start + i]))
            });
        }
        self.turn();
    }

    /// Sorts the cells by the bound they are on, for [`Slab::tangent_sums`].
    pub(super) fn sort_by_bound(&mut self, upper: f64) {
        let Self { p, v, open, full, .. } = self;
        open.clear();
        full.clear();
        open.extend(p.iter().zip(&*v).filter(|(p, _)| **p <= 0.0).map(|(_, v)| *v));
        if upper < f64::INFINITY {
            full.extend(p.iter().zip(&*v).filter(|(p, _)| **p >= upper).map(|(_, v)| *v));
        }
        self.between = sums(p, v, |p, v| {
            let between = (p > 0.0) & (p < upper);
            [if between { v } else { 0.0 }, if between { 1.0 } else { 0.0 }]
        });
    }

    /// Sum of the gradients v − λ of the cells that may move, and their number.
    pub(super) fn tangent_sums(&self, lambda: f64) -> [f64; 2] {
        let Self { open, full, between: [v, count], .. } = self;
        let count_if = |counts: bool, g: f64| [if counts { g } else { 0.0 }, if counts { 1.0 } else { 0.0 }];
        let below = sums(open, open, |v, _| count_if(v < lambda, v - lambda));
        let above = sums(full, full, |v, _| count_if(v > lambda, v - lambda));
        [v - count * lambda + below[0] + above[0], count + below[1] + above[1]]
    }

    /// Writes the gradient v − λ, over `unit`, of the cells of a row that may move into it; false if there are none.
    pub(super) fn scatter_gradient(&self, row: usize, lambda: f64, upper: f64, unit: f64, out: &mut [f32]) -> bool {
        let mut any = false;
        let factor = 1.0 / unit;
        for i in self.cells(row) {
            let gradient = self.v[i] - lambda;
            if may_move(self.p[i], gradient, upper) {
                out[self.columns[i] as usize] = (factor * gradient) as f32;
                any = true;
            }
        }
        any
    }

    /// Takes the preconditioned gradient of a row, `unit` times `values`.
    pub(super) fn take_preconditioned(&mut self, row: usize, values: &[f32], unit: f64) {
        let cells = self.cells(row);
        if cells.start == 0 {
            self.preconditioned.clear();
        }
        self.preconditioned.truncate(cells.start);
        let columns = &self.columns[cells];
        self.preconditioned.extend(columns.iter().map(|column| unit * f64::from(values[*column as usize])));
    }

    /// Forgets the preconditioned gradient.
    pub(super) fn forget_preconditioned(&mut self) {
        self.preconditioned.clear();
        self.preconditioned.resize(self.p.len(), 0.0);
    }

    /// Largest pressure of the step.
    pub(super) fn largest_step(&self) -> f64 {
        let s = &self.trial;
        -least(s, s, |s, _| -s.abs()).min(0.0)
    }

    /// Largest displacement by the last step.
    pub(super) fn largest_image(&self) -> f64 {
        let w = &self.image;
        -least(w, w, |w, _| -w.abs()).min(0.0)
    }

    /// The sums over the cells that may move.
    pub(super) fn products(&self, lambda: f64, upper: f64) -> Products {
        let lists = [&self.p, &self.v, &self.step, &self.image, &self.preconditioned].map(Vec::as_slice);
        let [members, g, z, s, w, gg, gz, gs, sw, zw, pw, pg, at_upper] = sums_of(lists, |[p, v, s, w, z]| {
            let g = v - lambda;
            let member = may_move(p, g, upper);
            let masked = |value: f64| if member { value } else { 0.0 };
            let (g, s, w, z) = (masked(g), masked(s), masked(w), masked(z));
            let at_upper = if p >= upper { 1.0 } else { 0.0 };
            [masked(1.0), g, z, s, w, g * g, g * z, g * s, s * w, z * w, p * w, p * g, at_upper]
        });
        Products { members, g, z, s, w, gg, gz, gs, sw, zw, pw, pg, at_upper }
    }

    /// Σ p u of the cells that may move, u = v + z, from the heights of the slab's rows.
    pub(super) fn work(&self, heights_m: &[f64], mean_height_m: f64, lambda: f64, upper: f64) -> f64 {
        let width = self.row.len();
        let mut sum = 0.0;
        for (row, heights_m) in heights_m.chunks_exact(width).enumerate() {
            for i in self.cells(row) {
                if may_move(self.p[i], self.v[i] - lambda, upper) {
                    sum += self.p[i] * (self.v[i] + heights_m[self.columns[i] as usize] - mean_height_m);
                }
            }
        }
        sum
    }

    /// Puts the pressure on trial in `direction` into `trial`, for the cells that may move or for all.
    pub(super) fn propose(&mut self, direction: Direction, lambda: f64, upper: f64, all: bool) -> Extent {
        let Self { p, v, step: s, preconditioned: z, trial, .. } = self;
        trial.resize(p.len(), 0.0);
        wide::<Propose, _>((
            trial.as_mut_slice(),
            [&*p, &*v, &*s, &*z].map(Vec::as_slice),
            direction,
            lambda,
            upper,
            all,
        ));
        self.extent()
    }

    /// That of the trial.
    fn extent(&self) -> Extent {
        wide::<Span, _>(self.trial.as_slice())
    }

    /// Puts the pressure itself into `trial` where it is between the bounds.
    pub(super) fn propose_itself(&mut self, upper: f64) -> Extent {
        self.trial.clear();
        let held = |p: f64| if p > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
        self.trial.extend(self.p.iter().map(|p| if (*p > 0.0) & (*p < upper) { *p } else { held(*p) }));
        self.extent()
    }

    /// Pressure of the cells that the trial holds on the upper bound.
    pub(super) fn held(&self, upper: f64) -> f64 {
        let held = self.trial.iter().filter(|t| **t == f64::INFINITY).count();
        if held > 0 { held as f64 * upper } else { 0.0 }
    }

    /// Sum of the trial pressures, shifted and within the bounds, and the number of them that follow a shift.
    pub(super) fn shifted_sum(&self, shift: f64, upper: f64) -> [f64; 2] {
        sums(&self.trial, &self.trial, |t, _| {
            let value = t + shift;
            [within(value, upper), if (value > 0.0) & (value < upper) { 1.0 } else { 0.0 }]
        })
    }

    /// Makes `trial` the step to the trial pressure, shifted and within the bounds; returns its slope and its squared norm.
    pub(super) fn restrict(&mut self, shift: Shift, lambda: f64, upper: f64) -> [f64; 2] {
        let Self { p, v, trial, .. } = self;
        if let Some(shift) = shift.common() {
            wide::<Cut, _>((trial.as_mut_slice(), p.as_slice(), shift, upper));
        } else {
            trial.iter_mut().zip(&*p).for_each(|(t, p)| *t = shift.applied(*t, upper) - p);
        }
        sums(trial, v, |s, v| [(v - lambda) * s, s * s])
    }

    /// The largest multiple of the step that stays within the bounds.
    pub(super) fn longest_feasible(&self, upper: f64) -> f64 {
        let room = |(p, s): (&f64, &f64)| match *s {
            s if s < 0.0 => -p / s,
            s if s > 0.0 => (upper - p) / s,
            _ => f64::INFINITY,
        };
        self.p.iter().zip(&self.trial).map(room).fold(f64::INFINITY, f64::min)
    }

    /// Writes the step, over `unit`, into a row; false if it has none.
    pub(super) fn scatter_step(&self, row: usize, unit: f64, out: &mut [f32]) -> bool {
        let cells = self.cells(row);
        let factor = 1.0 / unit;
        for (column, step) in self.columns[cells.clone()].iter().zip(&self.trial[cells.clone()]) {
            out[*column as usize] = (factor * step) as f32;
        }
        !cells.is_empty()
    }

    /// Writes the pressure, the trial being a step of it, into the rows of the grid.
    fn write_stepped(&self, p: &mut [f64], upper: f64) {
        let width = self.row.len();
        for (row, out) in p.chunks_exact_mut(width).enumerate() {
            for i in self.cells(row) {
                out[self.columns[i] as usize] = within(self.p[i] + self.trial[i], upper);
            }
        }
    }
}

impl Rows<'_> {
    /// Goes `length` times the step in a row, which moves the surface by so many times `unit_m` times `values`, and takes up
    /// the cells that are near contact then.
    pub(super) fn advance(&mut self, row: usize, length: f64, unit_m: f64, values: &[f32], bound: f64, upper: f64) {
        let cells = self.slab.cells(row);
        let Slab { columns, p, trial, next, row: steps, .. } = &mut *self.slab;
        let row = row % ROWS_OF_SLAB;
        if row == 0 {
            next.clear();
        }
        let piece = row * steps.len()..(row + 1) * steps.len();
        let (row_p, row_v) = (&mut self.p[piece.clone()], &mut self.v[piece]);
        for ((column, before), step) in columns[cells.clone()].iter().zip(&p[cells.clone()]).zip(&trial[cells.clone()])
        {
            // The step was formed as (bound − p), so a whole step lands on the bound exactly up to rounding.
            let mut after = (before + length * step).clamp(0.0, upper);
            if length >= 1.0 && *step == -before {
                after = 0.0;
            } else if length >= 1.0 && *step == upper - before {
                after = upper;
            }
            self.moved |= after != *before;
            row_p[*column as usize] = after;
            steps[*column as usize] = *step;
        }
        wide::<Add, _>((row_v, values, length, unit_m));
        next.take_up(row, row_p, row_v, bound, |i| (steps[i], unit_m * f64::from(values[i])));
        columns[cells].iter().for_each(|column| steps[*column as usize] = 0.0);
    }
}

/// `value`, or the bound of [0, `upper`] that it is beyond.
#[inline(always)]
pub(super) fn within(value: f64, upper: f64) -> f64 {
    let value = if value > 0.0 { value } else { 0.0 };
    if value < upper { value } else { upper }
}

/// All slabs of a grid.
#[derive(Debug, Clone)]
pub(super) struct Slabs {
    slabs: Vec<Slab>,
    width: usize,
    shared: bool,
}

impl Slabs {
    /// Of a grid of `rows` × `columns` cells.
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let slab = Slab { row: vec![0.0; columns], ..Slab::default() };
        Self { slabs: vec![slab; rows.div_ceil(ROWS_OF_SLAB)], width: columns, shared: rows * columns >= SHARED_FROM }
    }

    /// The slab of a row of the grid.
    pub(super) fn of_row(&self, row: usize) -> &Slab {
        &self.slabs[row / ROWS_OF_SLAB]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Slab> {
        self.slabs.iter()
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Slab> {
        self.slabs.iter_mut()
    }

    /// Does `work` on every slab.
    pub(super) fn map<R: Send>(&mut self, work: impl Fn(&mut Slab) -> R + Sync + Send) -> Vec<R> {
        if self.shared {
            self.slabs.par_iter_mut().map(work).collect()
        } else {
            self.slabs.iter_mut().map(work).collect()
        }
    }

    /// Sums of K terms of every slab.
    pub(super) fn sums<const K: usize>(&self, terms: impl Fn(&Slab) -> [f64; K] + Sync + Send) -> [f64; K] {
        let add = |total: [f64; K], terms: [f64; K]| std::array::from_fn(|k| total[k] + terms[k]);
        if self.shared {
            self.slabs.par_iter().map(terms).collect::<Vec<_>>().into_iter().fold([0.0; K], add)
        } else {
            self.slabs.iter().map(terms).fold([0.0; K], add)
        }
    }

    /// Looks for the cells near contact all over the grid.
    pub(super) fn look(&mut self, p: &[f64], v: &[f64], bound: f64) {
        let chunk = self.width * ROWS_OF_SLAB;
        let fields = self.slabs.iter_mut().zip(p.chunks(chunk).zip(v.chunks(chunk)));
        if self.shared {
            fields.collect::<Vec<_>>().into_par_iter().for_each(|(slab, (p, v))| slab.look(p, v, bound));
        } else {
            fields.for_each(|(slab, (p, v))| slab.look(p, v, bound));
        }
    }

    /// Every slab with its rows of the fields.
    pub(super) fn rows<'s>(&'s mut self, p: &'s mut [f64], v: &'s mut [f64]) -> Vec<Rows<'s>> {
        let chunk = self.width * ROWS_OF_SLAB;
        let fields = p.chunks_mut(chunk).zip(v.chunks_mut(chunk));
        self.slabs.iter_mut().zip(fields).map(|(slab, (p, v))| Rows { slab, p, v, moved: false }).collect()
    }

    /// Replaces the lists by those in the making.
    pub(super) fn turn(&mut self) {
        self.slabs.iter_mut().for_each(Slab::turn);
    }

    /// Writes the pressure, the trial being a step of it, into the grid.
    pub(super) fn write_stepped(&self, p: &mut [f64], upper: f64) {
        let chunks = p.chunks_mut(self.width * ROWS_OF_SLAB);
        self.slabs.iter().zip(chunks).for_each(|(slab, p)| slab.write_stepped(p, upper));
    }
}
