//! Factors of an [`Arrow`] and solutions with them.
//!
//! Block 0 joins the border, which opens the loop; the other blocks are eliminated in order. Cost and memory are linear
//! in n: O(n (b+g)² b). Pivoting is inside a block.

use super::super::kernels::{self, Inverter, Update, gemm, gemv};
use super::{Arrow, Parts, Shape};
use pushbelt_archive::Archive;

/// A pivot block was singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the Jacobian is singular (block {block})")]
pub struct Singular {
    /// Block where elimination stopped; the number of blocks stands for the border.
    pub block: usize,
}

/// Factors of an [`Arrow`] with all scratch memory: factoring and solving allocate nothing.
#[derive(Clone, Debug)]
pub struct ArrowLu {
    shape: Shape,
    /// For pivot blocks of a size unknown to the compiler.
    pivot: Inverter,
    /// D_k⁻¹: a product with it waits for nothing, where two triangular solutions wait for each unknown in turn.
    inverses: Vec<f64>,
    /// L_{k+1} D_k⁻¹ at k + 1: what elimination takes from a block to the next, so that it needn't wait for D_k⁻¹.
    lower: Vec<f64>,
    /// D_k⁻¹ [U_k | border columns], b×(b+w) each.
    solved: Vec<f64>,
    /// Border rows w×b of each block after elimination.
    rows: Vec<f64>,
    /// For the border.
    corner: Inverter,
    /// Inverse of block 0 and the border, w×w.
    border: Vec<f64>,
    /// Right-hand side [U_k | border columns] of the block in work.
    columns: Vec<f64>,
    next_border: Vec<f64>,
    work: Vec<f64>,
    tail: Vec<f64>,
    /// Of the matrix that was factored.
    order: Vec<usize>,
    /// A right-hand side in that order.
    ordered: Vec<f64>,
}

