//! Inverses of dense matrices whose size the compiler doesn't know, by faer's LU.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::triangular_solve::{solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{MatMut, MatRef, Par};

/// Memory to invert matrices of one size.
#[derive(Clone, Debug)]
pub(super) struct Inverter {
    size: usize,
    factors: Vec<f64>,
    /// Row of the matrix that stands at each row of the factors.
    rows: Vec<usize>,
    /// The inverse of `rows`: faer asks for it.
    places: Vec<usize>,
    scratch: Scratch,
}

impl Inverter {
    pub(super) fn new(size: usize) -> Self {
        Self {
            size,
            factors: vec![0.0; size * size],
            rows: vec![0; size],
            places: vec![0; size],
            scratch: Scratch::new(size),
        }
    }

    /// Replaces a column-major matrix by its inverse. False if it is singular or not finite.
    pub(super) fn invert(&mut self, a: &mut [f64]) -> bool {
        self.factors.copy_from_slice(a);
        if !self.factor() {
            return false;
        }
        let n = self.size;
        a.fill(0.0);
        for (i, &row) in self.rows.iter().enumerate() {
            a[row * n + i] = 1.0;
        }
        let factors = MatRef::from_column_major_slice(&self.factors, n, n);
        let mut a = MatMut::from_column_major_slice_mut(a, n, n);
        solve_unit_lower_triangular_in_place(factors, a.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(factors, a, Par::Seq);
        true
    }

    /// Replaces the matrix in `factors` by its factors. False if it is singular or not finite.
    fn factor(&mut self) -> bool {
        let n = self.size;
        lu_in_place(
            MatMut::from_column_major_slice_mut(&mut self.factors, n, n),
            &mut self.rows,
            &mut self.places,
            Par::Seq,
            MemStack::new(&mut self.scratch.buffer),
            faer::Spec::default(),
        );
        (0..n).all(|i| {
            let pivot = self.factors[i * n + i];
            pivot.is_finite() && pivot != 0.0
        })
    }
}

/// faer's stack memory for one factorization.
struct Scratch {
    size: usize,
    buffer: MemBuffer,
}

impl Scratch {
    fn new(size: usize) -> Self {
        let need = lu_in_place_scratch::<usize, f64>(size, size, Par::Seq, faer::Spec::default());
        Self {
            size,
            buffer: MemBuffer::new(need),
        }
    }
}

impl Clone for Scratch {
    fn clone(&self) -> Self {
        Self::new(self.size)
    }
}

impl std::fmt::Debug for Scratch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scratch")
            .field("size", &self.size)
            .finish_non_exhaustive()
    }
}
