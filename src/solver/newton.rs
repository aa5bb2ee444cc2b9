//! Newton's method for one implicit stage, with reuse of the factored Jacobian.

use super::arrow::{Arrow, ArrowLu};
use super::{System, View};

/// Most iterations with a Jacobian of this stage.
const FRESH_ITERATIONS: usize = 12;
/// Most iterations with a Jacobian from before.
const REUSED_ITERATIONS: usize = 6;
/// Contraction per iteration above which a reused Jacobian is given up.
const SLOW: f64 = 0.5;

/// What was done, for tests and reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Accepted steps.
    pub steps: u64,
    /// Steps rejected by the error control.
    pub rejected: u64,
    /// Stages that Newton did not solve.
    pub failed: u64,
    /// Residual evaluations.
    pub residuals: u64,
    /// Jacobians formed and factored.
    pub factorizations: u64,
}

/// Newton did not converge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotConverged;

/// Memory of the iteration.
#[derive(Clone, Debug)]
pub struct Newton {
    matrix: Arrow,
    factors: ArrowLu,
    /// α of the factored matrix; NaN before the first.
    alpha: f64,
    residual: Vec<f64>,
    scale: Vec<f64>,
    /// Work counts.
    pub counts: Counts,
}

/// A stage: ẏ = α(y − `base`), q = `position` + y/α.
#[derive(Debug)]
pub struct Stage<'a> {
    /// 1/(hγ), 1/s.
    pub alpha: f64,
    /// y at which ẏ = 0.
    pub base: &'a [f64],
    /// q at y = 0.
    pub position: &'a [f64],
    /// In: first guess. Out: solution.
    pub y: &'a mut [f64],
    /// Out: ẏ.
    pub y_dot: &'a mut [f64],
    /// Out: q.
    pub q: &'a mut [f64],
}

impl Stage<'_> {
    fn complete(&mut self, has_position: &[bool]) {
        let beta = 1.0 / self.alpha;
        for i in 0..self.y.len() {
            self.y_dot[i] = self.alpha * (self.y[i] - self.base[i]);
            if has_position[i] {
                self.q[i] = self.position[i] + beta * self.y[i];
            }
        }
    }

    fn view(&self) -> View<'_> {
        View {
            y: self.y,
            y_dot: self.y_dot,
            q: self.q,
        }
    }
}

impl Newton {
    /// Memory for `system`.
    #[must_use]
    pub fn new(system: &impl System) -> Self {
        let shape = system.shape();
        Self {
            matrix: Arrow::new(shape),
            factors: ArrowLu::new(shape),
            alpha: f64::NAN,
            residual: vec![0.0; shape.len()],
            scale: vec![0.0; shape.len()],
            counts: Counts::default(),
        }
    }

    /// Forgets the factored Jacobian.
    pub fn forget(&mut self) {
        self.alpha = f64::NAN;
    }

    fn refresh<S: System>(&mut self, system: &mut S, stage: &Stage<'_>) -> Result<(), NotConverged> {
        self.counts.factorizations += 1;
        system.jacobian(stage.view(), stage.alpha, 1.0 / stage.alpha, &mut self.matrix);
        self.alpha = f64::NAN;
        self.factors.factor(&self.matrix).map_err(|_| NotConverged)?;
        self.alpha = stage.alpha;
        Ok(())
    }

    /// Solves a stage to `tolerance` times the system's Newton scale. `reuse` allows a Jacobian from before.
    /// Returns the number of iterations.
    ///
    /// # Errors
    /// No convergence; `stage.y` is then meaningless.
    pub fn solve<S: System>(
        &mut self,
        system: &mut S,
        stage: &mut Stage<'_>,
        tolerance: f64,
        reuse: bool,
    ) -> Result<usize, NotConverged> {
        let ratio = stage.alpha / self.alpha;
        if reuse && (0.7..1.4).contains(&ratio) {
            let guess_is_kept = self.iterate(system, stage, tolerance, true);
            if let Ok(iterations) = guess_is_kept {
                return Ok(iterations);
            }
        }
        self.iterate(system, stage, tolerance, false)
    }

    fn iterate<S: System>(
        &mut self,
        system: &mut S,
        stage: &mut Stage<'_>,
        tolerance: f64,
        reused: bool,
    ) -> Result<usize, NotConverged> {
        system.newton_scale(1.0 / stage.alpha, &mut self.scale);
        let limit = if reused { REUSED_ITERATIONS } else { FRESH_ITERATIONS };
        let mut before = f64::INFINITY;
        let mut fresh = false;
        for iteration in 1..=limit {
            stage.complete(system.has_position());
            system.residual(stage.view(), &mut self.residual);
            self.counts.residuals += 1;
            // A first guess far off makes the first Jacobian useless for the last iterations, so it is renewed until
            // the contraction is good.
            if !reused && !fresh {
                self.refresh(system, stage)?;
            }
            self.factors.solve(&mut self.residual);
            let mut change = 0.0_f64;
            let mut finite = true;
            for ((y, d), s) in stage.y.iter_mut().zip(&self.residual).zip(&self.scale) {
                *y -= d;
                finite &= d.is_finite();
                change = change.max((d / s).abs());
            }
            if !finite {
                return Err(NotConverged);
            }
            let rate = change / before;
            if change < tolerance && iteration > 1 && rate < 0.9 || change < 1e-3 * tolerance {
                stage.complete(system.has_position());
                return Ok(iteration);
            }
            if rate.is_finite() && rate < 1.0 && change * rate / (1.0 - rate) < 0.3 * tolerance {
                stage.complete(system.has_position());
                return Ok(iteration);
            }
            if iteration > 1 {
                if reused && rate > SLOW || rate > 2.0 && iteration > 3 {
                    return Err(NotConverged);
                }
                fresh = rate < 0.2;
            }
            before = change;
        }
        Err(NotConverged)
    }
}
