//! Newton's method for one implicit stage, with reuse of the factored Jacobian. Its work may be bounded ([`WorkBound`]): the solution then
//! stops before a Jacobian for which the work does not last, and continues there.

use super::System;
use super::arrow::{Arrow, ArrowLu};
use super::broyden::Broyden;
use super::stage::{Stage, move_by};
use pushbelt_archive::Archive;

// "Half, twice" is what half and twice a constant change in the work, residuals and 12 for each Jacobian: of the manoeuvre with ALE; of
// torque flips with ALE0, 1 s at each ratio, jumping and ramped. Chaotic loads alone vary by some 2 %.

/// Most Jacobians in a stage. Half, twice: 0, 0 %; 0, 0 %.
const JACOBIANS: usize = 15;
/// Most iterations of Broyden's method with the same factors. The best point of those that fail is where Newton's method begins.
/// Half, twice: 0, 0 %; +2, 0 %.
const ITERATIONS: usize = 24;
/// Largest change of α, as a share of that of the factored matrix, with which the factors are tried: as in CVODE (Hindmarsh et al. 2005).
/// Half, twice: 0, −1 %; +1, −6 %, but with twice as much four times the stages fail.
const REUSED: f64 = 0.3;
/// Iterations beyond the first of each stage, added up over stages, after which the next stage takes a new Jacobian: twice the residuals
/// that a Jacobian with its factors costs, nine to fourteen for a push belt, since a stage with new factors takes a second iteration too.
/// Half, twice: 0, +1 %; −3, +4 %. With half of it noisy forces take up to a quarter more.
const STALE: u64 = 24;
/// Growth of the step in one iteration at which Broyden's method is abandoned: as in CVODE. Half, twice: +3, −1 %; +7, +1 %.
const DIVERGED: f64 = 2.0;
/// Exponent of the contraction of the last stage, for the first iteration of the next: so it is measured again before it is stale. Hairer
/// and Wanner, Solving Ordinary Differential Equations II, IV.8, give 0.8, which takes a tenth more under smooth loads.
/// Half, and 1, beyond which a contraction would fall unmeasured: +4, +19 %; 0, 0 %.
const AGEING: f64 = 0.9;
/// Part of the tolerance that may be left after the last iteration. Hairer and Wanner, IV.8, find 0.01 to 0.1 best.
/// Half, twice: +3, −2 %; +2, −1 %.
const LEFT: f64 = 0.15;
/// Part of a correction that may point along the step before it, where a search along the step may end. Half, twice: 0, −1 %; +1, 0 %.
const PROJECTION: f64 = 0.2;
/// Residuals after which a search along a step ends, at the best place it has found; without one it fails after twice as many.
/// Half, twice: −1, 0 %; −2, +2 %, but with half of it 638 stages of the flips fail instead of 8.
const TRIALS: usize = 6;

/// Work done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Accepted steps.
    pub steps: u64,
    /// Steps rejected by the error control; in real time, steps whose result was not kept.
    pub rejected: u64,
    /// Stages that Newton did not solve.
    pub failed: u64,
    /// Residual evaluations.
    pub residuals: u64,
    /// Jacobians formed and factored.
    pub factorizations: u64,
}

impl Counts {
    pub(super) fn each_mut(&mut self) -> [&mut u64; 5] {
        let Self {
            steps,
            rejected,
            failed,
            residuals,
            factorizations,
        } = self;
        [steps, rejected, failed, residuals, factorizations]
    }

    fn with(mut self, mut other: Self, combine: fn(u64, u64) -> u64) -> Self {
        let pairs = self.each_mut().into_iter().zip(other.each_mut());
        pairs.for_each(|(count, other)| *count = combine(*count, *other));
        self
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        *self = self.with(more, |count, more| count + more);
    }
}

/// Work from an earlier count on.
impl std::ops::Sub for Counts {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        self.with(earlier, |count, earlier| count - earlier)
    }
}

/// Why a stage is not solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unsolved {
    /// Newton's method does not converge.
    #[error("Newton's method found no solution")]
    NoSolution,
    /// The allowed work is used up. The next call continues from the stage's best point.
    #[error("the work for Newton's method is used up")]
    OutOfWork,
}

