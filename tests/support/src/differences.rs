//! A Jacobian beside differences of its residual.

use pushbelt::solver::arrow::Arrow;
use pushbelt::solver::{State, System};

#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub row: usize,
    pub column: usize,
    /// Its value in the Jacobian.
    pub exact: f64,
    /// Central difference of fourth order.
    pub difference: f64,
    /// Largest entry of the column.
    pub largest: f64,
    /// Sizes of the residuals in its row, over the step: a few roundings of this are in the
    /// difference.
    pub rounded: f64,
}

/// Calls `check` with every entry of ∂F/∂y + α ∂F/∂ẏ + β ∂F/∂q at `time`; differences in an unknown
/// are over its `step`.
pub fn compare(
    system: &mut impl System,
    time: f64,
    state: &State,
    [alpha, beta]: [f64; 2],
    step: impl Fn(usize) -> f64,
    check: impl Fn(&Entry),
) {
    let n = state.y.len();
    let mut matrix = Arrow::new(system.shape());
    // As Newton's method does it: a residual may leave what the Jacobian uses.
    system.residual(time, state.view(), &mut vec![0.0; n]);
    system.jacobian(time, state.view(), alpha, beta, &mut matrix);
    let (mut unit, mut exact) = (vec![0.0; n], vec![0.0; n]);
    for column in 0..n {
        unit[column] = 1.0;
        matrix.multiply(&unit, &mut exact);
        unit[column] = 0.0;
        let h = step(column);
        let [plus, minus, far, farther] = [h, -h, 2.0 * h, -2.0 * h].map(|h| {
            let (mut shifted, mut residual) = (state.clone(), vec![0.0; n]);
            shifted.y[column] += h;
            shifted.y_dot[column] += alpha * h;
            shifted.q[column] += beta * h;
            system.residual(time, shifted.view(), &mut residual);
            residual
        });
        let largest = exact.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for row in 0..n {
            check(&Entry {
                row,
                column,
                exact: exact[row],
                difference: (8.0 * (plus[row] - minus[row]) - far[row] + farther[row]) / (12.0 * h),
                largest,
                rounded: plus[row].abs() / h,
            });
        }
    }
}
