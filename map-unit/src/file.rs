//! The file of the tables: read from JSON, checked, and refined once by monotone cubics.

use std::path::Path;

use pushbelt::variator::settings::{Parameters, parameters};
use pushbelt_fmi::table::Value as Setting;
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
const PARAMETERS: &str = "geometry.centerDistance geometry.beltLength geometry.wedgeAngle belt.pitchOffset \
                          friction.fall friction.fallSpeed";

/// Least and greatest value of an axis or table.
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
        let axis = |name: &str, range: Range| axis(&document, name, range);
        let (forces, speeds) = (axis("force", [1e-3, 1e7])?, axis("speed", [1e-3, 1e5])?);
        let (ratios, utilisation) = (axis("ratio", [0.01, 100.0])?, axis("utilisation", UTILISATION)?);
        let (share, excess) = (axis("slipShare", [-1.0, 1.0])?, axis("excess", [-100.0, 100.0])?);
        let shift_utilisations = axis("shiftUtilisation", UTILISATION)?;
        if axis("direction", [-1.0, 1.0])? != [-1.0, 1.0] || share[0] != -1.0 || share[share.len() - 1] != 1.0 {
            return Err("it is damaged: the axes direction and slipShare must end with -1 and 1".to_owned());
        }
        let file = File {
            document: &document,
            lines: forces.len() * speeds.len(),
            ratios: ratios.iter().map(|ratio| ratio.ln()).collect(),
        };
        let count = shift_utilisations.len();
        file.check_size([&utilisation, &share, &excess].map(Vec::len), count)?;
        let of_belt = |name, range| {
            Ok::<_, String>(file.refined(
                &file.numbers(name, utilisation.len(), range)?,
                &utilisation,
                UTILISATIONS,
            ))
        };
        let ((along, thrust_ratio), (_, torque_loss), (_, bearing_load)) = (
            of_belt("thrustRatio", THRUST_RATIO)?,
            of_belt("beltTorqueLoss", [-1e4, 1e4])?,
            of_belt("bearingLoad", [0.0, 1e7])?,
        );
        let rates = file.rising("shiftRate", [count, excess.len()], [-1e3, 1e3])?;
        let shift_rates = (0..count).map(|k| {
            let rows = rates.chunks(excess.len()).skip(k).step_by(count);
            file.risen(&rows.flatten().copied().collect::<Vec<_>>(), &excess, EXCESSES)
        });
        let traction = file.rising("traction", [1, share.len()], UTILISATION)?;
        let (capacity, slip) = (
            file.pairs("capacity", CAPACITY)?,
            file.pairs("capacitySlip", CAPACITY_SLIP)?,
        );
        let limits = capacity.chunks(2).zip(slip.chunks(2));
        Ok(Self {
            parameters: parameters_of(&document)?,
            hash: hash::of_bytes(bytes),
            belt: Sheet::of(along, [thrust_ratio, torque_loss, bearing_load]),
            traction: file.risen(&traction, &share, SHARES),
            shift_rates: shift_rates.collect(),
            limits: limits.map(|(of, at)| [of[0], of[1], at[0], at[1]]).collect(),
            forces,
            speeds: speeds.iter().map(|speed| speed * speed).collect(),
            ratios: file.even_ratios(),
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
    fn even_ratios(&self) -> Even {
        Even::between(self.ratios[0], self.ratios[self.ratios.len() - 1], RATIOS)
    }

    /// The numbers of a table, so many for each force, speed and ratio.
    fn numbers(&self, name: &str, width: usize, range: Range) -> Result<Vec<f64>, String> {
        let count = self.lines * self.ratios.len() * width;
        let values = flat(&self.document["tables"][name]["values"]);
        if values.len() != count {
            let found = values.len();
            return Err(format!(
                "it is damaged: the table {name} has {found} numbers instead of {count}"
            ));
        }
        within(&format!("the table {name}"), &values, range)?;
        Ok(values)
    }

    /// The numbers of a table that does not fall along its last axis.
    fn rising(&self, name: &str, [rows, width]: [usize; 2], range: Range) -> Result<Vec<f64>, String> {
        let values = self.numbers(name, rows * width, range)?;
        if values.chunks(width).all(|row| row.is_sorted()) {
            return Ok(values);
        }
        Err(format!("it is damaged: the table {name} falls along its last axis"))
    }

    /// The values against and along the direction of running, whose signs are those of the direction; refined along the ratio.
    fn pairs(&self, name: &str, [least, most]: Range) -> Result<Vec<f64>, String> {
        let values = self.numbers(name, 2, [-most, most])?;
        let of = |at: usize| values.iter().skip(at).step_by(2).copied().collect::<Vec<_>>();
        within(&format!("the table {name} in direction -1"), &of(0), [-most, -least])?;
        within(&format!("the table {name} in direction 1"), &of(1), [least, most])?;
        Ok(self.along_ratio(&values, 2))
    }

    /// Checks the number of values before memory is taken, from the lengths of the last axes and the number of tables of shift rates.
    fn check_size(&self, widths: [usize; 3], shift_rates: usize) -> Result<(), String> {
        let [belt, traction, rates] = [UTILISATIONS, SHARES, EXCESSES].map(|count| count as f64);
        let [wide, share, excess] = widths.map(|width| width as f64);
        let row = 3.0 * belt.max(wide) + traction.max(share) + shift_rates as f64 * rates.max(excess) + 4.0;
        let most = self.lines as f64 * self.ratios.len().max(RATIOS) as f64 * row;
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
        (
            even,
            self.along_ratio(&resampled(along, values, 1, even.places()), even.count),
        )
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
        resampled(&self.ratios, values, width, self.even_ratios().places())
    }
}

/// The parameters of the file, and the start values otherwise.
fn parameters_of(document: &Value) -> Result<Parameters, String> {
    let mut of = Parameters::default();
    for parameter in parameters::<Parameters, ()>() {
        let variable = parameter.variable();
        let name = &variable.name;
        if PARAMETERS.split(' ').any(|one| one == name) {
            let found = document["parameters"][name].as_f64();
            let found = found.ok_or_else(|| format!("it is damaged: the parameter {name} is missing"))?;
            variable.set(&mut of, Setting::Real(found))?;
        }
    }
    of.validate_belt().map_err(|error| error.to_string())?;
    Ok(of)
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
    let Some(at) = values.iter().position(|value| !(least..=most).contains(value)) else {
        return Ok(());
    };
    let (value, place) = (values[at], at + 1);
    Err(format!(
        "{name} has the value {value:?} in place {place}, which is out of range: {least} to {most}"
    ))
}
