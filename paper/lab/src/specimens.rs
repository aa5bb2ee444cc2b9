//! Rings and curves with known answers.

use std::f64::consts::TAU;

use crate::circle::Circle;
use nalgebra::Vector2;
use pushbelt::ring::Ring;
use pushbelt::variator::settings::Parameters;
use pushbelt_paper::reference_curve::{ReferenceCurve, TwoPulley};

/// A ring of the paper's fig. 6 and 7, and the curve from which it starts.
#[derive(Clone, Debug)]
pub struct Specimen {
    /// What it is, in tables.
    pub name: &'static str,
    pub ring: Ring,
    pub curve: TwoPulley,
}

impl Specimen {
    /// The thick ring of the reference numbers.
    pub fn thick() -> Self {
        Self {
            name: "thick ring",
            ring: solid(),
            curve: solid_curve(),
        }
    }

    /// All layers of bench168, unbonded, on its pulleys, without damping.
    pub fn bench168() -> Self {
        let parameters = Parameters::default();
        let ring = Ring {
            damping: 0.0,
            ..parameters.ring
        };
        Self {
            name: "ring of bench168",
            ring,
            curve: TwoPulley::new(parameters.geometry.center_distance, parameters.geometry.belt_length),
        }
    }

    /// One of its layers.
    pub fn layer() -> Self {
        let all = Self::bench168();
        let share =
            1.0 / f64::from(u32::try_from(2 * Parameters::default().layers.count).expect("some layers"));
        Self {
            name: "one layer of bench168",
            ring: Ring {
                mass_per_length: all.ring.mass_per_length * share,
                axial_stiffness: all.ring.axial_stiffness * share,
                bending_stiffness: all.ring.bending_stiffness * share,
                lateral_bending_stiffness: all.ring.lateral_bending_stiffness * share,
                damping: 0.0,
            },
            curve: all.curve,
        }
    }

    /// Time scale of bending, L² √(m/EI), s.
    pub fn bending_time(&self) -> f64 {
        (self.ring.mass_per_length / self.ring.bending_stiffness).sqrt() * self.curve.length().powi(2)
    }
}

/// The ring of the reference numbers for the paper's fig. 6 and 7: L = 1 m, d_A = 0.2 m, a plate
/// rather than a ring of a belt. EA belongs to the same steel section (E = 2.1e11 N/m², ρ = 7800
/// kg/m³).
pub fn solid() -> Ring {
    Ring {
        mass_per_length: 154.0,
        axial_stiffness: 154.0 / 7800.0 * 2.1e11,
        bending_stiffness: 35_000.0,
        lateral_bending_stiffness: 35_000.0,
        damping: 0.0,
    }
}

pub fn solid_curve() -> TwoPulley {
    TwoPulley::new(0.2, 1.0)
}

/// A steel band of `thickness`, 9.5 mm wide.
pub fn band(thickness: f64) -> Ring {
    let (e, rho, width) = (2.1e11, 7800.0, 9.5e-3_f64);
    Ring {
        mass_per_length: rho * thickness * width,
        axial_stiffness: e * thickness * width,
        bending_stiffness: e * width * thickness.powi(3) / 12.0,
        lateral_bending_stiffness: e * thickness * width.powi(3) / 12.0,
        damping: 0.0,
    }
}

/// Circumference of the free band, m.
pub const BAND_LENGTH: f64 = 0.70;

pub fn band_circle() -> Circle {
    Circle {
        radius: BAND_LENGTH / TAU,
    }
}

/// First bending frequency of a free thin ring, Hz.
pub fn thin_ring_frequency(ring: &Ring, radius: f64) -> f64 {
    (36.0_f64 / 5.0).sqrt() * (ring.bending_stiffness / (ring.mass_per_length * radius.powi(4))).sqrt() / TAU
}

/// The same ring without stiffness: its residual is inertia alone.
pub fn without_stiffness(ring: &Ring) -> Ring {
    Ring {
        axial_stiffness: 0.0,
        bending_stiffness: 0.0,
        lateral_bending_stiffness: 0.0,
        ..ring.clone()
    }
}

/// A ring with a soft membrane, and an estimate of its first frequency, rad/s.
pub fn soft_membrane() -> (Ring, f64) {
    let radius = BAND_LENGTH / TAU;
    let thin = band(0.185e-3);
    let near = 0.9 * TAU * thin_ring_frequency(&thin, radius);
    let ring = Ring {
        axial_stiffness: 10.0 * thin.bending_stiffness / (radius * radius),
        ..thin
    };
    (ring, near)
}

/// The two-arc shape of a belt of the band's length at Θ = 0.4 and d_A = 0.155 m: (r, r') at ξ.
pub fn two_arc() -> impl Fn(f64) -> [Vector2<f64>; 2] {
    let curve = TwoPulley::new(0.155, BAND_LENGTH);
    let frame = curve.frame::<f64>(0.4);
    // Same leftmost point as the circle.
    let shift = curve.at(&frame, 0.0).r + Vector2::new(BAND_LENGTH / TAU, 0.0);
    move |xi| {
        let point = curve.at(&frame, xi);
        [point.r - shift, point.t]
    }
}
