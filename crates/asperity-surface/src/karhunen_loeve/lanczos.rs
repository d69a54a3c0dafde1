//! Largest eigenpairs of symmetric operators that are given only by their products.

use ndarray::{Array2, ArrayView2, Axis, s};

use super::profile::dense_eigenpairs;
use crate::GeneratorError;
use asperity_base::blocks;
use asperity_base::random;

/// Number of vectors multiplied at once; it exceeds the multiplicity of any eigenvalue within one class of parity.
const BLOCK: usize = 4;
/// Number of vectors of a subspace in addition to twice the number of wanted eigenpairs.
const SPARE: usize = 64;
/// Largest number of restarts from the best vectors of a full subspace.
const RESTARTS: usize = 200;
/// Number of columns of a basis in one unit of work; sums over them are added in order.
const CHUNK: usize = 4096;

/// Returns the number of vectors of full length in the bases of `wanted` eigenpairs in this many equal spaces.
pub(super) fn basis_vectors(spaces: usize, wanted: usize) -> f64 {
    2.0 * wanted as f64 / spaces as f64 + SPARE as f64
}

/// Symmetric operators on several spaces that are applied together. For example, one product with a map applies a
/// covariance to all classes of parity.
pub(super) trait Operator: Sync {
    /// Scratch memory of one thread.
    type Workspace;

    /// Creates scratch memory.
    fn workspace(&self) -> Self::Workspace;

    /// Returns the dimensions of the spaces.
    fn dimensions(&self) -> Vec<usize>;

    /// Replaces one vector of each space by its image; an empty vector is left out.
    fn apply(&self, vectors: &mut [Vec<f64>], work: &mut Self::Workspace);
}

/// Eigenpairs of one space.
#[derive(Debug, Clone)]
pub(super) struct Eigenpairs {
    /// Eigenvalues, falling.
    pub(super) values: Vec<f64>,
    /// Unit eigenvectors as rows.
    pub(super) vectors: Array2<f64>,
}

/// Computes the `wanted` largest eigenvalues of all spaces together and their eigenvectors, by block Lanczos with full
/// reorthogonalisation from seeded random blocks, restarted from its best vectors when a subspace is full.
///
/// A pair has converged if ‖Av − λv‖ ≤ `tolerance`·λ₁. Each space stores at most twice its number of wanted pairs plus
/// [`SPARE`] vectors.
///
/// # References
/// Golub & Underwood, in *Mathematical Software III* (1977) 361, <https://doi.org/10.1016/B978-0-12-587260-7.50018-2>;
/// Wu & Simon, *SIAM J. Matrix Anal. Appl.* **22** (2000) 602, <https://doi.org/10.1137/S0895479898334605>.
pub(super) fn largest_eigenpairs<O: Operator>(
    operator: &O,
    wanted: usize,
    tolerance: f64,
    seed: u64,
) -> Result<Vec<Eigenpairs>, GeneratorError> {
    let dimensions = operator.dimensions();
    let each = wanted.div_ceil(dimensions.len());
    let mut stream = random::stream(seed, "karhunen-loeve lanczos", 0);
    let mut spaces: Vec<Space> = dimensions.iter().map(|n| Space::new(*n, wanted, &mut stream)).collect();
    let mut counts = vec![each; spaces.len()];
    let (mut steps_to_check, mut restarts) = (each / BLOCK + 1, 0);
    loop {
        for (space, wanted) in spaces.iter_mut().zip(&counts) {
            restarts += usize::from(space.make_room(*wanted)?);
            space.append();
        }
        multiply(operator, &mut spaces);
        spaces.iter_mut().for_each(|space| space.project(&mut stream));

        let exhausted = spaces.iter().all(Space::is_whole);
        steps_to_check -= 1;
        if steps_to_check > 0 && !exhausted {
            continue;
        }
        let largest = spaces.iter().map(|space| space.size).max().unwrap_or(0);
        steps_to_check = (largest / (8 * BLOCK)).max(1);
        for space in &mut spaces {
            space.solve()?;
        }
        let survey = Survey::of(&spaces, wanted, tolerance);
        counts.clone_from(&survey.counts);
        if survey.complete {
            return Ok(spaces.into_iter().zip(survey.counts).map(|(space, wanted)| space.into_pairs(wanted)).collect());
        }
        if restarts > RESTARTS || exhausted {
            return Err(GeneratorError::NotConverged {
                wanted,
                converged: survey.converged,
                subspace: spaces.iter().map(|space| space.size).sum(),
                residual: survey.residual,
                tolerance,
            });
        }
    }
}

