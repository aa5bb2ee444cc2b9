//! Search along a step of Newton's method for the place from which the next correction no longer points along it.
//!
//! Friction saturates. From far off a whole step overshoots: an arc slides the other way with all its cells at once, and
//! the correction there leads back along the step. What has to be solved is then one equation in one unknown, φ(λ) = 0 with
//! φ = d(λ)·d(0)/d(0)², where d(λ) is the simplified correction after the share λ of the step. φ is 1 at λ = 0, falls slowly
//! while the arc slides on, and steeply where it turns. A residual finds φ out; a new Jacobian costs nine to fourteen of them.

/// Part of the interval, from its lower end, within which the next share lies: φ has a kink, so interpolation alone creeps.
const INNER: [f64; 2] = [0.25, 0.6];
/// Part of its upper end below which an interval is narrow.
const NARROW: f64 = 0.05;

/// An end of the interval: share of the step, and φ there.
#[derive(Clone, Copy, Debug)]
struct End {
    share: f64,
    along: f64,
}

/// The interval that holds the place, narrowed by the Illinois method, which halves φ of an end that stays.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineSearch {
    before: End,
    /// Its φ is NaN where only the share is known to be too large.
    beyond: End,
    /// Whether the last share was before the place; none at first.
    last_before: Option<bool>,
}

impl LineSearch {
    /// The share that is tried first.
    pub const WHOLE: f64 = 1.0;

    /// A search in which nothing has been tried.
    pub fn new() -> Self {
        Self {
            before: End { share: 0.0, along: 1.0 },
            beyond: End {
                share: Self::WHOLE,
                along: f64::NAN,
            },
            last_before: None,
        }
    }

    /// Records φ at a share, `along`, and whether the correction there was `accepted`. One that was not, though it does not
    /// lead back, is too far: it grows across the step.
    pub fn record(&mut self, share: f64, along: f64, accepted: bool) {
        let before = accepted && along > 0.0;
        if self.last_before == Some(before) {
            let stays = if before { &mut self.beyond } else { &mut self.before };
            stays.along *= 0.5;
        }
        if before {
            self.before = End { share, along };
        } else {
            let along = if along < 0.0 { along } else { f64::NAN };
            self.beyond = End { share, along };
        }
        self.last_before = Some(before);
    }

    /// The next share to try.
    pub fn next(&self) -> f64 {
        let [before, beyond] = [self.before, self.beyond];
        let part = before.along / (before.along - beyond.along);
        let [least, most] = INNER;
        let part = if part.is_nan() { 0.5 } else { part.clamp(least, most) };
        before.share + part * (beyond.share - before.share)
    }

    /// The least share that is known to be too large.
    pub fn end(&self) -> f64 {
        self.beyond.share
    }

    /// Whether the place is known well enough.
    pub fn is_narrow(&self) -> bool {
        self.beyond.share - self.before.share < NARROW * self.beyond.share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force that saturates on both sides, and is steep between: an arc that turns, anywhere along the step.
    #[test]
    fn an_arc_that_turns_is_found_in_a_few_residuals() {
        for turn in [0.02, 0.1, 0.3, 0.5, 0.8, 0.95] {
            for jump in [2.0, 10.0, 50.0] {
                let steep = 0.02 * turn;
                let phi = |share: f64| 1.0 - share - 0.5 * jump * (1.0 + ((share - turn) / steep).tanh());
                let mut line = LineSearch::new();
                let mut tried = vec![LineSearch::WHOLE];
                while let Some(&share) = tried.last()
                    && phi(share).abs() > 0.2
                    && !line.is_narrow()
                    && tried.len() < 20
                {
                    line.record(share, phi(share), true);
                    tried.push(line.next());
                }
                let found = tried[tried.len() - 1];
                let near = phi(found).abs() <= 0.2 || (found - turn).abs() < 0.1 * turn;
                assert!(near, "turn at {turn} by {jump}: {tried:?}");
                assert!(tried.len() <= 12, "turn at {turn} by {jump}: {tried:?}");
            }
        }
    }

    #[test]
    fn what_is_refused_halves_the_step() {
        let mut line = LineSearch::new();
        line.record(1.0, f64::NAN, false);
        assert_eq!(line.next(), 0.5);
        line.record(0.5, 0.4, false);
        assert_eq!(line.next(), 0.25);
        line.record(0.25, 0.6, true);
        assert!((line.next() - 0.375).abs() < 1e-15, "what was accepted is a lower end");
    }
}
