//! The two pulleys, values for each, and the end stops of the movable sheaves. Their equations of
//! motion are in `variator/pulleys/`.

use crate::scalar::{Real, smooth_plus_energy};
use std::ops::{Index, IndexMut, RangeInclusive};

/// A pulley of the variator, in the order along ξ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pulley {
    /// The driven pulley, at the origin.
    #[default]
    Secondary,
    /// The driving pulley, at (d_A, 0).
    Primary,
}

impl Pulley {
    /// Both pulleys.
    pub const BOTH: [Self; 2] = [Self::Secondary, Self::Primary];

    /// The other pulley.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Secondary => Self::Primary,
            Self::Primary => Self::Secondary,
        }
    }

    /// Prefix of the names of its FMI variables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Secondary => "secondary",
            Self::Primary => "primary",
        }
    }
}

/// A value for each pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PerPulley<T> {
    /// Of the secondary pulley.
    pub secondary: T,
    /// Of the primary pulley.
    pub primary: T,
}

impl<T> PerPulley<T> {
    /// Calls `f` for each pulley, the secondary first.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(Pulley) -> T) -> Self {
        Self {
            secondary: f(Pulley::Secondary),
            primary: f(Pulley::Primary),
        }
    }

    /// Applies `f` to each value.
    #[inline(always)]
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> PerPulley<U> {
        PerPulley {
            secondary: f(self.secondary),
            primary: f(self.primary),
        }
    }

    /// Mutable references to both values, the secondary pulley's first.
    #[inline(always)]
    pub fn each_mut(&mut self) -> [&mut T; 2] {
        [&mut self.secondary, &mut self.primary]
    }
}

impl<T> Index<Pulley> for PerPulley<T> {
    type Output = T;
    #[inline(always)]
    fn index(&self, pulley: Pulley) -> &T {
        match pulley {
            Pulley::Secondary => &self.secondary,
            Pulley::Primary => &self.primary,
        }
    }
}

impl<T> IndexMut<Pulley> for PerPulley<T> {
    #[inline(always)]
    fn index_mut(&mut self, pulley: Pulley) -> &mut T {
        match pulley {
            Pulley::Secondary => &mut self.secondary,
            Pulley::Primary => &mut self.primary,
        }
    }
}

/// Functions of the wedge angle β of the sheaves.
#[derive(Clone, Copy, Debug)]
pub struct Wedge {
    /// sin β.
    pub sin: f64,
    /// cos β.
    pub cos: f64,
    /// tan β.
    pub tan: f64,
}

/// Stiffness of the end stops, N/m: 20 kN compress a stop by 20 µm.
pub const STOP_STIFFNESS: f64 = 1.0e9;

/// Damping time of the end stops, s.
pub const STOP_DAMPING: f64 = 1.0e-4;

/// Smoothing width of the end stops, m.
pub const STOP_SMOOTHING: f64 = 1.0e-6;

/// Axial travel between the end stops, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Opening stop 2(r_min − r₀) tan β.
    pub open: f64,
    /// Closing stop 2(r_max − r₀) tan β.
    pub closed: f64,
}

/// Force of the end stops on the sheave, N, closing positive.
#[derive(Clone, Copy, Debug)]
pub struct StopForce<T> {
    /// Elastic and damping force.
    pub force: T,
    /// Damping part.
    pub viscous: T,
}

impl Travel {
    /// Travel of a pulley over these pitch radii, m; `r0` is that at ratio 1, m.
    #[must_use]
    pub fn new(radii: RangeInclusive<f64>, r0: f64, wedge: &Wedge) -> Self {
        let stop = |radius: f64| 2.0 * (radius - r0) * wedge.tan;
        Self {
            open: stop(*radii.start()),
            closed: stop(*radii.end()),
        }
    }

    /// Force of the stops at position `z` and speed `z_dot`.
    #[inline]
    pub fn stop_force<T: Real>(&self, z: T, z_dot: T) -> StopForce<T> {
        let over = (z - self.closed).smooth_plus(STOP_SMOOTHING);
        let under = (-z + self.open).smooth_plus(STOP_SMOOTHING);
        let viscous = (over.slope + under.slope) * z_dot * (-STOP_STIFFNESS * STOP_DAMPING);
        StopForce {
            force: (under.value - over.value) * STOP_STIFFNESS + viscous,
            viscous,
        }
    }

    /// Energy stored in the stops, J.
    #[must_use]
    pub fn energy(&self, z: f64) -> f64 {
        STOP_STIFFNESS
            * (smooth_plus_energy(z - self.closed, STOP_SMOOTHING, 1.0)
                + smooth_plus_energy(self.open - z, STOP_SMOOTHING, 1.0))
    }
}
