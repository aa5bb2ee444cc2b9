//! Newton's method for one implicit stage, with reuse of the factored Jacobian. Its work may be
//! bounded ([`WorkBound`]): the solution then stops before a Jacobian that takes more, and
//! continues there.

use super::arrow::{Arrow, ArrowLu};
use super::broyden::{self, Step};
use super::{State, System};
use nalgebra::DVector;
use pushbelt_archive::Archive;

// "Half, twice": change of the work, residuals and 12 for each Jacobian, with half and twice the
// constant: of the manoeuvre with ALE; of torque flips with ALE0, 1 s at each ratio, jumping and
// ramped. Chaotic loads alone vary by some 2 %.

/// Most Jacobians in a stage. Half, twice: 0, 0 %; 0, 0 %.
const JACOBIANS: u64 = 15;
/// Most iterations of Broyden's method in a stage: twice the residuals that a Jacobian with its
/// factors costs, nine to fourteen for a push belt, since a stage with new factors takes a second
/// iteration too. Half, twice: 0, 0 %; +2, 0 %.
const ITERATIONS: usize = 24;
/// Most iterations that a new Jacobian would have saved: those beyond the first of each stage as far
/// as they rise with the stages, or half of them; then the next stage takes one. Half, twice: +4,
/// −3 %; +2, +2 %.
const EXCESS_ITERATIONS: u64 = 24;
/// Largest change of α, as a fraction of that of a factored matrix, with which the factors are
/// tried. CVODE (Hindmarsh et al. 2005) takes 0.3. Half, twice: +2, +7 %; +1, −1 %. Random
/// communication steps of 0.055 to 0.145 ms take 2.5 and 1.6 times the work of equal ones instead
/// of 1.2.
const REUSED: f64 = 0.4;
/// Growth of the step in one iteration at which Broyden's method is abandoned: as in CVODE. Half,
/// twice: +3, −1 %; +7, +1 %.
const DIVERGED: f64 = 2.0;
/// Exponent of the contraction of the last stage for the first iteration of the next, so that it is
/// measured before it is stale. Hairer and Wanner, Solving Ordinary Differential Equations II,
/// IV.8, give 0.8, which takes a tenth more under smooth loads. Half, and 1, beyond which a
/// contraction would fall unmeasured: +4, +19 %; 0, 0 %.
const AGEING: f64 = 0.9;
/// Part of the tolerance that may remain after the last iteration. Hairer and Wanner, IV.8, find
/// 0.01 to 0.1 best. Half, twice: +3, −2 %; +2, −1 %.
const REMAINDER: f64 = 0.15;
/// Largest projection of the correction on the step where a search along the step ends, as a
/// fraction of the step. Half, twice: 0, −1 %; +1, 0 %.
const PROJECTION: f64 = 0.2;
/// Residuals after which a search along a step ends at its best point; without one it fails
/// after twice as many. Half, twice: −1, 0 %; −2, +2 %, but with half of it 638 stages of
/// flips fail, not 8.
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
        let [steps, rejected, failed] = [&mut self.steps, &mut self.rejected, &mut self.failed];
        [steps, rejected, failed, &mut self.residuals, &mut self.factorizations]
    }

    /// Writes to an archive, or reads from it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        for count in self.each_mut() {
            archive.counter(count);
        }
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, mut more: Self) {
        let pairs = self.each_mut().into_iter().zip(more.each_mut());
        pairs.for_each(|(count, more)| *count += *more);
    }
}

/// Work from an earlier count on.
impl std::ops::Sub for Counts {
    type Output = Self;

    fn sub(mut self, mut earlier: Self) -> Self {
        let pairs = self.each_mut().into_iter().zip(earlier.each_mut());
        pairs.for_each(|(count, earlier)| *count -= *earlier);
        self
    }
}

/// Why a stage is not solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsolved {
    /// Newton's method does not converge.
    NoSolution,
    /// The allowed work is used up. The next call continues from the stage's best point.
    OutOfWork,
}

