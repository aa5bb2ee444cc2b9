//! The file of the tables: read from JSON, checked, and refined once by monotone cubics.

use std::path::Path;

use pushbelt::variator::settings::{ParameterRows, Parameters, RowValue};
use pushbelt_fmi::{hash, resources};
use serde_json::Value;

use crate::cubic::resampled;
use crate::tables::{Even, Sheet, Tables};

/// Name of the file in the resources.
pub const FILE: &str = "maps.json";
/// Format of the file.
const FORMAT: &str = "pushbelt map unit";
/// Version of the file's content.
const VERSION: u64 = 1;
/// Largest size of the file, bytes.
const LARGEST: u64 = 1 << 24;
/// Largest number of values of the refined tables: 128 MB, 29 times those of the variator that is part of the FMU.
const MOST_VALUES: f64 = (1_u32 << 24) as f64;
/// Number of ratios of the refined tables.
const RATIOS: usize = 65;
/// Number of utilisations of the refined tables.
const UTILISATIONS: usize = 97;
/// Number of slips of the refined traction.
const SHARES: usize = 257;
/// Number of excesses of the refined shift rates.
const EXCESSES: usize = 97;
/// Least distance of neighbours on an axis, as a share of its largest place.
const LEAST_STEP: f64 = 1e-6;

/// Parameters of the variator whose maps these are.
const PARAMETERS: [&str; 6] = [
    "geometry.centerDistance",
    "geometry.beltLength",
    "geometry.wedgeAngle",
    "belt.pitchOffset",
    "friction.fall",
    "friction.fallSpeed",
];

/// Least and greatest value of an axis, table or parameter.
type Range = [f64; 2];

/// Thrust ratios.
pub(crate) const THRUST_RATIO: Range = [1e-3, 100.0];
const UTILISATION: Range = [-10.0, 10.0];
/// Utilisations and slips at capacity, without their sign.
const CAPACITY: Range = [1e-3, 10.0];
const CAPACITY_SLIP: Range = [1e-6, 2.0];

impl Tables {
    /// Reads the tables from the folder of the resources.
    ///
    /// # Errors
    /// The file is missing or damaged; the reason, as a sentence.
    pub fn read(resources: &Path) -> Result<Self, String> {
        let path = resources.join(FILE);
        let unusable = |why: String| format!("the tables in {} can't be used: {why}", path.display());
        let bytes = resources::content(&path, LARGEST).map_err(unusable)?;
        let bytes = bytes.ok_or_else(|| unusable("there is no such file".to_owned()))?;
        Self::of_bytes(&bytes).map_err(unusable)
    }

    /// The tables in the content of a file, without byte-order mark.
    ///
    /// # Errors
    /// The reason, as a sentence.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, String> {
        let document: Value = serde_json::from_slice(bytes).map_err(|error| format!("it is not JSON: {error}"))?;
        if document["format"] != FORMAT || document["version"] != VERSION {
            return Err(format!("it is not of the format {FORMAT:?} in version {VERSION}"));
        }
        File(&document).tables(hash::of_bytes(bytes))
    }
}

/// The document of a file.
struct File<'a>(&'a Value);

