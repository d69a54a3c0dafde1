//! Sobol' indices of Ishigami's function by sparse polynomial chaos: `cargo run --example chaos`.
//!
//! y = sin x₁ + 7 sin² x₂ + 0.1 x₃⁴ sin x₁ with independent x uniform on [−π, π] has indices in closed form.

#![expect(clippy::print_stdout, reason = "the numbers are what this example shows")]

use std::error::Error;
use std::f64::consts::PI;

use asperity::chaos::{
    Basis, Candidates, Design, Expansion, MultiIndexSet, PolynomialFamily, SamplingMethod, SparseRegression,
};

fn main() -> Result<(), Box<dyn Error>> {
    let basis = Basis::new(MultiIndexSet::total_degree(3, 12)?, vec![PolynomialFamily::Legendre; 3])?;
    println!("samples   terms   variance   S1       S2       S3       S13");
    for samples in [100, 200, 400] {
        // Sobol' points on [−1, 1]³, and the function there.
        let design = Design::new(SamplingMethod::Sobol, 1, "example", samples, 3)?;
        let point = |i: usize| design.unit(i).into_iter().map(|u| PolynomialFamily::Legendre.from_unit(u)).collect();
        let points: Vec<Vec<f64>> = (0..samples).map(point).collect();
        let values: Vec<f64> = points
            .iter()
            .map(|x| {
                let [x1, x2, x3] = [x[0], x[1], x[2]].map(|x| PI * x);
                x1.sin() + 7.0 * x2.sin().powi(2) + 0.1 * x3.powi(4) * x1.sin()
            })
            .collect();

        // Few of the 455 terms, chosen by cross-validation.
        let matrix = basis.design_matrix(&points);
        let chosen = SparseRegression::default().select(&Candidates::new(matrix.view())?, &values)?;
        let (expansion, _) = Expansion::fit(basis.select(&chosen.terms)?, &points, &values)?;
        let first = expansion.first_order_indices();
        println!(
            "{samples:<9} {:<7} {:<10.4} {:.4}   {:.4}   {:.4}   {:.4}",
            chosen.terms.len(),
            expansion.variance(),
            first[0],
            first[1],
            first[2],
            expansion.subset_index(&[0, 2])
        );
    }
    println!("exact             13.8446    0.3139   0.4424   0.0000   0.2437");
    Ok(())
}
