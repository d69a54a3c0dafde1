//! Cells near contact, stored by slabs of rows.
//!
//! Most cells of a rough contact are out of contact and stay so. Lists store the data of the other cells, one set of
//! lists for each slab of [`ROWS_OF_SLAB`] rows. The lists of a slab fit in the cache for a sequence of operations, and
//! threads can share slabs. Sums are added slab by slab in order, for any number of threads. For cells far from contact
//! only v is stored, in single precision, to detect when they come near contact.

mod hardness;
mod kernels;
mod sums;

use std::ops::Range;

use self::hardness::{Unbounded, Yielding};
pub(super) use self::kernels::Step;
use self::kernels::{
    Below, Beyond, Cut, Drift, Go, Gradient, Largest, Multiply, OnBound, Propose, Room, Shifted, Span, Summarise,
};
pub(super) use self::sums::{Advance, Direction, Part, Products, Summary};
use crate::projection::{Extent, Shift, within};
use asperity_base::fourier::ROWS_OF_SLAB;
use asperity_base::wide::wide;

/// Cells far from contact are removed from the lists when more than one in this number is far from contact.
const IDLE_ONE_IN: f64 = 8.0;
/// Largest number of cells for which the memory of unused lists is kept.
const MOST_KEPT: usize = 1 << 11;

/// Evaluates an expression with the hardness of the cells of a slab, compiled separately for infinite hardness.
macro_rules! with_h {
    ($hardness:expr, |$h:ident| $work:expr) => {
        if let Some(hardness_pa) = $hardness {
            let $h = Yielding(hardness_pa);
            $work
        } else {
            let $h = Unbounded;
            $work
        }
    };
}

/// Cells of a slab that carry pressure or may soon carry it, row by row.
#[derive(Debug, Clone, Default)]
pub(super) struct Slab {
    pub(super) width: usize,
    lists: Lists,
    /// Lists under construction.
    next: Lists,
    entrants: Vec<Entrant>,
    /// Gradient of the cells that may move, zero for others; and 1 for these cells, 0 for others.
    gradient: Vec<f32>,
    moves: Vec<f32>,
    /// The preconditioned gradient.
    preconditioned: Vec<f32>,
    /// Trial pressure, not yet within the bounds; for cells that may not move, an infinity beyond their bound. After
    /// [`Slab::restrict`] it is the step to the trial pressure. Before that, see [`Slab::tangent_sums`], its first
    /// `open` entries are the v of the cells on the lower bound.
    trial: Vec<f64>,
    open: usize,
    /// The v of the cells at the hardness.
    full: Vec<f64>,
    /// v of the other cells of the slab's rows as `origin_m` + `unit_m` times this value; infinite for the listed cells.
    far: Vec<f32>,
    origin_m: f64,
    unit_m: f64,
    /// Hardness in pascal, if any.
    hardness_pa: Option<f64>,
    pub(super) summary: Summary,
    pub(super) products: Products,
    pub(super) step: Step,
}

/// One value for each cell near contact.
#[derive(Debug, Clone, Default)]
struct Lists {
    /// Start of the cells of each row, and the end of the last row.
    starts: [u32; ROWS_OF_SLAB + 1],
    columns: Vec<u32>,
    /// Pressure and S p − z.
    p: Vec<f64>,
    v: Vec<f64>,
    /// Last step and its image under S, over their units; zero for cells that were not near contact then.
    step: Vec<f32>,
    image: Vec<f32>,
}

impl Lists {
    fn clear(&mut self) {
        self.starts = [0; ROWS_OF_SLAB + 1];
        self.columns.clear();
        self.p.clear();
        self.v.clear();
        self.step.clear();
        self.image.clear();
    }

    /// Reserves exactly this number of cells.
    fn reserve(&mut self, cells: usize) {
        self.columns.reserve_exact(cells);
        self.p.reserve_exact(cells);
        self.v.reserve_exact(cells);
        self.step.reserve_exact(cells);
        self.image.reserve_exact(cells);
    }

    /// Returns the range of the cells of a row.
    fn cells(&self, row: usize) -> Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    fn push(&mut self, column: u32, [p, v]: [f64; 2], [step, image]: [f32; 2]) {
        self.columns.push(column);
        self.p.push(p);
        self.v.push(v);
        self.step.push(step);
        self.image.push(image);
    }

