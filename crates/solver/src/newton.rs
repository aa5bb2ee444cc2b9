//! Newton's method for one implicit stage, with reuse of the factored Jacobian. Its work may be bounded ([`WorkBound`]): the solution then
//! stops before a Jacobian for which the work does not last, and continues there.

use super::System;
use super::broyden::Broyden;
use super::line_search::LineSearch;
use super::stage::{Chord, Stage};
use pushbelt_tape::Tape;

/// Most Jacobians in a stage.
const FRESH_ITERATIONS: usize = 15;
/// Most iterations of Broyden's method with the same factors. For a push belt a Jacobian with its factors costs nine to fourteen
/// iterations, since most update the constitutive tangents only. With 16 to 36 ten loads that jump take the same time within 2 %, with
/// 8 stages fail. The best point of those that fail is where Newton's method begins.
const QUASI_ITERATIONS: usize = 24;
/// Bounds of α over that of the factored matrix, within which the factors are tried. CVODE (Hindmarsh et al. 2005)
/// takes 0.7 to 1.3 for the inverse.
const REUSED: std::ops::Range<f64> = 0.7..1.4;
/// What iterations beyond the first of a stage cost, added up over stages, after which the next stage takes a new
/// Jacobian. The second counts once, for a new Jacobian saves it in smooth motions only; each further one counts
/// [`FURTHER`] times. Half of it takes the same time (fewer residuals, more Jacobians), twice as much 2 to 6 % more.
const STALE: u64 = 40;
const FURTHER: usize = 3;
/// Growth of the step in one iteration at which Broyden's method is abandoned. Where a law changes its regime steps
/// grow and fall again.
const DIVERGED: f64 = 8.0;
/// Contraction that the first iteration is trusted with at best, and its growth with each stage that ends without
/// measuring it: so it is measured again before it is stale.
const BEST_RATE: f64 = 1.0e-3;
const AGEING: f64 = 1.2;
/// Exponent of the contraction seen last, for that of the next iteration: Broyden's method contracts a little faster
/// from one to the next.
const FASTER: f64 = 0.8;
/// Part of the tolerance that may be left after the last iteration.
const LEFT: f64 = 0.15;
/// Part of the tolerance below which the first correction shows that the predictor is the solution.
const SOLVED: f64 = 1.0e-3;
/// Part of the tolerance below which corrections may be rounding, so that they need not fall.
const ROUNDED: f64 = 0.1;
/// By how much the correction after a full step must be below the one before: the restricted monotonicity test of
/// Deuflhard, Newton Methods for Nonlinear Problems (2011), section 3.3, 1 − λ/4 at damping λ.
const RESTRICTION: f64 = 0.25;
/// Largest part of a correction that may point along the step before it, where a search along the step may end.
const ALONG: f64 = 0.2;
/// Residuals after which a search along a step ends at the best place it has found. With 3 to 10 the loads take the same time, with 2
/// a fifth more Jacobians.
const TRIALS: usize = 6;
/// Least share of a step that is tried; a stage for which it is too large is abandoned.
const LEAST: f64 = 0.02;

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

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        self.steps += more.steps;
        self.rejected += more.rejected;
        self.failed += more.failed;
        self.residuals += more.residuals;
        self.factorizations += more.factorizations;
    }
}

/// Work from an earlier count on.
impl std::ops::Sub for Counts {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        Self {
            steps: self.steps - earlier.steps,
            rejected: self.rejected - earlier.rejected,
            failed: self.failed - earlier.failed,
            residuals: self.residuals - earlier.residuals,
            factorizations: self.factorizations - earlier.factorizations,
        }
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
        jacobians: FRESH_ITERATIONS,
    };

    /// Whether an iteration that has begun has to stop.
    fn is_overdrawn(&self) -> bool {
        self.left <= -self.overdraft
    }
}

