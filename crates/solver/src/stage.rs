//! An implicit stage of a one-step method.

use super::State;

/// A stage: F(t, y, ẏ, q) = 0 with ẏ = α(y − `base`), q = `position` + y/α.
#[derive(Debug)]
pub struct Stage<'a> {
    /// t, s.
    pub time: f64,
    /// α = 1/(hγ), 1/s.
    pub alpha: f64,
    /// y at which ẏ = 0.
    pub base: &'a [f64],
    /// q at y = 0.
    pub position: &'a [f64],
    /// In: predictor y. Out: solution.
    pub state: &'a mut State,
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
        let (alpha, beta) = (self.alpha, 1.0 / self.alpha);
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