/// Bound of the work of Newton's method. The unit is a residual with its correction.
#[derive(Clone, Copy, Debug)]
pub struct WorkBound {
    /// Remaining work.
    pub remaining: f64,
    /// Work of a Jacobian with its factors and reused geometry.
    pub jacobian: f64,
    /// Further work where all geometry is evaluated.
    pub geometry: f64,
    /// Work that an iteration that has begun may take beyond the remaining one.
    pub overdraft: f64,
    /// Most Jacobians in a stage.
    pub jacobians: u64,
}

impl WorkBound {
    /// No bound but that of Jacobians.
    pub const NONE: Self = Self {
        remaining: f64::INFINITY,
        jacobian: 0.0,
        geometry: 0.0,
        overdraft: 0.0,
        jacobians: JACOBIANS,
    };

    /// Whether an iteration that has begun has to stop.
    fn is_overdrawn(&self) -> bool {
        self.remaining <= -self.overdraft
    }
}

/// `out` = `from` + `time`·`rate`.
pub(super) fn move_by(time: f64, out: &mut [f64], from: &[f64], rate: &[f64]) {
    for ((out, from), rate) in out.iter_mut().zip(from).zip(rate) {
        *out = from + time * rate;
    }
}

/// An implicit stage of a one-step method: F(t, y, ẏ, q) = 0 with ẏ = α(y − `base`), q = `position`
/// + y/α.
#[derive(Clone, Debug)]
pub struct Stage {
    /// t, s.
    pub time: f64,
    /// α = 1/(hγ), 1/s.
    pub alpha: f64,
    /// Largest error of the solution, in units of [`System::newton_scale`].
    pub tolerance: f64,
    /// y at which ẏ = 0.
    pub base: Vec<f64>,
    /// q at y = 0.
    pub position: Vec<f64>,
    /// In: predictor y. Out: solution.
    pub state: State,
}

impl Stage {
    pub(super) fn new(unknowns: usize) -> Self {
        let state = State::zero(unknowns);
        Self {
            time: 0.0,
            alpha: 1.0,
            tolerance: 1.0,
            base: state.y.clone(),
            position: state.q.clone(),
            state,
        }
    }

    /// Sets ẏ and q to those of y.
    fn complete(&mut self, has_position: &[bool]) {
        let State { y, y_dot, q } = &mut self.state;
        for ((rate, y), base) in y_dot.iter_mut().zip(&*y).zip(&self.base) {
            *rate = self.alpha * (y - base);
        }
        let beta = 1.0 / self.alpha;
        let new = self.position.iter().zip(&*y).map(|(position, y)| position + beta * y);
        for ((q, has), new) in q.iter_mut().zip(has_position).zip(new) {
            *q = if *has { new } else { *q };
        }
    }
}

#[derive(Clone, Debug)]
struct Factored {
    lu: ArrowLu,
    /// α of the matrix; infinite without one, so no stage reuses it.
    alpha: f64,
    /// Contraction per iteration seen with these factors; 1 before any.
    rate: f64,
    /// Stages with these factors; sum of their iterations beyond the first; sum of these times the
    /// number of their stage.
    excess: [u64; 3],
}

impl Factored {
    /// Change from the α of the matrix to another, as a fraction of it: 1 without a matrix.
    fn alpha_change(&self, alpha: f64) -> f64 {
        (alpha / self.alpha - 1.0).abs()
    }

    fn forget(&mut self) {
        (self.alpha, self.rate, self.excess) = (f64::INFINITY, 1.0, [0; 3]);
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.bounded_real(&mut self.alpha, 0.0, f64::INFINITY);
        if self.alpha.is_finite() {
            self.lu.serialize(archive);
        }
        archive.real(&mut self.rate);
        self.excess.iter_mut().for_each(|count| archive.counter(count));
    }
}