/// Bound of the work of Newton's method. The unit is a residual with its correction.
#[derive(Clone, Copy, Debug)]
pub struct WorkBound {
    /// Work that is left.
    pub left: f64,
    /// Work of a Jacobian with its factors: with reused geometry, and what all geometry takes beside.
    pub jacobian: [f64; 2],
    /// What an iteration that has begun may take beyond the work that is left.
    pub overdraft: f64,
    /// Most Jacobians in a stage.
    pub jacobians: usize,
}

impl WorkBound {
    /// No bound but that of Jacobians.
    pub const NONE: Self = Self {
        left: f64::INFINITY,
        jacobian: [0.0; 2],
        overdraft: 0.0,
        jacobians: JACOBIANS,
    };

    /// Whether an iteration that has begun has to stop.
    fn is_overdrawn(&self) -> bool {
        self.left <= -self.overdraft
    }
}

/// Newton's method with its factored Jacobian, which later stages use again.
#[derive(Clone, Debug)]
pub struct Newton {
    matrix: Arrow,
    factors: ArrowLu,
    /// α of the factored matrix; infinite before the first, so no stage reuses it.
    alpha: f64,
    /// Change of each unknown that counts as 1.
    scale: Vec<f64>,
    /// By the factors, from the residual at the place evaluated last.
    correction: Vec<f64>,
    broyden: Broyden,
    /// Residual at the place evaluated last.
    residual: Vec<f64>,
    /// Step along which a search goes.
    step: Vec<f64>,
    /// y where the search begins; or the best y of Broyden's method.
    anchor: Vec<f64>,
    /// Residual at the best place.
    best_residual: Vec<f64>,
    /// Contraction per iteration seen with these factors; 1 before any.
    rate: f64,
    /// Iterations with these factors beyond the first of each stage.
    excess: u64,
    /// Largest change that the last iteration of a stage left to make, as a share of the tolerance, as far as its contraction
    /// shows. The caller sets it to zero.
    pub left: f64,
    /// Jacobians of a stage for which the work did not last: the residual at the stage's point is at hand.
    open: Option<usize>,
    /// Bound of the work.
    pub bound: WorkBound,
    /// Work counts.
    pub counts: Counts,
}

impl Newton {
    /// Memory for `system`.
    #[must_use]
    pub fn new(system: &impl System) -> Self {
        let shape = system.shape();
        let unknowns = shape.len();
        let zeros = vec![0.0; unknowns];
        Self {
            matrix: Arrow::new(shape),
            factors: ArrowLu::new(shape),
            alpha: f64::INFINITY,
            scale: zeros.clone(),
            correction: zeros.clone(),
            broyden: Broyden::new(ITERATIONS, unknowns),
            residual: zeros.clone(),
            step: zeros.clone(),
            anchor: zeros.clone(),
            best_residual: zeros,
            rate: 1.0,
            excess: 0,
            left: 0.0,
            open: None,
            bound: WorkBound::NONE,
            counts: Counts::default(),
        }
    }

