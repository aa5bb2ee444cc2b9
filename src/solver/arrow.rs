//! Periodic block-tridiagonal matrix with a thin border: n blocks of size b around a loop, g border unknowns coupled to
//! all of them.
//!
//! ```text
//!  D0 U0          L0 | R0
//!  L1 D1 U1          | R1
//!     L2 D2 …        | ⋮
//!  Un-1    … Ln-1 Dn-1 | Rn-1
//!  ───────────────────+────
//!  B0 B1 …       Bn-1 | C
//! ```
//! Unknowns whose neighbours change may stand in an order of their own, see [`Arrow::reorder`].
//!
//! Block 0 joins the border, which opens the loop; the other blocks are eliminated in order. Cost and memory are linear
//! in n: O(n (b+g)² b). Pivoting is inside a block; faer inverts the border, and blocks whose size the compiler doesn't
//! know.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::triangular_solve::{solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{MatMut, MatRef, Par};

use super::kernels::{self, gemm, gemv};
use crate::tape::Tape;

/// Sizes of an [`Arrow`] matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Number of blocks n ≥ 3.
    pub blocks: usize,
    /// Block size b.
    pub block: usize,
    /// Border size g.
    pub border: usize,
}

impl Shape {
    /// Number of unknowns n·b + g.
    #[must_use]
    pub fn len(&self) -> usize {
        self.blocks * self.block + self.border
    }

    /// Whether there is no unknown.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Starts of the parts in the storage of an [`Arrow`]: D, U, L, R, B, C, end. Each part holds its blocks in order,
    /// a block its columns.
    fn starts(&self) -> [usize; 7] {
        let (square, strip) = (
            self.blocks * self.block * self.block,
            self.blocks * self.block * self.border,
        );
        let mut start = 0;
        let mut next = |size: usize| {
            start += size;
            start - size
        };
        [square, square, square, strip, strip, self.border * self.border, 0].map(&mut next)
    }

    /// Place of an entry in the storage of an [`Arrow`], if it is in the band.
    #[must_use]
    pub fn index(&self, row: usize, column: usize) -> Option<usize> {
        let Self {
            blocks: n,
            block: b,
            border: g,
        } = *self;
        let [d, u, l, r, s, c, _] = self.starts();
        let split = n * b;
        let (row_block, i) = (row / b, row % b);
        let (column_block, j) = (column / b, column % b);
        let in_block = row_block * b * b + j * b + i;
        match (row < split, column < split) {
            (true, true) if row_block == column_block => Some(d + in_block),
            (true, true) if (row_block + 1) % n == column_block => Some(u + in_block),
            (true, true) if (column_block + 1) % n == row_block => Some(l + in_block),
            (true, true) => None,
            (true, false) => Some(r + (row_block * g + column - split) * b + i),
            (false, true) => Some(s + (column_block * b + j) * g + row - split),
            (false, false) => Some(c + (column - split) * g + row - split),
        }
    }
}

/// The matrix. Indices are those of the vector: blocks in order, then the border, unless it was reordered.
#[derive(Clone, Debug)]
pub struct Arrow {
    shape: Shape,
    values: Vec<f64>,
    /// Place of each unknown of the vector; empty where the vector's order is the matrix's.
    order: Vec<usize>,
}

/// The parts of an [`Arrow`].
struct Parts<'a> {
    diagonal: &'a [f64],
    upper: &'a [f64],
    lower: &'a [f64],
    right: &'a [f64],
    bottom: &'a [f64],
    corner: &'a [f64],
}

