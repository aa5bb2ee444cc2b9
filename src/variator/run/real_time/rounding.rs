//! By what share laws are rounded in real time: not at all while steps are solved, wholly for some time after one that was not.

use crate::tape::Tape;

/// Defects (root mean squares of the correction that is left, in units of Newton's scale) from which on the laws begin to be rounded
/// and are rounded wholly.
const DEFECTS: [f64; 2] = [150.0, 800.0];
/// Level after a defect above those. With it and the fading below, the laws stay rounded for nine ticks, so that they still are where a torque flips each
/// 10 ms, and are those of the user again after twenty-seven. With a fading by 0.9 they sharpen between two flips, and more
/// steps are left unsolved.
const HIGHEST: f64 = 2.0;
const FADING: f64 = 0.93;
/// Level below which the laws are those of the user: ticks on laws that are rounded less are solved less often than calm ones.
const CALM: f64 = 0.3;

/// A level that rises at once with what a tick leaves unsolved, and fades.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rounding {
    level: f64,
}

impl Rounding {
    /// From 0, the user's laws, to 1, those of [`Rounded`](crate::variator::settings::parameters::Rounded).
    pub fn share(self) -> f64 {
        if self.level < CALM { 0.0 } else { self.level.min(1.0) }
    }

    /// Rises: a step was abandoned.
    pub fn rise(&mut self) {
        self.level = HIGHEST;
    }

    /// Follows a step that left a defect.
    pub fn follow(&mut self, defect: f64) {
        let [least, most] = DEFECTS;
        let rough = ((defect / least).ln() / (most / least).ln()).clamp(0.0, 1.0);
        self.level = (FADING * self.level).max(HIGHEST * rough);
    }

    /// Writes to a tape, or reads from it.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        tape.real(&mut self.level);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rises_at_once_stays_and_fades_to_nothing() {
        let mut rounding = Rounding::default();
        for calm in [0.0, 1e-300, 149.0] {
            rounding.follow(calm);
            assert_eq!(rounding.share(), 0.0);
        }
        rounding.follow(1e9);
        for tick in 0..=9 {
            assert_eq!(rounding.share(), 1.0, "{tick}");
            rounding.follow(0.0);
        }
        let share = rounding.share();
        assert!((0.8..1.0).contains(&share), "{share}");
        for _ in 0..17 {
            rounding.follow(0.0);
        }
        assert_eq!(rounding.share(), 0.0);
        rounding.follow(200.0);
        let share = rounding.share();
        assert!((0.3..0.4).contains(&share), "{share}");
    }
}
