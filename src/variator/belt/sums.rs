//! Loads of the belt on the pulleys: sums over its cells.

use crate::pulley::{PerPulley, Pulley};
use crate::scalar::{Lanes, Real};
use crate::variator::law::place::CellBalance;

/// Load of the belt on a pulley.
#[derive(Clone, Copy, Debug, Default)]
pub struct PulleyLoad<T = f64> {
    /// Axial force on one sheave, N.
    pub axial: T,
    /// Moment of the axial force on one sheave, N·m.
    pub tilting: [T; 2],
    /// Torque on the pulley, N·m.
    pub torque: T,
    /// Resultant of the contact forces on the belt, N.
    pub resultant: [T; 2],
}

impl<T: Real> PulleyLoad<T> {
    /// Adds `on` times the load of a cell.
    #[inline(always)]
    pub fn add(&mut self, cell: &CellBalance<T>, on: T) {
        self.axial += cell.axial * on;
        self.torque += cell.torque * on;
        for (sum, moment) in self.tilting.iter_mut().zip(cell.tilting) {
            *sum += moment * on;
        }
        for (sum, force) in self.resultant.iter_mut().zip(cell.resultant) {
            *sum += force * on;
        }
    }
}

impl PulleyLoad<Lanes> {
    /// Sums over the lanes.
    pub fn sum(&self) -> PulleyLoad {
        PulleyLoad {
            axial: self.axial.sum(),
            tilting: self.tilting.map(Lanes::sum),
            torque: self.torque.sum(),
            resultant: self.resultant.map(Lanes::sum),
        }
    }
}

impl PulleyLoad {
    /// Load of one cell.
    pub fn of_cell<T: Real<Constant = f64>>(cell: &CellBalance<T>) -> Self {
        Self {
            axial: cell.axial.re(),
            tilting: cell.tilting.map(|moment| moment.re()),
            torque: cell.torque.re(),
            resultant: cell.resultant.map(|force| force.re()),
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
        for (sum, force) in self.resultant.iter_mut().zip(more.resultant) {
            *sum += force;
        }
    }
}

/// Derivatives of the resultants of the contact forces on the belt with respect to every unknown, for the drag of the
/// shafts. The resultants are not rows of the matrix.
#[derive(Clone, Debug)]
pub struct ResultantSlopes(PerPulley<[Vec<f64>; 2]>);

impl ResultantSlopes {
    /// Memory for this number of unknowns.
    pub fn new(unknowns: usize) -> Self {
        Self(PerPulley::from_fn(|_| [0, 1].map(|_| vec![0.0; unknowns])))
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        for of in self.0.each_mut() {
            for slopes in of {
                slopes.fill(0.0);
            }
        }
    }

    /// Derivatives of component `axis` at a pulley with respect to each unknown.
    #[inline(always)]
    pub fn of(&mut self, pulley: Pulley, axis: usize) -> &mut [f64] {
        &mut self.0[pulley][axis]
    }

    /// Derivatives of `factors`·resultant at a pulley with respect to each unknown.
    pub fn along(&self, pulley: Pulley, factors: [f64; 2]) -> impl Iterator<Item = f64> + '_ {
        let [x, y] = &self.0[pulley];
        x.iter().zip(y).map(move |(x, y)| factors[0] * x + factors[1] * y)
    }
}