/// Multiplies the newest block of every space; the j-th vectors of all spaces are multiplied together.
fn multiply<O: Operator>(operator: &O, spaces: &mut [Space]) {
    let blocks: Vec<Vec<Vec<f64>>> = blocks::map_with(
        0..BLOCK,
        || operator.workspace(),
        |work, j| {
            let row = |space: &Space| match space.from + j {
                row if row < space.size => space.basis.row(row).to_vec(),
                _ => Vec::new(),
            };
            let mut vectors: Vec<Vec<f64>> = spaces.iter().map(row).collect();
            if vectors.iter().any(|vector| !vector.is_empty()) {
                operator.apply(&mut vectors, work);
            }
            vectors
        },
    );
    for (j, vectors) in blocks.into_iter().enumerate() {
        for (space, vector) in spaces.iter_mut().zip(vectors) {
            if !vector.is_empty() {
                space.block.row_mut(j).iter_mut().zip(vector).for_each(|(to, from)| *to = from);
            }
        }
    }
}

/// Convergence of the spaces together.
struct Survey {
    /// Number of wanted pairs in each space.
    counts: Vec<usize>,
    /// Whether all wanted pairs have converged.
    complete: bool,
    converged: usize,
    /// Largest residual of the wanted pairs over the first eigenvalue.
    residual: f64,
}

impl Survey {
    fn of(spaces: &[Space], wanted: usize, tolerance: f64) -> Self {
        let mut all: Vec<(f64, usize)> = Vec::new();
        for (i, space) in spaces.iter().enumerate() {
            all.extend(space.values.iter().map(|value| (*value, i)));
        }
        sort_falling(&mut all);
        let enough = all.len() >= wanted;
        all.truncate(wanted);
        let scale = all[0].0.max(f64::MIN_POSITIVE);
        let cut = all[all.len() - 1].0;
        let mut counts = vec![0; spaces.len()];
        all.iter().for_each(|(_, i)| counts[*i] += 1);
        let (mut converged, mut residual, mut separate) = (0, 0.0_f64, true);
        for (space, wanted) in spaces.iter().zip(&counts) {
            let residuals = (0..*wanted).map(|j| space.residual(j) / scale);
            for own in residuals {
                residual = residual.max(own);
                converged += usize::from(own <= tolerance);
            }
            // The first value left out must be accurate enough to stay out.
            if *wanted < space.values.len() {
                let above = space.values[*wanted] + space.residual(*wanted);
                separate &= above <= cut + 2.0 * tolerance * scale;
            } else {
                separate &= space.is_whole();
            }
        }
        Self { complete: enough && converged == wanted && separate, counts, converged, residual }
    }
}

/// Krylov subspace of one space.
struct Space {
    /// Orthonormal rows, the first `size` of which are in use. Memory that is never written is never allocated
    /// physically.
    basis: Array2<f64>,
    size: usize,
    /// First row of the newest block.
    from: usize,
    /// The next block before a product; the image of the newest block after it.
    block: Array2<f64>,
    /// Projection of the operator on the basis, in the first `size` rows and columns.
    projected: Array2<f64>,
    /// Coupling of the newest block to the next.
    coupling: Array2<f64>,
    /// Ritz values, falling, and their vectors in the basis as rows.
    values: Vec<f64>,
    vectors: Array2<f64>,
}

impl Space {
    fn new(n: usize, wanted: usize, stream: &mut random::Stream) -> Self {
        let rows = BLOCK.min(n);
        let capacity = (2 * wanted + SPARE).min(n);
        let draws = random::standard_normal(stream, rows * n);
        let mut block = Array2::from_shape_fn((rows, n), |(i, j)| draws[i * n + j]);
        orthonormalise(&mut block, Array2::zeros((0, n)).view(), stream);
        Self {
            basis: Array2::zeros((capacity, n)),
            size: 0,
            from: 0,
            block,
            projected: Array2::zeros((capacity, capacity)),
            coupling: Array2::zeros((0, 0)),
            values: Vec::new(),
            vectors: Array2::zeros((0, 0)),
        }
    }