impl Arrow {
    /// Zero matrix.
    ///
    /// # Panics
    /// With fewer than three blocks: neighbours would not be distinct.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        assert!(shape.blocks >= 3, "an arrow matrix needs three blocks");
        Self {
            shape,
            values: vec![0.0; shape.starts()[6]],
            order: Vec::new(),
        }
    }

    /// Sets every entry to zero and gives unknown i of the vector the place `order[i]`, a permutation that leaves the
    /// border where it is. Factors keep the order that they were made in.
    pub fn reorder(&mut self, order: &[usize]) {
        self.clear();
        self.order.clear();
        self.order.extend_from_slice(order);
    }

    /// Place of an entry in the storage, if it is in the band.
    #[inline]
    #[must_use]
    pub fn index(&self, row: usize, column: usize) -> Option<usize> {
        let place = |i: usize| self.order.get(i).copied().unwrap_or(i);
        self.shape.index(place(row), place(column))
    }

    /// Sizes.
    #[must_use]
    pub fn shape(&self) -> Shape {
        self.shape
    }

    fn parts(&self) -> Parts<'_> {
        let [_, u, l, r, s, c, _] = self.shape.starts();
        Parts {
            diagonal: &self.values[..u],
            upper: &self.values[u..l],
            lower: &self.values[l..r],
            right: &self.values[r..s],
            bottom: &self.values[s..c],
            corner: &self.values[c..],
        }
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds to an entry. Blocks of the two indices must be equal or neighbours around the loop.
    ///
    /// # Panics
    /// If the entry is outside the band.
    #[inline]
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.add_at(self.index(row, column).expect("an entry in the band"), value);
    }

    /// Adds to the entry at a place that [`Shape::index`] or [`Arrow::index`] found.
    #[inline]
    pub fn add_at(&mut self, index: usize, value: f64) {
        self.values[index] += value;
    }

    /// Replaces a row by a multiple of the unit row: `scale`·x_row.
    pub fn set_unit_row(&mut self, row: usize, scale: f64) {
        for column in 0..self.shape.len() {
            if let Some(index) = self.index(row, column) {
                self.values[index] = 0.0;
            }
        }
        self.add(row, row, scale);
    }

    /// Adds `factor` times border row `from` to border row `into`. Indices are those of the vector.
    ///
    /// # Panics
    /// If an index is not in the border.
    pub fn add_row(&mut self, into: usize, from: usize, factor: f64) {
        let Shape {
            blocks: n,
            block: b,
            border: g,
        } = self.shape;
        let (into, from) = (into - n * b, from - n * b);
        let bottom = self.shape.starts()[4];
        for column in self.values[bottom..].chunks_exact_mut(g) {
            column[into] += factor * column[from];
        }
    }

    /// `out` = A·`x`. Allocates if the unknowns are reordered.
    pub fn multiply(&self, x: &[f64], out: &mut [f64]) {
        if self.order.is_empty() {
            self.multiply_in_order(x, out);
        } else {
            let (mut ordered, mut image) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            for (&place, x) in self.order.iter().zip(x) {
                ordered[place] = *x;
            }
            self.multiply_in_order(&ordered, &mut image);
            for (&place, out) in self.order.iter().zip(out) {
                *out = image[place];
            }
        }
    }

    fn multiply_in_order(&self, x: &[f64], out: &mut [f64]) {
        let Shape {
            blocks: n,
            block: b,
            border: g,
        } = self.shape;
        let Parts {
            diagonal,
            upper,
            lower,
            right,
            bottom,
            corner,
        } = self.parts();
        let split = n * b;
        out.fill(0.0);
        for k in 0..n {
            let row = k * b..(k + 1) * b;
            let (next, previous) = ((k + 1) % n, (k + n - 1) % n);
            let blocks = k * b * b..(k + 1) * b * b;
            let strip = k * b * g..(k + 1) * b * g;
            let y = &mut out[row.clone()];
            gemv::<0, 0>(1.0, &diagonal[blocks.clone()], &x[row.clone()], y);
            gemv::<0, 0>(1.0, &upper[blocks.clone()], &x[next * b..(next + 1) * b], y);
            gemv::<0, 0>(1.0, &lower[blocks], &x[previous * b..(previous + 1) * b], y);
            gemv::<0, 0>(1.0, &right[strip.clone()], &x[split..], y);
            gemv::<0, 0>(1.0, &bottom[strip], &x[row], &mut out[split..]);
        }
        gemv::<0, 0>(1.0, corner, &x[split..], &mut out[split..]);
    }
}

