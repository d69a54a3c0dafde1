//! Polynomial chaos expansions of published functions.

use asperity::chaos::{Basis, Design, Expansion, MultiIndexSet, PolynomialFamily, SamplingMethod};
use asperity_testing::{BOREHOLE, ISHIGAMI, SOBOL_G, TestFunction};

use crate::{Result, error, table};

pub(crate) fn functions() -> Result<String> {
    let cases = [
        ("Ishigami", ISHIGAMI, vec![(6, 200), (8, 400), (10, 700), (12, 1024), (14, 1500)]),
        ("borehole", BOREHOLE, vec![(2, 150), (3, 500), (4, 1500)]),
        ("Sobol’ G", SOBOL_G, vec![(4, 300), (6, 2000), (8, 2500), (10, 4000)]),
    ];
    let mut rows = Vec::new();
    for (name, function, sizes) in &cases {
        for (degree, samples) in sizes {
            let expansion = expand(function, *degree, *samples)?;
            let largest = |found: Vec<f64>, wanted: &[f64]| {
                let differences = found.iter().zip(wanted).map(|(found, wanted)| (found - wanted).abs());
                error(differences.fold(0.0, f64::max))
            };
            rows.push(vec![
                (*name).to_owned(),
                degree.to_string(),
                expansion.coefficients().len().to_string(),
                samples.to_string(),
                error(expansion.mean() / function.mean - 1.0),
                error(expansion.variance() / function.variance - 1.0),
                largest(expansion.first_order_indices(), function.first),
                largest(expansion.total_indices(), function.total),
            ]);
        }
    }
    let headers = [
        "function",
        "degree",
        "terms",
        "samples",
        "mean",
        "variance",
        "first indices, absolute",
        "total indices, absolute",
    ];
    let works =
        cases.iter().map(|(name, function, _)| format!("{name}: {}", function.name)).collect::<Vec<_>>().join("; ");
    Ok(format!(
        "## Ishigami, borehole and Sobol’ G\n\nExpansions by least squares over Sobol’ points. The first and the last function have closed forms; the statistics of the \
         borehole are known to five digits. The G function has kinks, so its series converges slowly: degree 6 misses 0.6 % of the variance of |x|. {works}.\n\n{}",
        table(&headers, rows)
    ))
}

fn expand(function: &TestFunction, degree: usize, samples: usize) -> Result<Expansion> {
    let family = |place| if place < function.normal { PolynomialFamily::Hermite } else { PolynomialFamily::Legendre };
    let families: Vec<PolynomialFamily> = (0..function.first.len()).map(family).collect();
    let basis = Basis::new(MultiIndexSet::total_degree(families.len(), degree)?, families.clone())?;
    let design = Design::new(SamplingMethod::Sobol, 3, "expansion", samples, families.len())?;
    let points: Vec<Vec<f64>> = (0..samples)
        .map(|place| design.unit(place).iter().zip(&families).map(|(unit, family)| family.from_unit(*unit)).collect())
        .collect();
    let response: Vec<f64> = points.iter().map(|point| (function.evaluate)(point)).collect();
    Ok(Expansion::fit(basis, &points, &response)?.0)
}
