//! An implicit stage, and the simplified Newton corrections that all solvers of this crate share.

use super::arrow::{Arrow, ArrowLu};
use super::{State, System};
use pushbelt_archive::Archive;

/// A stage: F(t, y, ẏ, q) = 0 with ẏ = α(y − `base`), q = `position` + β y, β = 1/α.
#[derive(Debug)]
pub struct Stage<'a> {
    /// t, s.
    pub time: f64,
    /// α = 1/(hγ), 1/s, and β = hγ, s.
    pub slopes: [f64; 2],
    /// y at which ẏ = 0.
    pub base: &'a [f64],
    /// q at y = 0.
    pub position: &'a [f64],
    /// In: predictor y. Out: solution.
    pub state: &'a mut State,
}

/// α and β of a stage from α.
#[must_use]
pub fn slopes(alpha: f64) -> [f64; 2] {
    [alpha, 1.0 / alpha]
}

/// `out` = `from` + `time`·`rate`.
pub(super) fn move_by(time: f64, out: &mut [f64], from: &[f64], rate: &[f64]) {
    for ((out, from), rate) in out.iter_mut().zip(from).zip(rate) {
        *out = from + time * rate;
    }
}

impl Stage<'_> {
    /// Sets ẏ and q to those of y.
    pub(super) fn complete(&mut self, has_position: &[bool]) {
        let [alpha, beta] = self.slopes;
        let State { y, y_dot, q } = &mut *self.state;
        for ((rate, y), base) in y_dot.iter_mut().zip(&*y).zip(self.base) {
            *rate = alpha * (y - base);
        }
        let new = self.position.iter().zip(&*y).map(|(position, y)| position + beta * y);
        for ((q, has), new) in q.iter_mut().zip(has_position).zip(new) {
            *q = if *has { new } else { *q };
        }
    }
}

/// A factored Jacobian, which later iterations and stages use again, and the correction from it: simplified Newton.
#[derive(Clone, Debug)]
pub(super) struct Chord {
    matrix: Arrow,
    factors: ArrowLu,
    /// Change of each unknown that counts as 1.
    pub scale: Vec<f64>,
    pub correction: Vec<f64>,
}

impl Chord {
    pub fn new(system: &impl System) -> Self {
        let shape = system.shape();
        Self {
            matrix: Arrow::new(shape),
            factors: ArrowLu::new(shape),
            scale: vec![0.0; shape.len()],
            correction: vec![0.0; shape.len()],
        }
    }

    /// Factors the Jacobian that `form` evaluates. False if it is singular.
    pub fn factor(&mut self, form: impl FnOnce(&mut Arrow)) -> bool {
        form(&mut self.matrix);
        self.factors.factor(&self.matrix).is_ok()
    }

    /// Sets the correction to that for a residual.
    pub fn correct(&mut self, residual: &[f64]) {
        self.correction.copy_from_slice(residual);
        self.factors.solve(&mut self.correction);
    }

    /// The largest scaled entry of the correction and its scaled 2-norm.
    pub fn measure(&self) -> (f64, f64) {
        let scaled = || self.correction.iter().zip(&self.scale).map(|(d, s)| d / s);
        let largest = scaled().fold(0.0, |most: f64, x| most.max(x.abs()));
        (largest, scaled().map(|x| x * x).sum::<f64>().sqrt())
    }

    /// The scaled product of the correction with a step.
    pub fn along(&self, step: &[f64]) -> f64 {
        let products = self.correction.iter().zip(step).zip(&self.scale);
        products.map(|((d, step), s)| (d / s) * (step / s)).sum()
    }

    /// Writes the factors to an archive, or reads them from it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.factors.serialize(archive);
    }
}
