//! Products and inverses of small dense matrices, column-major. Of sizes known to the compiler they stand in registers,
//! several times as fast as loops over slices; for products a size of 0 stands for any.

use nalgebra::{DMatrixViewMut, DVector};

/// What becomes of y by a product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// It is replaced.
    Set,
    /// The product is added.
    Add,
    /// The product is subtracted.
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
    } else if !y.is_empty() {
        if update == Update::Set {
            y.fill(0.0);
        }
        let sign = if update == Update::Subtract { -1.0 } else { 1.0 };
        for (column, &xj) in a.chunks_exact(y.len()).zip(x) {
            for (yi, &aij) in y.iter_mut().zip(column) {
                *yi += sign * xj * aij;
            }
        }
    }
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
    [rows, inner]: [usize; 2],
    a: &[f64],
    x: &[f64],
    y: &mut [f64],
) {
    if R > 8 {
        beside::<R, C, 2>(update, a, x, y);
    } else if R > 0 {
        beside::<R, C, 4>(update, a, x, y);
    } else {
        for (x, y) in x.chunks(BESIDE * inner).zip(y.chunks_mut(BESIDE * rows)) {
            if y.len() == BESIDE * rows {
                tiles::<BESIDE>(update, rows, a, x, y);
            } else {
                for (x, y) in x.chunks_exact(inner).zip(y.chunks_exact_mut(rows)) {
                    tiles::<1>(update, rows, a, x, y);
                }
            }
        }
    }
}

/// Columns of Y at a time where the size is not known to the compiler: with 8 rows their sums are half of the 16 registers of AVX2.
const BESIDE: usize = 4;

/// [`gemm`] of any size for N columns of Y, in tiles whose sums stand in registers.
fn tiles<const N: usize>(update: Update, rows: usize, a: &[f64], x: &[f64], y: &mut [f64]) {
    let mut top = 0;
    while top < rows {
        top += match rows - top {
            8.. => tile::<8, N>(update, [rows, top], a, x, y),
            4.. => tile::<4, N>(update, [rows, top], a, x, y),
            2.. => tile::<2, N>(update, [rows, top], a, x, y),
            _ => tile::<1, N>(update, [rows, top], a, x, y),
        }
    }
}

/// [`gemm`] for R rows of Y from `top` on and N columns; returns R.
#[inline(always)]
fn tile<const R: usize, const N: usize>(
    update: Update,
    [rows, top]: [usize; 2],
    a: &[f64],
    x: &[f64],
    y: &mut [f64],
) -> usize {
    let columns: [&[f64]; N] = std::array::from_fn(|n| &x[n * x.len() / N..(n + 1) * x.len() / N]);
    let mut sums = [[0.0; R]; N];
    for (j, a) in a.chunks_exact(rows).enumerate() {
        let a = &a[top..top + R];
        for (sums, x) in sums.iter_mut().zip(columns) {
            for i in 0..R {
                sums[i] += a[i] * x[j];
            }
        }
    }
    for (y, sums) in y.chunks_exact_mut(rows).zip(&sums) {
        for (y, sum) in y[top..].iter_mut().zip(sums) {
            update.apply(y, *sum);
        }
    }
    R
}

