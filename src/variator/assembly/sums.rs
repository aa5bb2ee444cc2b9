//! Loads of the belt on the pulleys: sums over its cells.

use crate::scalar::{Lanes, Real};
use crate::variator::law::place::CellBalance;

/// Load of the belt on a pulley.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PulleyLoad<T = f64> {
    /// Axial force on one sheave, N.
    pub axial: T,
    /// Moment of the axial force on one sheave, N·m.
    pub tilting: [T; 2],
    /// Torque on the pulley, N·m.
    pub torque: T,
}

impl<T: Real> PulleyLoad<T> {
    /// Adds the load of a cell, times `on`.
    #[inline(always)]
    pub(crate) fn add(&mut self, cell: &CellBalance<T>, on: T) {
        self.axial += cell.axial * on;
        self.torque += cell.torque * on;
        for (sum, moment) in self.tilting.iter_mut().zip(cell.tilting) {
            *sum += moment * on;
        }
    }
}

impl PulleyLoad<Lanes> {
    /// Sums over the lanes.
    pub(crate) fn sum(&self) -> PulleyLoad {
        PulleyLoad {
            axial: self.axial.sum(),
            tilting: self.tilting.map(Lanes::sum),
            torque: self.torque.sum(),
        }
    }
}

impl PulleyLoad {
    /// Load of one cell.
    pub(crate) fn of_cell<T: Real<Constant = f64>>(cell: &CellBalance<T>) -> Self {
        Self {
            axial: cell.axial.re(),
            tilting: cell.tilting.map(|moment| moment.re()),
            torque: cell.torque.re(),
        }
    }
}

impl std::ops::AddAssign for PulleyLoad {
    fn add_assign(&mut self, more: Self) {
        self.axial += more.axial;
        self.torque += more.torque;
        for (sum, moment) in self.tilting.iter_mut().zip(more.tilting) {
            *sum += moment;
        }
    }
}