    fn dimension(&self) -> usize {
        self.basis.ncols()
    }

    /// Returns whether the subspace is the whole space, so that Ritz pairs are eigenpairs.
    fn is_whole(&self) -> bool {
        self.size == self.dimension()
    }

    /// Replaces a full basis by its best vectors; returns whether it did.
    fn make_room(&mut self, wanted: usize) -> Result<bool, GeneratorError> {
        let capacity = (2 * wanted + SPARE).min(self.basis.nrows());
        if self.is_whole() || self.size + BLOCK <= capacity || capacity == self.dimension() {
            return Ok(false);
        }
        self.solve()?;
        let kept = (wanted + SPARE / 2).min(self.size - BLOCK);
        self.rotate(kept);
        self.projected.fill(0.0);
        for (j, value) in self.values[..kept].iter().enumerate() {
            self.projected[[j, j]] = *value;
        }
        self.size = kept;
        Ok(true)
    }

    /// Appends the next block to the basis, cut if the space is full.
    fn append(&mut self) {
        let count = self.block.nrows().min(self.basis.nrows() - self.size);
        self.from = self.size;
        self.size += count;
        self.basis.slice_mut(s![self.from..self.size, ..]).assign(&self.block.slice(s![..count, ..]));
        if count < self.block.nrows() {
            self.block = self.block.slice(s![..count, ..]).to_owned();
        }
    }

    /// Projects the operator onto the basis by the image of the newest block, and makes the remainder the next block.
    fn project(&mut self, stream: &mut random::Stream) {
        if self.from == self.size {
            return;
        }
        let basis = self.basis.slice(s![..self.size, ..]);
        let columns = overlaps(basis, self.block.view());
        self.projected.slice_mut(s![..self.size, self.from..self.size]).assign(&columns);
        self.projected.slice_mut(s![self.from..self.size, ..self.size]).assign(&columns.t());
        subtract(&mut self.block, &columns, basis);
        self.coupling = orthonormalise(&mut self.block, basis, stream);
    }

    /// Computes the Ritz pairs.
    fn solve(&mut self) -> Result<(), GeneratorError> {
        let projected = &self.projected;
        let entry = |i: usize, j: usize| 0.5 * (projected[[i, j]] + projected[[j, i]]);
        (self.values, self.vectors) = dense_eigenpairs(self.size, entry)?;
        Ok(())
    }

    /// Returns ‖Av − θv‖ of a Ritz pair: A·v = θ·v + (next block)ᵀ R s, with s the part of the vector in the newest
    /// block.
    fn residual(&self, j: usize) -> f64 {
        if self.is_whole() {
            return 0.0;
        }
        let tail = self.vectors.slice(s![j, self.from..]).to_owned();
        self.coupling.dot(&tail).mapv(|v| v * v).sum().sqrt()
    }

    /// Overwrites the first rows of the basis by its first Ritz vectors.
    fn rotate(&mut self, kept: usize) {
        let rotation = self.vectors.slice(s![..kept, ..]);
        let size = self.size;
        blocks::for_each(self.basis.axis_chunks_iter_mut(Axis(1), CHUNK), |mut chunk| {
            let rotated = rotation.dot(&chunk.slice(s![..size, ..]));
            chunk.slice_mut(s![..kept, ..]).assign(&rotated);
        });
    }

    fn into_pairs(mut self, wanted: usize) -> Eigenpairs {
        self.rotate(wanted);
        let n = self.dimension();
        let (mut rows, _) = self.basis.into_raw_vec_and_offset();
        rows.truncate(wanted * n);
        rows.shrink_to_fit();
        self.values.truncate(wanted);
        // The length is wanted·n by the lines above.
        let vectors = Array2::from_shape_vec((wanted, n), rows).unwrap_or_default();
        Eigenpairs { values: self.values, vectors }
    }
}

/// Returns basis·blockᵀ, summed over chunks in order.
fn overlaps(basis: ArrayView2<f64>, block: ArrayView2<f64>) -> Array2<f64> {
    let chunks: Vec<_> = basis.axis_chunks_iter(Axis(1), CHUNK).zip(block.axis_chunks_iter(Axis(1), CHUNK)).collect();
    let parts: Vec<Array2<f64>> = blocks::map(0..chunks.len(), |chunk| chunks[chunk].0.dot(&chunks[chunk].1.t()));
    let mut sum = Array2::zeros((basis.nrows(), block.nrows()));
    parts.iter().for_each(|part| sum += part);
    sum
}

