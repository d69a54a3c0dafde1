//! Residuals, orthogonality and closed forms.

use ndarray::Array1;

use super::*;
use crate::random;
use ndarray::Array2;

const SIZES: [usize; 9] = [1, 2, 3, 31, 32, 33, 65, 150, 333];

fn normal(rows: usize, columns: usize, index: u64) -> Array2<f64> {
    let values = random::standard_normal(&mut random::stream(5, "dense", index), rows * columns);
    Array2::from_shape_vec((rows, columns), values).unwrap()
}

fn largest(matrix: &Array2<f64>) -> f64 {
    matrix.iter().fold(0.0, |m, value| m.max(value.abs()))
}

#[test]
fn the_triangle_of_cholesky_has_the_matrix_as_its_square_and_solves() {
    for n in SIZES {
        let root = normal(n, n, 1);
        let matrix = root.dot(&root.t()) + Array2::<f64>::eye(n);
        let factor = Cholesky::new(matrix.clone()).unwrap();
        let wanted = normal(n, 1, 2).column(0).to_vec();
        let found = factor.solve(&matrix.dot(&Array1::from(wanted.clone())).to_vec());
        let error = found.iter().zip(&wanted).fold(0.0_f64, |m, (f, w)| m.max((f - w).abs()));
        assert!(error < 1e-10, "{n}: {error:e}");
        let eigen = symmetric_eigen(matrix).unwrap();
        let wanted: f64 = eigen.values.iter().map(|value| value.ln()).sum();
        assert!((factor.log_determinant() - wanted).abs() < 1e-10 * n as f64, "{n}");
    }
}

#[test]
fn cholesky_refuses_matrices_that_are_not_positive_definite() {
    for n in [1, 40, 100] {
        for entry in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut matrix = Array2::<f64>::eye(n);
            matrix[[n - 1, n - 1]] = entry;
            assert!(Cholesky::new(matrix).is_none(), "{n} {entry}");
        }
    }
}

#[test]
fn elimination_solves_systems_that_need_their_pivots_and_shows_singular_ones() {
    for n in SIZES {
        let mut matrix = normal(n, n, 3);
        if n > 1 {
            matrix[[0, 0]] = 0.0;
        }
        let right = normal(n, 1, 4).column(0).to_vec();
        let found = dense_solution(matrix.view(), &right);
        let size = found.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        let residual = matrix.dot(&Array1::from(found)) - Array1::from(right.clone());
        assert!(residual.iter().all(|r| r.abs() < 1e-13 * size * n as f64), "{n}");
        matrix.row_mut(n / 2).fill(0.0);
        assert!(dense_solution(matrix.view(), &right).iter().any(|x| !x.is_finite()), "{n}");
    }
}

#[test]
fn an_upper_triangle_is_solved_in_any_layout() {
    for n in SIZES {
        let mut matrix = normal(n, n, 5) / n as f64;
        matrix.diag_mut().mapv_inplace(|d| d.signum() + d);
        let upper = Array2::from_shape_fn((n, n), |(i, j)| if i <= j { matrix[[i, j]] } else { 0.0 });
        let wanted = normal(n, 70, 6);
        for columns in [1, 70] {
            let wanted = wanted.slice(s![.., ..columns]);
            let mut by_rows = upper.dot(&wanted).as_standard_layout().into_owned();
            let mut by_columns = by_rows.t().as_standard_layout().into_owned();
            solve_upper(matrix.view(), by_rows.view_mut());
            solve_upper(matrix.view(), by_columns.view_mut().reversed_axes());
            assert!(largest(&(&by_rows - &wanted)) < 1e-11, "{n}");
            assert!(largest(&(&by_columns.t() - &wanted)) < 1e-11, "{n}");
        }
    }
}

#[test]
fn a_matrix_is_its_orthonormal_columns_times_its_triangle() {
    for n in SIZES {
        for rows in [n, n + 1, 2 * n + 40] {
            let mut matrix = normal(rows, n, 7);
            // Dependent columns leave the others orthonormal.
            for singular in [false, true] {
                if singular {
                    matrix.column_mut(n - 1).fill(0.0);
                    let first = matrix.column(0).to_owned();
                    matrix.column_mut(n / 2).assign(&first);
                }
                let Qr { q, r } = Qr::new(matrix.clone());
                assert!(largest(&(q.t().dot(&q) - Array2::<f64>::eye(n))) < 1e-13, "{rows} × {n}");
                assert!(largest(&(q.dot(&r) - &matrix)) < 1e-13 * n as f64, "{rows} × {n}");
                assert!(r.indexed_iter().all(|((i, j), value)| i <= j || *value == 0.0));
            }
        }
    }
}