/// Newton's method with its factored Jacobian, which later stages use again.
#[derive(Clone, Debug)]
pub struct Newton {
    chord: Chord,
    /// α of the factored matrix; infinite before the first, so no stage reuses it.
    alpha: f64,
    step: Vec<f64>,
    guess: Vec<f64>,
    broyden: Broyden,
    best: Vec<f64>,
    /// Residuals: at the place evaluated last, and at the best one.
    residual: Vec<f64>,
    best_residual: Vec<f64>,
    /// Residual where a search begins.
    from_residual: Vec<f64>,
    /// Contraction per iteration seen with these factors; 1 before any.
    rate: f64,
    /// What iterations with these factors have cost beyond the first of each stage.
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
        Self {
            chord: Chord::new(system),
            alpha: f64::INFINITY,
            step: vec![0.0; shape.len()],
            guess: vec![0.0; shape.len()],
            broyden: Broyden::new(QUASI_ITERATIONS, shape.len()),
            best: vec![0.0; shape.len()],
            residual: vec![0.0; shape.len()],
            best_residual: vec![0.0; shape.len()],
            from_residual: vec![0.0; shape.len()],
            rate: 1.0,
            excess: 0,
            left: 0.0,
            open: None,
            bound: WorkBound::NONE,
            counts: Counts::default(),
        }
    }

    /// Writes to a tape, or reads from it, all that later solutions depend on: the factored Jacobian is used again.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        let mut is_open = self.open.is_some();
        tape.flag(&mut is_open);
        if is_open {
            let mut jacobians = self.open.unwrap_or(0) as u64;
            tape.counter(&mut jacobians);
            self.open = usize::try_from(jacobians).ok();
            tape.reals(&mut self.residual);
        } else {
            self.open = None;
        }
        tape.within(&mut self.bound.left, f64::MIN, f64::INFINITY);
        tape.within(&mut self.alpha, 0.0, f64::INFINITY);
        if self.alpha.is_finite() {
            self.chord.serialize(tape);
        }
        tape.real(&mut self.rate);
        tape.counter(&mut self.excess);
        let Counts {
            steps,
            rejected,
            failed,
            residuals,
            factorizations,
        } = &mut self.counts;
        for count in [steps, rejected, failed, residuals, factorizations] {
            tape.counter(count);
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
        let [alpha, beta] = stage.slopes;
        self.counts.factorizations += 1;
        self.alpha = f64::INFINITY;
        let view = stage.state.view();
        let mut renewed = 0.0;
        let regular = self.chord.factor(|matrix| {
            renewed = system.renew_jacobian(stage.time, view, alpha, beta, matrix);
        });
        let [tangents, geometry] = self.bound.jacobian;
        self.bound.left -= tangents + geometry * renewed;
        if !regular {
            return Err(Unsolved::NoSolution);
        }
        self.alpha = alpha;
        self.rate = 1.0;
        self.excess = 0;
        Ok(())
    }

    /// Sets the scale that stages with this α are solved to: the system's.
    pub fn set_scale(&mut self, system: &impl System, alpha: f64) {
        system.newton_scale(1.0 / alpha, &mut self.chord.scale);
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
            return self.damped(system, stage, tolerance, (jacobians, true));
        }
        if self.bound.left <= 0.0 {
            return Err(Unsolved::OutOfWork);
        }
        let ratio = stage.slopes[0] / self.alpha;
        let tries = reuse && REUSED.contains(&ratio);
        if tries && self.quasi(system, stage, tolerance, false).is_ok() {
            return Ok(0);
        }
        self.damped(system, stage, tolerance, (0, tries))
    }

    /// The residual at `stage.state.y`, into `self.residual`.
    fn evaluate<S: System>(&mut self, system: &mut S, stage: &mut Stage<'_>) {
        stage.complete(system.has_position());
        system.residual(stage.time, stage.state.view(), &mut self.residual);
        self.counts.residuals += 1;
        self.bound.left -= 1.0;
    }

    /// Newton correction at `stage.state.y` with the factors at hand, into `self.chord.correction`.
    fn correct<S: System>(&mut self, system: &mut S, stage: &mut Stage<'_>) {
        self.evaluate(system, stage);
        self.chord.correct(&self.residual);
    }

    /// The same with new factors; `known`: the residual is at hand.
    fn correct_anew<S: System>(&mut self, system: &mut S, stage: &mut Stage<'_>, known: bool) -> Result<(), Unsolved> {
        if known {
            stage.complete(system.has_position());
        } else {
            self.evaluate(system, stage);
        }
        self.refresh(system, stage)?;
        self.chord.correct(&self.residual);
        Ok(())
    }

    /// The largest scaled entry of the correction at hand and its scaled 2-norm.
    fn measure(&self) -> Result<(f64, f64), Unsolved> {
        let (largest, sum) = self.chord.measure();
        if sum.is_finite() {
            Ok((largest, sum.sqrt()))
        } else {
            Err(Unsolved::NoSolution)
        }
    }

    /// Broyden's method from the factors at hand. It is abandoned when it diverges; `stage.state.y` is then the best point it reached, and the
    /// residual there is at hand.
    /// `corrected`: the correction at `stage.state.y` is at hand.
    fn quasi<S: System>(
        &mut self,
        system: &mut S,
        stage: &mut Stage<'_>,
        tolerance: f64,
        corrected: bool,
    ) -> Result<(), Unsolved> {
        self.broyden.restart();
        let (mut least, mut before) = (f64::INFINITY, f64::INFINITY);
        for iteration in 0..QUASI_ITERATIONS {
            if self.bound.is_overdrawn() {
                break;
            }
            let at_hand = corrected && iteration == 0;
            if !at_hand {
                self.correct(system, stage);
            }
            let step = self.broyden.step(&self.chord.correction, &self.chord.scale);
            let change = step.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
            let is_finite = self.broyden.is_finite();
            if iteration == 0 || is_finite && change < least {
                least = change;
                self.best.copy_from_slice(&stage.state.y);
                self.best_residual.copy_from_slice(&self.residual);
            }
            if !is_finite {
                break;
            }
            if iteration > 0 {
                let rate = change / before;
                self.rate = if iteration == 1 { rate } else { self.rate.max(rate) };
                if rate > DIVERGED && change > tolerance {
                    break;
                }
            }
            // After the first iteration the last stage's rate counts.
            let ahead = if iteration == 0 {
                self.rate = (self.rate.max(BEST_RATE) * AGEING).min(1.0);
                self.rate
            } else {
                (change / before).powf(FASTER).min(1.0)
            };
            before = change;
            self.broyden.add_to(&mut stage.state.y, &self.chord.scale);
            // What is left after this step, as far as the rate shows.
            if change * ahead < LEFT * tolerance {
                self.left = self.left.max(change * ahead / tolerance);
                stage.complete(system.has_position());
                self.excess += (iteration.min(1) + FURTHER * iteration.saturating_sub(1)) as u64;
                if self.excess > STALE {
                    self.forget();
                }
                return Ok(());
            }
        }
        self.rate = 1.0;
        stage.state.y.copy_from_slice(&self.best);
        self.residual.copy_from_slice(&self.best_residual);
        Err(Unsolved::NoSolution)
    }

    /// Newton with the exact Jacobian, damped where friction saturates: from far off, full steps overshoot from one sliding
    /// direction to the other for ever. After a full step Broyden's method goes on. `before`: Jacobians
    /// of the stage so far; `known`: the residual is at hand.
    fn damped<S: System>(
        &mut self,
        system: &mut S,
        stage: &mut Stage<'_>,
        tolerance: f64,
        (before, known): (usize, bool),
    ) -> Result<usize, Unsolved> {
        for iteration in before + 1..=self.bound.jacobians {
            let known = known || iteration > 1;
            if self.bound.left < self.bound.jacobian[0] {
                self.open = known.then_some(iteration - 1);
                return Err(Unsolved::OutOfWork);
            }
            self.correct_anew(system, stage, known)?;
            let (largest, norm) = self.measure()?;
            if iteration == 1 && largest < SOLVED * tolerance {
                self.left = self.left.max(largest / tolerance);
                return Ok(iteration);
            }
            self.guess.copy_from_slice(&stage.state.y);
            self.step.copy_from_slice(&self.chord.correction);
            let share = self.search(system, stage, tolerance, norm)?;
            if share >= LineSearch::WHOLE && self.quasi(system, stage, tolerance, true).is_ok() {
                return Ok(iteration);
            }
        }
        Err(Unsolved::NoSolution)
    }

    /// Goes along the step at hand, whose scaled 2-norm is `norm`, to a place that the natural monotonicity test accepts
    /// (Deuflhard 2011, section 3.3): the simplified correction there is smaller than the step. Short of the whole step it
    /// seeks one from which the correction points along the step no more. Returns the share of the step; the residual there is
    /// at hand, and after a whole step the correction.
    fn search<S: System>(
        &mut self,
        system: &mut S,
        stage: &mut Stage<'_>,
        tolerance: f64,
        norm: f64,
    ) -> Result<f64, Unsolved> {
        let mut line = LineSearch::new();
        let mut share = LineSearch::WHOLE;
        let mut best: Option<(f64, f64)> = None;
        self.from_residual.copy_from_slice(&self.residual);
        for trial in 1.. {
            self.go(share, &mut stage.state.y);
            self.correct(system, stage);
            let measured = self.measure();
            let along = self.along(norm);
            let accepted = measured.ok().filter(|(change, after)| {
                *after <= (1.0 - RESTRICTION * share) * norm || *change < ROUNDED * tolerance
            });
            if let Some((change, after)) = accepted {
                if share >= LineSearch::WHOLE || along.abs() < ALONG || change < ROUNDED * tolerance {
                    return Ok(share);
                }
                if best.is_none_or(|(_, least)| after < least) {
                    best = Some((share, after));
                    self.best_residual.copy_from_slice(&self.residual);
                }
            }
            line.record(share, along, accepted.is_some());
            if let Some((share, _)) = best.filter(|_| trial >= TRIALS || line.is_narrow() || self.bound.is_overdrawn())
            {
                self.go(share, &mut stage.state.y);
                self.residual.copy_from_slice(&self.best_residual);
                return Ok(share);
            }
            if self.bound.is_overdrawn() {
                self.go(0.0, &mut stage.state.y);
                self.residual.copy_from_slice(&self.from_residual);
                return Ok(0.0);
            }
            if line.end() <= LEAST {
                break;
            }
            share = line.next().max(LEAST);
        }
        Err(Unsolved::NoSolution)
    }

    /// Goes a share of the step at hand from where it began.
    fn go(&self, share: f64, y: &mut [f64]) {
        for ((y, from), d) in y.iter_mut().zip(&self.guess).zip(&self.step) {
            *y = from - share * d;
        }
    }

    /// How far the correction points along the step at hand, whose scaled 2-norm is `norm`: 1 if it is the step once more.
    fn along(&self, norm: f64) -> f64 {
        let products = self.chord.correction.iter().zip(&self.step).zip(&self.chord.scale);
        products.map(|((d, step), s)| (d / s) * (step / s)).sum::<f64>() / (norm * norm)
    }
}
