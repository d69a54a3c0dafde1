use super::*;

pub(super) fn layer(youngs_modulus_pa: f64, poisson_ratio: f64, base: Base) -> Layer {
    Layer { thickness_m: 1.0, material: Elastic { youngs_modulus_pa, poisson_ratio }, base }
}

pub(super) fn elastic(youngs_modulus_pa: f64, poisson_ratio: f64) -> Base {
    Base::Elastic(Elastic { youngs_modulus_pa, poisson_ratio })
}

/// Returns Airy's function (c + dz) e^{sq(z−z₀)} and its derivatives at z for c and d, as [φ, φ′, φ″, φ‴].
fn airy(q: f64, sign: f64, z0: f64, z: f64) -> [[f64; 2]; 4] {
    let s = sign * q;
    let e = (s * (z - z0)).exp();
    [
        [e, z * e],
        [s * e, (1.0 + s * z) * e],
        [s * s * e, (2.0 * s + s * s * z) * e],
        [s.powi(3) * e, (3.0 * s * s + s.powi(3) * z) * e],
    ]
}

/// Returns the displacements [along the wave, into the body] of Airy's function.
fn displacements(material: Elastic, q: f64, phi: [f64; 4]) -> [f64; 2] {
    let (g, nu) = (material.shear_modulus_pa(), material.poisson_ratio);
    let along = (1.0 - nu) * phi[2] / q + nu * q * phi[0];
    let into = (1.0 - nu) * phi[3] / (q * q) - (2.0 - nu) * phi[1];
    [along / (2.0 * g), into / (2.0 * g)]
}

/// Computes C(q) from the boundary conditions by Gaussian elimination.
fn compliance_by_boundary_conditions(layer: &Layer, q: f64) -> f64 {
    let h = layer.thickness_m;
    // Columns: the layer's decaying and growing pair, the base's decaying pair.
    let at = |z: f64, column: usize| -> [f64; 4] {
        let family = match column / 2 {
            0 => airy(q, -1.0, 0.0, z),
            1 => airy(q, 1.0, h, z),
            _ => airy(q, -1.0, h, z),
        };
        family.map(|pair| pair[column % 2])
    };
    let n = if let Base::Elastic(_) = layer.base { 6 } else { 4 };
    let mut rows = vec![vec![0.0; n + 1]; n];
    for column in 0..n {
        let inside = column < 4;
        if inside {
            // σ_zz = −q²φ = −1 and no shear, qφ′, on top.
            rows[0][column] = q * q * at(0.0, column)[0];
            rows[1][column] = q * at(0.0, column)[1];
        }
        let phi = at(h, column);
        match layer.base {
            Base::Rigid => {
                [rows[2][column], rows[3][column]] = displacements(layer.material, q, phi);
            }
            Base::Slippery => {
                rows[2][column] = q * phi[1];
                rows[3][column] = displacements(layer.material, q, phi)[1];
            }
            Base::Elastic(base) => {
                let (sign, material) = if inside { (1.0, layer.material) } else { (-1.0, base) };
                let [along, into] = displacements(material, q, phi);
                rows[2][column] = sign * q * q * phi[0];
                rows[3][column] = sign * q * phi[1];
                rows[4][column] = sign * along;
                rows[5][column] = sign * into;
            }
        }
    }
    rows[0][n] = 1.0;
    let solution = eliminate(rows);
    (0..4).map(|column| solution[column] * displacements(layer.material, q, at(0.0, column))[1]).sum()
}

/// Solves a linear system that contains its right-hand side, with rows scaled to their largest entry and row exchanges.
fn eliminate(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for row in &mut rows {
        let largest = row[..n].iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        row.iter_mut().for_each(|value| *value /= largest);
    }
    for i in 0..n {
        let pivot = (i..n).max_by(|a, b| rows[*a][i].abs().total_cmp(&rows[*b][i].abs())).unwrap();
        rows.swap(i, pivot);
        for j in i + 1..n {
            let factor = rows[j][i] / rows[i][i];
            for k in i..=n {
                rows[j][k] -= factor * rows[i][k];
            }
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| rows[i][k] * x[k]).sum();
        x[i] = (rows[i][n] - sum) / rows[i][i];
    }
    x
}

#[test]
fn the_compliance_satisfies_the_boundary_conditions() {
    let bases = [
        Base::Rigid,
        Base::Slippery,
        elastic(1.0, 0.3),
        elastic(0.01, 0.5),
        elastic(300.0, 0.1),
        elastic(2.0, -0.4),
        elastic(1e-4, 0.2),
    ];
    let mut worst = 0.0_f64;
    for base in bases {
        for nu in [-0.5, 0.0, 0.3, 0.5] {
            let layer = Layer { thickness_m: 0.7, ..layer(1.0, nu, base) };
            for q in [0.03, 0.2, 0.9, 2.0, 5.0, 20.0] {
                let found = Substrate::Layer(layer).compliance_m_per_pa(q);
                let wanted = compliance_by_boundary_conditions(&layer, q);
                // Elimination loses digits on thin, nearly incompressible layers.
                worst = worst.max((found / wanted - 1.0).abs());
                assert!((found / wanted - 1.0).abs() < 1e-7, "{base:?} {nu} {q}: {found:e} {wanted:e}");
            }
        }
    }
    println!("worst: {worst:.1e}");
}

