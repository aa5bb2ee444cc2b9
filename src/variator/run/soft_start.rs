//! Starts without load. Sharp friction on a slack belt at a standstill makes one cell after the other stick and slide by
//! turns: half of the Jacobians of a launch went there. So the friction velocity v₀ is large at first and falls.

use crate::variator::run::tuning::{RAMP, RAMP_PARTS, RAMP_VELOCITY};

/// Time at which a run started without load, if it did.
#[derive(Clone, Copy, Debug)]
pub(super) struct SoftStart {
    /// Time of the start, s; −∞ if it was none.
    pub from: f64,
}

impl SoftStart {
    /// The run started under load.
    pub const NONE: Self = Self {
        from: f64::NEG_INFINITY,
    };

    /// Time for which friction is held from `time` on, s.
    pub fn piece(self, time: f64) -> f64 {
        if time - self.from < RAMP {
            RAMP / RAMP_PARTS
        } else {
            f64::INFINITY
        }
    }

    /// v₀ in the piece that begins at `time`, that of the ramp in its middle, where it becomes its `own` in the end, m/s.
    pub fn friction_velocity(self, time: f64, own: f64) -> f64 {
        let left = 1.0 - (time - self.from + 0.5 * self.piece(time)) / RAMP;
        if left > 0.0 {
            own * (own.max(RAMP_VELOCITY) / own).powf(left)
        } else {
            own
        }
    }
}
