//! The file of the tables: read from JSON, checked, refined by monotone cubics.

use std::array::from_fn;
use std::ops::RangeInclusive;
use std::path::Path;

use pushbelt::variator::settings::{Parameters, parameters};
use pushbelt_fmi::table::Value as Setting;
use pushbelt_fmi::{hash, resources};
use serde_json::Value;

use crate::cubic::resampled;
use crate::tables::{Table, Tables, UniformAxis};
use crate::tuning::{EXCESSES, RATIOS, SHARES, TORQUES};

/// Name of the file in the resources.
pub const FILE: &str = "maps.json";
/// Its format, and the version of its content.
const FORMAT: &str = "pushbelt map unit";
const VERSION: u64 = 2;
/// Largest size of the file, bytes.
const LARGEST_FILE: u64 = 1 << 24;
/// Largest number of values of the refined tables: 128 MB, 23 times those in the FMU.
const MOST_VALUES: f64 = (1_u32 << 24) as f64;
/// Least distance of neighbours on an axis, as a fraction of its largest value.
const LEAST_STEP: f64 = 1e-6;

/// Parameters of the variator whose maps these are.
const PARAMETERS: &str = "geometry.centerDistance geometry.beltLength geometry.wedgeAngle belt.pitchOffset \
                          friction.fall friction.fallSpeed";

/// Range of the values of an axis or table.
type Range = RangeInclusive<f64>;

/// Thrust ratios.
pub const THRUST_RATIO: Range = 1e-3..=100.0;
/// Utilisations.
pub const UTILISATION: Range = -10.0..=10.0;

impl Tables {
    /// Reads the tables from the folder of the resources, or returns a sentence why they can't be
    /// used.
    pub fn read(resources: &Path) -> Result<Self, String> {
        let path = resources.join(FILE);
        let bytes = resources::content(&path, LARGEST_FILE);
        let bytes = bytes.and_then(|bytes| bytes.ok_or_else(|| "there is no such file".to_owned()));
        let tables = bytes.and_then(|bytes| Self::of_bytes(&bytes));
        tables.map_err(|why| format!("the tables in {} can't be used: {why}", path.display()))
    }

    /// The tables in the content of a file, without byte-order mark.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, String> {
        let document: Value =
            serde_json::from_slice(bytes).map_err(|error| format!("it is not JSON: {error}"))?;
        if document["format"] != FORMAT || document["version"] != VERSION {
            return Err(format!("it is not of the format {FORMAT:?} in version {VERSION}"));
        }
        let axis = |name: &str, range: Range| axis(&document, name, range);
        let (forces, speeds) = (axis("force", 1e-3..=1e7)?, axis("speed", 1e-3..=1e5)?);
        let (ratios, excess) = (axis("ratio", 0.01..=100.0)?, axis("excess", -100.0..=100.0)?);
        let [directions, share, torque] =
            ["direction", "slipShare", "torqueShare"].map(|name| axis(name, -1.0..=1.0));
        let (directions, share, torque) = (directions?, share?, torque?);
        let shift_utilisations = axis("shiftUtilisation", UTILISATION)?;
        let is_whole = |axis: &Vec<f64>| axis[0] == -1.0 && axis[axis.len() - 1] == 1.0;
        if directions.len() != 2 || ![&directions, &share, &torque].into_iter().all(is_whole) {
            return Err(
                "it is damaged: the axes direction, slipShare and torqueShare must end with -1 and 1"
                    .to_owned(),
            );
        }
        let (lines, rates) = (forces.len() * speeds.len(), shift_utilisations.len());
        // Before an allocation: a file of few numbers may have many refined ones.
        let width = |axis: &[f64], fine: usize| axis.len().max(fine);
        let row = 3 * width(&torque, TORQUES) + width(&share, SHARES) + rates * width(&excess, EXCESSES) + 4;
        let most = lines as f64 * width(&ratios, RATIOS) as f64 * row as f64;
        if most > MOST_VALUES {
            return Err(format!(
                "its tables have {most:e} values after refinement, and at most {MOST_VALUES} are allowed: fewer forces, speeds or \
                 utilisations"
            ));
        }
        let file = File {
            document: &document,
            lines,
            ratios: ratios.iter().map(|ratio| ratio.ln()).collect(),
        };
        let numbers = |name, range| file.numbers(name, torque.len(), range);
        let belt = [
            numbers("thrustRatioAtShare", THRUST_RATIO)?,
            numbers("beltTorqueLossAtShare", -1e4..=1e4)?,
            numbers("bearingLoadAtShare", 0.0..=1e7)?,
        ];
        let ([against, along], [slip_against, slip_along]) = (
            file.capacities("capacity", 1e-3, 10.0)?,
            file.capacities("capacitySlip", 1e-6, 2.0)?,
        );
        Ok(Self {
            parameters: parameters_of(&document)?,
            hash: hash::of_bytes(bytes),
            ratios: UniformAxis::over(&file.ratios, RATIOS),
            belt: file.refined(1, belt, &torque, TORQUES),
            traction: file.rising("traction", 1, UTILISATION, &share, SHARES)?,
            shift_rates: file.rising("shiftRate", rates, -1e3..=1e3, &excess, EXCESSES)?,
            limits: file.refined(1, [against, along, slip_against, slip_along], &[0.0], 1),
            forces,
            speeds: speeds.iter().map(|speed| speed * speed).collect(),
            shift_utilisations,
        })
    }
}

