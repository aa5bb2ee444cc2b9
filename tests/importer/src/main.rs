//! Runs the FMU in the importer `fmu-runner`: `importer FMU STEPS` reads the description, checks
//! it, makes steps of 1 ms, continues a second run from a stored state, and prints the outputs at
//! the end, one `name value` a line.

use std::collections::HashMap;
use std::error::Error;
use fmu_runner::{Fmu, FmuInstance, fmi2Type};

/// Inputs, and their values, which differ from the start values.
const INPUTS: [(&str, f64); 4] = [
    ("primary.torque", 60.0),
    ("secondary.torque", -58.0),
    ("primary.clampingForce", 14e3),
    ("secondary.clampingForce", 10e3),
];
const OUTPUTS: [&str; 6] = [
    "thrustRatio",
    "belt.speed",
    "primary.speed",
    "secondary.speed",
    "ratio.geometric",
    "loss.total",
];
/// Communication step, s.
const STEP: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let (Some(path), Some(steps)) = (words.next(), words.next()) else {
        return Err("importer FMU STEPS".into());
    };
    let steps: u32 = steps.parse()?;
    let library = Fmu::unpack(path)?.load(fmi2Type::fmi2CoSimulation)?;
    let variables = library.variables();
    let find = |name: &str| {
        variables
            .get(name)
            .ok_or_else(|| format!("the description has no {name}"))
    };
    let mut outputs = Vec::new();
    for name in OUTPUTS {
        outputs.push(find(name)?);
    }
    let mut inputs = HashMap::new();
    for (name, value) in INPUTS {
        inputs.insert(find(name)?, value);
    }

    let unit = FmuInstance::instantiate(&library, true)?;
    unit.setup_experiment(0.0, Some(1.0), None)?;
    unit.enter_initialization_mode()?;
    unit.exit_initialization_mode()?;
    unit.set_reals(&inputs)?;
    let run = |from: u32, to: u32| -> Result<Vec<f64>, Box<dyn Error>> {
        for number in from..to {
            unit.do_step(f64::from(number) * STEP, STEP, true)?;
        }
        let values = unit.get_reals(&outputs)?;
        Ok(outputs.iter().map(|output| values[output]).collect())
    };
    run(0, steps / 2)?;
    let states = unit.get_set_state_capability().ok_or("states can't be stored")?;
    let bytes = unit.serialize_state_capability().ok_or("states can't be serialised")?;
    let stored = bytes.serialize_state(&states.get_state()?)?;
    let first = run(steps / 2, steps)?;
    states.set_state(bytes.deserialize_state(&stored)?)?;
    let again = run(steps / 2, steps)?;
    if first != again {
        return Err(format!("{again:?} instead of {first:?} from a stored state").into());
    }
    for (name, value) in OUTPUTS.iter().zip(first) {
        println!("{name} {value:e}");
    }
    Ok(())
}
