//! Prints the linear model about a steady working point as JSON: `linear_model FREQUENCY [NAME=VALUE …]`, with names
//! and values of parameters and inputs. `cargo fmu linearize` runs it.

use std::process::ExitCode;

use pushbelt::fmi::Unit as _;
use pushbelt::fmi::table::{Access, Causality, Kind, Variable};
use pushbelt::unit::{Settings, VariatorUnit};
use pushbelt::variator::linear::linearise;
use pushbelt::variator::settings::{Outputs, Readings};
use serde_json::{Map, Value, json};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(model) => {
            println!("{model:#}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[String]) -> Result<Value, String> {
    let (frequency, settings) = arguments.split_first().ok_or("a frequency is missing")?;
    let frequency: f64 = frequency
        .parse()
        .map_err(|_| format!("{frequency} is not a frequency"))?;
    let table = VariatorUnit::table();
    let mut chosen = Settings::default();
    for assignment in settings {
        let (name, value) = assignment
            .split_once('=')
            .ok_or_else(|| format!("`{assignment}` is not NAME=VALUE"))?;
        let variable = table.by_name(name).ok_or_else(|| format!("there is no {name}"))?;
        set(&mut chosen, variable, value)?;
    }

    let outputs: Vec<_> = table
        .variables()
        .iter()
        .filter(|variable| variable.causality == Causality::Output)
        .filter_map(|variable| match variable.kind {
            Kind::Real {
                access: Access::Reading(get),
                unit,
                ..
            } => Some((variable.name.as_str(), unit, get)),
            _ => None,
        })
        .collect();
    let read: Vec<_> = outputs
        .iter()
        .map(|&(_, _, get)| move |outputs: &Outputs| get(&outputs.clone().into()))
        .collect();
    let read: Vec<&dyn Fn(&Outputs) -> f64> = read.iter().map(|get| get as _).collect();
    let model = linearise(&chosen.parameters, &chosen.inputs, frequency, &read).map_err(|error| error.to_string())?;

    let unit_of = |name: &str| match table.by_name(name).map(|variable| &variable.kind) {
        Some(Kind::Real { unit, .. }) => *unit,
        _ => "1",
    };
    let mut held = model.inputs;
    eprintln!("what holds the working point:");
    for load in &model.loads {
        let (name, asked) = (load.name(), *load.field(&mut chosen.inputs));
        let found = *load.field(&mut held);
        eprintln!("  {name} = {found:.6} {} (given: {asked})", unit_of(name));
    }
    let inputs: Vec<Value> = model
        .loads
        .iter()
        .map(|load| json!({"name": load.name(), "unit": unit_of(load.name()), "value": *load.field(&mut held)}))
        .collect();
    let outputs: Vec<Value> = outputs
        .iter()
        .map(|(name, unit, get)| json!({"name": name, "unit": unit, "value": get(&(*model.outputs).clone().into())}))
        .collect();
    let mut found = Map::new();
    for (key, value) in [
        (
            "about",
            json!("dx/dt = A x + B u, y = C x + D u: deviations from the working point, SI units"),
        ),
        ("frequency", json!({"unit": "Hz", "value": frequency})),
        ("inputs", json!(inputs)),
        ("outputs", json!(outputs)),
        ("poles", json!(model.poles)),
        ("A", json!(model.a)),
        ("B", json!(model.b)),
        ("C", json!(model.c)),
        ("D", json!(model.d)),
    ] {
        found.insert(key.into(), value);
    }
    Ok(Value::Object(found))
}

fn set(settings: &mut Settings, variable: &Variable<Settings, Readings>, text: &str) -> Result<(), String> {
    let name = &variable.name;
    let no_value = || format!("`{text}` is no value of {name}");
    match &variable.kind {
        Kind::Real {
            access: Access::Setting { set, .. },
            ..
        } => {
            let value = text.parse().map_err(|_| no_value())?;
            set(settings, variable.admit_real(value).map_err(|error| error.to_string())?);
        }
        Kind::Integer {
            access: Access::Setting { set, .. },
            ..
        }
        | Kind::Enumeration {
            access: Access::Setting { set, .. },
            ..
        } => {
            let value = text.parse().map_err(|_| no_value())?;
            set(
                settings,
                variable.admit_integer(value).map_err(|error| error.to_string())?,
            );
        }
        Kind::Boolean {
            access: Access::Setting { set, .. },
        } => set(settings, text.parse().map_err(|_| no_value())?),
        _ => return Err(format!("{name} is calculated and can't be set")),
    }
    Ok(())
}
