//! The tables of a variator: read from JSON, refined once by monotone cubics, then evaluated linearly on even spacings.
//!
//! A table has the axes force, speed, ratio and one more. It is linear in the force and in the square of the speed, with which the belt's
//! centrifugal force and the loss by turning elements grow. Along the ratio, over ln i, and along the
//! last axis it is the monotone cubic through the given values, in pieces so short that they are straight. Beyond the axes the
//! value at the border holds.

use std::fs;
use std::path::Path;

use pushbelt_fmi::hash;
use serde_json::Value;

use crate::cubic::resampled;

/// Name of the file in the resources.
pub const FILE: &str = "maps.json";
/// Format of the file.
const FORMAT: &str = "pushbelt map unit";
/// Version of the file's content.
const VERSION: u64 = 1;
/// Largest size of the file, bytes.
const LARGEST: u64 = 1 << 28;
/// Number of ratios of the refined tables.
const RATIOS: usize = 65;
/// Number of utilisations of the refined tables.
const UTILISATIONS: usize = 97;
/// Number of slips of the refined traction.
const SHARES: usize = 257;
/// Number of excesses of the refined shift rates.
const EXCESSES: usize = 97;

/// Even places on an axis.
#[derive(Clone, Copy, Debug)]
pub struct Even {
    first: f64,
    last: f64,
    per_step: f64,
    count: usize,
}

impl Even {
    fn between(first: f64, last: f64, count: usize) -> Self {
        let count = if last > first { count } else { 1 };
        let per_step = if count > 1 {
            (count - 1) as f64 / (last - first)
        } else {
            0.0
        };
        Self {
            first,
            last,
            per_step,
            count,
        }
    }

    fn places(&self) -> Vec<f64> {
        let last = self.count.saturating_sub(1);
        (0..self.count)
            .map(|k| match k {
                0 => self.first,
                k if k == last => self.last,
                k => self.first + k as f64 / self.per_step,
            })
            .collect()
    }

