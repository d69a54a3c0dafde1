//! The slabs of a whole grid.

use crate::slab::Slab;
use asperity_base::blocks;
use asperity_base::fourier::ROWS_OF_SLAB;

/// Least number of cells of a grid for which threads share its slabs.
const SHARED_FROM: usize = 1 << 16;

/// All slabs of a grid.
#[derive(Debug, Clone, Default)]
pub(super) struct Slabs {
    slabs: Vec<Slab>,
    shared: bool,
}

impl Slabs {
    /// Initialises the slabs with the pressures `p` on rows of `width` cells and a hardness, if any; v is not yet known.
    pub(super) fn begin(&mut self, width: usize, p: &[f64], hardness_pa: Option<f64>, unit_m: f64) {
        let chunk = width * ROWS_OF_SLAB;
        self.slabs.resize_with(p.len().div_ceil(chunk), Slab::default);
        self.shared = p.len() >= SHARED_FROM && rayon::current_num_threads() > 1;
        for (slab, p) in self.slabs.iter_mut().zip(p.chunks(chunk)) {
            slab.begin(width, p, hardness_pa, unit_m);
        }
    }

    /// Frees the memory.
    pub(super) fn release(&mut self) {
        self.slabs = Vec::new();
    }

    pub(super) fn as_mut_slice(&mut self) -> &mut [Slab] {
        &mut self.slabs
    }

    /// Returns the slab of a row of the grid.
    pub(super) fn of_row(&self, row: usize) -> &Slab {
        &self.slabs[row / ROWS_OF_SLAB]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Slab> {
        self.slabs.iter()
    }

    /// Calls `work` on every slab.
    pub(super) fn each(&mut self, work: impl Fn(&mut Slab) + Sync) {
        if self.shared { blocks::for_each(&mut self.slabs, work) } else { self.slabs.iter_mut().for_each(work) }
    }

    /// Calls `work` on every slab and joins the results in order.
    pub(super) fn fold<R: Send>(
        &mut self,
        first: R,
        work: impl Fn(&mut Slab) -> R + Sync,
        join: impl Fn(R, R) -> R,
    ) -> R {
        if self.shared {
            let mut results: Vec<Option<R>> = self.slabs.iter().map(|_| None).collect();
            blocks::for_each(self.slabs.iter_mut().zip(&mut results), |(slab, result)| *result = Some(work(slab)));
            results.into_iter().flatten().fold(first, join)
        } else {
            self.slabs.iter_mut().map(work).fold(first, join)
        }
    }

    /// Returns sums of K terms of every slab.
    pub(super) fn sums<const K: usize>(&self, terms: impl Fn(&Slab) -> [f64; K] + Sync) -> [f64; K] {
        let add = |total: [f64; K], terms: [f64; K]| std::array::from_fn(|k| total[k] + terms[k]);
        if self.shared {
            let sums: Vec<[f64; K]> = blocks::map(0..self.slabs.len(), |number| terms(&self.slabs[number]));
            sums.into_iter().fold([0.0; K], add)
        } else {
            self.slabs.iter().map(terms).fold([0.0; K], add)
        }
    }

    /// Adds the cells of the whole grid whose v is below `bound` to the lists; `exact` is v of all cells, if known.
    pub(super) fn look(&mut self, bound: f64, exact: Option<&[f64]>) {
        let chunk = self.slabs.first().map_or(0, |slab| slab.width * ROWS_OF_SLAB);
        let rows = |number: usize| exact.map(|v| &v[number * chunk..v.len().min((number + 1) * chunk)]);
        if self.shared {
            blocks::for_each(self.slabs.iter_mut().enumerate(), |(number, slab)| slab.look(bound, rows(number)));
        } else {
            self.slabs.iter_mut().enumerate().for_each(|(number, slab)| slab.look(bound, rows(number)));
        }
    }
}
