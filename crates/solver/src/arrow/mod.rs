//! Periodic block-tridiagonal matrix with a thin border: n blocks of size b around a loop, g border
//! unknowns coupled to all of them.
//!
//! ```text
//!  D0 U0          L0 | R0
//!  L1 D1 U1          | R1
//!     L2 D2 …        | ⋮
//!  Un-1    … Ln-1 Dn-1 | Rn-1
//!  ───────────────────+────
//!  B0 B1 …       Bn-1 | C
//! ```

mod lu;

use super::kernels::{Update, gemv};

pub use lu::{ArrowLu, Singular};

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
    /// Index of the first border unknown, n·b.
    fn split(&self) -> usize {
        self.blocks * self.block
    }

    /// Number of unknowns n·b + g.
    #[must_use]
    pub fn len(&self) -> usize {
        self.split() + self.border
    }

    /// Whether there is no unknown.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of entries of D, as of U and L.
    fn square(&self) -> usize {
        self.split() * self.block
    }

    /// Number of entries of R, as of B.
    fn strip(&self) -> usize {
        self.split() * self.border
    }

    /// Index of an entry in the storage of an [`Arrow`], if it is in the band. The storage holds D,
    /// U, L, R, B and C, each part its blocks in order, a block its columns.
    #[must_use]
    pub fn index(&self, row: usize, column: usize) -> Option<usize> {
        let (n, b, g) = (self.blocks, self.block, self.border);
        let (square, strip, split) = (self.square(), self.strip(), self.split());
        let (row_block, i) = (row / b, row % b);
        let (column_block, j) = (column / b, column % b);
        let in_block = row_block * b * b + j * b + i;
        match (row < split, column < split) {
            (true, true) if row_block == column_block => Some(in_block),
            (true, true) if (row_block + 1) % n == column_block => Some(square + in_block),
            (true, true) if (column_block + 1) % n == row_block => Some(2 * square + in_block),
            (true, true) => None,
            (true, false) => Some(3 * square + (row_block * g + column - split) * b + i),
            (false, true) => Some(3 * square + strip + (column_block * b + j) * g + row - split),
            (false, false) => Some(3 * square + 2 * strip + (column - split) * g + row - split),
        }
    }
}

/// The matrix. Indices are those of the vector: blocks in order, then the border, unless it was
/// reordered.
#[derive(Clone, Debug)]
pub struct Arrow {
    shape: Shape,
    values: Vec<f64>,
    /// Index in the matrix of each unknown of the vector.
    order: Vec<usize>,
}

/// Number k of the blocks of a part with so many entries each.
#[inline(always)]
fn block(part: &[f64], k: usize, size: usize) -> &[f64] {
    &part[k * size..(k + 1) * size]
}

fn to_matrix_order(order: &[usize], x: &[f64], ordered: &mut [f64]) {
    for (&index, x) in order.iter().zip(x) {
        ordered[index] = *x;
    }
}

/// Brings a vector from the order of the matrix into its own.
fn to_vector_order(order: &[usize], ordered: &[f64], x: &mut [f64]) {
    for (&index, x) in order.iter().zip(x) {
        *x = ordered[index];
    }
}

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
            values: vec![0.0; 3 * shape.square() + 2 * shape.strip() + shape.border * shape.border],
            order: (0..shape.len()).collect(),
        }
    }

    /// Sets every entry to zero and gives unknown i of the vector the index `order[i]`, a
    /// permutation that leaves the border where it is. Factors keep the order that they were made
    /// in.
    pub fn reorder(&mut self, order: &[usize]) {
        self.clear();
        self.order.copy_from_slice(order);
    }

    /// Index of an entry in the storage, if it is in the band.
    #[inline]
    #[must_use]
    pub fn index(&self, row: usize, column: usize) -> Option<usize> {
        self.shape.index(self.order[row], self.order[column])
    }

    /// Sizes.
    #[must_use]
    pub fn shape(&self) -> Shape {
        self.shape
    }

    fn parts(&self) -> Parts<'_> {
        let (square, strip) = (self.shape.square(), self.shape.strip());
        let (band, border) = self.values.split_at(3 * square);
        Parts {
            diagonal: &band[..square],
            upper: &band[square..2 * square],
            lower: &band[2 * square..],
            right: &border[..strip],
            bottom: &border[strip..2 * strip],
            corner: &border[2 * strip..],
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

    /// Adds to the entry at an index that [`Shape::index`] or [`Arrow::index`] found.
    #[inline]
    pub fn add_at(&mut self, index: usize, value: f64) {
        self.values[index] += value;
    }

    /// Adds to entries in N rows of a column and of a block, the first of which has that index.
    #[inline(always)]
    pub fn add_run<const N: usize>(&mut self, index: usize, values: [f64; N]) {
        let run: &mut [f64; N] = self.values[index..].first_chunk_mut().expect("rows of a block");
        for (entry, value) in run.iter_mut().zip(values) {
            *entry += value;
        }
    }

    /// Replaces a row by a multiple of the unit row: `scale`·x_row.
    pub fn set_unit_row(&mut self, row: usize, scale: f64) {
        if let Some(row) = row.checked_sub(self.shape.split()) {
            self.border_columns().for_each(|column| column[row] = 0.0);
        } else {
            for column in 0..self.shape.len() {
                if let Some(index) = self.index(row, column) {
                    self.values[index] = 0.0;
                }
            }
        }
        self.add(row, row, scale);
    }

    /// The entries of the border rows, column by column in the order of the matrix.
    fn border_columns(&mut self) -> impl Iterator<Item = &mut [f64]> {
        let bottom = 3 * self.shape.square() + self.shape.strip();
        self.values[bottom..].chunks_exact_mut(self.shape.border)
    }

    /// Adds to all entries of a border row. Indices are those of the vector.
    pub fn add_to_border_row(&mut self, row: usize, values: impl Iterator<Item = f64>) {
        let row = row - self.shape.split();
        let start = 3 * self.shape.square() + self.shape.strip() + row;
        for (index, value) in self.order.iter().zip(values) {
            self.values[start + index * self.shape.border] += value;
        }
    }

    /// Adds `factor` times border row `from` to border row `into`. Indices are those of the vector.
    ///
    /// # Panics
    /// If an index is not in the border.
    pub fn add_row(&mut self, into: usize, from: usize, factor: f64) {
        let split = self.shape.split();
        let (into, from) = (into - split, from - split);
        for column in self.border_columns() {
            column[into] += factor * column[from];
        }
    }

    /// `out` = A·`x`. Allocates.
    pub fn multiply(&self, x: &[f64], out: &mut [f64]) {
        let Shape {
            blocks: n,
            block: b,
            border: g,
        } = self.shape;
        let a = self.parts();
        let (mut ordered, mut image) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        to_matrix_order(&self.order, x, &mut ordered);
        let (x, border) = ordered.split_at(n * b);
        let (y, border_image) = image.split_at_mut(n * b);
        let add = |a: &[f64], x: &[f64], y: &mut [f64]| gemv::<0, 0>(Update::Add, a, x, y);
        for (k, y) in y.chunks_exact_mut(b).enumerate() {
            let part = |k: usize| block(x, k % n, b);
            add(block(a.diagonal, k, b * b), part(k), y);
            add(block(a.upper, k, b * b), part(k + 1), y);
            add(block(a.lower, k, b * b), part(k + n - 1), y);
            add(block(a.right, k, b * g), border, y);
            add(block(a.bottom, k, b * g), part(k), border_image);
        }
        add(a.corner, border, border_image);
        to_vector_order(&self.order, &image, out);
    }
}
