//! Starts without load. Sharp friction on a slack belt at a standstill makes one cell after the other stick and slide by
//! turns: half of the Jacobians of a launch went there. So loads ramp in, and friction is soft at first: its velocity v₀ is
//! large and falls.

/// Time over which the loads ramp in, s.
pub const LOAD_RAMP: f64 = 2.0e-3;

/// Time over which friction sharpens, s.
pub const SHARPENING: f64 = 1.0e-2;

/// v₀ that friction starts with, m/s, unless its own is larger.
const SOFT_VELOCITY: f64 = 0.02;

/// Time for which loads are held on their ramp, and friction after it, s. Larger steps of the loads shake the belt
/// more.
const LOAD_PIECE: f64 = 1.25e-4;
const FRICTION_PIECE: f64 = 5.0e-4;

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
            LOAD_PIECE
        } else if past < SHARPENING {
            FRICTION_PIECE
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

    /// v₀ in the piece that begins at `time`, where it becomes `sharp` in the end, m/s.
    #[must_use]
    pub fn friction_velocity(self, time: f64, sharp: f64) -> f64 {
        let left = 1.0 - (self.middle(time) / SHARPENING).min(1.0);
        if left > 0.0 {
            sharp * (sharp.max(SOFT_VELOCITY) / sharp).powf(left)
        } else {
            sharp
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
        assert!((time - 3.0 - SHARPENING).abs() < FRICTION_PIECE);
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