/// A pivot block was singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the Jacobian is singular (block {block})")]
pub struct Singular {
    /// Block where elimination stopped; the number of blocks stands for the border.
    pub block: usize,
}

/// Inverts dense blocks of a size that the compiler doesn't know, by LU: factors, row order beside them.
#[derive(Clone, Debug)]
struct DenseLu {
    size: usize,
    factors: Vec<f64>,
    rows: Vec<usize>,
}

impl DenseLu {
    fn new(size: usize) -> Self {
        Self {
            size,
            factors: vec![0.0; size * size],
            rows: vec![0; size],
        }
    }

    /// Factors the matrix that stands in `factors`. False if it is singular or not finite.
    fn factor(&mut self, places: &mut [usize], stack: &mut MemStack) -> bool {
        let n = self.size;
        lu_in_place(
            MatMut::from_column_major_slice_mut(&mut self.factors, n, n),
            &mut self.rows,
            &mut places[..n],
            Par::Seq,
            stack,
            faer::Spec::default(),
        );
        (0..n).all(|i| {
            let pivot = self.factors[i * n + i];
            pivot.is_finite() && pivot != 0.0
        })
    }

    fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.factors, self.size, self.size)
    }

    /// Replaces a column-major matrix by its inverse. False if it is singular or not finite.
    fn invert(&mut self, a: &mut [f64], places: &mut [usize], stack: &mut MemStack) -> bool {
        self.factors.copy_from_slice(a);
        if !self.factor(places, stack) {
            return false;
        }
        let n = self.size;
        a.fill(0.0);
        for (i, &row) in self.rows.iter().enumerate() {
            a[row * n + i] = 1.0;
        }
        let mut a = MatMut::from_column_major_slice_mut(a, n, n);
        solve_unit_lower_triangular_in_place(self.view(), a.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(self.view(), a, Par::Seq);
        true
    }
}

/// faer's stack memory for one dense factorization.
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

/// Factors of an [`Arrow`] with all scratch memory: factoring and solving allocate nothing.
#[derive(Clone, Debug)]
pub struct ArrowLu {
    shape: Shape,
    /// For pivot blocks whose size the compiler doesn't know.
    pivot: DenseLu,
    /// D_k⁻¹: a product with it waits for nothing, where two triangular solutions wait for each unknown in turn.
    inverses: Vec<f64>,
    /// L_{k+1} D_k⁻¹ at k + 1: what elimination takes from a block to the next, so that it needn't wait for D_k⁻¹.
    lower: Vec<f64>,
    /// D_k⁻¹ [U_k | border columns], b×(b+w) each.
    solved: Vec<f64>,
    /// Border rows w×b of each block after elimination.
    rows: Vec<f64>,
    /// For the border.
    corner: DenseLu,
    /// Inverse of block 0 and the border, w×w.
    border: Vec<f64>,
    /// Right-hand side [U_k | border columns] of the block in work.
    columns: Vec<f64>,
    next_border: Vec<f64>,
    /// Where each row went, as faer wants it; unused.
    places: Vec<usize>,
    work: Vec<f64>,
    tail: Vec<f64>,
    scratch: Scratch,
    /// Of the matrix that was factored.
    order: Vec<usize>,
    /// A right-hand side in that order.
    ordered: Vec<f64>,
}

