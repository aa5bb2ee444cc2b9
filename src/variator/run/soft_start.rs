//! Starts without load. Sharp friction on a slack belt at a standstill makes one cell after the other stick and slide by
//! turns: half of the Jacobians of a launch went there. So loads ramp in, and the friction velocity v₀ is large at first and falls.

use crate::variator::run::tuning::{FRICTION_RAMP, LOAD_RAMP, RAMP_PARTS, RAMP_VELOCITY};

/// Time at which a run started without load, if it did.
#[derive(Clone, Copy, Debug)]
pub struct SoftStart {
    /// Time of the start, s; −∞ if it was none.
    pub from: f64,
}

impl SoftStart {
    /// The run started under load.
    pub const NONE: Self = Self {
        from: f64::NEG_INFINITY,
    };

    /// Time for which loads and friction are held from `time` on, s.
    #[must_use]
    pub fn piece(self, time: f64) -> f64 {
        let past = time - self.from;
        if past < LOAD_RAMP {
            LOAD_RAMP / RAMP_PARTS
        } else if past < FRICTION_RAMP {
            (FRICTION_RAMP - LOAD_RAMP) / RAMP_PARTS
        } else {
            f64::INFINITY
        }
    }

    /// Time since the start in the middle of the piece that begins at `time`, s.
    fn middle(self, time: f64) -> f64 {
        time - self.from + 0.5 * self.piece(time)
    }

    /// Share of the loads in the piece that begins at `time`.
    #[must_use]
    pub fn load_share(self, time: f64) -> f64 {
        (self.middle(time) / LOAD_RAMP).min(1.0)
    }

    /// v₀ in the piece that begins at `time`, where it becomes its `own` in the end, m/s.
    #[must_use]
    pub fn friction_velocity(self, time: f64, own: f64) -> f64 {
        let left = 1.0 - (self.middle(time) / FRICTION_RAMP).min(1.0);
        if left > 0.0 {
            own * (own.max(RAMP_VELOCITY) / own).powf(left)
        } else {
            own
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_grow_and_friction_sharpens_until_both_are_the_users() {
        let start = SoftStart { from: 3.0 };
        let (mut time, mut load, mut velocity) = (3.0, 0.0, 1.0);
        while start.piece(time).is_finite() {
            let (share, v) = (start.load_share(time), start.friction_velocity(time, 5e-4));
            assert!((0.0..=1.0).contains(&share) && share >= load && v < velocity && v > 5e-4);
            (load, velocity) = (share, v);
            time += start.piece(time);
        }
        assert!((time - 3.0 - FRICTION_RAMP).abs() < FRICTION_RAMP / RAMP_PARTS);
        for start in [start, SoftStart::NONE] {
            assert_eq!(
                (start.load_share(time), start.friction_velocity(time, 5e-4)),
                (1.0, 5e-4)
            );
        }
        // Friction that is softer anyhow stays as it is.
        assert_eq!(start.friction_velocity(3.0, 0.1), 0.1);
    }
}
