//! The linear model of a variator in the names of the interface, as JSON.

use serde_json::{Value, json};
use std::ops::RangeInclusive;

use crate::fmi::table::{Access, Kind, Variable};
use crate::fmi::unit::Message;
use crate::unit::rings::{Rings, Settings};
use crate::unit::table;
use crate::unit::variator_unit::UnitWith;
use crate::variator::linear::{LinearModel, Load, linearise_at};
use crate::variator::settings::Outputs;

/// Frequencies below which modes can be kept, Hz.
const FREQUENCIES: RangeInclusive<f64> = 1.0e-2..=1.0e5;

/// Name, unit and value of a real output.
pub(super) type Column<'a> = (&'a str, &'static str, fn(&Outputs) -> f64);

/// The linear model about the present state of `unit` under the inputs of `settings`, with modes
/// below `frequency`, Hz, and a warning for each difference from the specified point.
///
/// # Errors
/// The reason, as a sentence.
pub fn linear_model<R: Rings>(
    unit: &mut UnitWith<R>,
    settings: &Settings<R>,
    frequency: f64,
    remarks: &mut Vec<Message>,
) -> Result<String, String> {
    if !FREQUENCIES.contains(&frequency) {
        let (least, most) = FREQUENCIES.into_inner();
        return Err(format!(
            "frequency = {frequency} Hz, below which modes are kept, is out of range: {least} to {most} Hz"
        ));
    }
    let outputs: Vec<_> = table::outputs().collect();
    let columns: Vec<_> = outputs.iter().filter_map(column).collect();
    let read: Vec<&dyn Fn(&Outputs) -> f64> = columns.iter().map(|(_, _, get)| get as _).collect();
    let time = unit.variator.time();
    let found = linearise_at(&mut unit.variator, &settings.inputs, frequency, &read);
    let found = found.map_err(|error| error.to_string())?;
    let differs = |text: &String| format!("the linear model is not about the specified point: {text}");
    remarks.extend(found.remarks.iter().map(differs).map(Message::warning));
    Ok(format!("{:#}", to_json(&found, &columns, frequency, time)))
}

pub(super) fn column(output: &Variable<(), Outputs>) -> Option<Column<'_>> {
    match output.kind {
        Kind::Real {
            unit,
            access: Access::Reading(get),
            ..
        } => Some((&output.name, unit, get)),
        _ => None,
    }
}

pub(super) fn to_output((name, unit, get): &Column<'_>, outputs: &Outputs) -> Value {
    json!({"name": name, "unit": unit, "value": get(outputs)})
}

fn to_json(model: &LinearModel, columns: &[Column<'_>], frequency: f64, time: f64) -> Value {
    let load = |load: &Load| {
        let (given, held) = (load.value(&model.given), load.value(&model.inputs));
        json!({"name": load.name(), "unit": load.unit(), "given": given, "held": held})
    };
    json!({
        "about": "dx/dt = A x + B u, y = C x + D u: deviations from the working point in SI units; the inputs held keep it",
        "frequency": {"unit": "Hz", "value": frequency},
        "time": {"unit": "s", "value": time},
        "inputs": model.loads.iter().map(load).collect::<Vec<_>>(),
        "outputs": columns.iter().map(|column| to_output(column, &model.outputs)).collect::<Vec<_>>(),
        "states": states(&model.poles),
        "poles": model.poles,
        "slip": model.outputs.slip,
        "macroSlip": model.outputs.macro_slip,
        "remarks": model.remarks,
        "A": model.a,
        "B": model.b,
        "C": model.c,
        "D": model.d,
    })
}

/// Names of the states: `mode1`, and of a pair of conjugates `mode2.re` and `mode2.im`.
fn states(poles: &[[f64; 2]]) -> Vec<String> {
    let (mut names, mut number) = (Vec::new(), 0);
    for [_, turn] in poles {
        if *turn < 0.0 {
            names.push(format!("mode{number}.im"));
            continue;
        }
        number += 1;
        names.push(format!("mode{number}{}", if *turn > 0.0 { ".re" } else { "" }));
    }
    names
}

#[cfg(test)]
mod tests {
    use super::states;

    #[test]
    fn a_pair_has_two_states_of_one_mode() {
        let poles = [[-0.1, 0.0], [-2.0, 5.0], [-2.0, -5.0], [-9.0, 0.0]];
        assert_eq!(states(&poles), ["mode1", "mode2.re", "mode2.im", "mode3"]);
    }
}
