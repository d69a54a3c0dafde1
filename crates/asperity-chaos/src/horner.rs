//! Sums of products of polynomials in nested form, evaluated at many points at once.

use std::array;

use super::{Basis, Factor};
use asperity_base::wide::Kernel;

/// SIMD lanes: points that are evaluated together.
const LANES: usize = 16;

/// Nested form of Σ_α c_α Ψ_α(ξ) with common leading factors taken out, as in Horner's rule:
///
/// Σ_β ψ_{β₁}(ξ_{i₁}) [c_β + Σ_γ ψ_{γ₁}(ξ_{i₂}) [c_{βγ} + …]], i₁ < i₂ < …
///
/// Every term costs one product and one sum; terms with zero coefficients cost nothing. At degree 2 this is the
/// quadratic form ½ ξᵀCξ by rows. The order of summation is fixed, so a value depends neither on its neighbours nor on
/// the machine.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Horner {
    recurrences: Vec<Recurrence>,
    /// Total number of polynomials of all recurrences.
    polynomials: usize,
    /// Products with continuations, each after its predecessor. The first is the constant.
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    branches: Vec<Branch>,
}

/// Polynomials of degree 1 to `steps.len()` of one variable.
#[derive(Debug, Clone, PartialEq)]
struct Recurrence {
    variable: usize,
    first: usize,
    /// (a_n, 1/b_{n+1}, b_n) of b_{n+1} ψ_{n+1} = (x − a_n) ψ_n − b_n ψ_{n−1}.
    steps: Vec<(f64, f64, f64)>,
}

#[derive(Debug, Clone, PartialEq)]
struct Node {
    coefficient: f64,
    leaves: std::ops::Range<usize>,
    branches: std::ops::Range<usize>,
}

/// Last factor of a product: coefficient times polynomial.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Leaf {
    polynomial: u32,
    coefficient: f64,
}

/// Factor with continuations: polynomial times the sum of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Branch {
    polynomial: u32,
    node: u32,
}

/// Scratch memory of an evaluation, `[lane]` innermost.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    polynomials: Vec<[f64; LANES]>,
    sums: Vec<[f64; LANES]>,
}

impl Horner {
    pub(super) fn new(basis: &Basis, coefficients: &[f64]) -> Self {
        let set = basis.set();
        let mut terms: Vec<(&[Factor], f64)> = set
            .iter()
            .zip(coefficients.iter().copied())
            .filter(|(factors, c)| *c != 0.0 || factors.is_empty())
            .collect();
        // Lexicographic order puts the continuations of a product directly after it.
        terms.sort_unstable_by(|a, b| a.0.cmp(b.0));
        let mut degrees = vec![0; set.variables()];
        for factor in terms.iter().flat_map(|(factors, _)| *factors) {
            let degree = &mut degrees[factor.variable as usize];
            *degree = usize::from(factor.degree).max(*degree);
        }
        let mut horner = Self {
            recurrences: Vec::new(),
            polynomials: 0,
            nodes: Vec::new(),
            leaves: Vec::new(),
            branches: Vec::new(),
        };
        let mut first = vec![0; set.variables()];
        for (variable, &degree) in degrees.iter().enumerate().filter(|(_, degree)| **degree > 0) {
            let own = &basis.polynomials()[variable].steps()[..degree];
            let before = std::iter::once(0.0).chain(own.iter().map(|(_, b)| *b));
            let steps = own.iter().zip(before).map(|(&(a, b_next), b)| (a, 1.0 / b_next, b)).collect();
            first[variable] = horner.polynomials;
            horner.recurrences.push(Recurrence { variable, first: horner.polynomials, steps });
            horner.polynomials += degree;
        }
        let polynomial = |factor: Factor| (first[factor.variable as usize] + usize::from(factor.degree) - 1) as u32;
        // Breadth first: terms[range] have their first `depth` factors in common, which form node number `done`.
        let mut queue = vec![(0..terms.len(), 0_usize)];
        let mut done = 0;
        while done < queue.len() {
            let (range, depth) = queue[done].clone();
            let (mut at, mut coefficient) = (range.start, 0.0);
            let (leaves, branches) = (horner.leaves.len(), horner.branches.len());
            if let Some((factors, c)) = terms[range.clone()].first()
                && factors.len() == depth
            {
                coefficient = *c;
                at += 1;
            }
            while at < range.end {
                let factor = terms[at].0[depth];
                let count = terms[at..range.end].iter().take_while(|(factors, _)| factors[depth] == factor).count();
                if count == 1 && terms[at].0.len() == depth + 1 {
                    horner.leaves.push(Leaf { polynomial: polynomial(factor), coefficient: terms[at].1 });
                } else {
                    horner.branches.push(Branch { polynomial: polynomial(factor), node: queue.len() as u32 });
                    queue.push((at..at + count, depth + 1));
                }
                at += count;
            }
            let (leaves, branches) = (leaves..horner.leaves.len(), branches..horner.branches.len());
            horner.nodes.push(Node { coefficient, leaves, branches });
            done += 1;
        }
        horner
    }

    /// Evaluates up to [`LANES`] points; surplus lanes repeat the last point.
    #[inline(always)]
    fn evaluate<G: AsRef<[f64]>>(&self, xi_samples: &[G], scratch: &mut Scratch) -> [f64; LANES] {
        let rows: [&[f64]; LANES] = array::from_fn(|lane| xi_samples[lane.min(xi_samples.len() - 1)].as_ref());
        let psi = &mut scratch.polynomials[..self.polynomials];
        for recurrence in &self.recurrences {
            let x: [f64; LANES] = array::from_fn(|lane| rows[lane][recurrence.variable]);
            let (mut before, mut now) = ([0.0; LANES], [1.0; LANES]);
            for (row, &(a, inverse, b)) in psi[recurrence.first..].iter_mut().zip(&recurrence.steps) {
                let next = array::from_fn(|lane| ((x[lane] - a) * now[lane] - b * before[lane]) * inverse);
                *row = next;
                (before, now) = (now, next);
            }
        }
        let mut value = [0.0; LANES];
        for (number, node) in self.nodes.iter().enumerate().rev() {
            value = [node.coefficient; LANES];
            for leaf in &self.leaves[node.leaves.clone()] {
                let psi = &psi[leaf.polynomial as usize];
                value = array::from_fn(|lane| value[lane] + leaf.coefficient * psi[lane]);
            }
            for branch in &self.branches[node.branches.clone()] {
                let (psi, sum) = (&psi[branch.polynomial as usize], &scratch.sums[branch.node as usize]);
                value = array::from_fn(|lane| value[lane] + sum[lane] * psi[lane]);
            }
            scratch.sums[number] = value;
        }
        value
    }
}

/// Kernel that writes f(ξ) for each sample.
pub(super) struct Evaluate;

impl<'a, G: AsRef<[f64]>> Kernel<(&'a Horner, &'a [G], &'a mut [f64], &'a mut Scratch)> for Evaluate {
    type Output = ();

    #[inline(always)]
    fn run((horner, xi_samples, values, scratch): (&'a Horner, &'a [G], &'a mut [f64], &'a mut Scratch)) {
        scratch.polynomials.resize(horner.polynomials.max(scratch.polynomials.len()), [0.0; LANES]);
        scratch.sums.resize(horner.nodes.len().max(scratch.sums.len()), [0.0; LANES]);
        for (xi_samples, values) in xi_samples.chunks(LANES).zip(values.chunks_mut(LANES)) {
            let found = horner.evaluate(xi_samples, scratch);
            values.copy_from_slice(&found[..values.len()]);
        }
    }
}
