//! Runge–Kutta methods as data.

/// Explicit method with an error estimate.
#[derive(Debug)]
pub(super) struct Tableau {
    /// Order of the solution that is used for the next step.
    pub(super) order: usize,
    pub(super) nodes: &'static [f64],
    /// Weights of the first i slopes in row i.
    pub(super) stages: &'static [&'static [f64]],
    pub(super) weights: &'static [f64],
    pub(super) error: ErrorEstimate,
}

/// Formula of the error of a step from its slopes.
#[derive(Debug)]
pub(super) enum ErrorEstimate {
    /// Difference of two solutions.
    Difference(&'static [f64]),
    /// ε₅²/√(ε₅² + ε₃²/100) from the weights of ε₅ and ε₃.
    Pair(&'static [f64], &'static [f64]),
}

/// Fehlberg's method of order 5, with the embedded method of order 4 as error estimate.
///
/// # References
/// Fehlberg, *Computing* **6** (1970) 61, <https://doi.org/10.1007/BF02241732>.
pub(super) const FEHLBERG: Tableau = Tableau {
    order: 5,
    nodes: &[0.0, 1.0 / 4.0, 3.0 / 8.0, 12.0 / 13.0, 1.0, 1.0 / 2.0],
    stages: &[
        &[],
        &[1.0 / 4.0],
        &[3.0 / 32.0, 9.0 / 32.0],
        &[1932.0 / 2197.0, -7200.0 / 2197.0, 7296.0 / 2197.0],
        &[439.0 / 216.0, -8.0, 3680.0 / 513.0, -845.0 / 4104.0],
        &[-8.0 / 27.0, 2.0, -3544.0 / 2565.0, 1859.0 / 4104.0, -11.0 / 40.0],
    ],
    weights: &[16.0 / 135.0, 0.0, 6656.0 / 12825.0, 28561.0 / 56430.0, -9.0 / 50.0, 2.0 / 55.0],
    error: ErrorEstimate::Difference(&[1.0 / 360.0, 0.0, -128.0 / 4275.0, -2197.0 / 75240.0, 1.0 / 50.0, 2.0 / 55.0]),
};

/// Dormand and Prince's method of order 8, whose error is estimated by formulas of orders 5 and 3.
///
/// # References
/// Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I* (2nd ed., 1993), §II.5 and §II.10.
pub(super) const DORMAND_PRINCE: Tableau = Tableau {
    order: 8,
    nodes: &[
        0.0,
        0.05260015195876773,
        0.0789002279381516,
        0.1183503419072274,
        0.2816496580927726,
        0.3333333333333333,
        0.25,
        0.3076923076923077,
        0.6512820512820513,
        0.6,
        0.8571428571428571,
        1.0,
    ],
    stages: &[
        &[],
        &[0.05260015195876773],
        &[0.0197250569845379, 0.0591751709536137],
        &[0.02958758547680685, 0.0, 0.08876275643042054],
        &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
        &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
        &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
        &[
            0.03709200011850479,
            0.0,
            0.0,
            0.17038392571223998,
            0.10726203044637328,
            -0.015319437748624402,
            0.008273789163814023,
        ],
        &[
            0.6241109587160757,
            0.0,
            0.0,
            -3.3608926294469414,
            -0.868219346841726,
            27.59209969944671,
            20.154067550477894,
            -43.48988418106996,
        ],
        &[
            0.47766253643826434,
            0.0,
            0.0,
            -2.4881146199716677,
            -0.590290826836843,
            21.230051448181193,
            15.279233632882423,
            -33.28821096898486,
            -0.020331201708508627,
        ],
        &[
            -0.9371424300859873,
            0.0,
            0.0,
            5.186372428844064,
            1.0914373489967295,
            -8.149787010746927,
            -18.52006565999696,
            22.739487099350505,
            2.4936055526796523,
            -3.0467644718982196,
        ],
        &[
            2.273310147516538,
            0.0,
            0.0,
            -10.53449546673725,
            -2.0008720582248625,
            -17.9589318631188,
            27.94888452941996,
            -2.8589982771350235,
            -8.87285693353063,
            12.360567175794303,
            0.6433927460157636,
        ],
    ],
    weights: &[
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ],
    error: ErrorEstimate::Pair(
        &[
            0.01312004499419488,
            0.0,
            0.0,
            0.0,
            0.0,
            -1.2251564463762044,
            -0.4957589496572502,
            1.6643771824549864,
            -0.35032884874997366,
            0.3341791187130175,
            0.08192320648511571,
            -0.022355307863886294,
        ],
        &[
            -0.18980075407240762,
            0.0,
            0.0,
            0.0,
            0.0,
            4.450312892752409,
            1.8915178993145003,
            -5.801203960010585,
            -0.4226823213237919,
            -0.1521609496625161,
            0.20136540080403034,
            0.02265179219836082,
        ],
    ),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_sum_to_their_nodes_and_weights_integrate_powers() {
        for tableau in [&FEHLBERG, &DORMAND_PRINCE] {
            for (row, node) in tableau.stages.iter().zip(tableau.nodes) {
                assert!(
                    (row.iter().sum::<f64>() - node).abs() < 1e-14 * (1.0 + row.iter().map(|a| a.abs()).sum::<f64>())
                );
            }
            // Σ b_i c_i^k = 1/(k+1) below the order, and not at it.
            for k in 0..=tableau.order {
                let sum: f64 = tableau.weights.iter().zip(tableau.nodes).map(|(b, c)| b * c.powi(k as i32)).sum();
                assert_eq!((sum - 1.0 / (k + 1) as f64).abs() < 1e-14, k < tableau.order, "{k} of {}", tableau.order);
            }
            let estimates = match tableau.error {
                ErrorEstimate::Difference(d) => vec![d],
                ErrorEstimate::Pair(five, three) => vec![five, three],
            };
            for weights in estimates {
                assert!(weights.iter().sum::<f64>().abs() < 1e-14);
            }
        }
    }
}
