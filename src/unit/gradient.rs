//! Derivatives of the outputs of a steady start, as JSON.

use serde_json::json;

use super::linear::{Column, column, to_output};
use super::rings::{Rings, Settings};
use super::table;
use super::variator_unit::UnitWith;
use crate::fmi::table::{Access, Kind, Range, Variable};
use crate::fmi::unit::Unit;
use crate::variator::run::SteadyTangent;
use crate::variator::settings::{INPUTS, Readings};

/// Relative step of differences on the tangent. With a third, rounding changes small
/// derivatives by 1 %; with three times, curvature some by 5 %.
const STEP: f64 = 3.0e-5;

/// Parts of names of outputs without a derivative: extremes over the belt, ends of arcs, and work,
/// which jump.
const WITHOUT: [&str; 5] = ["idleArc", "Max", "Min", ".max", "solver."];

/// Derivatives of the real outputs of a steady start with respect to real parameters and inputs, by
/// value reference. What held the start, its ratio or both clamping forces, holds the changed ones.
///
/// # Errors
/// The reason, as a sentence.
pub fn gradient<R: Rings>(
    unit: &mut UnitWith<R>,
    settings: &Settings<R>,
    references: &[u32],
) -> Result<String, String> {
    let mut near = unit.variator.tangent().ok_or(
        "there is no gradient: it is that of a steady start before the first step, in which the belt does not slip through and no \
         sheave is at a stop",
    )?;
    let (table, outputs): (_, Vec<_>) = (UnitWith::<R>::table(), table::outputs().collect());
    let columns: Vec<_> = outputs.iter().filter_map(column).collect();
    let (mut variables, mut slopes) = (Vec::new(), Vec::new());
    for reference in references {
        let variable = table.by_reference(*reference);
        let setting = variable.and_then(Setting::of).ok_or_else(|| {
            let name =
                variable.map_or_else(|| format!("value reference {reference}"), |found| found.name.clone());
            format!("there is no gradient over {name}, which is not a real parameter or input")
        })?;
        variables.push(json!({"name": setting.name, "unit": setting.unit, "value": (setting.get)(settings)}));
        slopes.push(setting.slopes(settings, &mut near, &columns)?);
    }
    let held = if unit.variator.balances() {
        "clamping forces"
    } else {
        "ratio"
    };
    let present = unit.variator.outputs();
    let row = |(k, (name, ..)): (usize, &Column<'_>)| -> Vec<Option<f64>> {
        let jumps = WITHOUT.iter().any(|part| name.contains(part));
        let is_undefined = jumps || name.contains("efficiency") && present.efficiency == 0.0;
        slopes
            .iter()
            .map(|slopes: &Vec<f64>| (!is_undefined).then(|| slopes[k]))
            .collect()
    };
    let found = json!({
        "about": "derivatives of the outputs (rows) of a steady start over the variables (columns), SI units",
        "held": held,
        "outputs": columns.iter().map(|column| to_output(column, present)).collect::<Vec<_>>(),
        "variables": variables,
        "gradient": columns.iter().enumerate().map(row).collect::<Vec<_>>(),
    });
    Ok(format!("{found:#}"))
}

/// A real parameter or input.
struct Setting<'a, R> {
    name: &'a str,
    unit: &'static str,
    range: Range,
    get: fn(&Settings<R>) -> f64,
    set: fn(&mut Settings<R>, f64),
}

impl<'a, R: Rings> Setting<'a, R> {
    fn of(variable: &'a Variable<Settings<R>, Readings>) -> Option<Self> {
        match variable.kind {
            Kind::Real {
                unit,
                range,
                access: Access::Setting { get, set },
                ..
            } => Some(Self {
                name: &variable.name,
                unit,
                range,
                get,
                set,
            }),
            _ => None,
        }
    }

    /// Derivatives of outputs by central differences, within the range of the values.
    fn slopes(
        &self,
        settings: &Settings<R>,
        near: &mut SteadyTangent,
        columns: &[Column<'_>],
    ) -> Result<Vec<f64>, String> {
        let value = (self.get)(settings);
        let typical = INPUTS
            .iter()
            .find(|input| input.name == self.name)
            .map(|input| input.size);
        let sizes = [value, (self.get)(&Settings::default()), typical.unwrap_or_default()];
        let size = sizes.into_iter().find(|size| *size != 0.0).ok_or_else(|| {
            format!(
                "there is no gradient over {} at 0, where no size of a step is known",
                self.name
            )
        })?;
        let step = STEP * size.abs();
        let least = self.range.min.unwrap_or(f64::NEG_INFINITY);
        let most = self.range.max.unwrap_or(f64::INFINITY);
        let low = (value - step).min(most - 2.0 * step).max(least);
        let mut outputs = |value: f64| -> Result<Vec<f64>, String> {
            let mut settings = settings.clone();
            (self.set)(&mut settings, value);
            UnitWith::check(&settings)?;
            let ring = settings.own.ring(&settings.parameters);
            let ring = ring.map_err(|error| error.to_string())?;
            let outputs = near.outputs(&settings.parameters, ring, &settings.inputs);
            let outputs = outputs.ok_or("the steady states beside this one are on another branch")?;
            Ok(columns.iter().map(|(_, _, get)| get(&outputs)).collect())
        };
        let pair = outputs(low).and_then(|below| Ok((below, outputs(low + 2.0 * step)?)));
        let (below, above) = pair.map_err(|why| format!("there is no gradient over {}: {why}", self.name))?;
        Ok(above
            .iter()
            .zip(below)
            .map(|(above, below)| (above - below) / (2.0 * step))
            .collect())
    }
}
