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

/// A refined table.
#[derive(Clone, Debug)]
struct Sheet {
    along: Even,
    values: Vec<f64>,
}

impl Sheet {
    /// The table with each row made to rise: the refinement along the ratio keeps rising rows only nearly so.
    fn rising(mut self) -> Self {
        for row in self.values.chunks_mut(self.along.count) {
            let mut most = f64::NEG_INFINITY;
            for value in row {
                most = most.max(*value);
                *value = most;
            }
        }
        self
    }

    /// The value, and its slope along the last axis.
    fn at(&self, place: &Place, x: f64) -> (f64, f64) {
        let (k, t) = self.along.find(x);
        let next = usize::from(self.along.count > 1);
        let (mut value, mut rise) = (0.0, 0.0);
        for (line, weight) in place.lines {
            let row = line * self.along.count + k;
            let (low, high) = (self.values[row], self.values[row + next]);
            value += weight * (low + t * (high - low));
            rise += weight * (high - low);
        }
        (value, rise * self.along.per_step)
    }
}

/// Values that belong to the two directions of the torque: secondary drives, primary drives.
#[derive(Clone, Debug)]
struct Pair(Vec<[f64; 2]>);

impl Pair {
    fn at(&self, place: &Place) -> [f64; 2] {
        let mut found = [0.0; 2];
        for (line, weight) in place.lines {
            let [low, high] = self.0[line];
            found[0] += weight * low;
            found[1] += weight * high;
        }
        found
    }
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
    thrust_ratio: Sheet,
    torque_loss: Sheet,
    bearing_load: Sheet,
    traction: Sheet,
    shift_rates: Vec<Sheet>,
    capacity: Pair,
    capacity_slip: Pair,
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
        if self.thrust_ratio.values.iter().any(|value| *value <= 0.0) {
            return wrong("a thrust ratio is not positive");
        }
        let signs = |pair: &[f64; 2]| pair[0] < 0.0 && pair[1] > 0.0;
        if !self.capacity.0.iter().all(signs) || !self.capacity_slip.0.iter().all(signs) {
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
        (self.capacity.at(place), self.capacity_slip.at(place))
    }

    /// Utilisation at a slip, as a share of the slip at capacity from −1 to 1, and its slope.
    #[must_use]
    pub fn traction(&self, place: &Place, share: f64) -> (f64, f64) {
        self.traction.at(place, share)
    }

    /// Thrust ratio κ at a utilisation.
    #[must_use]
    pub fn thrust_ratio(&self, place: &Place, utilisation: f64) -> f64 {
        self.thrust_ratio.at(place, utilisation).0
    }

    /// Thrust ratio κ at a utilisation, and its slope.
    #[must_use]
    pub fn thrust_ratio_and_slope(&self, place: &Place, utilisation: f64) -> (f64, f64) {
        self.thrust_ratio.at(place, utilisation)
    }

    /// Torque loss of the belt at the primary pulley, N·m.
    #[must_use]
    pub fn torque_loss(&self, place: &Place, utilisation: f64) -> f64 {
        self.torque_loss.at(place, utilisation).0
    }

    /// Resultant of the belt's contact forces on a pulley, N.
    #[must_use]
    pub fn bearing_load(&self, place: &Place, utilisation: f64) -> f64 {
        self.bearing_load.at(place, utilisation).0
    }

    /// −d(ln i)/dt / ω_P at an excess ln(F_P/(κ F_S)), 1/rad, and its slope over the excess.
    #[must_use]
    pub fn shift_rate(&self, place: &Place, utilisation: f64, excess: f64) -> (f64, f64) {
        let (k, t) = interval(&self.shift_utilisations, utilisation);
        let low = self.shift_rates[k].at(place, excess);
        if t == 0.0 {
            return low;
        }
        let high = self.shift_rates[k + 1].at(place, excess);
        (low.0 + t * (high.0 - low.0), low.1 + t * (high.1 - low.1))
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
        let refined = |name: &str, along: &[f64], count: usize| -> Result<Sheet, String> {
            let values = self.numbers(name, grid.lines * logs.len() * along.len())?;
            Ok(grid.sheet(&values, along, count))
        };
        let pairs = |name: &str| -> Result<Pair, String> {
            let values = self.numbers(name, grid.lines * logs.len() * 2)?;
            let rows = grid.along_ratio(&values, 2);
            Ok(Pair(rows.as_chunks::<2>().0.to_vec()))
        };
        let count = shift_utilisations.len();
        let rates = self.numbers("shiftRate", grid.lines * logs.len() * count * excess.len())?;
        rises("shiftRate", &rates, excess.len())?;
        rises(
            "traction",
            &self.numbers("traction", grid.lines * logs.len() * share.len())?,
            share.len(),
        )?;
        let shift_rates = (0..count).map(|k| {
            let rows = rates.chunks(excess.len()).skip(k).step_by(count);
            grid.sheet(&rows.flatten().copied().collect::<Vec<_>>(), &excess, EXCESSES)
                .rising()
        });
        Ok(Tables {
            geometry: self.geometry()?,
            hash,
            ratios,
            thrust_ratio: refined("thrustRatio", &utilisation, UTILISATIONS)?,
            torque_loss: refined("beltTorqueLoss", &utilisation, UTILISATIONS)?,
            bearing_load: refined("bearingLoad", &utilisation, UTILISATIONS)?,
            traction: refined("traction", &share, SHARES)?.rising(),
            shift_rates: shift_rates.collect(),
            capacity: pairs("capacity")?,
            capacity_slip: pairs("capacitySlip")?,
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
    fn sheet(&self, values: &[f64], along: &[f64], count: usize) -> Sheet {
        let even = Even::between(along[0], along[along.len() - 1], count);
        let places = even.places();
        let rows = values.chunks(along.len());
        let fine: Vec<f64> = rows.flat_map(|row| resampled(along, row, &places)).collect();
        Sheet {
            along: even,
            values: self.along_ratio(&fine, even.count),
        }
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
