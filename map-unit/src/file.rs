//! The file of the tables: read from JSON, checked, and refined once by monotone cubics.

use std::path::Path;

use pushbelt::variator::settings::{ParameterRows, Parameters, RowValue};
use pushbelt_fmi::{hash, resources};
use serde_json::Value;

use crate::cubic::resampled;
use crate::tables::{Even, Sheet, Tables};
use crate::tuning::{EXCESSES, RATIOS, SHARES, UTILISATIONS};

/// Name of the file in the resources.
pub const FILE: &str = "maps.json";
/// Format of the file.
const FORMAT: &str = "pushbelt map unit";
/// Version of the file's content.
const VERSION: u64 = 1;
/// Largest size of the file, bytes.
const LARGEST_FILE: u64 = 1 << 24;
/// Largest number of values of the refined tables: 128 MB, 29 times those of the variator that is part of the FMU.
const MOST_VALUES: f64 = (1_u32 << 24) as f64;
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
/// Utilisations.
pub(crate) const UTILISATION: Range = [-10.0, 10.0];
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
        let bytes = resources::content(&path, LARGEST_FILE).map_err(unusable)?;
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
        File::new(&document)?.tables(hash::of_bytes(bytes))
    }
}

/// The document of a file, with its lines along the ratio and their refinement.
struct File<'a> {
    document: &'a Value,
    forces: Vec<f64>,
    speeds: Vec<f64>,
    logs: Vec<f64>,
    ratios: Even,
}

impl<'a> File<'a> {
    fn new(document: &'a Value) -> Result<Self, String> {
        let [forces, speeds, ratios] = [
            axis(document, "force", [1e-3, 1e7])?,
            axis(document, "speed", [1e-3, 1e5])?,
            axis(document, "ratio", [0.01, 100.0])?,
        ];
        let logs: Vec<f64> = ratios.iter().map(|ratio| ratio.ln()).collect();
        Ok(Self {
            document,
            forces,
            speeds,
            ratios: Even::between(logs[0], logs[logs.len() - 1], RATIOS),
            logs,
        })
    }