    /// Appends the cells in `cells` of other lists.
    fn extend(&mut self, other: &Self, cells: Range<usize>) {
        self.columns.extend_from_slice(&other.columns[cells.clone()]);
        self.p.extend_from_slice(&other.p[cells.clone()]);
        self.v.extend_from_slice(&other.v[cells.clone()]);
        self.step.extend_from_slice(&other.step[cells.clone()]);
        self.image.extend_from_slice(&other.image[cells]);
    }
}

/// A cell that comes near contact.
#[derive(Debug, Clone, Copy)]
struct Entrant {
    row: usize,
    column: u32,
    v: f64,
    image: f32,
}

impl Slab {
    /// Initialises the lists with the pressures `p` of its rows; v is not yet known.
    pub(super) fn begin(&mut self, width: usize, p: &[f64], hardness_pa: Option<f64>, unit_m: f64) {
        self.width = width;
        (self.origin_m, self.unit_m) = (0.0, unit_m);
        self.far.clear();
        self.far.resize(p.len(), f32::INFINITY);
        self.hardness_pa = hardness_pa;
        self.entrants.clear();
        self.summary = Summary::NONE;
        self.lists.clear();
        self.lists.reserve(p.iter().filter(|p| **p > 0.0).count());
        for (row, p) in p.chunks_exact(width).enumerate() {
            for (column, p) in p.iter().enumerate().filter(|(_, p)| **p > 0.0) {
                self.lists.push(column as u32, [*p, 0.0], [0.0; 2]);
            }
            self.lists.starts[row + 1..].fill(self.lists.columns.len() as u32);
        }
    }

    /// Frees the buffers of the current iteration.
    pub(super) fn release_scratch(&mut self) {
        (self.gradient, self.moves, self.preconditioned) = (Vec::new(), Vec::new(), Vec::new());
        (self.trial, self.full, self.open) = (Vec::new(), Vec::new(), 0);
    }

    fn rows(&self) -> usize {
        self.far.len() / self.width
    }

    /// Returns a bound on [`Slab::far`] that includes every v below `bound`.
    fn far_bound(&self, bound: f64) -> f32 {
        let over = (bound - self.origin_m) / self.unit_m;
        if over.is_finite() { (over + 1e-6 * over.abs()) as f32 } else { over as f32 }
    }

    /// Writes the pressures of a row of the grid; returns false if there are none.
    pub(super) fn write_pressure(&self, row: usize, out: &mut [f64]) -> bool {
        let cells = self.lists.cells(row % ROWS_OF_SLAB);
        for (column, p) in self.lists.columns[cells.clone()].iter().zip(&self.lists.p[cells.clone()]) {
            out[*column as usize] = *p;
        }
        !cells.is_empty()
    }

    /// Returns the largest pressure.
    pub(super) fn largest_pressure(&self) -> f64 {
        self.lists.p.iter().copied().fold(0.0, f64::max)
    }

    /// Sets pressures below `least` to zero.
    pub(super) fn drop_below(&mut self, least: f64) {
        self.lists.p.iter_mut().filter(|p| **p < least).for_each(|p| *p = 0.0);
    }

    /// Stores v of a row of the grid and, after the last row, adds all cells near contact to the lists.
    pub(super) fn settle(&mut self, row: usize, v: &[f64], origin_m: f64, bound: f64) {
        let row = row % ROWS_OF_SLAB;
        self.origin_m = origin_m;
        let factor = 1.0 / self.unit_m;
        let far = &mut self.far[row * self.width..][..self.width];
        far.iter_mut().zip(v).for_each(|(far, v)| *far = (factor * (v - origin_m)) as f32);
        let cells = self.lists.cells(row);
        for (column, list_v) in self.lists.columns[cells.clone()].iter().zip(&mut self.lists.v[cells]) {
            *list_v = v[*column as usize];
            far[*column as usize] = f32::INFINITY;
        }
        self.find(row, bound, None, Some(v));
        if row + 1 == self.rows() {
            self.merge(bound);
        }
    }