/// [`gemm`] for N columns of Y at a time: as many sums as the registers hold, so that each entry of A is read once for
/// all of them.
#[inline(always)]
fn beside<const R: usize, const C: usize, const N: usize>(update: Update, a: &[f64], x: &[f64], y: &mut [f64]) {
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

/// Least size of a pivot, as a share of the largest entry that could take its place: threshold pivoting (Duff, Erisman,
/// Reid 1986). Half, twice, and 1, which is partial pivoting: the work of steady states stays the same within a residual of 12 000.
const PIVOT: f64 = 0.1;

/// Replaces A, of R rows, by its inverse: Gauss and Jordan's elimination with row pivoting. False if A is singular or
/// not finite.
#[inline(always)]
pub fn invert<const R: usize>(a: &mut [f64]) -> bool {
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

/// [`invert`] for any number of rows.
#[derive(Clone, Debug)]
pub struct Inverter {
    pivots: DVector<f64>,
    swaps: Vec<usize>,
}

impl Inverter {
    /// Memory for matrices of so many rows.
    pub fn new(rows: usize) -> Self {
        Self {
            pivots: DVector::zeros(rows),
            swaps: vec![0; rows],
        }
    }

    /// [`invert`].
    pub fn invert(&mut self, a: &mut [f64]) -> bool {
        let (n, pivots) = (self.swaps.len(), &mut self.pivots);
        let mut a = DMatrixViewMut::from_slice(a, n, n);
        for k in 0..n {
            let below = a.view_range(k.., k);
            let (row, largest) = (k + below.icamax(), below.camax());
            let row = if a[(k, k)].abs() < PIVOT * largest { row } else { k };
            a.swap_rows(k, row);
            self.swaps[k] = row;
            let inverse = a[(k, k)].recip();
            if !inverse.is_finite() {
                return false;
            }
            pivots.copy_from(&a.column(k));
            a.column_mut(k).fill(0.0);
            for mut column in a.column_iter_mut() {
                let factor = column[k] * inverse;
                column.axpy(-factor, pivots, 1.0);
                column[k] = factor;
            }
            pivots[k] = -1.0;
            a.column_mut(k).axpy(-inverse, pivots, 0.0);
        }
        for (k, &column) in self.swaps.iter().enumerate().rev() {
            a.swap_columns(k, column);
        }
        a.iter().all(|x| x.is_finite())
    }
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
        gemm::<8, 8>(Update::Set, [8, 8], &a, &inverse, &mut product);
        for (k, entry) in product.iter().enumerate() {
            let unit = if k % 9 == 0 { 1.0 } else { 0.0 };
            assert!((entry - unit).abs() < 1e-12);
        }
        let mut any = a.clone();
        assert!(Inverter::new(8).invert(&mut any));
        assert_eq!(any, inverse, "the same elimination");
        for singular in [[1.0, 2.0, 2.0, 4.0], [1.0, f64::NAN, 2.0, 4.0]] {
            assert!(!Inverter::new(2).invert(&mut singular.clone()));
        }
        assert!(!invert::<2>(&mut [1.0, 2.0, 2.0, 4.0]));
        assert!(!invert::<2>(&mut [1.0, f64::NAN, 2.0, 4.0]));
    }

    #[test]
    fn products_are_those_of_any_size() {
        fn compare<const R: usize, const C: usize>(columns: usize) {
            let (a, x, y) = (numbers(R * C, 1), numbers(C * columns, 2), numbers(R * columns, 3));
            for update in [Update::Set, Update::Add, Update::Subtract] {
                let (mut fixed, mut any, mut single) = (y.clone(), y.clone(), [y.clone(), y.clone()]);
                gemm::<R, C>(update, [R, C], &a, &x, &mut fixed);
                gemm::<0, 0>(update, [R, C], &a, &x, &mut any);
                for (k, x) in x.chunks_exact(C).enumerate() {
                    gemv::<R, C>(update, &a, x, &mut single[0][k * R..(k + 1) * R]);
                    gemv::<0, 0>(update, &a, x, &mut single[1][k * R..(k + 1) * R]);
                }
                for other in [any, single[0].clone(), single[1].clone()] {
                    for (fixed, other) in fixed.iter().zip(&other) {
                        assert!(
                            (fixed - other).abs() < 1e-14,
                            "{R} rows, {C} inner, {columns} columns, {update:?}"
                        );
                    }
                }
            }
        }
        for columns in [1, 2, 3, 5, 8] {
            compare::<20, 8>(columns);
            compare::<8, 8>(columns);
            compare::<3, 5>(columns);
            compare::<1, 1>(columns);
        }
    }
}