/// Newton's method with two factored Jacobians, which later stages use again: where the
/// communication step changes all the time, α returns.
#[derive(Clone, Debug)]
pub struct Newton {
    matrix: Arrow,
    kept: [Factored; 2],
    /// Index of the one in use.
    present: usize,
    /// Change of each unknown that counts as 1.
    scale: Vec<f64>,
    /// Correction by the factors from `residual`.
    correction: Vec<f64>,
    /// Steps of Broyden's method.
    steps: Vec<Step>,
    /// Residual at the point evaluated last.
    residual: Vec<f64>,
    /// Whether that is the stage's point, where a stage continues after its work was used up.
    known: bool,
    /// Jacobians of the last stage.
    pub jacobians: u64,
    /// Step along which a search goes.
    step: Vec<f64>,
    /// y where the search begins; or the best y of Broyden's method.
    anchor: Vec<f64>,
    best_residual: Vec<f64>,
    /// Largest error that remained after the last iteration of a stage, estimated from its
    /// contraction, as a fraction of the tolerance. The caller sets it to zero.
    pub defect: f64,
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
        let zeros = vec![0.0; shape.len()];
        let first = Step {
            vector: DVector::zeros(zeros.len()),
            square: 0.0,
        };
        let kept = [(); 2].map(|()| Factored {
            lu: ArrowLu::new(shape),
            alpha: f64::INFINITY,
            rate: 1.0,
            excess: [0; 3],
        });
        Self {
            matrix: Arrow::new(shape),
            kept,
            present: 0,
            scale: zeros.clone(),
            correction: zeros.clone(),
            steps: vec![first; ITERATIONS],
            residual: zeros.clone(),
            known: false,
            jacobians: 0,
            step: zeros.clone(),
            anchor: zeros.clone(),
            best_residual: zeros,
            defect: 0.0,
            bound: WorkBound::NONE,
            counts: Counts::default(),
        }
    }

    /// Writes to an archive, or reads from it, what later solutions need beside the factors.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.flag(&mut self.known);
        if self.known {
            archive.counter(&mut self.jacobians);
            archive.reals(&mut self.residual);
        }
        archive.bounded_real(&mut self.bound.remaining, f64::MIN, f64::INFINITY);
        self.counts.serialize(archive);
    }

    /// Writes the factored Jacobians to an archive, or reads them.
    pub fn serialize_factors(&mut self, archive: &mut Archive<'_>) {
        archive.indices(std::slice::from_mut(&mut self.present), 2);
        self.kept.iter_mut().for_each(|factored| factored.serialize(archive));
    }

    /// Forgets the factored Jacobians.
    pub fn forget_factors(&mut self) {
        self.present = 0;
        self.kept.iter_mut().for_each(Factored::forget);
    }

    /// Forgets the contraction of the factored Jacobians: the law has changed since.
    pub fn forget_rate(&mut self) {
        self.kept.iter_mut().for_each(|factored| factored.rate = 1.0);
    }

    /// Abandons an unsolved stage.
    pub fn abandon(&mut self) {
        self.known = false;
    }

    /// Solves a stage. `reuse` allows a Jacobian from before.
    ///
    /// # Errors
    /// No convergence: `stage.state.y` is then meaningless. Or the work is used up: the next call
    /// with this stage continues.
    pub fn solve(
        &mut self,
        system: &mut impl System,
        stage: &mut Stage,
        reuse: bool,
    ) -> Result<(), Unsolved> {
        system.newton_scale(1.0 / stage.alpha, &mut self.scale);
        if !self.known {
            if self.bound.remaining <= 0.0 {
                return Err(Unsolved::OutOfWork);
            }
            self.jacobians = 0;
            if self.choose(stage.alpha) && reuse {
                if self.broyden(system, stage, false) {
                    return Ok(());
                }
                // The law has changed since, and more since the other factors.
                self.kept[1 - self.present].forget();
                self.known = true;
            }
        }
        let solved = self.damped_newton(system, stage);
        self.known &= solved == Err(Unsolved::OutOfWork);
        solved
    }

    /// Chooses the factors of the nearer α. Returns whether they may be tried at this α; else they
    /// are the ones to replace.
    fn choose(&mut self, alpha: f64) -> bool {
        let [here, there] = [self.present, 1 - self.present];
        let changes = [here, there].map(|k| self.kept[k].alpha_change(alpha));
        let stays = changes[0] < REUSED || self.kept[here].alpha.is_infinite();
        if changes[1] < changes[0].min(REUSED) || !stays {
            self.present = there;
        }
        self.kept[self.present].alpha_change(alpha) < REUSED
    }

    /// Newton's method with the exact Jacobian, damped where friction saturates: from far off, full
    /// steps overshoot from one sliding direction to the other for ever. After a full step
    /// Broyden's method continues.
    fn damped_newton(&mut self, system: &mut impl System, stage: &mut Stage) -> Result<(), Unsolved> {
        while self.jacobians < self.bound.jacobians {
            if self.bound.remaining < self.bound.jacobian {
                return Err(Unsolved::OutOfWork);
            }
            if self.known {
                stage.complete(system.has_position());
            } else {
                self.evaluate(system, stage);
                self.known = true;
            }
            self.refresh(system, stage)?;
            self.correct();
            if self.search(system, stage)? && self.broyden(system, stage, true) {
                return Ok(());
            }
        }
        Err(Unsolved::NoSolution)
    }

    fn refresh(&mut self, system: &mut impl System, stage: &Stage) -> Result<(), Unsolved> {
        self.jacobians += 1;
        self.counts.factorizations += 1;
        let (view, alpha) = (stage.state.view(), stage.alpha);
        let renewed = system.renew_jacobian(stage.time, view, alpha, 1.0 / alpha, &mut self.matrix);
        self.bound.remaining -= self.bound.jacobian + self.bound.geometry * renewed;
        let factored = &mut self.kept[self.present];
        factored.forget();
        factored.lu.factor(&self.matrix).map_err(|_| Unsolved::NoSolution)?;
        factored.alpha = alpha;
        Ok(())
    }

    fn evaluate(&mut self, system: &mut impl System, stage: &mut Stage) {
        stage.complete(system.has_position());
        system.residual(stage.time, stage.state.view(), &mut self.residual);
        self.counts.residuals += 1;
        self.bound.remaining -= 1.0;
    }

    fn correct(&mut self) {
        self.correction.copy_from_slice(&self.residual);
        self.kept[self.present].lu.solve(&mut self.correction);
    }

    fn scaled_correction(&self) -> impl Iterator<Item = f64> {
        self.correction.iter().zip(&self.scale).map(|(d, s)| d / s)
    }

    /// Scaled 2-norm of the correction.
    fn norm(&self) -> f64 {
        self.scaled_correction().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Broyden's method with the present factors. Returns whether it converges; else
    /// `stage.state.y` is its best point, and `residual` is that of it. `corrected`: the correction
    /// at `stage.state.y` is known.
    fn broyden(&mut self, system: &mut impl System, stage: &mut Stage, corrected: bool) -> bool {
        let (mut least, mut before) = (f64::INFINITY, f64::INFINITY);
        for iteration in 0..ITERATIONS {
            if self.bound.is_overdrawn() {
                break;
            }
            if !corrected || iteration > 0 {
                self.evaluate(system, stage);
                self.correct();
            }
            let change = broyden::set_last(&mut self.steps[..=iteration], &self.correction, &self.scale);
            if iteration == 0 || change < least {
                least = change;
                self.anchor.copy_from_slice(&stage.state.y);
                self.best_residual.copy_from_slice(&self.residual);
            }
            let contraction = change / before;
            let factored = &mut self.kept[self.present];
            if !change.is_finite() || contraction > DIVERGED && change > stage.tolerance {
                break;
            }
            // Remaining error over this step: before a contraction is measured, by that of the last
            // stage; at most 1, since steps that are rounding need not fall.
            let remainder = if iteration == 0 {
                let rate = factored.rate.max(factored.alpha_change(stage.alpha));
                factored.rate = rate.max(f64::EPSILON).powf(AGEING);
                factored.rate
            } else {
                factored.rate = contraction.max(if iteration == 1 { 0.0 } else { factored.rate });
                (contraction / (1.0 - contraction).max(0.0)).min(1.0)
            };
            before = change;
            let step = self.steps[iteration].vector.iter().zip(&self.scale);
            step.zip(&mut stage.state.y).for_each(|((u, s), y)| *y += u * s);
            if change * remainder < REMAINDER * stage.tolerance {
                self.defect = self.defect.max(change * remainder / stage.tolerance);
                stage.complete(system.has_position());
                let [stages, sum, moment] = &mut factored.excess;
                *stages += 1;
                *sum += iteration as u64;
                *moment += *stages * iteration as u64;
                // What a straight line through the iterations rises to above its start, summed.
                let rise = (6 * *moment / *stages).saturating_sub(3 * *sum);
                if rise.max(*sum / 2) > EXCESS_ITERATIONS {
                    factored.alpha = f64::INFINITY;
                }
                return true;
            }
        }
        self.kept[self.present].rate = 1.0;
        stage.state.y.copy_from_slice(&self.anchor);
        self.residual.copy_from_slice(&self.best_residual);
        false
    }

    /// Moves along the correction to a point that the natural monotonicity test accepts (Deuflhard,
    /// Newton Methods for Nonlinear Problems, 2011, section 3.3): the simplified correction there
    /// is smaller. Returns whether that is the whole step, after which the correction is known; the
    /// residual is in any case. A shorter one ends, by bisection, where the correction no longer
    /// points along the step: beyond, where an arc slides the other way, it leads back.
    fn search(&mut self, system: &mut impl System, stage: &mut Stage) -> Result<bool, Unsolved> {
        let norm = self.norm();
        if !norm.is_finite() {
            return Err(Unsolved::NoSolution);
        }
        self.anchor.copy_from_slice(&stage.state.y);
        self.step.copy_from_slice(&self.correction);
        self.best_residual.copy_from_slice(&self.residual);
        let (mut best, mut least) = (0.0, norm);
        let ([mut lower, mut upper], mut fraction) = ([0.0, 1.0], 1.0);
        for trial in 1..=2 * TRIALS {
            move_by(-fraction, &mut stage.state.y, &self.anchor, &self.step);
            self.evaluate(system, stage);
            self.correct();
            let change = self.scaled_correction().fold(0.0, |most: f64, x| most.max(x.abs()));
            let after = self.norm();
            let products = self.correction.iter().zip(&self.step).zip(&self.scale);
            let projection = products.map(|((d, step), s)| (d / s) * (step / s)).sum::<f64>() / (norm * norm);
            let solved = after.is_finite() && change < REMAINDER * stage.tolerance;
            let accepted = solved || after < norm;
            if accepted && (fraction >= 1.0 || solved || projection.abs() < PROJECTION) {
                return Ok(fraction >= 1.0);
            }
            if accepted && after < least {
                (best, least) = (fraction, after);
                self.best_residual.copy_from_slice(&self.residual);
            }
            if accepted && projection > 0.0 {
                lower = fraction;
            } else {
                upper = fraction;
            }
            if self.bound.is_overdrawn() || best > 0.0 && trial >= TRIALS {
                break;
            }
            fraction = 0.5 * (lower + upper);
        }
        if best == 0.0 && !self.bound.is_overdrawn() {
            return Err(Unsolved::NoSolution);
        }
        move_by(-best, &mut stage.state.y, &self.anchor, &self.step);
        self.residual.copy_from_slice(&self.best_residual);
        Ok(false)
    }
}