    /// Collects the cells of a row whose v is below `bound`, with the displacements of the last step and the exact v of
    /// the row if given.
    fn find(&mut self, row: usize, bound: f64, image: Option<&[f32]>, exact: Option<&[f64]>) {
        let far_bound = self.far_bound(bound);
        let Self { far, entrants, origin_m, unit_m, .. } = self;
        let far = &far[row * self.width..][..self.width];
        if wide::<Below, _>((far, far_bound)) == 0 {
            return;
        }
        for (column, value) in far.iter().enumerate().filter(|(_, far)| **far < far_bound) {
            let v = exact.map_or_else(|| *origin_m + *unit_m * f64::from(*value), |v| v[column]);
            if v < bound || exact.is_none() {
                let image = image.map_or(0.0, |image| image[column]);
                entrants.push(Entrant { row, column: column as u32, v, image });
            }
        }
    }

    /// Adds all cells whose v is below `bound` to the lists, with the exact v if given.
    pub(super) fn look(&mut self, bound: f64, exact: Option<&[f64]>) {
        for row in 0..self.rows() {
            let exact = exact.map(|v| &v[row * self.width..][..self.width]);
            self.find(row, bound, None, exact);
        }
        self.merge(bound);
    }

    /// Adds the new cells near contact to the lists, removes those far from contact if worthwhile, and updates the
    /// summary.
    fn merge(&mut self, bound: f64) {
        // The number of idle cells in the last summary decides whether removal is worthwhile.
        let dismisses = IDLE_ONE_IN * self.summary.idle > self.lists.p.len() as f64;
        if self.entrants.is_empty() && !dismisses {
            self.summarise(bound);
            return;
        }
        let width = self.width;
        let Self { lists, next, entrants, far, origin_m, unit_m, .. } = self;
        next.clear();
        next.reserve(lists.p.len() + entrants.len());
        let mut waiting = entrants.iter().peekable();
        for row in 0..far.len() / width {
            let cells = lists.cells(row);
            if dismisses {
                for i in cells {
                    let (column, p, v) = (lists.columns[i], lists.p[i], lists.v[i]);
                    let place = row * width + column as usize;
                    if p > 0.0 || v < bound {
                        next.push(column, [p, v], [lists.step[i], lists.image[i]]);
                    } else {
                        far[place] = ((v - *origin_m) / *unit_m) as f32;
                    }
                }
            } else {
                next.extend(lists, cells);
            }
            while let Some(entrant) = waiting.next_if(|entrant| entrant.row == row) {
                let place = row * width + entrant.column as usize;
                next.push(entrant.column, [0.0, entrant.v], [0.0, entrant.image]);
                far[place] = f32::INFINITY;
            }
            next.starts[row + 1..].fill(next.columns.len() as u32);
        }
        entrants.clear();
        std::mem::swap(lists, next);
        // In large problems memory is scarcer than the time to allocate it.
        if next.p.capacity() > MOST_KEPT {
            *next = Lists::default();
        }
        self.summarise(bound);
    }

    /// Computes the summary of the lists.
    fn summarise(&mut self, bound: f64) {
        let Self { lists, trial, open, full, summary, hardness_pa, .. } = self;
        let (p, v) = (lists.p.as_slice(), lists.v.as_slice());
        *summary = with_h!(*hardness_pa, |h| wide::<Summarise, _>((p, v, bound, h)));
        trial.resize(p.len(), 0.0);
        *open = wide::<OnBound<false>, _>((trial.as_mut_slice(), p, v, Unbounded));
        full.clear();
        if let Some(hardness_pa) = *hardness_pa {
            full.resize(p.len(), 0.0);
            let count = wide::<OnBound<true>, _>((full.as_mut_slice(), p, v, Yielding(hardness_pa)));
            full.truncate(count);
        }
        summary.full = full.len() as f64;
    }

