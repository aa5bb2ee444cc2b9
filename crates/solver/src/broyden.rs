//! Broyden's good update on earlier factors, in the form of Kelley, Iterative Methods for Linear
//! and Nonlinear Equations (1995), section 7.3: it needs the steps made so far and no matrix. Where
//! some rows have changed between sticking and sliding, as many updates suffice.

use super::kernels::largest;
use nalgebra::DVector;

#[derive(Clone, Debug)]
pub(super) struct Step {
    pub vector: DVector<f64>,
    /// Square of its 2-norm.
    pub square: f64,
}

/// Sets the last of the steps made from one point on, by the `correction` that the factors give at
/// the present point, after whole steps. Returns its largest entry, which is not finite if the step
/// is not.
pub(super) fn set_last(steps: &mut [Step], correction: &[f64], scale: &[f64]) -> f64 {
    let Some((last, earlier)) = steps.split_last_mut() else {
        return 0.0;
    };
    let step = &mut last.vector;
    for ((u, d), s) in step.iter_mut().zip(correction).zip(scale) {
        *u = -d / s;
    }
    for pair in earlier.windows(2) {
        let projection = pair[0].vector.dot(step) / pair[0].square;
        step.axpy(projection, &pair[1].vector, 1.0);
    }
    if let Some(before) = earlier.last() {
        *step *= 1.0 / (1.0 - before.vector.dot(step) / before.square);
    }
    last.square = step.norm_squared();
    let change = largest(step.as_slice());
    if last.square.is_finite() { change } else { f64::INFINITY }
}
