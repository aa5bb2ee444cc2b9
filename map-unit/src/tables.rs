//! The tables of a variator, evaluated linearly on even spacings. [`crate::file`] reads and refines
//! them.
//!
//! A table has the axes force, speed, ratio and one more. It is linear in the force and in the
//! square of the speed. Along the ratio, over ln i, and along the last axis it is the monotone
//! cubic through the given values, in short straight pieces. Beyond the axes the value at the
//! border holds.

use pushbelt::variator::settings::Parameters;

/// Even spacing of an axis; one point if it has no length.
#[derive(Clone, Copy, Debug)]
pub struct UniformAxis {
    first: f64,
    last: f64,
    pub per_step: f64,
    pub count: usize,
}

impl UniformAxis {
    /// `count` points from the first to the last one of an ascending axis.
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

    pub fn points(self) -> impl Iterator<Item = f64> {
        let fraction = move |k| k as f64 / (self.count - 1).max(1) as f64;
        (0..self.count).map(move |k| self.first + fraction(k) * (self.last - self.first))
    }

    /// Position of a value, within the axis.
    pub fn find(&self, value: f64) -> AxisPosition {
        let scaled = ((value - self.first) * self.per_step).clamp(0.0, (self.count - 1) as f64);
        let index = (scaled as usize).min(self.count.saturating_sub(2));
        let fraction = scaled - index as f64;
        AxisPosition { index, fraction }
    }
}

/// Position on an axis: index of an interval, and the fraction of it below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPosition {
    pub index: usize,
    pub fraction: f64,
}

/// Position of a state among the lines of the tables.
#[derive(Clone, Copy, Debug, Default)]
pub struct GridPosition {
    lines: [usize; 8],
    weights: [f64; 8],
    /// Whether force, speed or ratio are beyond the tables, but not below the lowest force and
    /// speed: torque falls with the force, and tables hardly change with a low speed.
    pub outside: bool,
}

/// A value and its slope.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sloped {
    pub value: f64,
    pub slope: f64,
}

/// Refined tables with the same axes. The values of a point are together, so that one look-up reads
/// them all.
#[derive(Clone, Debug)]
pub struct Table<const N: usize> {
    /// The last axis, and the number of rows along it of each line.
    pub axis: UniformAxis,
    pub rows: usize,
    pub values: Vec<[f64; N]>,
}

impl<const N: usize> Table<N> {
    /// Values at `x` in a row, and their slopes along it.
    #[inline(always)]
    pub fn interpolate(&self, position: &GridPosition, row: usize, x: f64) -> [Sloped; N] {
        let AxisPosition { index, fraction } = self.axis.find(x);
        let next = usize::from(self.axis.count > 1);
        let mut found = [Sloped::default(); N];
        for (line, weight) in position.lines.iter().zip(position.weights) {
            let first = (line * self.rows + row) * self.axis.count + index;
            let pair = &self.values[first..=first + next];
            let (low, high) = (&pair[0], &pair[next]);
            for n in 0..N {
                found[n].value += weight * (low[n] + fraction * (high[n] - low[n]));
                found[n].slope += weight * (high[n] - low[n]);
            }
        }
        for sloped in &mut found {
            sloped.slope *= self.axis.per_step;
        }
        found
    }
}

#[derive(Clone, Debug)]
pub struct Tables {
    /// Geometry of the variator and fall of its friction; the start values otherwise.
    pub parameters: Parameters,
    pub hash: u128,
    pub forces: Vec<f64>,
    /// Squares of the speeds.
    pub speeds: Vec<f64>,
    /// Points over ln i.
    pub ratios: UniformAxis,
    /// Thrust ratio, torque loss, bearing load, over the utilisation divided by that at capacity.
    pub belt: Table<3>,
    /// Utilisation over the fraction of the slip at capacity.
    pub traction: Table<1>,
    /// Shift rates over the excess, with a row for each of the utilisations.
    pub shift_rates: Table<1>,
    pub shift_utilisations: Vec<f64>,
    /// Utilisation at capacity where the secondary and where the primary pulley drives, then the
    /// slips; without another axis.
    pub limits: Table<4>,
}

impl Tables {
    /// Position of a force (N), a speed (rad/s) and ln i.
    pub fn position(&self, force: f64, speed: f64, log_ratio: f64) -> GridPosition {
        let square = speed * speed;
        // Both ends of the interval on an axis, with their weights.
        let ends = |AxisPosition { index, fraction }, count: usize| {
            [(index, 1.0 - fraction), ((index + 1).min(count - 1), fraction)]
        };
        let (speeds, ratios) = (self.speeds.len(), self.ratios.count);
        let axes = [
            ends(interval(&self.forces, force), self.forces.len()),
            ends(interval(&self.speeds, square), speeds),
            ends(self.ratios.find(log_ratio), ratios),
        ];
        let (mut lines, mut weights) = ([0; 8], [1.0; 8]);
        for corner in 0..8 {
            let [(f, a), (s, b), (r, c)] = [0, 1, 2].map(|n| axes[n][corner >> (2 - n) & 1]);
            lines[corner] = (f * speeds + s) * ratios + r;
            weights[corner] = a * b * c;
        }
        // Rounding of a ratio at the border is no reason for a remark.
        let ratios = self.ratios.first - 1e-9..=self.ratios.last + 1e-9;
        let above = self.forces.last() < Some(&force) || self.speeds.last() < Some(&square);
        let outside = above || !ratios.contains(&log_ratio);
        GridPosition {
            lines,
            weights,
            outside,
        }
    }

    /// −d(ln i)/dt / ω_P at an excess ln(F_P/(κ F_S)), 1/rad, and its slope over the excess.
    pub fn shift_rate(&self, position: &GridPosition, utilisation: f64, excess: f64) -> Sloped {
        let AxisPosition { index, fraction } = interval(&self.shift_utilisations, utilisation);
        let next = (index + 1).min(self.shift_utilisations.len() - 1);
        let [[low], [high]] = [index, next].map(|row| self.shift_rates.interpolate(position, row, excess));
        Sloped {
            value: low.value + fraction * (high.value - low.value),
            slope: low.slope + fraction * (high.slope - low.slope),
        }
    }
}

/// Position of a value on an ascending axis, within it.
pub fn interval(axis: &[f64], value: f64) -> AxisPosition {
    let (mut index, mut fraction) = (0, 0.0);
    if axis.len() > 1 {
        // From the first one on: axes have few points.
        let inner = axis[1..axis.len() - 1].iter();
        index = inner.take_while(|point| **point < value).count();
        fraction = ((value - axis[index]) / (axis[index + 1] - axis[index])).clamp(0.0, 1.0);
    }
    AxisPosition { index, fraction }
}