#[test]
fn limits_equal_half_spaces_and_thin_layers() {
    let close = |a: f64, b: f64, tolerance: f64| assert!((a / b - 1.0).abs() < tolerance, "{a:e} is not {b:e}");
    for (nu, base) in [(0.3, Base::Rigid), (0.2, Base::Slippery), (0.5, elastic(7.0, 0.1)), (0.0, elastic(0.1, 0.4))] {
        let substrate = Substrate::Layer(layer(2.0, nu, base));
        let half_space = Substrate::HalfSpace { modulus_pa: substrate.modulus_pa() };
        for q in [30.0, 1e3, 1e9] {
            close(substrate.compliance_m_per_pa(q), half_space.compliance_m_per_pa(q), 1e-14);
        }
        let q = 1e-9;
        let wanted = match base {
            Base::Elastic(base) => 2.0 / (base.contact_modulus_pa() * q),
            _ => substrate.mean_compliance_m_per_pa().unwrap(),
        };
        // The change is of first order in qh times the ratio of the moduli.
        close(substrate.compliance_m_per_pa(q), wanted, 1e-7);
        assert_eq!(substrate.compliance_m_per_pa(0.0), substrate.mean_compliance_m_per_pa().unwrap_or(f64::INFINITY));
    }
    let bonded = Substrate::Layer(layer(2.0, 0.3, Base::Rigid));
    close(bonded.mean_compliance_m_per_pa().unwrap(), 1.3 * 0.4 / (2.0 * 0.7), 1e-15);
    // A layer of the same material as its base is a half-space.
    let same = Substrate::Layer(layer(2.0, 0.3, elastic(2.0, 0.3)));
    for q in [1e-6, 1e-3, 0.1, 0.5, 1.0, 3.0, 50.0] {
        close(same.compliance_m_per_pa(q), 2.0 / (same.modulus_pa() * q), 1e-14);
    }
    // For materials that differ only in Poisson's ratio, R = 1/(1 − λe^{−2qh}) with λ = 1 − (1−ν₁)/(1−ν₂).
    let other = Substrate::Layer(layer(2.4, 0.2, elastic(3.0, 0.5)));
    for q in [1e-3, 0.3, 1.0, 4.0] {
        let lambda = 1.0 - 0.8 / 0.5;
        close(
            other.compliance_m_per_pa(q) * other.modulus_pa() * q / 2.0,
            1.0 / (1.0 - lambda * (-2.0 * q).exp()),
            1e-14,
        );
    }
    // A thin incompressible layer follows lubrication: C = h³q²/(3G)·… with R = (2qh)³/12.
    let incompressible = Substrate::Layer(layer(3.0, 0.5, Base::Rigid));
    for q in [1e-8, 1e-5] {
        close(incompressible.compliance_m_per_pa(q), q * q / 3.0, 1e-9);
    }
    assert_eq!(incompressible.mean_compliance_m_per_pa(), Some(0.0));
    assert_eq!(bonded.usual_mean_compliance_m_per_pa(Grid::new(4, 4, 1.0, 1.0).unwrap()), 1.3 * 0.4 / (2.0 * 0.7));
    let soft = same.usual_mean_compliance_m_per_pa(Grid::new(4, 8, 1.0, 1.0).unwrap());
    close(soft, 8.0 / (std::f64::consts::PI * same.modulus_pa()), 1e-14);
}

#[test]
fn stiffer_or_thinner_layers_yield_less() {
    let at = |substrate: Layer, q: f64| Substrate::Layer(substrate).compliance_m_per_pa(q);
    for q in [0.01, 0.1, 1.0, 3.0] {
        let bases = [Base::Rigid, elastic(100.0, 0.3), elastic(2.0, 0.3), elastic(0.5, 0.3), elastic(1e-3, 0.3)];
        let yields = bases.map(|base| at(layer(1.0, 0.3, base), q));
        assert!(yields.is_sorted(), "{yields:?}");
        assert!(at(layer(1.0, 0.3, Base::Rigid), q) < at(layer(1.0, 0.3, Base::Slippery), q));
        let thicker = [0.1, 0.3, 1.0].map(|thickness_m| at(Layer { thickness_m, ..layer(1.0, 0.3, Base::Rigid) }, q));
        assert!(thicker.is_sorted());
    }
}

#[test]
fn invalid_materials_are_refused() {
    let fails = |substrate: Substrate| substrate.validate().unwrap_err().to_string();
    assert!(fails(Substrate::HalfSpace { modulus_pa: 0.0 }).contains("contact modulus"));
    assert!(fails(Substrate::Layer(Layer { thickness_m: -1.0, ..layer(1.0, 0.3, Base::Rigid) })).contains("thickness"));
    assert!(fails(Substrate::Layer(layer(f64::NAN, 0.3, Base::Rigid))).contains("Young's modulus of the layer"));
    assert!(fails(Substrate::Layer(layer(1.0, 0.51, Base::Slippery))).contains("Poisson's ratio of the layer"));
    assert!(fails(Substrate::Layer(layer(1.0, 0.3, elastic(-1.0, 0.3)))).contains("Young's modulus of the base"));
    assert!(fails(Substrate::Layer(layer(1.0, 0.3, elastic(1.0, -1.0)))).contains("Poisson's ratio of the base"));
    assert!(Substrate::Layer(layer(1.0, 0.5, elastic(1.0, -0.9))).validate().is_ok());
}
