//! What the balance of the amounts needs of every cell, kept so that neighbours stand side by side.

use crate::chain::Transport;
use crate::scalar::{LANES, Lanes};

/// A figure after the other, in each the last cell, then all cells in their order, then room for a pack that ends beyond
/// them.
#[derive(Clone, Debug)]
pub(crate) struct Transports {
    figures: Transport<Vec<f64>>,
    cells: usize,
}

impl Transports {
    /// For as many cells.
    pub fn new(cells: usize) -> Self {
        Self {
            figures: Transport::default().map(|()| vec![0.0; 1 + cells + LANES]),
            cells,
        }
    }

    /// Of a cell.
    pub fn get(&self, cell: usize) -> Transport<f64> {
        let [flow, density, lag] = self.figures.each().map(|of| of[1 + cell]);
        Transport { flow, density, lag }
    }

    /// Records that of a cell.
    pub fn set(&mut self, cell: usize, transport: &Transport<f64>) {
        for (to, value) in self.figures.each_mut().into_iter().zip(transport.each()) {
            to[1 + cell] = *value;
        }
    }

    /// Records those of a pack that starts with cell `first`. Lanes that it doesn't use are those of the next pack, so packs
    /// come in their order.
    #[inline(always)]
    pub fn set_pack(&mut self, first: usize, transport: &Transport<Lanes>) {
        for (to, value) in self.figures.each_mut().into_iter().zip(transport.each()) {
            value.write(&mut to[1 + first..]);
        }
    }

    /// Lets the last cell stand before the first.
    pub fn close(&mut self) {
        let last = self.cells;
        for figure in self.figures.each_mut() {
            figure[0] = figure[last];
        }
    }

    /// On both sides of the left faces of the cells from `first` on, once the loop is closed.
    #[inline(always)]
    pub fn beside(&self, first: usize) -> [Transport<Lanes>; 2] {
        [first, first + 1].map(|start| {
            let [flow, density, lag] = self.figures.each().map(|of| Lanes::read(&of[start..]));
            Transport { flow, density, lag }
        })
    }
}
