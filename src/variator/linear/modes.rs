//! Slow modes of the descriptor system.

use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Mat, c64};
use nalgebra::DMatrix;
use nalgebra::linalg::balancing::balance_parlett_reinsch;

use super::descriptor::Descriptor;
use super::working_point::{LinearError, WorkingPoint};
use super::{NEUTRAL, SHIFT};
use crate::variator::settings::{Inputs, Parameters};

/// Eigenvalues of the steady state at the initial ratio and speed below `frequency`, Hz, in falling
/// order of growth: real and imaginary part, 1/s; of a conjugate pair the one with the positive
/// imaginary part.
///
/// # Errors
/// See [`LinearError`].
pub fn modes(parameters: &Parameters, inputs: &Inputs, frequency: f64) -> Result<Vec<[f64; 2]>, LinearError> {
    let mut point = WorkingPoint::new(parameters, inputs)?;
    let descriptor = Descriptor::new(&mut point.system, &point.state);
    let cut_off = std::f64::consts::TAU * frequency;
    let shift = SHIFT * cut_off;
    let inverted = Balanced::new(&descriptor.factors(shift).solve(&descriptor.e))?.matrix;
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

/// D⁻¹MD, whose rows have the norms of its columns. Without balancing, rounding moves eigenvalues
/// near the cut-off by a tenth, because the unknowns have many units.
struct Balanced {
    matrix: Mat<f64>,
    /// The diagonal of D.
    scale: Vec<f64>,
}

impl Balanced {
    fn new(matrix: &Mat<f64>) -> Result<Self, LinearError> {
        let n = matrix.nrows();
        let mut copy = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)]);
        if copy.iter().any(|x| !x.is_finite()) {
            return Err(LinearError::Eigenvalues);
        }
        let scale = balance_parlett_reinsch(&mut copy).iter().copied().collect();
        let matrix = Mat::from_fn(n, n, |i, j| copy[(i, j)]);
        Ok(Self { matrix, scale })
    }
}

/// The eigenvalue of the pencil that belongs to `value` of (σE − A)⁻¹E.
fn unshifted(sigma: f64, value: c64) -> c64 {
    c64::new(sigma, 0.0) - c64::new(1.0, 0.0) / value
}

/// The slow modes of a descriptor system, the slowest first.
pub(super) struct SlowModes {
    /// Real basis of the right invariant subspace, with a column for each real mode and two for a
    /// conjugate pair.
    pub right: Mat<f64>,
    /// The same of the left one, as rows.
    pub left: Mat<f64>,
    /// Real and imaginary part of the eigenvalue of each column. Of a pair that with the positive
    /// imaginary part comes first.
    pub poles: Vec<[f64; 2]>,
}

struct Eigenpair {
    lambda: c64,
    vector: Vec<c64>,
}

/// Modes with |λ| below `cut_off`, neutral ones left out: λ = σ − 1/μ for the eigenvalues μ of (σE
/// − A)⁻¹E. `factors` are those of σE − A.
pub(super) fn slow_modes(
    descriptor: &Descriptor,
    factors: &PartialPivLu<f64>,
    cut_off: f64,
) -> Result<SlowModes, LinearError> {
    let shift = SHIFT * cut_off;
    let Balanced { matrix, scale } = Balanced::new(&factors.solve(&descriptor.e))?;
    // One of each pair of conjugates.
    let pairs = |matrix: &Mat<f64>| -> Result<Vec<Eigenpair>, LinearError> {
        let eigen = matrix.eigen().map_err(|_| LinearError::Eigenvalues)?;
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let pair = |k: usize| Eigenpair {
            lambda: unshifted(shift, values[k]),
            vector: (0..matrix.nrows()).map(|i| vectors[(i, k)]).collect(),
        };
        let all = (0..values.nrows()).map(pair);
        Ok(all.filter(|pair| pair.lambda.im >= 0.0).collect())
    };
    let mut right = pairs(&matrix)?;
    right.retain(|pair| is_slow(pair.lambda, cut_off));
    right.sort_by(|a, b| a.lambda.norm().total_cmp(&b.lambda.norm()));
    // Left eigenvectors w of D⁻¹(σE − A)⁻¹ED; those of the pencil are w D⁻¹(σE − A)⁻¹. Rounding may
    // move an eigenvalue across the cut-off, so each is matched with the nearest one.
    let mut others = pairs(&matrix.transpose().to_owned())?;
    let mut left = Vec::with_capacity(right.len());
    for &Eigenpair { lambda, .. } in &right {
        let distance = |k: usize| (others[k].lambda - lambda).norm();
        let nearest = (0..others.len())
            .min_by(|&i, &j| distance(i).total_cmp(&distance(j)))
            .ok_or(LinearError::Eigenvalues)?;
        let found = others.swap_remove(nearest);
        let differs = (found.lambda - lambda).norm() > 0.1 * lambda.norm();
        if differs || is_oscillation(found.lambda) != is_oscillation(lambda) {
            return Err(LinearError::Eigenvalues);
        }
        left.push(found);
    }
    let rows = descriptor.a.nrows();
    let (right_basis, left_basis) = (real_basis(&right, rows), real_basis(&left, rows));
    let scaled = |basis: &Mat<f64>, factor: &dyn Fn(usize) -> f64| {
        Mat::from_fn(rows, basis.ncols(), |i, j| factor(i) * basis[(i, j)])
    };
    let left = factors.solve_transpose(&scaled(&left_basis, &|i| 1.0 / scale[i]));
    let mut poles = Vec::new();
    for Eigenpair { lambda, .. } in &right {
        if is_oscillation(*lambda) {
            poles.extend([[lambda.re, lambda.im], [lambda.re, -lambda.im]]);
        } else {
            poles.push([lambda.re, 0.0]);
        }
    }
    Ok(SlowModes {
        right: scaled(&right_basis, &|i| scale[i]),
        left: left.transpose().to_owned(),
        poles,
    })
}

/// Whether a mode is slower than `cut_off`, 1/s, and not neutral.
fn is_slow(lambda: c64, cut_off: f64) -> bool {
    (NEUTRAL..cut_off).contains(&lambda.norm())
}

/// Whether the eigenvalue is one of a conjugate pair.
fn is_oscillation(lambda: c64) -> bool {
    lambda.im > 1.0e-9 * lambda.norm()
}

fn real_basis(modes: &[Eigenpair], rows: usize) -> Mat<f64> {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for Eigenpair { lambda, vector } in modes {
        columns.push(vector.iter().map(|x| x.re).collect());
        if is_oscillation(*lambda) {
            columns.push(vector.iter().map(|x| x.im).collect());
        }
    }
    Mat::from_fn(rows, columns.len(), |i, j| columns[j][i])
}