impl File<'_> {
    fn tables(&self, hash: u128) -> Result<Tables, String> {
        let (forces, speeds) = (self.axis("force", [1e-3, 1e7])?, self.axis("speed", [1e-3, 1e5])?);
        let logs: Vec<f64> = self
            .axis("ratio", [0.01, 100.0])?
            .iter()
            .map(|ratio| ratio.ln())
            .collect();
        let utilisation = self.axis("utilisation", UTILISATION)?;
        let share = self.axis("slipShare", [-1.0, 1.0])?;
        let shift_utilisations = self.axis("shiftUtilisation", UTILISATION)?;
        let excess = self.axis("excess", [-100.0, 100.0])?;
        if self.axis("direction", [-1.0, 1.0])? != [-1.0, 1.0] || share[0] != -1.0 || share[share.len() - 1] != 1.0 {
            return Err("it is damaged: the axes direction and slipShare must end with -1 and 1".to_owned());
        }
        let grid = Refinement {
            lines: forces.len() * speeds.len(),
            logs: &logs,
            ratios: Even::between(logs[0], logs[logs.len() - 1], RATIOS),
        };
        let count = shift_utilisations.len();
        grid.check_size(count.max(2) - 1, [utilisation.len(), share.len(), count * excess.len()])?;
        let numbers =
            |name: &str, width: usize, range: Range| self.numbers(name, grid.lines * logs.len() * width, range);
        let rising = |name: &str, [rows, width]: [usize; 2], range: Range| {
            let values = numbers(name, rows * width, range)?;
            if values
                .chunks(width)
                .all(|row| row.windows(2).all(|pair| pair[0] <= pair[1]))
            {
                return Ok(values);
            }
            Err(format!("it is damaged: the table {name} falls along its last axis"))
        };
        let of_belt = |name: &str, range: Range| {
            let values = numbers(name, utilisation.len(), range)?;
            Ok::<_, String>(grid.refined(&values, &utilisation, UTILISATIONS).1)
        };
        let pairs = |name: &str, [least, most]: Range| {
            let values = numbers(name, 2, [-most, most])?;
            if values.chunks(2).all(|pair| -pair[0] >= least && pair[1] >= least) {
                return Ok(grid.along_ratio(&values, 2));
            }
            Err(format!(
                "the table {name} must have values of {} to {} in direction -1 and of {least} to {most} in direction 1",
                -most, -least
            ))
        };
        let rates = rising("shiftRate", [count, excess.len()], [-1e3, 1e3])?;
        let shift_rates = |k: usize| {
            let rows = rates.chunks(excess.len()).skip(k).step_by(count);
            let (even, values) = grid.refined(&rows.flatten().copied().collect::<Vec<_>>(), &excess, EXCESSES);
            (even, made_to_rise(values, even.count))
        };
        let shift_rates = (0..count.max(2) - 1).map(|k| {
            let ((even, low), (_, high)) = (shift_rates(k), shift_rates((k + 1).min(count - 1)));
            Sheet::of(even, [low, high])
        });
        let (shares, traction) = grid.refined(&rising("traction", [1, share.len()], UTILISATION)?, &share, SHARES);
        let (capacity, capacity_slip) = (pairs("capacity", CAPACITY)?, pairs("capacitySlip", CAPACITY_SLIP)?);
        let limits = capacity.chunks(2).zip(capacity_slip.chunks(2));
        Ok(Tables {
            parameters: self.parameters()?,
            hash,
            ratios: grid.ratios,
            belt: Sheet::of(
                Even::between(utilisation[0], utilisation[utilisation.len() - 1], UTILISATIONS),
                [
                    of_belt("thrustRatio", THRUST_RATIO)?,
                    of_belt("beltTorqueLoss", [-1e4, 1e4])?,
                    of_belt("bearingLoad", [0.0, 1e7])?,
                ],
            ),
            traction: Sheet::of(shares, [made_to_rise(traction, shares.count)]),
            shift_rates: shift_rates.collect(),
            limits: limits.map(|(of, at)| [of[0], of[1], at[0], at[1]]).collect(),
            forces,
            speeds: speeds.iter().map(|speed| speed * speed).collect(),
            shift_utilisations,
        })
    }

    fn parameters(&self) -> Result<Parameters, String> {
        let mut parameters = Parameters::default();
        for name in PARAMETERS {
            let row = ParameterRows::<Parameters>::WHOLE.iter().find(|row| row.name == name);
            let Some(RowValue::Real(_, _, range, field)) = row.map(|row| &row.value) else {
                continue;
            };
            let found = self.0["parameters"][name].as_f64();
            let found = found.ok_or_else(|| format!("it is damaged: the parameter {name} is missing"))?;
            within(&format!("the parameter {name}"), &[found], *range)?;
            (field.set)(&mut parameters, found);
        }
        parameters.validate_belt().map_err(|error| error.to_string())?;
        Ok(parameters)
    }

    fn axis(&self, name: &str, range: Range) -> Result<Vec<f64>, String> {
        let values = flat(&self.0["axes"][name]["values"]);
        within(&format!("the axis {name}"), &values, range)?;
        let largest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let ascends = values.windows(2).all(|pair| pair[1] - pair[0] >= LEAST_STEP * largest);
        if values.is_empty() || !ascends {
            return Err(format!(
                "it is damaged: the axis {name} is missing or does not ascend by at least {LEAST_STEP:e} of its largest value"
            ));
        }
        Ok(values)
    }

    fn numbers(&self, name: &str, count: usize, range: Range) -> Result<Vec<f64>, String> {
        let values = flat(&self.0["tables"][name]["values"]);
        if values.len() != count {
            return Err(format!(
                "it is damaged: the table {name} has {} numbers instead of {count}",
                values.len()
            ));
        }
        within(&format!("the table {name}"), &values, range)?;
        Ok(values)
    }
}

/// The numbers in nested lists; NaN for what is no number.
fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(flat).collect(),
        other => vec![other.as_f64().unwrap_or(f64::NAN)],
    }
}

/// Checks that values are numbers in a range.
fn within(name: &str, values: &[f64], [least, most]: Range) -> Result<(), String> {
    match values.iter().position(|value| !(least..=most).contains(value)) {
        None => Ok(()),
        Some(at) => Err(format!(
            "{name} has the value {:?} in place {}, which is out of range: {least} to {most}",
            values[at],
            at + 1
        )),
    }
}

/// Each row made to rise: the refinement along the ratio keeps rising rows only nearly so.
fn made_to_rise(mut values: Vec<f64>, width: usize) -> Vec<f64> {
    for row in values.chunks_mut(width) {
        let mut most = f64::NEG_INFINITY;
        for value in row {
            most = most.max(*value);
            *value = most;
        }
    }
    values
}

/// How tables are refined.
struct Refinement<'a> {
    /// Number of pairs of force and speed.
    lines: usize,
    logs: &'a [f64],
    ratios: Even,
}

impl Refinement<'_> {
    /// Checks the numbers of values before memory is taken: after the refinement with so many tables of shift rates, and in the file, where
    /// the last axes have these lengths.
    fn check_size(&self, shift_rates: usize, widths: [usize; 3]) -> Result<(), String> {
        let lines = self.lines as f64;
        let row = 3 * UTILISATIONS + SHARES + 4;
        let refined = lines * self.ratios.count as f64 * (row as f64 + 2.0 * EXCESSES as f64 * shift_rates as f64);
        let given = widths.map(|width| lines * self.logs.len() as f64 * width as f64);
        let most = given.into_iter().fold(refined, f64::max);
        if most <= MOST_VALUES {
            // Twice, for values that are refined in one direction only.
            let probe = Vec::<[f64; 2]>::new().try_reserve_exact(most as usize);
            return probe.map_err(|error| format!("memory for {most:e} values: {error}"));
        }
        Err(format!(
            "its tables have {most:e} values after refinement, and at most {MOST_VALUES} are allowed: fewer forces, speeds or \
             utilisations"
        ))
    }

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