    /// Index of the interval of a place and the share of it below the place; within the axis.
    fn find(&self, at: f64) -> (usize, f64) {
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
struct Sheet<const N: usize> {
    along: Even,
    values: Vec<[f64; N]>,
}

impl<const N: usize> Sheet<N> {
    fn of(along: Even, tables: [Vec<f64>; N]) -> Self {
        let count = tables[0].len();
        let values = (0..count).map(|k| std::array::from_fn(|n| tables[n][k])).collect();
        Self { along, values }
    }

    /// Values and slopes along the last axis, and the interval in which the slopes hold.
    fn at(&self, place: &Place, x: f64) -> Found<N> {
        let (k, t) = self.along.find(x);
        let next = usize::from(self.along.count > 1);
        let (mut values, mut slopes) = ([0.0; N], [0.0; N]);
        for (line, weight) in place.lines {
            let row = line * self.along.count + k;
            let pair = &self.values[row..=row + next];
            let (low, high) = (&pair[0], &pair[next]);
            for n in 0..N {
                values[n] += weight * (low[n] + t * (high[n] - low[n]));
                slopes[n] += weight * (high[n] - low[n]);
            }
        }
        Found {
            values,
            slopes: slopes.map(|rise| rise * self.along.per_step),
            interval: k,
        }
    }
}

/// What a look-up finds.
struct Found<const N: usize> {
    values: [f64; N],
    slopes: [f64; N],
    /// Index of the interval along the last axis.
    interval: usize,
}

/// Each row made to rise: the refinement along the ratio keeps rising rows only nearly so.
fn rising(mut values: Vec<f64>, width: usize) -> Vec<f64> {
    for row in values.chunks_mut(width) {
        let mut most = f64::NEG_INFINITY;
        for value in row {
            most = most.max(*value);
            *value = most;
        }
    }
    values
}

/// What the tables give for the belt at a utilisation.
#[derive(Clone, Copy, Debug)]
pub struct Belt {
    /// Thrust ratio κ.
    pub thrust_ratio: f64,
    /// Its slope over the utilisation.
    pub thrust_slope: f64,
    /// Torque loss of the belt at the primary pulley, N·m.
    pub torque_loss: f64,
    /// Resultant of the belt's contact forces on a pulley, N.
    pub bearing_load: f64,
}

/// Utilisation at a slip.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Utilisation.
    pub value: f64,
    /// Its slope.
    pub slope: f64,
    /// Slips between which the slope holds.
    pub between: [f64; 2],
}

/// Constants of the variator whose maps these are.
#[derive(Clone, Copy, Debug)]
pub struct Geometry {
    /// Distance of the pulley axes, m.
    pub center_distance: f64,
    /// Length of the ring's centre line, m.
    pub belt_length: f64,
    /// Half wedge angle, rad.
    pub wedge_angle: f64,
    /// Distance of the pitch line from the centre line of the ring, m.
    pub pitch_offset: f64,
    /// Relative decrease of the friction in fast sliding.
    pub fall: f64,
    /// Sliding speed over which the friction falls, m/s.
    pub fall_speed: f64,
}

/// All tables of a variator.
#[derive(Clone, Debug)]
pub struct Tables {
    /// Constants of the variator.
    pub geometry: Geometry,
    /// Hash of the file.
    pub hash: u128,
    forces: Vec<f64>,
    /// Squares of the speeds.
    speeds: Vec<f64>,
    ratios: Even,
    shift_utilisations: Vec<f64>,
    /// Thrust ratio, torque loss, bearing load.
    belt: Sheet<3>,
    traction: Sheet<1>,
    /// Shift rates at each utilisation and the next one.
    shift_rates: Vec<Sheet<2>>,
    /// Utilisations and slips at capacity; of each, where the secondary and where the primary pulley drives.
    limits: Vec<[f64; 4]>,
}

impl Tables {
    /// Reads the tables from the folder of the resources.
    ///
    /// # Errors
    /// The file is missing or damaged; the reason, as a sentence.
    pub fn read(resources: &Path) -> Result<Self, String> {
        let path = resources.join(FILE);
        let unusable = |why: String| format!("the tables in {} can't be used: {why}", path.display());
        let size = fs::metadata(&path).map_err(|error| unusable(error.to_string()))?.len();
        if size > LARGEST {
            return Err(unusable(format!("the file has more than {LARGEST} bytes")));
        }
        let bytes = fs::read(&path).map_err(|error| unusable(error.to_string()))?;
        Self::of_bytes(&bytes).map_err(unusable)
    }

    /// The tables in the content of a file.
    ///
    /// # Errors
    /// The reason, as a sentence.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, String> {
        let document: Value = serde_json::from_slice(bytes).map_err(|error| format!("it is not JSON: {error}"))?;
        let file = File(&document);
        if document["format"] != FORMAT || document["version"] != VERSION {
            return Err(format!("it is not of the format {FORMAT:?} in version {VERSION}"));
        }
        let tables = file.tables(hash::of_bytes(bytes))?;
        tables.check()?;
        Ok(tables)
    }

    /// What the equations rely on.
    fn check(&self) -> Result<(), String> {
        let wrong = |what: &str| Err(format!("it is damaged: {what}"));
        if self.belt.values.iter().any(|[thrust_ratio, ..]| *thrust_ratio <= 0.0) {
            return wrong("a thrust ratio is not positive");
        }
        let signs = |[back, ahead, back_slip, ahead_slip]: &[f64; 4]| {
            *back < 0.0 && *ahead > 0.0 && *back_slip < 0.0 && *ahead_slip > 0.0
        };
        if !self.limits.iter().all(signs) {
            return wrong("a capacity has the wrong sign");
        }
        let Geometry {
            center_distance,
            belt_length,
            wedge_angle,
            pitch_offset,
            fall,
            fall_speed,
        } = self.geometry;
        let sound = center_distance > 0.0
            && belt_length > 2.0 * center_distance
            && (0.0..1.5).contains(&wedge_angle)
            && (0.0..center_distance).contains(&pitch_offset)
            && (0.0..1.0).contains(&fall)
            && fall_speed > 0.0;
        if sound {
            Ok(())
        } else {
            wrong("its geometry or friction")
        }
    }