/// Computes block −= overlapsᵀ·basis.
fn subtract(block: &mut Array2<f64>, overlaps: &Array2<f64>, basis: ArrayView2<f64>) {
    let chunks = block.axis_chunks_iter_mut(Axis(1), CHUNK).zip(basis.axis_chunks_iter(Axis(1), CHUNK));
    blocks::for_each(chunks, |(mut block, basis)| block -= &overlaps.t().dot(&basis));
}

/// Makes the rows of `block` orthonormal and orthogonal to `basis`. Returns R with block_before = Rᵀ·block_after,
/// except for its part in the span of the basis.
///
/// A row that vanishes because the subspace is invariant is replaced by a random one with zero coupling.
fn orthonormalise(block: &mut Array2<f64>, basis: ArrayView2<f64>, stream: &mut random::Stream) -> Array2<f64> {
    let (rows, n) = block.dim();
    let room = n - basis.nrows();
    if room < rows {
        // The next block completes the space. Until then its coupling is bounded by the whole length of this block.
        let length = block.iter().map(|v| v * v).sum::<f64>().sqrt();
        *block = block.slice(s![..room, ..]).to_owned();
        orthonormalise(block, basis, stream);
        return Array2::from_diag_elem(rows, length);
    }
    let largest = block.rows().into_iter().fold(0.0_f64, |m, row| m.max(row.dot(&row).sqrt()));
    let mut coupling = within_block(block, f64::EPSILON * largest);
    for i in 0..rows {
        if coupling[[i, i]] == 0.0 {
            let fresh = random::standard_normal(stream, n);
            block.row_mut(i).iter_mut().zip(fresh).for_each(|(out, value)| *out = value);
            coupling.row_mut(i).fill(0.0);
        }
    }
    // Rounding leaves components in the basis that scaling to unit length magnifies. Projecting twice suffices, unless
    // a row was hardly more than rounding.
    for _ in 0..4 {
        if basis.nrows() > 0 {
            let columns = overlaps(basis, block.view());
            subtract(block, &columns, basis);
        }
        let again = within_block(block, 0.0);
        let kept = (0..rows).all(|i| again[[i, i]] > 0.5);
        coupling = again.dot(&coupling);
        if kept {
            break;
        }
    }
    coupling
}

/// Orthonormalises the rows by modified Gram–Schmidt. Rows of length up to `vanishing` get zero on the diagonal of R
/// and stay.
fn within_block(block: &mut Array2<f64>, vanishing: f64) -> Array2<f64> {
    let rows = block.nrows();
    let mut coupling = Array2::<f64>::zeros((rows, rows));
    for i in 0..rows {
        let mut row = block.row(i).to_owned();
        let start = row.dot(&row).sqrt();
        for j in 0..i {
            if coupling[[j, j]] > 0.0 {
                let overlap = block.row(j).dot(&row);
                row.scaled_add(-overlap, &block.row(j));
                coupling[[j, i]] = overlap;
            }
        }
        let norm = row.dot(&row).sqrt();
        if norm > vanishing && norm > 1e-13 * start {
            coupling[[i, i]] = norm;
            row /= norm;
        }
        block.row_mut(i).assign(&row);
    }
    coupling
}