    fn tables(self, hash: u128) -> Result<Tables, String> {
        let axis = |name: &str, range: Range| axis(self.document, name, range);
        let (utilisation, share) = (axis("utilisation", UTILISATION)?, axis("slipShare", [-1.0, 1.0])?);
        let (shift_utilisations, excess) = (axis("shiftUtilisation", UTILISATION)?, axis("excess", [-100.0, 100.0])?);
        if axis("direction", [-1.0, 1.0])? != [-1.0, 1.0] || share[0] != -1.0 || share[share.len() - 1] != 1.0 {
            return Err("it is damaged: the axes direction and slipShare must end with -1 and 1".to_owned());
        }
        let count = shift_utilisations.len();
        self.check_size(count, [utilisation.len(), share.len(), count * excess.len()])?;
        let of_belt = |name: &str, range: Range| {
            let values = self.numbers(name, utilisation.len(), range)?;
            Ok::<_, String>(self.refined(&values, &utilisation, UTILISATIONS))
        };
        let ((along, thrust_ratio), (_, torque_loss), (_, bearing_load)) = (
            of_belt("thrustRatio", THRUST_RATIO)?,
            of_belt("beltTorqueLoss", [-1e4, 1e4])?,
            of_belt("bearingLoad", [0.0, 1e7])?,
        );
        let rates = self.rising("shiftRate", [count, excess.len()], [-1e3, 1e3])?;
        let shift_rates = (0..count).map(|k| {
            let rows = rates.chunks(excess.len()).skip(k).step_by(count);
            self.risen(&rows.flatten().copied().collect::<Vec<_>>(), &excess, EXCESSES)
        });
        let traction = self.rising("traction", [1, share.len()], UTILISATION)?;
        let (capacity, slip) = (
            self.pairs("capacity", CAPACITY)?,
            self.pairs("capacitySlip", CAPACITY_SLIP)?,
        );
        let limits = capacity.chunks(2).zip(slip.chunks(2));
        Ok(Tables {
            parameters: self.parameters()?,
            hash,
            belt: Sheet::of(along, [thrust_ratio, torque_loss, bearing_load]),
            traction: self.risen(&traction, &share, SHARES),
            shift_rates: shift_rates.collect(),
            limits: limits.map(|(of, at)| [of[0], of[1], at[0], at[1]]).collect(),
            speeds: self.speeds.iter().map(|speed| speed * speed).collect(),
            forces: self.forces,
            ratios: self.ratios,
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
            let found = self.document["parameters"][name].as_f64();
            let found = found.ok_or_else(|| format!("it is damaged: the parameter {name} is missing"))?;
            within(&format!("the parameter {name}"), &[found], *range)?;
            (field.set)(&mut parameters, found);
        }
        parameters.validate_belt().map_err(|error| error.to_string())?;
        Ok(parameters)
    }

    /// Number of pairs of force and speed.
    fn lines(&self) -> usize {
        self.forces.len() * self.speeds.len()
    }

    /// The numbers of a table, so many for each force, speed and ratio.
    fn numbers(&self, name: &str, width: usize, range: Range) -> Result<Vec<f64>, String> {
        let count = self.lines() * self.logs.len() * width;
        let values = flat(&self.document["tables"][name]["values"]);
        if values.len() != count {
            return Err(format!(
                "it is damaged: the table {name} has {} numbers instead of {count}",
                values.len()
            ));
        }
        within(&format!("the table {name}"), &values, range)?;
        Ok(values)
    }

    /// The numbers of a table that does not fall along its last axis.
    fn rising(&self, name: &str, [rows, width]: [usize; 2], range: Range) -> Result<Vec<f64>, String> {
        let values = self.numbers(name, rows * width, range)?;
        let mut rows = values.chunks(width);
        if rows.all(|row| row.windows(2).all(|pair| pair[0] <= pair[1])) {
            return Ok(values);
        }
        Err(format!("it is damaged: the table {name} falls along its last axis"))
    }

    /// A table with a value for each direction, whose sign is that of the direction; refined along the ratio.
    fn pairs(&self, name: &str, [least, most]: Range) -> Result<Vec<f64>, String> {
        let values = self.numbers(name, 2, [-most, most])?;
        for (at, direction, range) in [(0, -1, [-most, -least]), (1, 1, [least, most])] {
            let values: Vec<f64> = values.iter().skip(at).step_by(2).copied().collect();
            within(&format!("the table {name} in direction {direction}"), &values, range)?;
        }
        Ok(self.along_ratio(&values, 2))
    }

    /// Checks the numbers of values before memory is taken: after the refinement with so many tables of shift rates, and in the file, where
    /// the last axes have these lengths.
    fn check_size(&self, shift_rates: usize, widths: [usize; 3]) -> Result<(), String> {
        let lines = self.lines() as f64;
        let row = 3 * UTILISATIONS + SHARES + 4;
        let refined = lines * self.ratios.count as f64 * (row as f64 + EXCESSES as f64 * shift_rates as f64);
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

    /// A table that rises along its last axis, refined: the refinement along the ratio leaves its rows only nearly rising.
    fn risen(&self, values: &[f64], along: &[f64], count: usize) -> Sheet<1> {
        let (even, mut fine) = self.refined(values, along, count);
        for row in fine.chunks_mut(even.count) {
            for k in 1..row.len() {
                row[k] = row[k].max(row[k - 1]);
            }
        }
        Sheet::of(even, [fine])
    }

    /// Refines along the ratio; rows have `width` values.
    fn along_ratio(&self, values: &[f64], width: usize) -> Vec<f64> {
        let places = self.ratios.places();
        let mut found = Vec::with_capacity(self.lines() * places.len() * width);
        for block in values.chunks(self.logs.len() * width) {
            let columns: Vec<_> = (0..width)
                .map(|column| {
                    let curve: Vec<f64> = block.iter().skip(column).step_by(width).copied().collect();
                    resampled(&self.logs, &curve, &places)
                })
                .collect();
            found.extend((0..places.len()).flat_map(|r| columns.iter().map(move |column| column[r])));
        }
        found
    }
}

/// The places of an axis.
fn axis(document: &Value, name: &str, range: Range) -> Result<Vec<f64>, String> {
    let values = flat(&document["axes"][name]["values"]);
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
