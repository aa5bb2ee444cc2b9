//! Products and inverses of small dense matrices, column-major. With sizes known to the compiler
//! they stay in registers, several times as fast as loops over slices; a size of 0 stands for any,
//! by nalgebra, which may allocate.

use nalgebra::{DMatrixView, DMatrixViewMut};

/// Effect of a product on y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    Set,
    Add,
    Subtract,
}

impl Update {
    #[inline(always)]
    fn apply(self, y: &mut f64, product: f64) {
        *y = match self {
            Self::Set => product,
            Self::Add => *y + product,
            Self::Subtract => *y - product,
        };
    }
}

/// Updates y by A·x, A of R rows and C columns.
#[inline(always)]
pub fn gemv<const R: usize, const C: usize>(update: Update, a: &[f64], x: &[f64], y: &mut [f64]) {
    if R > 0 {
        fixed::<R, C>(update, a, x, y);
    } else {
        general(update, y.len(), x.len(), 1, a, x, y);
    }
}

/// Updates Y, of `rows` and `columns`, by A·X of any size, A of `inner` columns.
fn general(update: Update, rows: usize, inner: usize, columns: usize, a: &[f64], x: &[f64], y: &mut [f64]) {
    let a = DMatrixView::from_slice(a, rows, inner);
    let x = DMatrixView::from_slice(x, inner, columns);
    let sign = if update == Update::Subtract { -1.0 } else { 1.0 };
    let old = if update == Update::Set { 0.0 } else { 1.0 };
    DMatrixViewMut::from_slice(y, rows, columns).gemm(sign, &a, &x, old);
}

#[inline(always)]
fn fixed<const R: usize, const C: usize>(update: Update, a: &[f64], x: &[f64], y: &mut [f64]) {
    let (a, x, y) = (&a[..R * C], &x[..C], &mut y[..R]);
    // Two sums: one waits for its addition while the other takes the next column.
    let (mut even, mut odd) = ([0.0; R], [0.0; R]);
    for j in 0..C / 2 {
        let (left, right) = (2 * j, 2 * j + 1);
        for i in 0..R {
            even[i] += a[left * R + i] * x[left];
            odd[i] += a[right * R + i] * x[right];
        }
    }
    if C % 2 == 1 {
        for i in 0..R {
            even[i] += a[(C - 1) * R + i] * x[C - 1];
        }
    }
    for i in 0..R {
        update.apply(&mut y[i], even[i] + odd[i]);
    }
}

/// Updates Y by A·X, A of `rows` rows (R) and `inner` columns (C).
#[inline(always)]
pub fn gemm<const R: usize, const C: usize>(
    update: Update,
    rows: usize,
    inner: usize,
    a: &[f64],
    x: &[f64],
    y: &mut [f64],
) {
    if R > 8 {
        blocked::<R, C, 2>(update, a, x, y);
    } else if R > 0 {
        blocked::<R, C, 4>(update, a, x, y);
    } else {
        general(update, rows, inner, y.len() / rows, a, x, y);
    }
}

/// [`gemm`] for N columns of Y at a time: as many sums as the registers hold, so that each entry of
/// A is read once for all of them.
#[inline(always)]
fn blocked<const R: usize, const C: usize, const N: usize>(
    update: Update,
    a: &[f64],
    x: &[f64],
    y: &mut [f64],
) {
    let a = &a[..R * C];
    let (x, y) = (x.as_chunks::<C>().0, y.as_chunks_mut::<R>().0);
    let ((x, x_rest), (y, y_rest)) = (x.as_chunks::<N>(), y.as_chunks_mut::<N>());
    for (x, y) in x.iter().zip(y) {
        let mut sums = [[0.0; R]; N];
        for j in 0..C {
            for (sums, x) in sums.iter_mut().zip(x) {
                for i in 0..R {
                    sums[i] += a[j * R + i] * x[j];
                }
            }
        }
        for (y, sums) in y.as_flattened_mut().iter_mut().zip(sums.as_flattened()) {
            update.apply(y, *sums);
        }
    }
    for (x, y) in x_rest.iter().zip(y_rest) {
        fixed::<R, C>(update, a, x, y);
    }
}

/// The largest magnitude of an entry that is a number, in eight independent maxima.
pub fn largest(x: &[f64]) -> f64 {
    let (eights, rest) = x.as_chunks::<8>();
    let mut most = [0.0_f64; 8];
    for eight in eights {
        for (most, x) in most.iter_mut().zip(eight) {
            *most = most.max(x.abs());
        }
    }
    most.iter().chain(rest).fold(0.0, |most, x| most.max(x.abs()))
}

/// Least size of a pivot, as a fraction of the largest entry that could take its place: threshold
/// pivoting (Duff, Erisman, Reid 1986). Half, twice, and 1, which is partial pivoting: the work of
/// steady states stays the same within a residual of 12 000.
const PIVOT: f64 = 0.1;

/// Replaces A, of R rows, by its inverse: Gauss and Jordan's elimination with row pivoting. False
/// if A is singular or not finite.
#[inline(always)]
pub fn invert<const R: usize>(a: &mut [f64]) -> bool {
    if R == 0 {
        let n = a.len().isqrt();
        let mut a = DMatrixViewMut::from_slice(a, n, n);
        return a.clone_owned().lu().try_inverse_to(&mut a) && a.iter().all(|x| x.is_finite());
    }
    let a = &mut a.as_chunks_mut::<R>().0[..R];
    let mut swaps = [0; R];
    for k in 0..R {
        let largest = a[k][k..].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let mut row = k;
        if a[k][k].abs() < PIVOT * largest {
            row = (k..R).find(|&i| a[k][i].abs() == largest).unwrap_or(k);
            a.iter_mut().for_each(|column| column.swap(k, row));
        }
        swaps[k] = row;
        let inverse = a[k][k].recip();
        if !inverse.is_finite() {
            return false;
        }
        let mut pivots = std::mem::replace(&mut a[k], [0.0; R]);
        for column in a.iter_mut() {
            let factor = column[k] * inverse;
            for i in 0..R {
                column[i] -= pivots[i] * factor;
            }
            column[k] = factor;
        }
        pivots[k] = -1.0;
        a[k] = pivots.map(|x| -x * inverse);
    }
    for (k, &column) in swaps.iter().enumerate().rev() {
        if column != k {
            a.swap(k, column);
        }
    }
    a.as_flattened().iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::super::tests::numbers;
    use super::*;

    #[test]
    fn an_inverse_is_one() {
        let mut a = numbers(64, 4);
        // Without pivoting there would be none.
        a[0] = 0.0;
        let (mut inverse, mut product) = (a.clone(), [0.0; 64]);
        assert!(invert::<8>(&mut inverse));
        gemm::<8, 8>(Update::Set, 8, 8, &a, &inverse, &mut product);
        for (k, entry) in product.iter().enumerate() {
            let unit = if k % 9 == 0 { 1.0 } else { 0.0 };
            assert!((entry - unit).abs() < 1e-12);
        }
        let mut other = a;
        assert!(invert::<0>(&mut other));
        for (found, expected) in other.iter().zip(&inverse) {
            assert!((found - expected).abs() < 1e-12);
        }
        for singular in [[1.0, 2.0, 2.0, 4.0], [1.0, f64::NAN, 2.0, 4.0]] {
            assert!(!invert::<0>(&mut singular.clone()));
            assert!(!invert::<2>(&mut singular.clone()));
        }
    }
}
