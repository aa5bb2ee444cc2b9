//! The balance of the contents: transport quantities of every cell, and the fluxes through the left
//! faces.

use crate::scalar::{LANES, Lanes, Real, Tangent};
use crate::solver::View;
use crate::stack::{self, Transport};
use crate::variator::belt::Belt;

/// Rate at which the unknowns of the elements of a chain vanish, 1/s.
pub const RELAXATION_RATE: f64 = 1.0e3;

/// Flow and density of every cell, each in a list that begins with the last cell, as the
/// predecessor of the first, and ends with padding for a pack that ends beyond them.
#[derive(Clone, Debug)]
pub struct Transports {
    quantities: Transport<Vec<f64>>,
    cells: usize,
}

impl Transports {
    /// Memory for this number of cells.
    #[must_use]
    pub fn new(cells: usize) -> Self {
        Self {
            quantities: Transport::default().map(|()| vec![0.0; 1 + cells + LANES]),
            cells,
        }
    }

    /// Records the quantities of a cell.
    pub fn set(&mut self, cell: usize, transport: &Transport<f64>) {
        for (to, value) in self.quantities.as_mut_array().into_iter().zip(transport.as_array()) {
            to[1 + cell] = *value;
        }
    }

    /// Records the quantities of a pack that starts with cell `first`. The next pack overwrites
    /// unused lanes, so packs must be recorded in their order.
    #[inline(always)]
    pub fn set_pack(&mut self, first: usize, transport: &Transport<Lanes>) {
        for (to, value) in self.quantities.as_mut_array().into_iter().zip(transport.as_array()) {
            value.write(&mut to[1 + first..]);
        }
    }

    /// Copies the last cell to the entry before the first.
    fn close(&mut self) {
        let last = self.cells;
        for quantity in self.quantities.as_mut_array() {
            quantity[0] = quantity[last];
        }
    }

    /// The quantities on both sides of the left faces of the cells from `first` on; requires
    /// [`Self::close`].
    #[inline(always)]
    fn neighbours(&self, first: usize) -> [Transport<Lanes>; 2] {
        [first, first + 1].map(|start| {
            let [flow, density] = self.quantities.as_array().map(|of| Lanes::read(&of[start..]));
            Transport { flow, density }
        })
    }

    /// Adds the balance of the contents to `out`: fluxes through the left faces. Nothing depends on
    /// speeds and contents of the elements of a chain: they vanish.
    pub fn add_fluxes(&mut self, belt: &Belt, view: View<'_>, out: &mut [f64]) {
        if belt.law.is_pull_chain() {
            for i in belt.cells_at.iter().flat_map(|at| [at.speed, at.content]) {
                out[i] += view.y_dot[i] + RELAXATION_RATE * view.y[i];
            }
            return;
        }
        self.close();
        let mut from = belt.cells_at[self.cells - 1].content;
        for (pack, at) in belt.cells_at.chunks(LANES).enumerate() {
            let [before, after] = self.neighbours(LANES * pack);
            for (at, flux) in at.iter().zip(stack::flux(&before, &after).to_array()) {
                let into = at.content;
                out[into] += view.y_dot[into] - flux;
                out[from] += flux;
                from = into;
            }
        }
    }

    /// The left faces of all cells.
    pub fn faces(&mut self) -> impl Iterator<Item = Face> {
        self.close();
        let (transports, cells) = (&*self, self.cells);
        (0..cells).step_by(LANES).flat_map(move |first| {
            let [before, after] = transports.neighbours(first);
            let seeded = |side: usize, of: Transport<Lanes>| Transport {
                flow: Tangent::<4>::seed(of.flow, 2 * side, 1.0),
                density: Tangent::seed(of.density, 2 * side + 1, 1.0),
            };
            let by = stack::flux(&seeded(0, before), &seeded(1, after)).eps;
            (first..cells.min(first + LANES)).map(move |cell| Face {
                cells: [(cell + cells - 1) % cells, cell],
                by: [0, 1].map(|side| Transport {
                    flow: by[2 * side].lane(cell - first),
                    density: by[2 * side + 1].lane(cell - first),
                }),
            })
        })
    }
}

/// The left face of a cell, between the cell before (0) and the cell itself (1).
pub struct Face {
    /// The two cells.
    pub cells: [usize; 2],
    /// Derivatives of the flux with respect to flow and density of both cells.
    pub by: [Transport<f64>; 2],
}