#[test]
fn the_condition_is_the_ratio_of_the_singular_values() {
    for (n, span) in [(1, 0.0), (40, 3.0), (150, 6.0)] {
        let [left, right] = [8, 9].map(|index| Qr::new(normal(n, n, index)).q);
        let scale = Array1::from_shape_fn(n, |i| 10.0_f64.powf(-span * i as f64 / (n as f64 - 1.0).max(1.0)));
        let found = triangular_condition(Qr::new((left * &scale).dot(&right)).r.view());
        assert!((found / 10.0_f64.powf(span) - 1.0).abs() < 1e-15 * 10.0_f64.powf(span) * 100.0, "{n}: {found:e}");
    }
    // Largest values that are equal, close to each other or alone, and a start vector that has hardly any of them.
    for values in [vec![1.0; 60], (0..60).map(|i| 1.0 - 1e-9 * f64::from(i)).collect(), {
        let mut alone = vec![1.0; 60];
        alone[59] = 3.0;
        alone
    }] {
        let spread = values.iter().fold(0.0_f64, |m, v| m.max(*v)) / values.iter().fold(f64::MAX, |m, v| m.min(*v));
        for rotated in [false, true] {
            let mut matrix = Array2::from_diag(&Array1::from(values.clone()));
            if rotated {
                matrix = matrix.dot(&Qr::new(normal(60, 60, 10)).q);
            }
            let found = triangular_condition(Qr::new(matrix).r.view());
            assert!((found / spread - 1.0).abs() < 1e-8, "{found} for {spread}");
        }
    }
    assert_eq!(triangular_condition(Array2::zeros((0, 0)).view()), 1.0);
    for singular in [ndarray::array![[0.0]], ndarray::array![[1.0, 2.0], [0.0, 0.0]], ndarray::array![[f64::NAN]]] {
        assert_eq!(triangular_condition(singular.view()), f64::INFINITY);
    }
    assert!(triangular_condition(ndarray::array![[1e200, 1e200], [0.0, 1e180]].view()) > 1e20);
    assert!((triangular_condition(ndarray::array![[1e-200, 0.0], [0.0, 1e-202]].view()) / 100.0 - 1.0).abs() < 1e-14);
}

/// Checks eigenpairs against the matrix.
fn check(what: &str, matrix: &Array2<f64>) -> Vec<f64> {
    let n = matrix.nrows();
    let SymmetricEigen { values, vectors } = symmetric_eigen(matrix.clone()).unwrap();
    let size = values[n - 1].abs().max(values[0].abs());
    let scaled = Array2::from_shape_fn((n, n), |(k, i)| values[k] * vectors[[k, i]]);
    let residual = largest(&(vectors.dot(matrix) - scaled));
    assert!(residual <= 1e-14 * size, "{what}, {n}: residual {:e}", residual / size);
    let orthogonality = largest(&(vectors.dot(&vectors.t()) - Array2::<f64>::eye(n)));
    assert!(orthogonality < 1e-14, "{what}, {n}: orthogonality {orthogonality:e}");
    assert!(values.is_sorted(), "{what}, {n}");
    values
}

#[test]
fn eigenvectors_are_orthonormal_and_reproduce_the_matrix() {
    for n in SIZES {
        let noise = normal(n, n, 10);
        check("random", &(&noise + &noise.t()));
        check("tiny", &((&noise + &noise.t()) * 1e-170));
        check("zero", &Array2::zeros((n, n)));
        check("identity", &Array2::eye(n));
        check("ones", &Array2::ones((n, n)));
        let few = normal(n, 3, 11);
        check("low rank", &few.dot(&few.t()));
        for length in [0.5, 5.0, 50.0, 500.0] {
            let lag = |i: usize, j: usize| (i as f64 - j as f64) / length;
            check("smooth", &Array2::from_shape_fn((n, n), |(i, j)| (-lag(i, j).powi(2)).exp()));
            check("rough", &Array2::from_shape_fn((n, n), |(i, j)| (-lag(i, j).abs()).exp()));
        }
        // Wilkinson's matrices, weakly coupled, have clusters of eigenvalues.
        for coupling in [1e-14, 1e-8, 1e-3] {
            let glued = Array2::from_shape_fn((n, n), |(i, j)| match i.abs_diff(j) {
                0 => (i % 21) as f64 - 10.0,
                1 => {
                    if i.max(j) % 21 == 0 {
                        coupling
                    } else {
                        1.0
                    }
                }
                _ => 0.0,
            });
            check("glued", &glued.mapv(f64::abs));
        }
        let graded =
            Array2::from_shape_fn((n, n), |(i, j)| 10.0_f64.powf(-0.1 * (i + j) as f64) * (2.0 - (i * j % 3) as f64));
        check("graded", &graded);
    }
}

#[test]
fn second_differences_have_their_closed_eigenvalues() {
    for n in SIZES {
        let matrix = Array2::from_shape_fn((n, n), |(i, j)| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)]);
        for (k, value) in check("differences", &matrix).into_iter().enumerate() {
            let angle = std::f64::consts::PI * (k + 1) as f64 / (n + 1) as f64;
            assert!((value - (2.0 - 2.0 * angle.cos())).abs() < 1e-14, "{n}, {k}: {value}");
        }
    }
}

#[test]
fn only_the_lower_triangle_is_read() {
    let noise = normal(90, 90, 12);
    let symmetric = &noise + &noise.t();
    let lower = Array2::from_shape_fn((90, 90), |(i, j)| if i >= j { symmetric[[i, j]] } else { f64::NAN });
    assert_eq!(symmetric_eigen(lower).unwrap().values, symmetric_eigen(symmetric).unwrap().values);
}

#[test]
fn a_matrix_that_is_not_finite_has_no_eigenvalues() {
    for n in [1, 70] {
        for entry in [f64::NAN, f64::INFINITY] {
            let mut matrix = Array2::<f64>::eye(n);
            matrix[[n / 2, n / 2]] = entry;
            assert_eq!(symmetric_eigen(matrix).unwrap_err(), NotConverged);
        }
    }
}
