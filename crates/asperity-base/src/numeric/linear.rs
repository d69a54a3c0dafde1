//! Scalar products and small dense linear systems.

/// Returns Σ aᵢ bᵢ, summed in the order of the elements.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Solves a square system by Gaussian elimination with row pivoting; the solutions replace the right-hand sides, one
/// per row.
///
/// A singular direction has the solution zero.
#[inline]
pub fn solve<R: AsMut<[f64]>, B: AsMut<[f64]>>(matrix: &mut [R], right: &mut [B]) {
    let n = matrix.len();
    for column in 0..n {
        let mut pivot = column;
        for row in column + 1..n {
            if matrix[row].as_mut()[column].abs() > matrix[pivot].as_mut()[column].abs() {
                pivot = row;
            }
        }
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        let ((_, [head, rows @ ..]), (_, [top, rights @ ..])) =
            (matrix.split_at_mut(column), right.split_at_mut(column))
        else {
            return;
        };
        let (head, top) = (head.as_mut(), top.as_mut());
        if head[column] == 0.0 {
            continue;
        }
        for (row, right) in rows.iter_mut().zip(rights) {
            let row = row.as_mut();
            let factor = row[column] / head[column];
            row[column + 1..n].iter_mut().zip(&head[column + 1..n]).for_each(|(x, h)| *x -= factor * h);
            right.as_mut().iter_mut().zip(&*top).for_each(|(x, t)| *x -= factor * t);
        }
    }
    for i in (0..n).rev() {
        let row = matrix[i].as_mut();
        let (head, solved) = right.split_at_mut(i + 1);
        for (k, x) in head[i].as_mut().iter_mut().enumerate() {
            let rest: f64 = row[i + 1..n].iter().zip(solved.iter_mut()).map(|(a, b)| a * b.as_mut()[k]).sum();
            *x = if row[i] == 0.0 { 0.0 } else { (*x - rest) / row[i] };
        }
    }
}

/// Returns the solution for one right-hand side; see [`solve`].
pub fn solution(mut matrix: Vec<Vec<f64>>, right: &[f64]) -> Vec<f64> {
    let mut rows: Vec<[f64; 1]> = right.iter().map(|value| [*value]).collect();
    solve(&mut matrix, &mut rows);
    rows.into_iter().flatten().collect()
}

/// Solves a symmetric positive definite system in place by Cholesky factorisation, after scaling its diagonal to one.
///
/// `matrix` contains the rows one after the other. Returns `false` if a pivot is too small for a well-determined
/// solution.
pub fn solve_positive_definite(matrix: &mut [f64], right: &mut [f64]) -> bool {
    /// Smallest pivot of a unit diagonal.
    const LEAST_PIVOT: f64 = 1e-11;
    let n = right.len();
    let scale: Vec<f64> = (0..n).map(|i| matrix[i * n + i].sqrt()).collect();
    if scale.iter().any(|s| s.is_nan() || *s == 0.0) {
        return false;
    }
    for i in 0..n {
        right[i] /= scale[i];
        for j in 0..n {
            matrix[i * n + j] /= scale[i] * scale[j];
        }
    }
    for i in 0..n {
        for j in 0..=i {
            let product: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let rest = matrix[i * n + j] - product;
            if i == j {
                if rest.is_nan() || rest < LEAST_PIVOT {
                    return false;
                }
                matrix[i * n + i] = rest.sqrt();
            } else {
                matrix[i * n + j] = rest / matrix[j * n + j];
            }
        }
        let product: f64 = (0..i).map(|k| matrix[i * n + k] * right[k]).sum();
        right[i] = (right[i] - product) / matrix[i * n + i];
    }
    for i in (0..n).rev() {
        let product: f64 = (i + 1..n).map(|k| matrix[k * n + i] * right[k]).sum();
        right[i] = (right[i] - product) / matrix[i * n + i];
    }
    right.iter_mut().zip(&scale).for_each(|(x, s)| *x /= s);
    true
}

/// Returns the inverse of a small symmetric matrix by Gauss–Jordan elimination; `None` unless all pivots are positive.
pub fn inverse(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let n = matrix.len();
    for pivot in 0..n {
        let diagonal = matrix[pivot][pivot];
        if !(diagonal > 0.0 && diagonal.is_finite()) {
            return None;
        }
        matrix[pivot][pivot] = 1.0;
        matrix[pivot].iter_mut().for_each(|entry| *entry /= diagonal);
        let row = matrix[pivot].clone();
        for (_, other) in matrix.iter_mut().enumerate().filter(|(index, _)| *index != pivot) {
            let factor = std::mem::take(&mut other[pivot]);
            other.iter_mut().zip(&row).for_each(|(entry, above)| *entry -= factor * above);
        }
    }
    (n > 0).then_some(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elimination_solves_a_system_that_needs_its_pivots() {
        // x = (1, −2, 3), and twice that.
        let mut matrix = [[0.0, 2.0, 1.0], [1.0, 1.0, 1.0], [4.0, -1.0, 0.5]];
        let mut right = [[-1.0, -2.0], [2.0, 4.0], [7.5, 15.0]];
        solve(&mut matrix, &mut right);
        for (row, wanted) in right.iter().zip([1.0, -2.0, 3.0]) {
            assert!((row[0] - wanted).abs() < 1e-14 && (row[1] - 2.0 * wanted).abs() < 1e-14, "{right:?}");
        }
        let (mut singular, mut right) = (vec![vec![2.0, 0.0], vec![0.0, 0.0]], vec![[1.0], [1.0]]);
        solve(&mut singular, &mut right);
        assert_eq!(right, [[0.5], [0.0]]);
    }

    #[test]
    fn a_badly_scaled_positive_definite_system_is_solved() {
        let (mut matrix, mut right) = (vec![4e12, 2.0, 2.0, 3e-12], vec![6e6, 5e-6]);
        assert!(solve_positive_definite(&mut matrix, &mut right));
        assert!((right[0] / 1e-6 - 1.0).abs() < 1e-14 && (right[1] / 1e6 - 1.0).abs() < 1e-14, "{right:?}");
        assert!(!solve_positive_definite(&mut [1.0, 1.0, 1.0, 1.0], &mut [1.0, 1.0]));
    }

    #[test]
    fn a_small_matrix_times_its_inverse_is_one() {
        let matrix = vec![vec![4.0, 1.0, -2.0], vec![1.0, 3.0, 0.5], vec![-2.0, 0.5, 5.0]];
        let inverse = inverse(matrix.clone()).unwrap();
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| matrix[i][k] * inverse[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
        assert!(super::inverse(vec![vec![1.0, 2.0], vec![2.0, 1.0]]).is_none());
    }
}
