//! Work of a run in real time, in the units of its bound.

use pushbelt::variator::run::Variator;

/// Work of a millisecond for each `solver.effort`, units.
pub const EFFORT: f64 = 15.5;
/// How far a millisecond may be above that, units: 12 carried on; and 16 overdrawn by a Jacobian of
/// 20 with the residuals before and after it, which begins where 6 are left.
pub const ABOVE: f64 = 28.0;
/// Work of a Jacobian with its factors, units: with reused geometry, and what all geometry takes
/// beside. A residual with its correction is 1.
const JACOBIAN: [f64; 2] = [6.0, 14.0];

/// Counts the work of a run from one communication step to the next.
#[derive(Debug)]
pub struct Meter {
    before: [f64; 3],
    /// Work since the meter began, units.
    pub sum: f64,
}

impl Meter {
    /// A meter that begins with the state of this variator.
    pub fn new(variator: &Variator) -> Self {
        Self {
            before: counts(variator),
            sum: 0.0,
        }
    }

    /// Work since the last call, units.
    pub fn read(&mut self, variator: &Variator) -> f64 {
        let now = counts(variator);
        let [residuals, jacobians, geometry] = std::array::from_fn(|k| now[k] - self.before[k]);
        self.before = now;
        let work = residuals + JACOBIAN[0] * jacobians + JACOBIAN[1] * geometry;
        self.sum += work;
        work
    }
}

/// Residuals, Jacobians, and how often the whole geometry was differentiated.
fn counts(variator: &Variator) -> [f64; 3] {
    let counts = variator.counts();
    let geometry = variator.system().differentiations();
    [counts.residuals, counts.factorizations, geometry].map(|count| count as f64)
}
