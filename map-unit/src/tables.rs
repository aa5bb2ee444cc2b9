//! The tables of a variator, evaluated linearly on even spacings. [`crate::file`] reads and refines
//! them.
//!
//! A table has the axes force, speed, ratio and one more. It is linear in the force and in the
//! square of the speed, with which the belt's centrifugal force and the loss by turning elements
//! grow. Along the ratio, over ln i, and along the last axis it is the monotone cubic through the
//! given values, in pieces so short that they are straight. Beyond the axes the value at the border
//! holds.

use pushbelt::variator::settings::Parameters;

/// Even places on an axis; one if it has no length.
#[derive(Clone, Copy, Debug)]
pub struct UniformAxis {
    first: f64,
    last: f64,
    pub per_step: f64,
    pub count: usize,
}

impl UniformAxis {
    /// So many places from the first to the last one of an ascending axis.
    pub fn over(axis: &[f64], count: usize) -> Self {
        let (first, last) = (axis[0], axis[axis.len() - 1]);
        let count = if last > first { count } else { 1 };
        Self {
            first,
            last,
            per_step: (count - 1) as f64 / (last - first).max(f64::MIN_POSITIVE),
            count,
        }
    }

    pub fn places(self) -> impl Iterator<Item = f64> {
        let fraction = move |k| k as f64 / (self.count - 1).max(1) as f64;
        (0..self.count).map(move |k| self.first + fraction(k) * (self.last - self.first))
    }

    /// Index of the interval of a place and the fraction of it below the place; within the axis.
    pub fn find(&self, at: f64) -> (usize, f64) {
        let scaled = ((at - self.first) * self.per_step).clamp(0.0, (self.count - 1) as f64);
        let k = (scaled as usize).min(self.count.saturating_sub(2));
        (k, scaled - k as f64)
    }
}

/// Where a state is among the lines of the tables: eight lines with their weights, and whether it
/// is beyond an axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct GridPosition {
    lines: [(usize, f64); 8],
    /// Whether force, speed or ratio are beyond the tables. Below the lowest force and speed they
    /// are not: torque falls with the force, and tables hardly change with a low speed.
    pub outside: bool,
}

/// Refined tables with the same axes. The values of a place are together, so that one look-up reads
/// them all.
#[derive(Clone, Debug)]
pub struct Table<const N: usize> {
    /// The last axis, and the number of rows along it of each line.
    pub axis: UniformAxis,
    pub rows: usize,
    pub values: Vec<[f64; N]>,
}

impl<const N: usize> Table<N> {
    /// Values in a row and slopes along it.
    #[inline(always)]
    pub fn interpolate(&self, place: &GridPosition, row: usize, x: f64) -> ([f64; N], [f64; N]) {
        let (k, t) = self.axis.find(x);
        let next = usize::from(self.axis.count > 1);
        let (mut values, mut slopes) = ([0.0; N], [0.0; N]);
        for (line, weight) in place.lines {
            let first = (line * self.rows + row) * self.axis.count + k;
            let pair = &self.values[first..=first + next];
            let (low, high) = (&pair[0], &pair[next]);
            for n in 0..N {
                values[n] += weight * (low[n] + t * (high[n] - low[n]));
                slopes[n] += weight * (high[n] - low[n]);
            }
        }
        (values, slopes.map(|rise| rise * self.axis.per_step))
    }
}

/// All tables of a variator.
#[derive(Clone, Debug)]
pub struct Tables {
    /// Geometry of the variator and fall of its friction; the start values otherwise.
    pub parameters: Parameters,
    /// Hash of the file.
    pub hash: u128,
    pub forces: Vec<f64>,
    /// Squares of the speeds.
    pub speeds: Vec<f64>,
    /// Places over ln i.
    pub ratios: UniformAxis,
    /// Thrust ratio, torque loss, bearing load, over the utilisation.
    pub belt: Table<3>,
    /// Utilisation over the fraction of the slip at capacity.
    pub traction: Table<1>,
    /// Shift rates over the excess, with a row for each of the utilisations.
    pub shift_rates: Table<1>,
    pub shift_utilisations: Vec<f64>,
    /// Utilisations and slips at capacity, of each where the secondary and where the primary pulley
    /// drives; without another axis.
    pub limits: Table<4>,
}

impl Tables {
    /// Where a force (N), a speed (rad/s) and ln i are among the lines.
    pub fn place(&self, force: f64, speed: f64, log_ratio: f64) -> GridPosition {
        let square = speed * speed;
        // Both ends of the interval on an axis, with their weights.
        let ends = |(k, fraction): (usize, f64), count: usize| {
            [(k, 1.0 - fraction), ((k + 1).min(count - 1), fraction)]
        };
        let (speeds, ratios) = (self.speeds.len(), self.ratios.count);
        let axes = [
            ends(interval(&self.forces, force), self.forces.len()),
            ends(interval(&self.speeds, square), speeds),
            ends(self.ratios.find(log_ratio), ratios),
        ];
        let lines = std::array::from_fn(|corner| {
            let [(f, a), (s, b), (r, c)] = [0, 1, 2].map(|n| axes[n][corner >> (2 - n) & 1]);
            ((f * speeds + s) * ratios + r, a * b * c)
        });
        // Rounding of a ratio at the border is no reason for a remark.
        let ratios = self.ratios.first - 1e-9..=self.ratios.last + 1e-9;
        let above = self.forces.last() < Some(&force) || self.speeds.last() < Some(&square);
        let outside = above || !ratios.contains(&log_ratio);
        GridPosition { lines, outside }
    }

    /// −d(ln i)/dt / ω_P at an excess ln(F_P/(κ F_S)), 1/rad, and its slope over the excess.
    pub fn shift_rate(&self, place: &GridPosition, utilisation: f64, excess: f64) -> (f64, f64) {
        let (k, t) = interval(&self.shift_utilisations, utilisation);
        let next = (k + 1).min(self.shift_utilisations.len() - 1);
        let [([low], [low_slope]), ([high], [high_slope])] =
            [k, next].map(|row| self.shift_rates.interpolate(place, row, excess));
        (low + t * (high - low), low_slope + t * (high_slope - low_slope))
    }
}

/// Index of the interval of a place on an ascending axis, and the fraction of it below the place;
/// within the axis.
pub fn interval(axis: &[f64], at: f64) -> (usize, f64) {
    if axis.len() == 1 {
        return (0, 0.0);
    }
    // From the first one on: axes have few places.
    let inner = axis[1..axis.len() - 1].iter();
    let k = inner.take_while(|place| **place < at).count();
    (k, ((at - axis[k]) / (axis[k + 1] - axis[k])).clamp(0.0, 1.0))
}
