//! The descriptor system E ẋ = A x about a working point.

use faer::Mat;
use faer::linalg::solvers::PartialPivLu;

use crate::solver::arrow::Arrow;
use crate::solver::{State, System};
use crate::variator::system::VariatorSystem;

/// E and A with x = (y, q), q without the drift position s, which nothing depends on.
pub(super) struct Descriptor {
    pub e: Mat<f64>,
    pub a: Mat<f64>,
    /// Unknowns whose positions follow the velocities in x.
    pub positions: Vec<usize>,
}

impl Descriptor {
    /// About a steady `state`.
    pub fn new(system: &mut VariatorSystem, state: &State) -> Self {
        let n = system.belt.layout.len();
        let drift = system.belt.layout.drift();
        let positions: Vec<usize> = (0..n).filter(|&i| system.has_position()[i] && i != drift).collect();
        let mut jacobian = |alpha, beta| dense_jacobian(system, state, alpha, beta);
        let (by_y, by_rate, by_position) = (jacobian(0.0, 0.0), jacobian(1.0, 0.0), jacobian(0.0, 1.0));
        let size = n + positions.len();
        let (mut e, mut a) = (Mat::<f64>::zeros(size, size), Mat::<f64>::zeros(size, size));
        for i in 0..n {
            for j in 0..n {
                e[(i, j)] = by_rate[(i, j)] - by_y[(i, j)];
                a[(i, j)] = -by_y[(i, j)];
            }
            for (k, &j) in positions.iter().enumerate() {
                a[(i, n + k)] = by_y[(i, j)] - by_position[(i, j)];
            }
        }
        for (k, &j) in positions.iter().enumerate() {
            e[(n + k, n + k)] = 1.0;
            a[(n + k, j)] = 1.0;
        }
        let mut descriptor = Self { e, a, positions };
        descriptor.constrain_amounts(system);
        descriptor
    }

    /// The total element content is constant: this replaces one of the balances, whose sum implies
    /// it. Otherwise it would be a mode with the eigenvalue 0, which rounding mixes with slow ones.
    fn constrain_amounts(&mut self, system: &VariatorSystem) {
        let cells = system.belt.layout.cells();
        let balance = system.belt.layout.content(cells - 1);
        for j in 0..self.a.ncols() {
            (self.e[(balance, j)], self.a[(balance, j)]) = (0.0, 0.0);
        }
        for cell in 0..cells {
            self.a[(balance, system.belt.layout.content(cell))] = 1.0;
        }
    }

    /// A direction of the state from a column of x and of its rates.
    pub fn direction(&self, x: &Mat<f64>, rates: &Mat<f64>, column: usize) -> State {
        let n = x.nrows() - self.positions.len();
        let mut direction = State::zero(n);
        for i in 0..n {
            (direction.y[i], direction.y_dot[i]) = (x[(i, column)], rates[(i, column)]);
        }
        for (k, &i) in self.positions.iter().enumerate() {
            direction.q[i] = x[(n + k, column)];
        }
        direction
    }

    /// The factors of σE − A.
    pub fn factors(&self, sigma: f64) -> PartialPivLu<f64> {
        (&self.e * faer::Scale(sigma) - &self.a).partial_piv_lu()
    }
}

/// The Jacobian with the factors `alpha` of ẏ and `beta` of q.
fn dense_jacobian(system: &mut VariatorSystem, state: &State, alpha: f64, beta: f64) -> Mat<f64> {
    let n = system.belt.layout.len();
    let mut arrow = Arrow::new(system.shape());
    system.jacobian(0.0, state.view(), alpha, beta, &mut arrow);
    let (mut unit, mut image) = (vec![0.0; n], vec![0.0; n]);
    let mut matrix = Mat::<f64>::zeros(n, n);
    for j in 0..n {
        unit[j] = 1.0;
        arrow.multiply(&unit, &mut image);
        unit[j] = 0.0;
        for i in 0..n {
            matrix[(i, j)] = image[i];
        }
    }
    matrix
}
