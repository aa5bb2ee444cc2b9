//! Oil between two elements. Its law is at the head of [`stack`](crate::stack).

use pushbelt::scalar::Real;

/// Oil between two elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oil {
    /// C, N·s·m².
    pub constant: f64,
    /// h_0, m.
    pub floor: f64,
    /// F_c, N.
    pub suction: f64,
}

impl Oil {
    /// Oil with the force `squeeze`, N·s, per rate of strain of elements of `thickness` at zero
    /// gap. 75 N·s at 6 µm are a tenth of oil of 10 mPa·s between faces of 8 by 24 mm.
    pub fn of_squeeze(squeeze: f64, floor: f64, thickness: f64, suction: f64) -> Self {
        Self {
            constant: squeeze / thickness * floor.powi(3),
            floor,
            suction,
        }
    }

    /// c' at the gap and its rate.
    #[inline(always)]
    pub(crate) fn coefficient<T: Real>(&self, gap: T, rate: T) -> T {
        let wide = gap + self.floor;
        let c = (wide * wide * wide).recip() * self.constant;
        let fraction = c * rate * (1.0 / self.suction);
        let (_, limited) = (fraction * fraction + 1.0).root_and_inverse();
        c * rate.if_positive(limited, T::one())
    }
}