    /// Where a force (N), a speed (rad/s) and ln i are among the lines.
    #[must_use]
    pub fn place(&self, force: f64, speed: f64, log_ratio: f64) -> Place {
        let (f, a) = interval(&self.forces, force);
        let (s, b) = interval(&self.speeds, speed * speed);
        let (r, c) = self.ratios.find(log_ratio);
        let count = self.ratios.count;
        let next = usize::from(count > 1);
        let mut lines = [(0, 0.0); 8];
        let mut at = 0;
        for (f, a) in [(f, 1.0 - a), ((f + 1).min(self.forces.len() - 1), a)] {
            for (s, b) in [(s, 1.0 - b), ((s + 1).min(self.speeds.len() - 1), b)] {
                let first = (f * self.speeds.len() + s) * count + r;
                lines[at] = (first, a * b * (1.0 - c));
                lines[at + 1] = (first + next, a * b * c);
                at += 2;
            }
        }
        let beyond = |axis: &[f64], value: f64| axis.last().is_some_and(|last| value > *last);
        // Rounding of a ratio at the border is no reason for a remark.
        let slack = 1e-9;
        let outside = beyond(&self.forces, force)
            || beyond(&self.speeds, speed * speed)
            || log_ratio < self.ratios.first - slack
            || log_ratio > self.ratios.last + slack;
        Place { lines, outside }
    }

    /// Capacity in both directions: utilisations and slips.
    #[must_use]
    pub fn limits(&self, place: &Place) -> ([f64; 2], [f64; 2]) {
        let mut found = [0.0; 4];
        for (line, weight) in place.lines {
            for (sum, value) in found.iter_mut().zip(&self.limits[line]) {
                *sum += weight * value;
            }
        }
        let [back, ahead, back_slip, ahead_slip] = found;
        ([back, ahead], [back_slip, ahead_slip])
    }

    /// Utilisation at a slip, as a share of the slip at capacity from −1 to 1.
    #[must_use]
    pub fn traction(&self, place: &Place, share: f64) -> Line {
        let found = self.traction.at(place, share);
        let along = &self.traction.along;
        let border = |k: usize| along.first + k as f64 / along.per_step;
        Line {
            value: found.values[0],
            slope: found.slopes[0],
            between: [border(found.interval), border(found.interval + 1)],
        }
    }

    /// The belt at a utilisation.
    #[must_use]
    pub fn belt(&self, place: &Place, utilisation: f64) -> Belt {
        let found = self.belt.at(place, utilisation);
        let [thrust_ratio, torque_loss, bearing_load] = found.values;
        Belt {
            thrust_ratio,
            thrust_slope: found.slopes[0],
            torque_loss,
            bearing_load,
        }
    }

    /// −d(ln i)/dt / ω_P at an excess ln(F_P/(κ F_S)), 1/rad, and its slope over the excess.
    #[must_use]
    pub fn shift_rate(&self, place: &Place, utilisation: f64, excess: f64) -> (f64, f64) {
        let (k, t) = interval(&self.shift_utilisations, utilisation);
        let Found {
            values: [low, high],
            slopes: [low_slope, high_slope],
            ..
        } = self.shift_rates[k].at(place, excess);
        (low + t * (high - low), low_slope + t * (high_slope - low_slope))
    }
}

/// Index of the interval of a place on an ascending axis, and the share of it below the place; within the axis.
fn interval(axis: &[f64], at: f64) -> (usize, f64) {
    let last = axis.len() - 1;
    let mut k = 0;
    while k + 1 < last && at > axis[k + 1] {
        k += 1;
    }
    if last == 0 {
        return (0, 0.0);
    }
    (k, ((at - axis[k]) / (axis[k + 1] - axis[k])).clamp(0.0, 1.0))
}

