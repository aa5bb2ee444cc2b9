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
//! Unknowns whose neighbours change may stand in an order of their own, see [`Arrow::reorder`].

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
    /// n, b and g.
    fn sizes(&self) -> [usize; 3] {
        [self.blocks, self.block, self.border]
    }

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

    /// Starts of the parts in the storage of an [`Arrow`]: D, U, L, R, B, C, end. Each part holds
    /// its blocks in order, a block its columns.
    fn starts(&self) -> [usize; 7] {
        let [n, b, g] = self.sizes();
        let (square, strip) = (n * b * b, n * b * g);
        let mut start = 0;
        let mut next = |size: usize| {
            start += size;
            start - size
        };
        [square, square, square, strip, strip, g * g, 0].map(&mut next)
    }

    /// Place of an entry in the storage of an [`Arrow`], if it is in the band.
    #[must_use]
    pub fn index(&self, row: usize, column: usize) -> Option<usize> {
        let [n, b, g] = self.sizes();
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

/// The matrix. Indices are those of the vector: blocks in order, then the border, unless it was
/// reordered.
#[derive(Clone, Debug)]
pub struct Arrow {
    shape: Shape,
    values: Vec<f64>,
    /// Place of each unknown of the vector.
    order: Vec<usize>,
}

/// Number k of the blocks of a part with so many entries each.
#[inline(always)]
fn block(part: &[f64], k: usize, size: usize) -> &[f64] {
    &part[k * size..(k + 1) * size]
}

/// Brings a vector into the order of the matrix.
fn to_places(order: &[usize], x: &[f64], ordered: &mut [f64]) {
    for (&place, x) in order.iter().zip(x) {
        ordered[place] = *x;
    }
}

/// Brings a vector from the order of the matrix into its own.
fn from_places(order: &[usize], ordered: &[f64], x: &mut [f64]) {
    for (&place, x) in order.iter().zip(x) {
        *x = ordered[place];
    }
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
            order: (0..shape.len()).collect(),
        }
    }

    /// Sets every entry to zero and gives unknown i of the vector the place `order[i]`, a
    /// permutation that leaves the border where it is. Factors keep the order that they were made
    /// in.
    pub fn reorder(&mut self, order: &[usize]) {
        self.clear();
        self.order.copy_from_slice(order);
    }

    /// Place of an entry in the storage, if it is in the band.
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

    /// Adds to entries in N rows of a column and of a block, the first of which has that place.
    #[inline(always)]
    pub fn add_run<const N: usize>(&mut self, index: usize, values: [f64; N]) {
        let run: &mut [f64; N] = self.values[index..].first_chunk_mut().expect("rows of a block");
        for (entry, value) in run.iter_mut().zip(values) {
            *entry += value;
        }
    }

    /// Replaces a row by a multiple of the unit row: `scale`·x_row.
    pub fn set_unit_row(&mut self, row: usize, scale: f64) {
        if let Some(row) = row.checked_sub(self.shape.blocks * self.shape.block) {
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
        let bottom = self.shape.starts()[4];
        self.values[bottom..].chunks_exact_mut(self.shape.border)
    }

    /// Adds to all entries of a border row. Indices are those of the vector.
    pub fn add_to_border_row(&mut self, row: usize, values: impl Iterator<Item = f64>) {
        let [n, b, g] = self.shape.sizes();
        let start = self.shape.starts()[4] + row - n * b;
        for (place, value) in self.order.iter().zip(values) {
            self.values[start + place * g] += value;
        }
    }

    /// Adds `factor` times border row `from` to border row `into`. Indices are those of the vector.
    ///
    /// # Panics
    /// If an index is not in the border.
    pub fn add_row(&mut self, into: usize, from: usize, factor: f64) {
        let [n, b, _] = self.shape.sizes();
        let (into, from) = (into - n * b, from - n * b);
        for column in self.border_columns() {
            column[into] += factor * column[from];
        }
    }

    /// `out` = A·`x`. Allocates.
    pub fn multiply(&self, x: &[f64], out: &mut [f64]) {
        let [n, b, g] = self.shape.sizes();
        let a = self.parts();
        let (mut ordered, mut image) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        to_places(&self.order, x, &mut ordered);
        let (x, border) = ordered.split_at(n * b);
        let (y, of_border) = image.split_at_mut(n * b);
        let any = gemv::<0, 0>;
        for (k, y) in y.chunks_exact_mut(b).enumerate() {
            let of = |k: usize| block(x, k % n, b);
            any(Update::Add, block(a.diagonal, k, b * b), of(k), y);
            any(Update::Add, block(a.upper, k, b * b), of(k + 1), y);
            any(Update::Add, block(a.lower, k, b * b), of(k + n - 1), y);
            any(Update::Add, block(a.right, k, b * g), border, y);
            any(Update::Add, block(a.bottom, k, b * g), of(k), of_border);
        }
        any(Update::Add, a.corner, border, of_border);
        from_places(&self.order, &image, out);
    }
}