/// Calls a method for the size of a block, B, and of the border together with block 0, W: those of the variator's
/// Eulerian rings, with one cell an element and in space too, and of `ALE` and `ANCF` rings alone, so that the compiler
/// knows them. 0 stands for any other; each size takes 20 kB of an FMU for two machines.
macro_rules! for_size {
    ($lu:expr, $method:ident($argument:expr)) => {
        match ($lu.shape.block, $lu.shape.border) {
            (4, 2) => $lu.$method::<4, 6>($argument),
            (3, 10) => $lu.$method::<3, 13>($argument),
            (6, 12) => $lu.$method::<6, 18>($argument),
            (8, 12) => $lu.$method::<8, 20>($argument),
            (10, 12) => $lu.$method::<10, 22>($argument),
            _ => $lu.$method::<0, 0>($argument),
        }
    };
}

impl ArrowLu {
    /// Workspace for matrices of this shape.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        let (n, b) = (shape.blocks, shape.block);
        let w = b + shape.border;
        Self {
            shape,
            pivot: DenseLu::new(b),
            inverses: vec![0.0; n * b * b],
            lower: vec![0.0; n * b * b],
            solved: vec![0.0; n * b * (b + w)],
            rows: vec![0.0; n * b * w],
            corner: DenseLu::new(w),
            border: vec![0.0; w * w],
            columns: vec![0.0; b * (b + w)],
            next_border: vec![0.0; b * w],
            places: vec![0; w],
            work: vec![0.0; w],
            tail: vec![0.0; w],
            scratch: Scratch::new(w),
            order: Vec::new(),
            ordered: Vec::new(),
        }
    }

    /// Passes the factors by a tape.
    pub fn pass(&mut self, tape: &mut Tape<'_>) {
        for part in [
            &mut self.inverses,
            &mut self.lower,
            &mut self.solved,
            &mut self.rows,
            &mut self.border,
        ] {
            tape.reals(part);
        }
        let mut reordered = !self.order.is_empty();
        tape.flag(&mut reordered);
        let length = if reordered { self.shape.len() } else { 0 };
        self.order.resize(length, 0);
        self.ordered.resize(length, 0.0);
        if reordered {
            tape.indices(&mut self.order, length);
        }
    }

    /// Factors `a`.
    ///
    /// # Errors
    /// A block or the border is singular or not finite.
    pub fn factor(&mut self, a: &Arrow) -> Result<(), Singular> {
        for_size!(self, factor_sized(a))
    }

    /// [`ArrowLu::factor`] for one size.
    fn factor_sized<const B: usize, const W: usize>(&mut self, a: &Arrow) -> Result<(), Singular> {
        let Shape {
            blocks: n,
            block: b,
            border: g,
        } = self.shape;
        let w = b + g;
        self.order.clone_from(&a.order);
        self.ordered.resize(a.order.len(), 0.0);
        let a = a.parts();
        let stack = MemStack::new(&mut self.scratch.buffer);
        // Border: block 0, then the globals.
        for j in 0..b {
            let column = &mut self.border[j * w..(j + 1) * w];
            column[..b].copy_from_slice(&a.diagonal[j * b..(j + 1) * b]);
            column[b..].copy_from_slice(&a.bottom[j * g..(j + 1) * g]);
        }
        for j in 0..g {
            let column = &mut self.border[(b + j) * w..(b + j + 1) * w];
            column[..b].copy_from_slice(&a.right[j * b..(j + 1) * b]);
            column[b..].copy_from_slice(&a.corner[j * g..(j + 1) * g]);
        }
        // Border rows of each block.
        self.rows.fill(0.0);
        for k in 1..n {
            for j in 0..b {
                let column = &mut self.rows[k * b * w + j * w..k * b * w + (j + 1) * w];
                if k == 1 {
                    for (x, y) in column[..b].iter_mut().zip(&a.upper[j * b..(j + 1) * b]) {
                        *x += y;
                    }
                }
                if k == n - 1 {
                    for (x, y) in column[..b].iter_mut().zip(&a.lower[j * b..(j + 1) * b]) {
                        *x += y;
                    }
                }
                column[b..].copy_from_slice(&a.bottom[k * b * g + j * g..k * b * g + (j + 1) * g]);
            }
        }
        let border_columns = |k: usize, out: &mut [f64]| {
            out[..b * b].fill(0.0);
            let block = k * b * b..(k + 1) * b * b;
            if k == 1 {
                for (x, y) in out[..b * b].iter_mut().zip(&a.lower[block.clone()]) {
                    *x += y;
                }
            }
            if k == n - 1 {
                for (x, y) in out[..b * b].iter_mut().zip(&a.upper[block]) {
                    *x += y;
                }
            }
            out[b * b..].copy_from_slice(&a.right[k * b * g..(k + 1) * b * g]);
        };
        self.inverses[b * b..2 * b * b].copy_from_slice(&a.diagonal[b * b..2 * b * b]);
        border_columns(1, &mut self.next_border);
        for k in 1..n {
            if k < n - 1 {
                self.columns[..b * b].copy_from_slice(&a.upper[k * b * b..(k + 1) * b * b]);
            } else {
                self.columns[..b * b].fill(0.0);
            }
            self.columns[b * b..].copy_from_slice(&self.next_border);
            let (inverses, pivots) = self.inverses.split_at_mut((k + 1) * b * b);
            let inverse = &mut inverses[k * b * b..];
            let regular = if B > 0 {
                kernels::invert::<B>(inverse)
            } else {
                self.pivot.invert(inverse, &mut self.places, stack)
            };
            if !regular {
                return Err(Singular { block: k });
            }
            let solved = &mut self.solved[k * b * (b + w)..(k + 1) * b * (b + w)];
            solved.fill(0.0);
            gemm::<B, B>([b, b], 1.0, inverse, &self.columns, solved);
            let (x_upper, x_border) = solved.split_at(b * b);
            let (done, rest) = self.rows.split_at_mut((k + 1) * b * w);
            let row = &done[k * b * w..];
            gemm::<W, B>([w, b], -1.0, row, x_border, &mut self.border);
            if k + 1 < n {
                gemm::<W, B>([w, b], -1.0, row, x_upper, &mut rest[..b * w]);
                let block = (k + 1) * b * b..(k + 2) * b * b;
                let lower = &mut self.lower[block.clone()];
                lower.fill(0.0);
                gemm::<B, B>([b, b], 1.0, &a.lower[block.clone()], inverse, lower);
                let pivot = &mut pivots[..b * b];
                pivot.copy_from_slice(&a.diagonal[block]);
                let (upper, border) = self.columns.split_at(b * b);
                gemm::<B, B>([b, b], -1.0, lower, upper, pivot);
                border_columns(k + 1, &mut self.next_border);
                gemm::<B, B>([b, b], -1.0, lower, border, &mut self.next_border);
            }
        }
        if self.corner.invert(&mut self.border, &mut self.places, stack) {
            Ok(())
        } else {
            Err(Singular { block: n })
        }
    }

    /// Replaces the right-hand side `x` by the solution.
    pub fn solve(&mut self, x: &mut [f64]) {
        if self.order.is_empty() {
            self.solve_in_order(x);
            return;
        }
        let mut ordered = std::mem::take(&mut self.ordered);
        for (&place, x) in self.order.iter().zip(&*x) {
            ordered[place] = *x;
        }
        self.solve_in_order(&mut ordered);
        for (&place, x) in self.order.iter().zip(x) {
            *x = ordered[place];
        }
        self.ordered = ordered;
    }

    fn solve_in_order(&mut self, x: &mut [f64]) {
        for_size!(self, solve_sized(x));
    }

    /// Solves with factors of the same size.
    fn solve_sized<const B: usize, const W: usize>(&mut self, x: &mut [f64]) {
        let (n, b) = (self.shape.blocks, self.shape.block);
        let w = b + self.shape.border;
        self.tail[..b].copy_from_slice(&x[..b]);
        self.tail[b..].copy_from_slice(&x[n * b..]);
        for k in 1..n {
            let (head, rest) = x.split_at_mut((k + 1) * b);
            let y = &mut head[k * b..];
            if k + 1 < n {
                gemv::<B, B>(-1.0, &self.lower[(k + 1) * b * b..(k + 2) * b * b], y, &mut rest[..b]);
            }
            self.work[..b].copy_from_slice(y);
            y.fill(0.0);
            gemv::<B, B>(1.0, &self.inverses[k * b * b..(k + 1) * b * b], &self.work[..b], y);
            gemv::<W, B>(-1.0, &self.rows[k * b * w..(k + 1) * b * w], y, &mut self.tail);
        }
        self.work.copy_from_slice(&self.tail);
        self.tail.fill(0.0);
        gemv::<W, W>(1.0, &self.border, &self.work, &mut self.tail);
        for k in (1..n).rev() {
            let (head, rest) = x.split_at_mut((k + 1) * b);
            let y = &mut head[k * b..];
            let solved = &self.solved[k * b * (b + w)..(k + 1) * b * (b + w)];
            gemv::<B, W>(-1.0, &solved[b * b..], &self.tail, y);
            if k + 1 < n {
                gemv::<B, B>(-1.0, &solved[..b * b], &rest[..b], y);
            }
        }
        x[..b].copy_from_slice(&self.tail[..b]);
        x[n * b..].copy_from_slice(&self.tail[b..]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pushbelt_lab::noise;

    #[test]
    fn solves_what_it_multiplies() {
        let mut random = noise(1);
        for (blocks, block, border) in [
            (3, 1, 2),
            (4, 3, 0),
            (9, 5, 4),
            (30, 8, 12),
            (7, 3, 10),
            (5, 10, 12),
            (6, 7, 10),
        ] {
            let shape = Shape { blocks, block, border };
            let mut a = Arrow::new(shape);
            let n = shape.len();
            let block_of = |i: usize| i / block;
            for i in 0..n {
                for j in 0..n {
                    let (p, q) = (block_of(i), block_of(j));
                    let near = i >= blocks * block
                        || j >= blocks * block
                        || p == q
                        || (p + 1) % blocks == q
                        || (q + 1) % blocks == p;
                    if near {
                        a.add(i, j, random());
                    }
                }
            }
            let x: Vec<f64> = (0..n).map(|_| random()).collect();
            let mut y = vec![0.0; n];
            a.multiply(&x, &mut y);
            let mut lu = ArrowLu::new(shape);
            lu.factor(&a).unwrap();
            lu.solve(&mut y);
            let error = x.iter().zip(&y).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-8, "{shape:?}: {error}");
        }
    }

    #[test]
    fn solves_in_another_order() {
        let shape = Shape {
            blocks: 5,
            block: 4,
            border: 3,
        };
        let (n, split) = (shape.len(), shape.blocks * shape.block);
        let order: Vec<usize> = (0..n).map(|i| if i < split { 7 * i % split } else { i }).collect();
        let mut random = noise(5);
        let mut a = Arrow::new(shape);
        a.reorder(&order);
        let mut dense = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                if a.index(i, j).is_some() {
                    dense[i * n + j] = random();
                    a.add(i, j, dense[i * n + j]);
                }
            }
        }
        let x: Vec<f64> = (0..n).map(|_| random()).collect();
        let mut y = vec![0.0; n];
        a.multiply(&x, &mut y);
        for (row, y) in dense.chunks_exact(n).zip(&y) {
            let product: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((product - y).abs() < 1e-12);
        }
        let mut lu = ArrowLu::new(shape);
        lu.factor(&a).unwrap();
        lu.solve(&mut y);
        let error = x.iter().zip(&y).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-8, "{error}");
    }

    #[test]
    fn tells_a_singular_matrix() {
        for (block, border) in [(2, 1), (3, 10)] {
            let blocks = 4;
            let shape = Shape { blocks, block, border };
            let a = Arrow::new(shape);
            assert_eq!(ArrowLu::new(shape).factor(&a), Err(Singular { block: 1 }));
        }
    }
}