/// The document of a file.
struct File<'a>(&'a Value);

impl File<'_> {
    fn tables(&self, hash: u128) -> Result<Tables, String> {
        let axis = |name: &str| self.axis(name);
        let (forces, speeds, ratio) = (axis("force")?, axis("speed")?, axis("ratio")?);
        if [&forces, &speeds, &ratio].iter().any(|axis| axis[0] <= 0.0) {
            return Err("it is damaged: a force, speed or ratio is not positive".to_owned());
        }
        let logs: Vec<f64> = ratio.iter().map(|ratio| ratio.ln()).collect();
        let ratios = Even::between(logs[0], logs[logs.len() - 1], RATIOS);
        let (utilisation, share) = (axis("utilisation")?, axis("slipShare")?);
        let (shift_utilisations, excess) = (axis("shiftUtilisation")?, axis("excess")?);
        if axis("direction")? != [-1.0, 1.0] || share[0] != -1.0 || share[share.len() - 1] != 1.0 {
            return Err("it is damaged: the axes direction and slipShare must end with -1 and 1".to_owned());
        }
        let grid = Refinement {
            lines: forces.len() * speeds.len(),
            logs: &logs,
            ratios,
        };
        let rises = |name: &str, values: &[f64], width: usize| {
            let mut rows = values.chunks(width);
            if rows.all(|row| row.windows(2).all(|pair| pair[0] <= pair[1])) {
                Ok(())
            } else {
                Err(format!("it is damaged: the table {name} falls along its last axis"))
            }
        };
        let refined = |name: &str, along: &[f64], count: usize| -> Result<(Even, Vec<f64>), String> {
            let values = self.numbers(name, grid.lines * logs.len() * along.len())?;
            Ok(grid.refined(&values, along, count))
        };
        let pairs = |name: &str| -> Result<Vec<f64>, String> {
            let values = self.numbers(name, grid.lines * logs.len() * 2)?;
            Ok(grid.along_ratio(&values, 2))
        };
        let count = shift_utilisations.len();
        let rates = self.numbers("shiftRate", grid.lines * logs.len() * count * excess.len())?;
        rises("shiftRate", &rates, excess.len())?;
        rises(
            "traction",
            &self.numbers("traction", grid.lines * logs.len() * share.len())?,
            share.len(),
        )?;
        let shift_rates = |k: usize| {
            let rows = rates.chunks(excess.len()).skip(k).step_by(count);
            let (even, values) = grid.refined(&rows.flatten().copied().collect::<Vec<_>>(), &excess, EXCESSES);
            (even, rising(values, even.count))
        };
        let shift_rates = (0..count.max(2) - 1).map(|k| {
            let ((even, low), (_, high)) = (shift_rates(k), shift_rates((k + 1).min(count - 1)));
            Sheet::of(even, [low, high])
        });
        let (utilisations, thrust_ratio) = refined("thrustRatio", &utilisation, UTILISATIONS)?;
        let (_, torque_loss) = refined("beltTorqueLoss", &utilisation, UTILISATIONS)?;
        let (_, bearing_load) = refined("bearingLoad", &utilisation, UTILISATIONS)?;
        let (shares, traction) = refined("traction", &share, SHARES)?;
        let (capacity, capacity_slip) = (pairs("capacity")?, pairs("capacitySlip")?);
        let limits = capacity.chunks(2).zip(capacity_slip.chunks(2));
        Ok(Tables {
            geometry: self.geometry()?,
            hash,
            ratios,
            belt: Sheet::of(utilisations, [thrust_ratio, torque_loss, bearing_load]),
            traction: Sheet::of(shares, [rising(traction, shares.count)]),
            shift_rates: shift_rates.collect(),
            limits: limits.map(|(of, at)| [of[0], of[1], at[0], at[1]]).collect(),
            forces,
            speeds: speeds.iter().map(|speed| speed * speed).collect(),
            shift_utilisations,
        })
    }

    fn geometry(&self) -> Result<Geometry, String> {
        let parameter = |name: &str| {
            let found = self.0["parameters"][name].as_f64();
            found.ok_or_else(|| format!("it is damaged: the parameter {name} is missing"))
        };
        Ok(Geometry {
            center_distance: parameter("geometry.centerDistance")?,
            belt_length: parameter("geometry.beltLength")?,
            wedge_angle: parameter("geometry.wedgeAngle")?,
            pitch_offset: parameter("belt.pitchOffset")?,
            fall: parameter("friction.fall")?,
            fall_speed: parameter("friction.fallSpeed")?,
        })
    }

    fn axis(&self, name: &str) -> Result<Vec<f64>, String> {
        let mut values = Vec::new();
        flatten(&self.0["axes"][name]["values"], &mut values);
        let ascends = values.windows(2).all(|pair| pair[0] < pair[1]);
        if values.is_empty() || !ascends || values.iter().any(|value| !value.is_finite()) {
            return Err(format!("it is damaged: the axis {name} is missing or does not ascend"));
        }
        Ok(values)
    }

    fn numbers(&self, name: &str, count: usize) -> Result<Vec<f64>, String> {
        let mut values = Vec::with_capacity(count);
        flatten(&self.0["tables"][name]["values"], &mut values);
        if values.len() != count || values.iter().any(|value| !value.is_finite()) {
            return Err(format!(
                "it is damaged: the table {name} has {} numbers instead of {count}",
                values.len()
            ));
        }
        Ok(values)
    }
}

