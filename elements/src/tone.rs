//! Tone: amplitudes of forces and torques at orders of the number N of elements per revolution of
//! the belt.
//!
//! The phase φ is in revolutions, dφ/dt = ΣV/(N Σ|c|), with the chords c: each element passes once
//! a revolution. The amplitude of x at the order k is |Σ h (x − x̄) e^{−2πikφ}| 2/Σ h with Hann's
//! window h over the part of the run that is its result.

use crate::{Machine, Vector, belt::add};
use std::f64::consts::TAU;

/// Signals: phase; axial forces and torques of the belt on S and P; of element 1 its place along
/// the belt, m, pitch, rad, normal force of a flank, N, and sliding speed, m/s.
pub const SIGNALS: &str = "revolutions,secondary.axialForce,primary.axialForce,secondary.beltTorque,\
    primary.beltTorque,place,pitch,normalForce,slidingSpeed";
/// Columns of a line: means, and the amplitudes at orders N and 2N, N and N·m.
pub const COLUMNS: &str = "ratio,thrustRatio,slip,secondary.axialForce,primary.axialForce,secondary.speed,\
    primary.speed,secondary.beltTorque,primary.beltTorque,secondary.axialForce.N,primary.axialForce.N,secondary.beltTorque.N,\
    primary.beltTorque.N,secondary.axialForce.2N,primary.axialForce.2N,secondary.beltTorque.2N,\
    primary.beltTorque.2N";

/// Signals at one time.
pub type Sample = [f64; 9];

/// The revolutions that the belt makes in a step.
pub fn revolutions(machine: &Machine) -> f64 {
    let n = machine.law.count;
    let speed: f64 = machine.belt.v[1..=n].iter().map(|v| v.re).sum();
    let length: f64 = machine.belt.length[1..=n].iter().sum();
    machine.dt * speed / (n as f64 * length)
}

/// Amplitudes of the last eight columns, for `count` elements.
pub fn amplitudes(samples: &[Sample], count: usize) -> [f64; 8] {
    let mut sums = [Vector::default(); 8];
    let (mut means, mut weight) = ([0.0; 4], 0.0);
    let window = |k: usize| 1.0 - (TAU * (k as f64 + 0.5) / samples.len() as f64).cos();
    for (k, sample) in samples.iter().enumerate() {
        weight += window(k);
        add(&mut means, sample[1..].iter().map(|value| window(k) * value));
    }
    for (k, sample) in samples.iter().enumerate() {
        for (c, sum) in sums.iter_mut().enumerate() {
            let order = (count * (1 + c / 4)) as f64;
            let value = sample[1 + c % 4] - means[c % 4] / weight;
            *sum += Vector::from_polar(window(k) * value, -TAU * order * sample[0]);
        }
    }
    sums.map(|sum| 2.0 * sum.norm() / weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cosine of its order has its amplitude, also beside a mean that drifts.
    #[test]
    fn amplitudes_are_those_of_cosines() {
        let sample = |k: u32| {
            let phase = f64::from(k) * 2.3e-4;
            let of = |order: f64, amplitude: f64| amplitude * (TAU * order * phase + 0.4).cos();
            let mut sample = [0.0; 9];
            (sample[0], sample[1]) = (phase, 9e3 + 50.0 * phase + of(464.0, 7.0));
            (sample[2], sample[3]) = (of(928.0, 3.0), of(460.0, 5.0));
            sample
        };
        let samples: Vec<_> = (0..8_000).map(sample).collect();
        let found = amplitudes(&samples, 464);
        for (found, expected) in found.into_iter().zip([7.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0]) {
            assert!((found - expected).abs() < 0.01, "{found} instead of {expected}");
        }
    }
}