/// Sorts by falling value, and values that only rounding tells apart by place: modes along x and along y of a square
/// would otherwise come in another order on another processor.
pub(super) fn sort_falling<P: Ord>(modes: &mut [(f64, P)]) {
    const ROUNDING: f64 = 1e-12;
    modes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let least = ROUNDING * modes.first().map_or(0.0, |first| first.0);
    for equal in modes.chunk_by_mut(|a, b| a.0 - b.0 <= least) {
        equal.sort_by(|a, b| a.1.cmp(&b.1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Diagonal operators on several spaces.
    struct Diagonal(Vec<Vec<f64>>);

    impl Operator for Diagonal {
        type Workspace = ();

        fn workspace(&self) {}

        fn dimensions(&self) -> Vec<usize> {
            self.0.iter().map(Vec::len).collect()
        }

        fn apply(&self, vectors: &mut [Vec<f64>], (): &mut ()) {
            for (vector, diagonal) in vectors.iter_mut().zip(&self.0) {
                vector.iter_mut().zip(diagonal).for_each(|(v, d)| *v *= d);
            }
        }
    }

    /// The operator v ↦ 1 (1·v).
    struct Ones(usize);

    impl Operator for Ones {
        type Workspace = ();

        fn workspace(&self) {}

        fn dimensions(&self) -> Vec<usize> {
            vec![self.0]
        }

        fn apply(&self, vectors: &mut [Vec<f64>], (): &mut ()) {
            for vector in vectors {
                let sum: f64 = vector.iter().sum();
                vector.fill(sum);
            }
        }
    }

    fn assert_orthonormal(vectors: &Array2<f64>) {
        let gram = vectors.dot(&vectors.t());
        assert!(gram.indexed_iter().all(|((i, j), v)| (v - f64::from(u8::from(i == j))).abs() < 1e-12));
    }

    #[test]
    fn repeated_eigenvalues_are_all_found() {
        // diag(10, 10, 10, 9, 9, 1/k …): a single start vector would find 10 and 9 once.
        let diagonal = (0..300).map(|i| match i {
            7 | 50 | 299 => 10.0,
            0 | 120 => 9.0,
            _ => 1.0 / f64::from(i),
        });
        let found = largest_eigenpairs(&Diagonal(vec![diagonal.collect()]), 7, 1e-10, 1).unwrap();
        for (value, wanted) in found[0].values.iter().zip([10.0, 10.0, 10.0, 9.0, 9.0, 1.0, 0.5]) {
            assert!((value - wanted).abs() < 1e-9, "{:?}", found[0].values);
        }
        assert_orthonormal(&found[0].vectors);
    }

    #[test]
    #[ignore = "slow"]
    fn the_largest_eigenvalues_of_all_spaces_are_found() {
        // Slowly falling values, most of them in one space, so that its subspace is filled and restarted.
        let spaces: Vec<Vec<f64>> = [(900, 1.0, 1e-3), (500, 0.95, 1e-2), (40, 0.5, 1e-2), (3, 0.99, 0.3)]
            .map(|(n, first, step): (usize, f64, f64)| (0..n).map(|i| first / (1.0 + step * i as f64)).collect())
            .into();
        let mut all: Vec<f64> = spaces.iter().flatten().copied().collect();
        all.sort_by(|a, b| b.total_cmp(a));
        let found = largest_eigenpairs(&Diagonal(spaces.clone()), 80, 1e-9, 2).unwrap();
        let mut values: Vec<f64> = found.iter().flat_map(|pairs| pairs.values.clone()).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        assert_eq!(values.len(), 80);
        assert!(values.iter().zip(&all).all(|(f, w)| (f - w).abs() < 1e-12));
        for (pairs, diagonal) in found.iter().zip(&spaces) {
            assert_orthonormal(&pairs.vectors);
            for (value, vector) in pairs.values.iter().zip(pairs.vectors.rows()) {
                let residual: f64 = vector.iter().zip(diagonal).map(|(v, d)| ((d - value) * v).powi(2)).sum();
                assert!(residual.sqrt() < 2e-9);
            }
        }
    }

    #[test]
    fn an_operator_of_low_rank_is_solved() {
        for n in [64, 5, 6, 3] {
            let count = n.min(5);
            let found = largest_eigenpairs(&Ones(n), count, 1e-10, 2).unwrap().remove(0);
            assert!((found.values[0] - n as f64).abs() < 1e-10, "{:?}", found.values);
            assert!(found.values[1..].iter().all(|v| v.abs() < 1e-10));
            assert!(found.vectors.row(0).iter().all(|v| (v.abs() - (n as f64).powf(-0.5)).abs() < 1e-12));
            assert_orthonormal(&found.vectors);
        }
    }

    #[test]
    #[ignore = "slow"]
    fn lack_of_convergence_is_an_error() {
        // A residual below rounding cannot be reached.
        let diagonal = (0..400).map(|i| 1.0 + 1e-3 * f64::from(i));
        let error = largest_eigenpairs(&Diagonal(vec![diagonal.collect()]), 20, 1e-18, 3).unwrap_err();
        assert!(matches!(error, GeneratorError::NotConverged { wanted: 20, .. }), "{error}");
    }
}
