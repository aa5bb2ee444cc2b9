//! Products and inverses of small dense matrices, column-major. Of sizes known to the compiler they stand in registers,
//! several times as fast as loops over slices; for products a size of 0 stands for any.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// y += α·A·x, A of R rows and C columns.
#[inline(always)]
pub fn gemv<const R: usize, const C: usize>(alpha: f64, a: &[f64], x: &[f64], y: &mut [f64]) {
    if R > 0 {
        fixed::<R, C>(alpha, a, x, y);
    } else if !y.is_empty() {
        for (column, &xj) in a.chunks_exact(y.len()).zip(x) {
            let s = alpha * xj;
            for (yi, &aij) in y.iter_mut().zip(column) {
                *yi += s * aij;
            }
        }
    }
}

#[inline(always)]
fn fixed<const R: usize, const C: usize>(alpha: f64, a: &[f64], x: &[f64], y: &mut [f64]) {
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
        y[i] += alpha * (even[i] + odd[i]);
    }
}

/// Y += α·A·X, A of `rows` rows (R) and `inner` columns (C).
#[inline(always)]
pub fn gemm<const R: usize, const C: usize>(
    [rows, inner]: [usize; 2],
    alpha: f64,
    a: &[f64],
    x: &[f64],
    y: &mut [f64],
) {
    if R > 0 {
        for (x, y) in x.chunks_exact(C).zip(y.chunks_exact_mut(R)) {
            fixed::<R, C>(alpha, a, x, y);
        }
    } else if let Some(columns) = y.len().checked_div(rows) {
        matmul(
            MatMut::from_column_major_slice_mut(y, rows, columns),
            Accum::Add,
            MatRef::from_column_major_slice(a, rows, inner),
            MatRef::from_column_major_slice(x, inner, columns),
            alpha,
            Par::Seq,
        );
    }
}

/// Replaces A, of R rows, by its inverse: Gauss and Jordan's elimination with row pivoting. False if A is singular or
/// not finite.
#[inline(always)]
pub fn invert<const R: usize>(a: &mut [f64]) -> bool {
    let a = &mut a.as_chunks_mut::<R>().0[..R];
    let mut swaps = [0; R];
    for k in 0..R {
        let mut row = k;
        for i in k + 1..R {
            if a[k][i].abs() > a[k][row].abs() {
                row = i;
            }
        }
        swaps[k] = row;
        a.iter_mut().for_each(|column| column.swap(k, row));
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
        a.swap(k, column);
    }
    a.as_flattened().iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use pushbelt_lab::noise;

    #[test]
    fn an_inverse_is_one() {
        let mut random = noise(4);
        let a: Vec<f64> = (0..64).map(|_| random()).collect();
        let (mut inverse, mut product) = (a.clone(), [0.0; 64]);
        assert!(invert::<8>(&mut inverse));
        gemm::<8, 8>([8, 8], 1.0, &a, &inverse, &mut product);
        for (k, entry) in product.iter().enumerate() {
            let unit = if k % 9 == 0 { 1.0 } else { 0.0 };
            assert!((entry - unit).abs() < 1e-12);
        }
        assert!(!invert::<2>(&mut [1.0, 2.0, 2.0, 4.0]));
        assert!(!invert::<2>(&mut [1.0, f64::NAN, 2.0, 4.0]));
    }

    #[test]
    fn products_are_those_of_any_size() {
        let mut random = noise(3);
        let mut numbers = |n: usize| (0..n).map(|_| random()).collect::<Vec<f64>>();
        let (a, x, y) = (numbers(20 * 8), numbers(8 * 3), numbers(20 * 3));
        let (mut fixed, mut any, mut single) = (y.clone(), y.clone(), y);
        gemm::<20, 8>([20, 8], -0.7, &a, &x, &mut fixed);
        gemm::<0, 0>([20, 8], -0.7, &a, &x, &mut any);
        for (x, y) in x.chunks_exact(8).zip(single.chunks_exact_mut(20)) {
            gemv::<0, 0>(-0.7, &a, x, y);
        }
        for ((fixed, any), single) in fixed.iter().zip(&any).zip(&single) {
            assert!((fixed - any).abs() < 1e-14 && (fixed - single).abs() < 1e-14);
        }
        // An odd number of columns.
        let (mut fixed, mut any) = (vec![0.0; 3], vec![0.0; 3]);
        gemv::<3, 5>(1.0, &a[..15], &x[..5], &mut fixed);
        gemv::<0, 0>(1.0, &a[..15], &x[..5], &mut any);
        for (fixed, any) in fixed.iter().zip(&any) {
            assert!((fixed - any).abs() < 1e-14);
        }
    }
}