    /// Returns pressure, v and hardness of the cells near contact.
    pub(super) fn part(&self) -> Part<'_> {
        Part { p: &self.lists.p, v: &self.lists.v, hardness_pa: self.hardness_pa }
    }

    /// Returns the sum of the gradients v − λ of the cells that may move, and their number below the hardness and at
    /// it. Valid until a trial is computed after the last summary.
    pub(super) fn tangent_sums(&self, lambda: f64) -> [f64; 3] {
        let Self { trial, open, full, summary: Summary { between_v, between, .. }, .. } = self;
        let below = wide::<Beyond<false>, _>((&trial[..*open], lambda));
        let above = if full.is_empty() { [0.0; 2] } else { wide::<Beyond<true>, _>((full.as_slice(), lambda)) };
        [between_v - between * lambda + below[0] + above[0], between + below[1], above[1]]
    }

    /// Computes the gradient v − λ, over `unit_m`, of the cells that may move, or of all.
    pub(super) fn differentiate(&mut self, lambda: f64, unit_m: f64, all: bool) {
        let Self { lists, gradient, moves, hardness_pa, .. } = self;
        let n = lists.p.len();
        gradient.resize(n, 0.0);
        moves.resize(n, 0.0);
        let terms = [lambda, 1.0 / unit_m];
        let fields = [lists.p.as_slice(), lists.v.as_slice()];
        let (gradient, moves) = (gradient.as_mut_slice(), moves.as_mut_slice());
        with_h!(*hardness_pa, |h| wide::<Gradient, _>((gradient, moves, fields, terms, all, h)));
    }

    /// Writes the gradient of a row; returns false if it has none.
    pub(super) fn scatter_gradient(&self, row: usize, out: &mut [f32]) -> bool {
        let cells = self.lists.cells(row % ROWS_OF_SLAB);
        for (column, gradient) in self.lists.columns[cells.clone()].iter().zip(&self.gradient[cells.clone()]) {
            out[*column as usize] = *gradient;
        }
        !cells.is_empty()
    }

    /// Stores the preconditioned gradient of a row and, after the last row, computes the products.
    pub(super) fn take_preconditioned(&mut self, row: usize, values: &[f32]) {
        let row = row % ROWS_OF_SLAB;
        self.preconditioned.resize(self.lists.p.len(), 0.0);
        let cells = self.lists.cells(row);
        for (z, column) in self.preconditioned[cells.clone()].iter_mut().zip(&self.lists.columns[cells]) {
            *z = values[*column as usize];
        }
        if row + 1 == self.rows() {
            let Self { lists, moves, gradient, preconditioned, .. } = self;
            self.products = wide::<Multiply, _>(
                [moves, gradient, preconditioned, &lists.step, &lists.image].map(|list: &Vec<f32>| list.as_slice()),
            );
        }
    }

    /// Returns [Σ p w, Σ p g, Σ p u] of the cells that may move, with u = v + z from the heights of the slab's rows; w
    /// and g over their units.
    pub(super) fn level(&self, heights_m: &[f64], mean_height_m: f64) -> [f64; 3] {
        let Lists { columns, p, v, image, .. } = &self.lists;
        let mut sums = [0.0; 3];
        for (row, heights_m) in heights_m.chunks_exact(self.width).enumerate() {
            for i in self.lists.cells(row) {
                if self.moves[i] > 0.0 {
                    sums[0] += p[i] * f64::from(image[i]);
                    sums[1] += p[i] * f64::from(self.gradient[i]);
                    sums[2] += p[i] * (v[i] + heights_m[columns[i] as usize] - mean_height_m);
                }
            }
        }
        sums
    }

    /// Writes the trial pressure in `direction` into `trial`, for the cells that may move.
    pub(super) fn propose(&mut self, direction: Direction) -> Extent {
        let Self { lists, moves, gradient, preconditioned, trial, .. } = self;
        trial.resize(lists.p.len(), 0.0);
        preconditioned.resize(lists.p.len(), 0.0);
        let fields = [moves, gradient, preconditioned, &lists.step].map(|list: &Vec<f32>| list.as_slice());
        wide::<Propose, _>((trial.as_mut_slice(), lists.p.as_slice(), fields, direction));
        self.extent()
    }

    /// Returns the extent of the trial.
    fn extent(&self) -> Extent {
        with_h!(self.hardness_pa, |h| wide::<Span, _>((self.trial.as_slice(), h)))
    }

    /// Copies the pressure into `trial` for the cells between the bounds.
    pub(super) fn propose_itself(&mut self) -> Extent {
        let Self { lists, trial, hardness_pa, .. } = self;
        trial.clear();
        let fixed = |p: f64| if p > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
        let hardness_pa = hardness_pa.unwrap_or(f64::INFINITY);
        let itself = |p: f64| if (p > 0.0) & (p < hardness_pa) { p } else { fixed(p) };
        trial.extend(lists.p.iter().map(|p| itself(*p)));
        self.gradient.clear();
        self.gradient.resize(self.lists.p.len(), 0.0);
        self.extent()
    }

    /// Returns the sum of the pressures of the cells that the trial fixes at the hardness.
    pub(super) fn fixed(&self) -> f64 {
        let Some(hardness_pa) = self.hardness_pa else { return 0.0 };
        self.trial.iter().map(|t| if *t == f64::INFINITY { hardness_pa } else { 0.0 }).sum()
    }

    /// Returns the sum of the trial pressures, shifted and within the bounds, and the number of cells that follow a
    /// shift.
    pub(super) fn shifted_sum(&self, shift: f64) -> [f64; 2] {
        with_h!(self.hardness_pa, |h| wide::<Shifted, _>((self.trial.as_slice(), shift, h)))
    }

    /// Replaces `trial` by the step to the trial pressure, shifted and within the bounds.
    pub(super) fn restrict(&mut self, shift: Shift) {
        let Self { lists, gradient, trial, step, hardness_pa, .. } = self;
        let (trial, p, gradient) = (trial.as_mut_slice(), lists.p.as_slice(), gradient.as_slice());
        *step = if let Some(by) = shift.common() {
            let shifted = |t: f64, hardness: f64| within(t + by, hardness);
            with_h!(*hardness_pa, |h| wide::<Cut, _>((trial, p, gradient, by, shifted, h)))
        } else {
            let shifted = |t: f64, hardness: f64| shift.applied(t, hardness);
            with_h!(*hardness_pa, |h| wide::<Cut, _>((trial, p, gradient, shift.largest(), shifted, h)))
        };
    }

    /// Returns the largest multiple of the step that stays within the bounds.
    pub(super) fn longest_feasible(&self) -> f64 {
        let (p, step) = (self.lists.p.as_slice(), self.trial.as_slice());
        with_h!(self.hardness_pa, |h| wide::<Room, _>((p, step, h)))
    }

    /// Writes the step of a row, over `unit`; returns false if it has none.
    pub(super) fn scatter_step(&self, row: usize, unit: f64, out: &mut [f32]) -> bool {
        let cells = self.lists.cells(row % ROWS_OF_SLAB);
        let factor = 1.0 / unit;
        for (column, step) in self.lists.columns[cells.clone()].iter().zip(&self.trial[cells.clone()]) {
            out[*column as usize] = (factor * step) as f32;
        }
        !cells.is_empty()
    }

    /// Receives the displacements of a row by the whole step, over their unit. After the last row, applies the step and
    /// adds the cells that are then near contact.
    pub(super) fn advance(&mut self, row: usize, advance: Advance, values: &[f32]) {
        let row = row % ROWS_OF_SLAB;
        let factor = (advance.length * advance.unit_m / self.unit_m) as f32;
        let bound = self.far_bound(advance.bound);
        let far = &mut self.far[row * self.width..][..self.width];
        if wide::<Drift, _>((far, values, factor, bound)) > 0 {
            self.find(row, advance.bound, Some(values), None);
        }
        let cells = self.lists.cells(row);
        for (image, column) in self.lists.image[cells.clone()].iter_mut().zip(&self.lists.columns[cells]) {
            *image = values[*column as usize];
        }
        if row + 1 == self.rows() {
            let moved = self.go(advance);
            let largest_image = f64::from(wide::<Largest, _>(self.lists.image.as_slice()));
            self.merge(advance.bound);
            (self.summary.moved, self.summary.largest_image) = (moved, largest_image);
        }
    }

    /// Applies the trial step; returns whether a pressure changed.
    fn go(&mut self, advance: Advance) -> bool {
        let Self { lists, trial, hardness_pa, .. } = self;
        let Lists { p, v, step, image, .. } = lists;
        let (p, v, step) = (p.as_mut_slice(), v.as_mut_slice(), step.as_mut_slice());
        with_h!(*hardness_pa, |h| wide::<Go, _>((p, v, step, [trial.as_slice()], image.as_slice(), advance, h)))
    }

    /// Adds the whole trial step to the pressures only.
    pub(super) fn step_pressure(&mut self) {
        let hardness_pa = self.hardness_pa.unwrap_or(f64::INFINITY);
        self.lists.p.iter_mut().zip(&self.trial).for_each(|(p, s)| *p = within(*p + s, hardness_pa));
    }
}
