//! Slow modes of the descriptor system.

use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Mat, c64};
use nalgebra::DMatrix;
use nalgebra::linalg::balancing::balance_parlett_reinsch;

use crate::variator::linear::descriptor::Descriptor;
use crate::variator::linear::working_point::{LinearError, WorkingPoint};
use crate::variator::linear::{NEUTRAL, SHIFT};
use crate::variator::settings::parameters::Parameters;
use crate::variator::settings::signals::Inputs;

/// Eigenvalues of the steady state at the initial ratio and speed below `frequency`, Hz, the one
/// that grows most first. Each is its real and imaginary part, 1/s; of a conjugate pair only the
/// one with the positive imaginary part is listed. A run with long steps doesn't show whether fast
/// modes grow: the integrator damps them.
///
/// # Errors
/// See [`LinearError`].
pub fn modes(parameters: &Parameters, inputs: &Inputs, frequency: f64) -> Result<Vec<[f64; 2]>, LinearError> {
    let mut point = WorkingPoint::new(parameters, inputs)?;
    let descriptor = Descriptor::new(&mut point.system, &point.state);
    let cut_off = std::f64::consts::TAU * frequency;
    let shift = SHIFT * cut_off;
    let (inverted, _) = balanced(&descriptor.factors(shift).solve(&descriptor.e))?;
    let values = inverted.eigenvalues().map_err(|_| LinearError::Eigenvalues)?;
    let mut modes: Vec<[f64; 2]> = values
        .iter()
        .map(|&value| unshifted(shift, value))
        .filter(|lambda| lambda.im >= 0.0 && is_slow(*lambda, cut_off))
        .map(|lambda| [lambda.re, lambda.im])
        .collect();
    modes.sort_by(|a, b| b[0].total_cmp(&a[0]));
    Ok(modes)
}

/// D⁻¹MD, whose rows have the norms of its columns, and the diagonal D. Without balancing, rounding
/// moves eigenvalues near the cut-off by a tenth, because the unknowns have many units.
fn balanced(matrix: &Mat<f64>) -> Result<(Mat<f64>, Vec<f64>), LinearError> {
    let n = matrix.nrows();
    let mut copy = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)]);
    if copy.iter().any(|x| !x.is_finite()) {
        return Err(LinearError::Eigenvalues);
    }
    let scale = balance_parlett_reinsch(&mut copy);
    Ok((Mat::from_fn(n, n, |i, j| copy[(i, j)]), scale.iter().copied().collect()))
}

/// The eigenvalue of the pencil that belongs to `value` of (σE − A)⁻¹E.
fn unshifted(sigma: f64, value: c64) -> c64 {
    c64::new(sigma, 0.0) - c64::new(1.0, 0.0) / value
}

/// The slow modes of a descriptor system, the slowest first: a real basis of the right invariant
/// subspace, with a column for each real mode and two for a conjugate pair; the same of the left
/// one, as rows; and the eigenvalues, one for each column. Of a pair that with the positive
/// imaginary part comes first.
pub(super) type SlowModes = (Mat<f64>, Mat<f64>, Vec<[f64; 2]>);

/// Modes with |λ| below `cut_off`, neutral ones left out: λ = σ − 1/μ for the eigenvalues μ of (σE
/// − A)⁻¹E. `factors` are those of σE − A.
pub(super) fn slow_modes(
    descriptor: &Descriptor,
    factors: &PartialPivLu<f64>,
    cut_off: f64,
) -> Result<SlowModes, LinearError> {
    let shift = SHIFT * cut_off;
    let (inverted, scale) = balanced(&factors.solve(&descriptor.e))?;
    // One of each pair of conjugates.
    let pairs = |matrix: &Mat<f64>| -> Result<Vec<(c64, Vec<c64>)>, LinearError> {
        let eigen = matrix.eigen().map_err(|_| LinearError::Eigenvalues)?;
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let lambda = |k: usize| unshifted(shift, values[k]);
        let column = |k: usize| (0..matrix.nrows()).map(|i| vectors[(i, k)]).collect();
        let upper = (0..values.nrows()).filter(|&k| lambda(k).im >= 0.0);
        Ok(upper.map(|k| (lambda(k), column(k))).collect())
    };
    let mut right = pairs(&inverted)?;
    right.retain(|(lambda, _)| is_slow(*lambda, cut_off));
    right.sort_by(|(a, _), (b, _)| a.norm().total_cmp(&b.norm()));
    // Left eigenvectors w of D⁻¹(σE − A)⁻¹ED; those of the pencil are w D⁻¹(σE − A)⁻¹. Rounding may
    // move an eigenvalue across the cut-off, so each is matched with the nearest one.
    let mut others = pairs(&inverted.transpose().to_owned())?;
    let mut left = Vec::with_capacity(right.len());
    for (lambda, _) in &right {
        let far = |k: usize| (others[k].0 - *lambda).norm();
        let nearest = (0..others.len())
            .min_by(|&i, &j| far(i).total_cmp(&far(j)))
            .ok_or(LinearError::Eigenvalues)?;
        let (other, vector) = others.swap_remove(nearest);
        if (other - *lambda).norm() > 0.1 * lambda.norm() || is_oscillation(other) != is_oscillation(*lambda)
        {
            return Err(LinearError::Eigenvalues);
        }
        left.push((other, vector));
    }
    let rows = descriptor.a.nrows();
    let (of_right, of_left) = (real_basis(&right, rows), real_basis(&left, rows));
    let scaled = |basis: &Mat<f64>, factor: &dyn Fn(usize) -> f64| {
        Mat::from_fn(rows, basis.ncols(), |i, j| factor(i) * basis[(i, j)])
    };
    let left = factors.solve_transpose(&scaled(&of_left, &|i| 1.0 / scale[i]));
    let mut poles = Vec::new();
    for (lambda, _) in &right {
        if is_oscillation(*lambda) {
            poles.extend([[lambda.re, lambda.im], [lambda.re, -lambda.im]]);
        } else {
            poles.push([lambda.re, 0.0]);
        }
    }
    let right = scaled(&of_right, &|i| scale[i]);
    Ok((right, left.transpose().to_owned(), poles))
}

/// Whether a mode is slower than `cut_off`, 1/s, and not neutral.
fn is_slow(lambda: c64, cut_off: f64) -> bool {
    (NEUTRAL..cut_off).contains(&lambda.norm())
}

/// Whether the eigenvalue is one of a conjugate pair.
fn is_oscillation(lambda: c64) -> bool {
    lambda.im > 1.0e-9 * lambda.norm()
}

/// Real and imaginary parts of eigenvectors.
fn real_basis(modes: &[(c64, Vec<c64>)], rows: usize) -> Mat<f64> {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for (lambda, vector) in modes {
        columns.push(vector.iter().map(|x| x.re).collect());
        if is_oscillation(*lambda) {
            columns.push(vector.iter().map(|x| x.im).collect());
        }
    }
    Mat::from_fn(rows, columns.len(), |i, j| columns[j][i])
}
