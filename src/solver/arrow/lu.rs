//! Factors of an [`Arrow`] and solutions with them.
//!
//! Block 0 joins the border, which opens the loop; the other blocks are eliminated in order. Cost and memory are linear
//! in n: O(n (b+g)² b). Pivoting is inside a block; faer inverts the border, and blocks whose size the compiler doesn't
//! know.

use super::super::kernels::{self, gemm, gemv};
use super::dense::Inverter;
use super::{Arrow, Parts, Shape};
use crate::tape::Tape;

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
    /// For pivot blocks whose size the compiler doesn't know.
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

/// Calls a method for the size of a block, B, and of the border together with block 0, W: those of the variator's
/// Eulerian rings, with one cell an element and in space too, and of `ALE` and `ANCF` rings alone, so that the compiler
/// knows them. 0 stands for any other; each size takes 20 kB of an FMU for two machines.
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
        let (n, b) = (self.shape.blocks, self.shape.block);
        self.order.clone_from(&a.order);
        self.ordered.resize(a.order.len(), 0.0);
        let a = a.parts();
        self.copy_border(&a);
        self.copy_border_rows(&a);
        self.inverses[b * b..2 * b * b].copy_from_slice(&a.diagonal[b * b..2 * b * b]);
        copy_border_columns(self.shape, &a, 1, &mut self.next_border);
        for k in 1..n {
            self.eliminate::<B, W>(&a, k)?;
        }
        if self.corner.invert(&mut self.border) {
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

    /// Copies the rows of block 0 and of the border at each other block.
    fn copy_border_rows(&mut self, a: &Parts<'_>) {
        let Shape {
            blocks: n,
            block: b,
            border: g,
        } = self.shape;
        let w = b + g;
        self.rows.fill(0.0);
        for k in 1..n {
            for j in 0..b {
                let column = &mut self.rows[k * b * w + j * w..k * b * w + (j + 1) * w];
                if k == 1 {
                    add(&mut column[..b], &a.upper[j * b..(j + 1) * b]);
                }
                if k == n - 1 {
                    add(&mut column[..b], &a.lower[j * b..(j + 1) * b]);
                }
                column[b..].copy_from_slice(&a.bottom[k * b * g + j * g..k * b * g + (j + 1) * g]);
            }
        }
    }

    /// Inverts the pivot of block k, and takes the block's part from block k + 1 and from the border.
    #[inline(always)]
    fn eliminate<const B: usize, const W: usize>(&mut self, a: &Parts<'_>, k: usize) -> Result<(), Singular> {
        let (n, b) = (self.shape.blocks, self.shape.block);
        let w = b + self.shape.border;
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
            self.pivot.invert(inverse)
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
            copy_border_columns(self.shape, a, k + 1, &mut self.next_border);
            gemm::<B, B>([b, b], -1.0, lower, border, &mut self.next_border);
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

/// Copies the columns of block 0 and of the border at block k.
fn copy_border_columns(shape: Shape, a: &Parts<'_>, k: usize, out: &mut [f64]) {
    let Shape {
        blocks: n,
        block: b,
        border: g,
    } = shape;
    out[..b * b].fill(0.0);
    let block = k * b * b..(k + 1) * b * b;
    if k == 1 {
        add(&mut out[..b * b], &a.lower[block.clone()]);
    }
    if k == n - 1 {
        add(&mut out[..b * b], &a.upper[block]);
    }
    out[b * b..].copy_from_slice(&a.right[k * b * g..(k + 1) * b * g]);
}

fn add(into: &mut [f64], from: &[f64]) {
    for (x, y) in into.iter_mut().zip(from) {
        *x += y;
    }
}
