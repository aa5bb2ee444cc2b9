//! Factors of an [`Arrow`] and solutions with them.
//!
//! Block 0 joins the border, which opens the loop; the other blocks are eliminated in order. Cost
//! and memory are linear in n: O(n (b+g)² b). Pivoting is inside a block.

use super::super::kernels::{Update, gemm, gemv, invert};
use super::{Arrow, Parts, Shape, block, to_matrix_order, to_vector_order};
use pushbelt_archive::Archive;

/// A pivot block was singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the Jacobian is singular (block {block})")]
pub struct Singular {
    /// Block where elimination stopped; the number of blocks stands for the border.
    pub block: usize,
}

/// Factors of an [`Arrow`] with all scratch memory: factoring and solving allocate nothing where
/// the compiler has the size.
#[derive(Clone, Debug)]
pub struct ArrowLu {
    shape: Shape,
    /// D_k⁻¹: its products have no dependent operations, unlike two triangular solutions.
    inverses: Vec<f64>,
    /// L_{k+1} D_k⁻¹ at k + 1: eliminating the next block does not wait for D_k⁻¹.
    lower: Vec<f64>,
    /// D_k⁻¹ [U_k | border columns], b×(b+w) each.
    solved: Vec<f64>,
    /// Border rows w×b of each block after elimination.
    rows: Vec<f64>,
    /// Inverse of block 0 and the border, w×w.
    border: Vec<f64>,
    /// Right-hand side [U_k | border columns] of the block in work.
    columns: Vec<f64>,
    next_border: Vec<f64>,
    work: Vec<f64>,
    tail: Vec<f64>,
    /// Order of the matrix that was factored.
    order: Vec<usize>,
    /// A right-hand side in that order.
    ordered: Vec<f64>,
}