/// The numbers in nested lists; NaN for what is no number.
fn flatten(value: &Value, into: &mut Vec<f64>) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| flatten(item, into)),
        other => into.push(other.as_f64().unwrap_or(f64::NAN)),
    }
}

/// How tables are refined.
struct Refinement<'a> {
    /// Number of pairs of force and speed.
    lines: usize,
    logs: &'a [f64],
    ratios: Even,
}

impl Refinement<'_> {
    /// The refined last axis, and the values refined along it and along the ratio.
    fn refined(&self, values: &[f64], along: &[f64], count: usize) -> (Even, Vec<f64>) {
        let even = Even::between(along[0], along[along.len() - 1], count);
        let places = even.places();
        let rows = values.chunks(along.len());
        let fine: Vec<f64> = rows.flat_map(|row| resampled(along, row, &places)).collect();
        (even, self.along_ratio(&fine, even.count))
    }

    /// Refines along the ratio; rows have `width` values.
    fn along_ratio(&self, values: &[f64], width: usize) -> Vec<f64> {
        let places = self.ratios.places();
        let mut found = vec![0.0; self.lines * places.len() * width];
        for line in 0..self.lines {
            let block = &values[line * self.logs.len() * width..][..self.logs.len() * width];
            for column in 0..width {
                let curve: Vec<f64> = block.iter().skip(column).step_by(width).copied().collect();
                for (r, value) in resampled(self.logs, &curve, &places).into_iter().enumerate() {
                    found[(line * places.len() + r) * width + column] = value;
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals() {
        assert_eq!(interval(&[1.0, 2.0, 4.0], 3.0), (1, 0.5));
        assert_eq!(interval(&[1.0, 2.0, 4.0], 0.0), (0, 0.0));
        assert_eq!(interval(&[1.0, 2.0, 4.0], 9.0), (1, 1.0));
        assert_eq!(interval(&[1.0], 9.0), (0, 0.0));
        let even = Even::between(-1.0, 1.0, 5);
        assert_eq!(even.find(0.25), (2, 0.5));
        assert_eq!(even.find(7.0), (3, 1.0));
        assert_eq!(Even::between(2.0, 2.0, 5).find(7.0), (0, 0.0));
    }
}
