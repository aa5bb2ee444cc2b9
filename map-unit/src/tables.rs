//! The tables of a variator, evaluated linearly on even spacings. [`crate::file`] reads and refines them.
//!
//! A table has the axes force, speed, ratio and one more. It is linear in the force and in the square of the speed, with which the belt's
//! centrifugal force and the loss by turning elements grow. Along the ratio, over ln i, and along the
//! last axis it is the monotone cubic through the given values, in pieces so short that they are straight. Beyond the axes the
//! value at the border holds.

use pushbelt::variator::settings::Parameters;

/// Even places on an axis; one if it has no length.
#[derive(Clone, Copy, Debug)]
pub struct Even {
    first: f64,
    last: f64,
    pub(crate) per_step: f64,
    pub(crate) count: usize,
}

impl Even {
    pub(crate) fn between(first: f64, last: f64, count: usize) -> Self {
        let count = if last > first { count } else { 1 };
        Self {
            first,
            last,
            per_step: (count - 1) as f64 / (last - first).max(f64::MIN_POSITIVE),
            count,
        }
    }

    pub(crate) fn places(self) -> impl Iterator<Item = f64> {
        let share = move |k| k as f64 / (self.count - 1).max(1) as f64;
        (0..self.count).map(move |k| self.first + share(k) * (self.last - self.first))
    }

    /// Index of the interval of a place and the share of it below the place; within the axis.
    pub(crate) fn find(&self, at: f64) -> (usize, f64) {
        let scaled = ((at - self.first) * self.per_step).clamp(0.0, (self.count - 1) as f64);
        let k = (scaled as usize).min(self.count.saturating_sub(2));
        (k, scaled - k as f64)
    }
}

/// Where a state is among the lines of the tables: eight lines with their weights, and whether it is beyond an axis.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    lines: [(usize, f64); 8],
    /// Whether force, speed or ratio are beyond the tables. Below the lowest force and speed they are not: torque falls with
    /// the force, and tables hardly change with a low speed.
    pub outside: bool,
}

/// Refined tables with the same axes. The values of a place are together, so that one look-up reads them all.
#[derive(Clone, Debug)]
pub(crate) struct Sheet<const N: usize> {
    axis: Even,
    values: Vec<[f64; N]>,
}

impl<const N: usize> Sheet<N> {
    pub(crate) fn of(axis: Even, tables: [Vec<f64>; N]) -> Self {
        let places = 0..tables[0].len();
        let values = places.map(|k| std::array::from_fn(|n| tables[n][k])).collect();
        Self { axis, values }
    }

    /// Values and slopes along the last axis.
    #[inline(always)]
    pub(crate) fn at(&self, place: &Place, x: f64) -> ([f64; N], [f64; N]) {
        let (k, t) = self.axis.find(x);
        let next = usize::from(self.axis.count > 1);
        let (mut values, mut slopes) = ([0.0; N], [0.0; N]);
        for (line, weight) in place.lines {
            let row = line * self.axis.count + k;
            let pair = &self.values[row..=row + next];
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
    pub(crate) forces: Vec<f64>,
    /// Squares of the speeds.
    pub(crate) speeds: Vec<f64>,
    pub(crate) ratios: Even,
    pub(crate) shift_utilisations: Vec<f64>,
    /// Thrust ratio, torque loss, bearing load.
    pub(crate) belt: Sheet<3>,
    pub(crate) traction: Sheet<1>,
    /// Shift rates at each utilisation.
    pub(crate) shift_rates: Vec<Sheet<1>>,
    /// Utilisations and slips at capacity, without another axis.
    pub(crate) limits: Vec<[f64; 4]>,
}

impl Tables {
    /// Where a force (N), a speed (rad/s) and ln i are among the lines.
    #[must_use]
    pub fn place(&self, force: f64, speed: f64, log_ratio: f64) -> Place {
        let square = speed * speed;
        // Both ends of the interval on an axis, with their weights.
        let ends = |(k, share): (usize, f64), count: usize| [(k, 1.0 - share), ((k + 1).min(count - 1), share)];
        let (speeds, ratios) = (self.speeds.len(), self.ratios.count);
        let force_ends = ends(interval(&self.forces, force), self.forces.len());
        let speed_ends = ends(interval(&self.speeds, square), speeds);
        let ratio_ends = ends(self.ratios.find(log_ratio), ratios);
        let lines = std::array::from_fn(|corner| {
            let ((f, a), (s, b), (r, c)) = (
                force_ends[corner >> 2],
                speed_ends[corner >> 1 & 1],
                ratio_ends[corner & 1],
            );
            ((f * speeds + s) * ratios + r, a * b * c)
        });
        let beyond = |axis: &[f64], value: f64| axis.last().is_some_and(|last| value > *last);
        // Rounding of a ratio at the border is no reason for a remark.
        let slack = 1e-9;
        let ratios = self.ratios.first - slack..=self.ratios.last + slack;
        let outside = beyond(&self.forces, force) || beyond(&self.speeds, square) || !ratios.contains(&log_ratio);
        Place { lines, outside }
    }

    /// Utilisations and slips at capacity: of each, where the secondary and where the primary pulley drives.
    #[must_use]
    pub fn limits(&self, place: &Place) -> [f64; 4] {
        let mut mean = [0.0; 4];
        for (line, weight) in place.lines {
            for (mean, value) in mean.iter_mut().zip(self.limits[line]) {
                *mean += weight * value;
            }
        }
        mean
    }

    /// −d(ln i)/dt / ω_P at an excess ln(F_P/(κ F_S)), 1/rad, and its slope over the excess.
    #[must_use]
    pub fn shift_rate(&self, place: &Place, utilisation: f64, excess: f64) -> (f64, f64) {
        let (k, t) = interval(&self.shift_utilisations, utilisation);
        let next = (k + 1).min(self.shift_rates.len() - 1);
        let [([low], [low_slope]), ([high], [high_slope])] = [k, next].map(|k| self.shift_rates[k].at(place, excess));
        (low + t * (high - low), low_slope + t * (high_slope - low_slope))
    }
}

/// Index of the interval of a place on an ascending axis, and the share of it below the place; within the axis.
fn interval(axis: &[f64], at: f64) -> (usize, f64) {
    if axis.len() == 1 {
        return (0, 0.0);
    }
    // From the first one on: axes have few places.
    let inner = axis[1..axis.len() - 1].iter();
    let k = inner.take_while(|place| **place < at).count();
    (k, ((at - axis[k]) / (axis[k + 1] - axis[k])).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_found_on_long_and_short_axes() {
        for (at, found) in [(3.0, (1, 0.5)), (0.0, (0, 0.0)), (9.0, (1, 1.0))] {
            assert_eq!(interval(&[1.0, 2.0, 4.0], at), found);
        }
        assert_eq!(interval(&[1.0], 9.0), (0, 0.0));
        let even = Even::between(-1.0, 1.0, 5);
        assert_eq!([even.find(0.25), even.find(7.0)], [(2, 0.5), (3, 1.0)]);
        assert_eq!(Even::between(2.0, 2.0, 5).find(7.0), (0, 0.0));
    }
}
