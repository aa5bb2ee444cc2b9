//! Broyden's good update on earlier factors, in the form of Kelley, Iterative Methods for Linear and Nonlinear Equations
//! (1995), section 7.3: it needs the steps made so far and no matrix. Where a few rows have changed between sticking and
//! sliding, the Jacobian has changed in rank by as few, which updates make good.

use nalgebra::DVector;

/// The steps of Broyden's method from one point on.
#[derive(Clone, Debug)]
pub(super) struct Broyden {
    /// Scaled steps, each with its squared 2-norm.
    steps: Vec<(DVector<f64>, f64)>,
    made: usize,
}

impl Broyden {
    /// Memory for at most so many steps of so many unknowns.
    pub fn new(steps: usize, unknowns: usize) -> Self {
        Self {
            steps: vec![(DVector::zeros(unknowns), 0.0); steps],
            made: 0,
        }
    }

    /// Forgets the steps made so far: the next one is Newton's with the factors at hand.
    pub fn restart(&mut self) {
        self.made = 0;
    }

    /// Largest entry of the next step, scaled, from the `correction` that the factors give at the present point, after whole
    /// steps. Not finite if the step is not.
    ///
    /// # Panics
    /// After as many steps as there is memory for.
    pub fn step(&mut self, correction: &[f64], scale: &[f64]) -> f64 {
        let (earlier, rest) = self.steps.split_at_mut(self.made);
        let (step, square) = &mut rest[0];
        for ((u, d), s) in step.iter_mut().zip(correction).zip(scale) {
            *u = -d / s;
        }
        for pair in earlier.windows(2) {
            let projection = pair[0].0.dot(step) / pair[0].1;
            step.axpy(projection, &pair[1].0, 1.0);
        }
        if let Some((last, of_last)) = earlier.last() {
            *step *= 1.0 / (1.0 - last.dot(step) / of_last);
        }
        *square = step.norm_squared();
        self.made += 1;
        if square.is_finite() { step.amax() } else { f64::INFINITY }
    }

    /// Adds the last step to y.
    pub fn add_to(&self, y: &mut [f64], scale: &[f64]) {
        for ((y, u), s) in y.iter_mut().zip(&self.steps[self.made - 1].0).zip(scale) {
            *y += u * s;
        }
    }
}