/// Calls a method for the size of a block, B, and of the border together with block 0, W, as constants: those of belts in
/// the plane and in space, and of a planar ring alone. 0 stands for any other size. Each size takes 20 kB of an FMU for two
/// machines.
macro_rules! for_size {
    ($lu:expr, $method:ident($argument:expr)) => {
        match ($lu.shape.block, $lu.shape.border) {
            (4, 2) => $lu.$method::<4, 6>($argument),
            (3, 14) => $lu.$method::<3, 17>($argument),
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
            pivot: Inverter::new(b),
            inverses: vec![0.0; n * b * b],
            lower: vec![0.0; n * b * b],
            solved: vec![0.0; n * b * (b + w)],
            rows: vec![0.0; n * b * w],
            corner: Inverter::new(w),
            border: vec![0.0; w * w],
            columns: vec![0.0; b * (b + w)],
            next_border: vec![0.0; b * w],
            work: vec![0.0; w],
            tail: vec![0.0; w],
            order: Vec::new(),
            ordered: Vec::new(),
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
        let mut reordered = !self.order.is_empty();
        archive.flag(&mut reordered);
        let length = if reordered { self.shape.len() } else { 0 };
        self.order.resize(length, 0);
        self.ordered.resize(length, 0.0);
        if reordered {
            archive.indices(&mut self.order, length);
        }
    }

    /// Factors `a`.
    ///
    /// # Errors
    /// A block or the border is singular or not finite.
    pub fn factor(&mut self, a: &Arrow) -> Result<(), Singular> {
        for_size!(self, factor_sized(a))
    }

    /// Sizes of a block, and of block 0 together with the border: constants if B > 0.
    #[inline(always)]
    fn sizes<const B: usize, const W: usize>(&self) -> [usize; 2] {
        if B > 0 {
            [B, W]
        } else {
            [self.shape.block, self.shape.block + self.shape.border]
        }
    }

    /// [`ArrowLu::factor`] for one size.
    fn factor_sized<const B: usize, const W: usize>(&mut self, a: &Arrow) -> Result<(), Singular> {
        let n = self.shape.blocks;
        let [b, _] = self.sizes::<B, W>();
        self.order.clone_from(&a.order);
        self.ordered.resize(a.order.len(), 0.0);
        let a = a.parts();
        self.copy_border(&a);
        self.inverses[b * b..2 * b * b].copy_from_slice(&a.diagonal[b * b..2 * b * b]);
        self.copy_border_rows::<B, W>(&a, 1);
        self.copy_border_columns::<B, W>(&a, 1);
        for k in 1..n {
            self.eliminate::<B, W>(&a, k)?;
        }
        if invert::<W>(&mut self.corner, &mut self.border) {
            Ok(())
        } else {
            Err(Singular { block: n })
        }
    }

    /// Copies block 0 and the border unknowns' own block.
    fn copy_border(&mut self, a: &Parts<'_>) {
        let (b, g) = (self.shape.block, self.shape.border);
        let w = b + g;
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
    }

    /// Copies the rows of block 0 and of the border at block k.
    #[inline(always)]
    fn copy_border_rows<const B: usize, const W: usize>(&mut self, a: &Parts<'_>, k: usize) {
        let [b, w] = self.sizes::<B, W>();
        let (n, g) = (self.shape.blocks, w - b);
        let rows = &mut self.rows[k * b * w..(k + 1) * b * w];
        for (j, column) in rows.chunks_exact_mut(w).enumerate() {
            column[..b].fill(0.0);
            column[b..].copy_from_slice(&a.bottom[(k * b + j) * g..][..g]);
        }
        // Block 0 has neighbours on both sides.
        for (neighbour, part) in [(1, a.upper), (n - 1, a.lower)] {
            if k == neighbour {
                for (column, part) in rows.chunks_exact_mut(w).zip(part.chunks_exact(b)) {
                    add(&mut column[..b], part);
                }
            }
        }
    }

    /// Copies the columns of block 0 and of the border at block k.
    #[inline(always)]
    fn copy_border_columns<const B: usize, const W: usize>(&mut self, a: &Parts<'_>, k: usize) {
        let [b, w] = self.sizes::<B, W>();
        let (n, g) = (self.shape.blocks, w - b);
        let (of_block, of_border) = self.next_border[..b * w].split_at_mut(b * b);
        of_block.fill(0.0);
        for (neighbour, part) in [(1, a.lower), (n - 1, a.upper)] {
            if k == neighbour {
                add(of_block, &part[k * b * b..(k + 1) * b * b]);
            }
        }
        of_border.copy_from_slice(&a.right[k * b * g..(k + 1) * b * g]);
    }

    /// Inverts the pivot of block k, and takes the block's part from block k + 1 and from the border.
    #[inline(always)]
    fn eliminate<const B: usize, const W: usize>(&mut self, a: &Parts<'_>, k: usize) -> Result<(), Singular> {
        let [b, w] = self.sizes::<B, W>();
        let has_next = k + 1 < self.shape.blocks;
        let (upper, border) = self.columns[..b * (b + w)].split_at_mut(b * b);
        border.copy_from_slice(&self.next_border[..b * w]);
        if has_next {
            upper.copy_from_slice(&a.upper[k * b * b..(k + 1) * b * b]);
            self.copy_border_columns::<B, W>(a, k + 1);
            self.copy_border_rows::<B, W>(a, k + 1);
        } else {
            upper.fill(0.0);
        }
        let (inverses, pivots) = self.inverses.split_at_mut((k + 1) * b * b);
        let inverse = &mut inverses[k * b * b..];
        if !invert::<B>(&mut self.pivot, inverse) {
            return Err(Singular { block: k });
        }
        let solved = &mut self.solved[k * b * (b + w)..(k + 1) * b * (b + w)];
        gemm::<B, B>(Update::Set, [b, b], inverse, &self.columns, solved);
        let (x_upper, x_border) = solved.split_at(b * b);
        let (done, rest) = self.rows.split_at_mut((k + 1) * b * w);
        let row = &done[k * b * w..];
        gemm::<W, B>(Update::Subtract, [w, b], row, x_border, &mut self.border);
        if has_next {
            gemm::<W, B>(Update::Subtract, [w, b], row, x_upper, &mut rest[..b * w]);
            let block = (k + 1) * b * b..(k + 2) * b * b;
            let lower = &mut self.lower[block.clone()];
            gemm::<B, B>(Update::Set, [b, b], &a.lower[block.clone()], inverse, lower);
            let pivot = &mut pivots[..b * b];
            pivot.copy_from_slice(&a.diagonal[block]);
            let (upper, border) = self.columns.split_at(b * b);
            gemm::<B, B>(Update::Subtract, [b, b], lower, upper, pivot);
            gemm::<B, B>(Update::Subtract, [b, b], lower, border, &mut self.next_border);
        }
        Ok(())
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
        let n = self.shape.blocks;
        let [b, w] = self.sizes::<B, W>();
        self.tail[..b].copy_from_slice(&x[..b]);
        self.tail[b..].copy_from_slice(&x[n * b..]);
        for k in 1..n {
            let (head, rest) = x.split_at_mut((k + 1) * b);
            let y = &mut head[k * b..];
            if k + 1 < n {
                gemv::<B, B>(
                    Update::Subtract,
                    &self.lower[(k + 1) * b * b..(k + 2) * b * b],
                    y,
                    &mut rest[..b],
                );
            }
            self.work[..b].copy_from_slice(y);
            gemv::<B, B>(
                Update::Set,
                &self.inverses[k * b * b..(k + 1) * b * b],
                &self.work[..b],
                y,
            );
            gemv::<W, B>(
                Update::Subtract,
                &self.rows[k * b * w..(k + 1) * b * w],
                y,
                &mut self.tail,
            );
        }
        self.work.copy_from_slice(&self.tail);
        gemv::<W, W>(Update::Set, &self.border, &self.work, &mut self.tail);
        for k in (1..n).rev() {
            let (head, rest) = x.split_at_mut((k + 1) * b);
            let y = &mut head[k * b..];
            let solved = &self.solved[k * b * (b + w)..(k + 1) * b * (b + w)];
            gemv::<B, W>(Update::Subtract, &solved[b * b..], &self.tail, y);
            if k + 1 < n {
                gemv::<B, B>(Update::Subtract, &solved[..b * b], &rest[..b], y);
            }
        }
        x[..b].copy_from_slice(&self.tail[..b]);
        x[n * b..].copy_from_slice(&self.tail[b..]);
    }
}

/// Replaces a matrix of R rows by its inverse; `any` is for sizes unknown to the compiler. False if it is
/// singular or not finite.
#[inline(always)]
fn invert<const R: usize>(any: &mut Inverter, a: &mut [f64]) -> bool {
    if R > 0 { kernels::invert::<R>(a) } else { any.invert(a) }
}

#[inline(always)]
fn add(into: &mut [f64], from: &[f64]) {
    for (x, y) in into.iter_mut().zip(from) {
        *x += y;
    }
}