/// The document of a file, its number of pairs of force and speed, and its ln i.
struct File<'a> {
    document: &'a Value,
    lines: usize,
    ratios: Vec<f64>,
}

impl File<'_> {
    /// The numbers of a table, `width` for each force, speed and ratio.
    fn numbers(&self, name: &str, width: usize, range: Range) -> Result<Vec<f64>, String> {
        let count = self.lines * self.ratios.len() * width;
        let values = flat(&self.document["tables"][name]["values"]);
        if values.len() != count {
            let found = values.len();
            return Err(format!(
                "it is damaged: the table {name} has {found} numbers instead of {count}"
            ));
        }
        check_range(&format!("the table {name}"), &values, range)?;
        Ok(values)
    }

    /// The values against and along the direction of running, with its sign.
    fn capacities(&self, name: &str, least: f64, most: f64) -> Result<[Vec<f64>; 2], String> {
        let values = self.numbers(name, 2, -most..=most)?;
        let [against, along] = [0, 1].map(|n| values.iter().skip(n).step_by(2).copied().collect::<Vec<_>>());
        check_range(&format!("the table {name} in direction -1"), &against, -most..=-least)?;
        check_range(&format!("the table {name} in direction 1"), &along, least..=most)?;
        Ok([against, along])
    }

    /// Tables with `rows` for each force, speed and ratio, refined along the rows and the ratio.
    fn refined<const N: usize>(
        &self,
        rows: usize,
        tables: [Vec<f64>; N],
        along: &[f64],
        count: usize,
    ) -> Table<N> {
        let (axis, ratios) = (UniformAxis::over(along, count), UniformAxis::over(&self.ratios, RATIOS));
        let tables = tables.map(|values| {
            let values = resampled(along, &values, 1, axis.points());
            resampled(&self.ratios, &values, rows * axis.count, ratios.points())
        });
        let points = 0..tables[0].len();
        let values = points.map(|k| from_fn(|n| tables[n][k])).collect();
        Table { axis, rows, values }
    }

    /// The same for a table whose rows rise.
    fn rising(
        &self,
        name: &str,
        rows: usize,
        range: Range,
        along: &[f64],
        count: usize,
    ) -> Result<Table<1>, String> {
        let values = self.numbers(name, rows * along.len(), range)?;
        if !values.chunks(along.len()).all(|row| row.is_sorted()) {
            return Err(format!("it is damaged: the table {name} falls along its last axis"));
        }
        // The refinement along the ratio leaves the rows only nearly rising.
        let mut sheet = self.refined(rows, [values], along, count);
        for row in sheet.values.chunks_mut(sheet.axis.count) {
            for k in 1..row.len() {
                row[k][0] = row[k][0].max(row[k - 1][0]);
            }
        }
        Ok(sheet)
    }
}

/// The parameters of the file, and the start values otherwise.
fn parameters_of(document: &Value) -> Result<Parameters, String> {
    let mut of = Parameters::default();
    let is_of_file = |name: &str| PARAMETERS.split(' ').any(|one| one == name);
    for parameter in parameters::<_, ()>().filter(|one| is_of_file(&one.name())) {
        let (name, variable) = (parameter.name(), parameter.variable());
        let found = document["parameters"][&name].as_f64();
        let found = found.ok_or_else(|| format!("it is damaged: the parameter {name} is missing"))?;
        variable.set(&mut of, Setting::Real(found))?;
    }
    of.validate_belt().map_err(|error| error.to_string())?;
    Ok(of)
}

fn axis(document: &Value, name: &str, range: Range) -> Result<Vec<f64>, String> {
    let values = flat(&document["axes"][name]["values"]);
    check_range(&format!("the axis {name}"), &values, range)?;
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
pub fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(flat).collect(),
        other => vec![other.as_f64().unwrap_or(f64::NAN)],
    }
}

fn check_range(name: &str, values: &[f64], range: Range) -> Result<(), String> {
    let Some(index) = values.iter().position(|value| !range.contains(value)) else {
        return Ok(());
    };
    let (value, place, (least, most)) = (values[index], index + 1, range.into_inner());
    Err(format!(
        "{name} has the value {value:?} in place {place}, which is out of range: {least} to {most}"
    ))
}