    /// Writes to an archive, or reads from it, all that later solutions depend on: the factored Jacobian is used again.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let mut is_open = self.open.is_some();
        archive.flag(&mut is_open);
        if is_open {
            let mut jacobians = self.open.unwrap_or(0) as u64;
            archive.counter(&mut jacobians);
            self.open = usize::try_from(jacobians).ok();
            archive.reals(&mut self.residual);
        } else {
            self.open = None;
        }
        archive.within(&mut self.bound.left, f64::MIN, f64::INFINITY);
        archive.within(&mut self.alpha, 0.0, f64::INFINITY);
        if self.alpha.is_finite() {
            self.factors.serialize(archive);
        }
        archive.real(&mut self.rate);
        archive.counter(&mut self.excess);
        for count in self.counts.each_mut() {
            archive.counter(count);
        }
    }

    /// Forgets how well the factored Jacobian contracted: the law has changed since.
    pub fn forget_rate(&mut self) {
        self.rate = 1.0;
    }

    /// Abandons a stage that is not solved.
    pub fn abandon(&mut self) {
        self.open = None;
    }

    /// Forgets the factored Jacobian.
    pub fn forget(&mut self) {
        self.alpha = f64::INFINITY;
    }

    /// Forms and factors the Jacobian at the stage.
    fn refresh<S: System>(&mut self, system: &mut S, stage: &Stage<'_>) -> Result<(), Unsolved> {
        self.counts.factorizations += 1;
        self.alpha = f64::INFINITY;
        let (view, beta) = (stage.state.view(), 1.0 / stage.alpha);
        let renewed = system.renew_jacobian(stage.time, view, stage.alpha, beta, &mut self.matrix);
        let [tangents, geometry] = self.bound.jacobian;
        self.bound.left -= tangents + geometry * renewed;
        if self.factors.factor(&self.matrix).is_err() {
            return Err(Unsolved::NoSolution);
        }
        self.alpha = stage.alpha;
        self.rate = 1.0;
        self.excess = 0;
        Ok(())
    }

    /// Sets the scale that stages with this α are solved to: the system's.
    pub fn set_scale(&mut self, system: &impl System, alpha: f64) {
        system.newton_scale(1.0 / alpha, &mut self.scale);
    }

    /// Solves a stage to `tolerance` times the scale that was set last. `reuse` allows a Jacobian from before.
    /// Returns the number of Jacobians formed.
    ///
    /// # Errors
    /// No convergence: `stage.state.y` is then meaningless. Or the work is used up: the next call with this stage continues from there.
    pub fn solve<S: System>(
        &mut self,
        system: &mut S,
        stage: &mut Stage<'_>,
        tolerance: f64,
        reuse: bool,
    ) -> Result<usize, Unsolved> {
        if let Some(jacobians) = self.open.take() {
            return self.damped_newton(system, stage, tolerance, (jacobians, true));
        }
        if self.bound.left <= 0.0 {
            return Err(Unsolved::OutOfWork);
        }
        let tries = reuse && (stage.alpha / self.alpha - 1.0).abs() < REUSED;
        if tries && self.broyden(system, stage, tolerance, false).is_ok() {
            return Ok(0);
        }
        self.damped_newton(system, stage, tolerance, (0, tries))
    }

    /// The residual at `stage.state.y`, into `self.residual`.
    fn evaluate<S: System>(&mut self, system: &mut S, stage: &mut Stage<'_>) {
        stage.complete(system.has_position());
        system.residual(stage.time, stage.state.view(), &mut self.residual);
        self.counts.residuals += 1;
        self.bound.left -= 1.0;
    }

    /// Newton correction from the residual at hand with the factors at hand.
    fn correct(&mut self) {
        self.correction.copy_from_slice(&self.residual);
        self.factors.solve(&mut self.correction);
    }

    /// The largest scaled entry of the correction and its scaled 2-norm.
    fn measure(&self) -> (f64, f64) {
        let scaled = || self.correction.iter().zip(&self.scale).map(|(d, s)| d / s);
        let largest = scaled().fold(0.0, |most: f64, x| most.max(x.abs()));
        (largest, scaled().map(|x| x * x).sum::<f64>().sqrt())
    }

    /// Broyden's method from the factors at hand. It is abandoned when it diverges; `stage.state.y` is then the best point it reached, and
    /// the residual there is at hand.
    /// `corrected`: the correction at `stage.state.y` is at hand.
    fn broyden<S: System>(
        &mut self,
        system: &mut S,
        stage: &mut Stage<'_>,
        tolerance: f64,
        corrected: bool,
    ) -> Result<(), Unsolved> {
        self.broyden.restart();
        let (mut least, mut before) = (f64::INFINITY, f64::INFINITY);
        for iteration in 0..ITERATIONS {
            if self.bound.is_overdrawn() {
                break;
            }
            if !corrected || iteration > 0 {
                self.evaluate(system, stage);
                self.correct();
            }
            let change = self.broyden.step(&self.correction, &self.scale);
            if iteration == 0 || change < least {
                least = change;
                self.anchor.copy_from_slice(&stage.state.y);
                self.best_residual.copy_from_slice(&self.residual);
            }
            let contraction = change / before;
            if !change.is_finite() || contraction > DIVERGED && change > tolerance {
                break;
            }
            // What is left after this step, over the step: before any is measured, by the contraction of the last stage. At most the step
            // itself: steps that are rounding need not fall.
            let ahead = if iteration == 0 {
                let off = (stage.alpha / self.alpha - 1.0).abs();
                self.rate = self.rate.max(off).max(f64::EPSILON).powf(AGEING);
                self.rate
            } else {
                self.rate = if iteration == 1 {
                    contraction
                } else {
                    self.rate.max(contraction)
                };
                (contraction / (1.0 - contraction).max(0.0)).min(1.0)
            };
            before = change;
            self.broyden.add_to(&mut stage.state.y, &self.scale);
            if change * ahead < LEFT * tolerance {
                self.left = self.left.max(change * ahead / tolerance);
                stage.complete(system.has_position());
                self.excess += iteration as u64;
                if self.excess > STALE {
                    self.forget();
                }
                return Ok(());
            }
        }
        self.rate = 1.0;
        stage.state.y.copy_from_slice(&self.anchor);
        self.residual.copy_from_slice(&self.best_residual);
        Err(Unsolved::NoSolution)
    }

    /// Newton with the exact Jacobian, damped where friction saturates: from far off, full steps overshoot from one sliding
    /// direction to the other for ever. After a full step Broyden's method goes on. `before`: Jacobians
    /// of the stage so far; `known`: the residual is at hand.
    fn damped_newton<S: System>(
        &mut self,
        system: &mut S,
        stage: &mut Stage<'_>,
        tolerance: f64,
        (before, mut known): (usize, bool),
    ) -> Result<usize, Unsolved> {
        for jacobians in before + 1..=self.bound.jacobians {
            if self.bound.left < self.bound.jacobian[0] {
                self.open = known.then_some(jacobians - 1);
                return Err(Unsolved::OutOfWork);
            }
            if known {
                stage.complete(system.has_position());
            } else {
                self.evaluate(system, stage);
                known = true;
            }
            self.refresh(system, stage)?;
            self.correct();
            let whole = self.search(system, stage, tolerance)?;
            if whole && self.broyden(system, stage, tolerance, true).is_ok() {
                return Ok(jacobians);
            }
        }
        Err(Unsolved::NoSolution)
    }

    /// Goes along the correction to a place that the natural monotonicity test accepts (Deuflhard, Newton Methods for Nonlinear
    /// Problems, 2011, section 3.3): the simplified correction there is smaller. Returns whether that is the whole step. Short of it, it
    /// seeks a place from which the correction points along the step no more, by bisection: where an arc slides the other way with all its
    /// cells at once, the correction beyond leads back. The residual there is at hand, and after a whole step the correction.
    fn search<S: System>(&mut self, system: &mut S, stage: &mut Stage<'_>, tolerance: f64) -> Result<bool, Unsolved> {
        let (_, norm) = self.measure();
        if !norm.is_finite() {
            return Err(Unsolved::NoSolution);
        }
        self.anchor.copy_from_slice(&stage.state.y);
        self.step.copy_from_slice(&self.correction);
        self.best_residual.copy_from_slice(&self.residual);
        let (mut best, mut least) = (0.0, norm);
        let ([mut lower, mut upper], mut share) = ([0.0, 1.0], 1.0);
        for trial in 1..=2 * TRIALS {
            move_by(-share, &mut stage.state.y, &self.anchor, &self.step);
            self.evaluate(system, stage);
            self.correct();
            let (change, after) = self.measure();
            let products = self.correction.iter().zip(&self.step).zip(&self.scale);
            let projection = products.map(|((d, step), s)| (d / s) * (step / s)).sum::<f64>() / (norm * norm);
            let solved = after.is_finite() && change < LEFT * tolerance;
            let accepted = solved || after < norm;
            if accepted && (share >= 1.0 || solved || projection.abs() < PROJECTION) {
                return Ok(share >= 1.0);
            }
            if accepted && after < least {
                (best, least) = (share, after);
                self.best_residual.copy_from_slice(&self.residual);
            }
            if accepted && projection > 0.0 {
                lower = share;
            } else {
                upper = share;
            }
            if self.bound.is_overdrawn() || best > 0.0 && trial >= TRIALS {
                break;
            }
            share = 0.5 * (lower + upper);
        }
        if best == 0.0 && !self.bound.is_overdrawn() {
            return Err(Unsolved::NoSolution);
        }
        move_by(-best, &mut stage.state.y, &self.anchor, &self.step);
        self.residual.copy_from_slice(&self.best_residual);
        Ok(false)
    }
}
