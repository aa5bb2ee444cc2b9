//! Broyden's good update on earlier factors, in the form of Kelley, Iterative Methods for Linear and Nonlinear Equations
//! (1995), section 7.3: it needs the steps made so far and no matrix. Where a few rows have changed between sticking and
//! sliding, the Jacobian has changed in rank by as few, which updates make good.

use nalgebra::DVectorView;

/// A scaled step.
#[derive(Clone, Debug)]
struct Step {
    entries: Vec<f64>,
    /// Their squared 2-norm.
    square: f64,
}

/// The steps of Broyden's method from one point on.
#[derive(Clone, Debug)]
pub(super) struct Broyden {
    steps: Vec<Step>,
    made: usize,
}

/// a·b.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    DVectorView::from_slice(a, a.len()).dot(&DVectorView::from_slice(b, b.len()))
}

impl Broyden {
    /// Memory for at most so many steps of so many unknowns.
    pub fn new(steps: usize, unknowns: usize) -> Self {
        let step = Step {
            entries: vec![0.0; unknowns],
            square: 0.0,
        };
        Self {
            steps: vec![step; steps],
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
        let Step { entries, square } = &mut rest[0];
        for ((u, d), s) in entries.iter_mut().zip(correction).zip(scale) {
            *u = -d / s;
        }
        for pair in earlier.windows(2) {
            let projection = dot(&pair[0].entries, entries) / pair[0].square;
            for (u, next) in entries.iter_mut().zip(&pair[1].entries) {
                *u += projection * next;
            }
        }
        if let Some(last) = earlier.last() {
            let factor = 1.0 / (1.0 - dot(&last.entries, entries) / last.square);
            entries.iter_mut().for_each(|u| *u *= factor);
        }
        *square = dot(entries, entries);
        self.made += 1;
        if square.is_finite() {
            entries.iter().fold(0.0, |most, u| most.max(u.abs()))
        } else {
            f64::INFINITY
        }
    }

    /// Adds the last step to y.
    pub fn add_to(&self, y: &mut [f64], scale: &[f64]) {
        for ((y, u), s) in y.iter_mut().zip(&self.steps[self.made - 1].entries).zip(scale) {
            *y += u * s;
        }
    }
}