/// Calls a method with the sizes of a block, B, and of the border together with block 0, W, as
/// constants: those of belts in the plane and in space, and of a planar ring alone, else 0. Each
/// size takes 20 kB of an FMU for two machines.
macro_rules! for_size {
    ($lu:expr, $method:ident($argument:expr)) => {
        match ($lu.shape.block, $lu.shape.border) {
            (4, 2) => $lu.$method::<4, 6>($argument),
            (3, 15) => $lu.$method::<3, 18>($argument),
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
            inverses: vec![0.0; n * b * b],
            lower: vec![0.0; n * b * b],
            solved: vec![0.0; n * b * (b + w)],
            rows: vec![0.0; n * b * w],
            border: vec![0.0; w * w],
            columns: vec![0.0; b * (b + w)],
            next_border: vec![0.0; b * w],
            work: vec![0.0; w],
            tail: vec![0.0; w],
            order: (0..shape.len()).collect(),
            ordered: vec![0.0; shape.len()],
        }
    }

    /// Writes the factors to an archive, or reads them from it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        for part in [
            &mut self.inverses,
            &mut self.lower,
            &mut self.solved,
            &mut self.rows,
            &mut self.border,
        ] {
            archive.reals(part);
        }
        archive.indices(&mut self.order, self.ordered.len());
    }

    /// Factors `a`.
    ///
    /// # Errors
    /// A block or the border is singular or not finite.
    pub fn factor(&mut self, a: &Arrow) -> Result<(), Singular> {
        for_size!(self, factor_sized(a))
    }

    /// Size of a block: a constant if B > 0.
    #[inline(always)]
    fn block_size<const B: usize>(&self) -> usize {
        if B > 0 { B } else { self.shape.block }
    }

    /// Size of block 0 together with the border: a constant if W > 0.
    #[inline(always)]
    fn border_size<const W: usize>(&self) -> usize {
        if W > 0 { W } else { self.shape.block + self.shape.border }
    }

    /// [`ArrowLu::factor`] for one size.
    fn factor_sized<const B: usize, const W: usize>(&mut self, a: &Arrow) -> Result<(), Singular> {
        let n = self.shape.blocks;
        let b = self.block_size::<B>();
        self.order.copy_from_slice(&a.order);
        let a = a.parts();
        self.copy_border(&a);
        self.inverses[b * b..2 * b * b].copy_from_slice(block(a.diagonal, 1, b * b));
        self.load::<B, W>(&a, 1);
        for k in 1..n {
            self.eliminate::<B, W>(&a, k)?;
        }
        if invert::<W>(&mut self.border) {
            Ok(())
        } else {
            Err(Singular { block: n })
        }
    }

    /// Copies block 0 and the border unknowns' own block.
    fn copy_border(&mut self, a: &Parts<'_>) {
        let (b, g) = (self.shape.block, self.shape.border);
        let (left, right) = self.border.split_at_mut(b * (b + g));
        for (j, column) in left.chunks_exact_mut(b + g).enumerate() {
            column[..b].copy_from_slice(block(a.diagonal, j, b));
            column[b..].copy_from_slice(block(a.bottom, j, g));
        }
        for (j, column) in right.chunks_exact_mut(b + g).enumerate() {
            column[..b].copy_from_slice(block(a.right, j, b));
            column[b..].copy_from_slice(block(a.corner, j, g));
        }
    }

    /// Copies the rows and the columns of block 0 and of the border at block k.
    #[inline(always)]
    fn load<const B: usize, const W: usize>(&mut self, a: &Parts<'_>, k: usize) {
        let (b, w) = (self.block_size::<B>(), self.border_size::<W>());
        let (n, g) = (self.shape.blocks, w - b);
        let rows = &mut self.rows[k * b * w..(k + 1) * b * w];
        for (j, column) in rows.chunks_exact_mut(w).enumerate() {
            column[..b].fill(0.0);
            column[b..].copy_from_slice(block(a.bottom, k * b + j, g));
        }
        let (block_0, border) = self.next_border[..b * w].split_at_mut(b * b);
        block_0.fill(0.0);
        border.copy_from_slice(block(a.right, k, b * g));
        // Block 0 has neighbours on both sides.
        for (neighbour, row, column) in [(1, a.upper, a.lower), (n - 1, a.lower, a.upper)] {
            if k == neighbour {
                add(block_0, block(column, k, b * b));
                for (to, part) in rows.chunks_exact_mut(w).zip(row.chunks_exact(b)) {
                    add(&mut to[..b], part);
                }
            }
        }
    }

    /// Inverts the pivot of block k, and takes the block's part from block k + 1 and from the
    /// border.
    #[inline(always)]
    fn eliminate<const B: usize, const W: usize>(&mut self, a: &Parts<'_>, k: usize) -> Result<(), Singular> {
        let (b, w) = (self.block_size::<B>(), self.border_size::<W>());
        let has_next = k + 1 < self.shape.blocks;
        let (upper, border) = self.columns[..b * (b + w)].split_at_mut(b * b);
        border.copy_from_slice(&self.next_border[..b * w]);
        if has_next {
            upper.copy_from_slice(block(a.upper, k, b * b));
            self.load::<B, W>(a, k + 1);
        } else {
            upper.fill(0.0);
        }
        let (inverses, pivots) = self.inverses.split_at_mut((k + 1) * b * b);
        let inverse = &mut inverses[k * b * b..];
        if !invert::<B>(inverse) {
            return Err(Singular { block: k });
        }
        let solved = &mut self.solved[k * b * (b + w)..(k + 1) * b * (b + w)];
        gemm::<B, B>(Update::Set, b, b, inverse, &self.columns, solved);
        let (x_upper, x_border) = solved.split_at(b * b);
        let (done, rest) = self.rows.split_at_mut((k + 1) * b * w);
        let row = &done[k * b * w..];
        gemm::<W, B>(Update::Subtract, w, b, row, x_border, &mut self.border);
        if has_next {
            gemm::<W, B>(Update::Subtract, w, b, row, x_upper, &mut rest[..b * w]);
            let lower = &mut self.lower[(k + 1) * b * b..(k + 2) * b * b];
            gemm::<B, B>(Update::Set, b, b, block(a.lower, k + 1, b * b), inverse, lower);
            let pivot = &mut pivots[..b * b];
            pivot.copy_from_slice(block(a.diagonal, k + 1, b * b));
            let (upper, border) = self.columns.split_at(b * b);
            gemm::<B, B>(Update::Subtract, b, b, lower, upper, pivot);
            gemm::<B, B>(Update::Subtract, b, b, lower, border, &mut self.next_border);
        }
        Ok(())
    }

    /// Replaces the right-hand side `x` by the solution.
    pub fn solve(&mut self, x: &mut [f64]) {
        // A sorted permutation is the identity.
        if self.order.is_sorted() {
            return for_size!(self, solve_sized(x));
        }
        let mut ordered = std::mem::take(&mut self.ordered);
        to_matrix_order(&self.order, x, &mut ordered);
        for_size!(self, solve_sized(&mut ordered));
        to_vector_order(&self.order, &ordered, x);
        self.ordered = ordered;
    }

    /// Solves with factors of the same size.
    fn solve_sized<const B: usize, const W: usize>(&mut self, x: &mut [f64]) {
        let n = self.shape.blocks;
        let (b, w) = (self.block_size::<B>(), self.border_size::<W>());
        self.tail[..b].copy_from_slice(&x[..b]);
        self.tail[b..].copy_from_slice(&x[n * b..]);
        for k in 1..n {
            let (head, rest) = x.split_at_mut((k + 1) * b);
            let y = &mut head[k * b..];
            if k + 1 < n {
                gemv::<B, B>(Update::Subtract, block(&self.lower, k + 1, b * b), y, &mut rest[..b]);
            }
            self.work[..b].copy_from_slice(y);
            gemv::<B, B>(Update::Set, block(&self.inverses, k, b * b), &self.work[..b], y);
            gemv::<W, B>(Update::Subtract, block(&self.rows, k, b * w), y, &mut self.tail);
        }
        self.work.copy_from_slice(&self.tail);
        gemv::<W, W>(Update::Set, &self.border, &self.work, &mut self.tail);
        for k in (1..n).rev() {
            let (head, rest) = x.split_at_mut((k + 1) * b);
            let y = &mut head[k * b..];
            let (upper, border) = block(&self.solved, k, b * (b + w)).split_at(b * b);
            gemv::<B, W>(Update::Subtract, border, &self.tail, y);
            if k + 1 < n {
                gemv::<B, B>(Update::Subtract, upper, &rest[..b], y);
            }
        }
        x[..b].copy_from_slice(&self.tail[..b]);
        x[n * b..].copy_from_slice(&self.tail[b..]);
    }
}

#[inline(always)]
fn add(into: &mut [f64], from: &[f64]) {
    for (x, y) in into.iter_mut().zip(from) {
        *x += y;
    }
}
