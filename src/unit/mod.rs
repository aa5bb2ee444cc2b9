//! The variator as a unit of the FMI layer: the table that binds the interface's names to its parameters, inputs and
//! outputs, and the calls that lead from one to the other.

#![forbid(unsafe_code)]

mod table;
mod types;

use crate::fmi2::Table;
use crate::fmi2::unit::{Experiment, Identity, Remark, StepFailure, Unit};
use crate::variator::instance::{StepError, Variator};
use crate::variator::parameters::Parameters;
use crate::variator::signals::{Inputs, Outputs};
use crate::variator::validation;

/// What a master sets: parameters and inputs. The default is the variator of the default experiment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Parameters.
    pub parameters: Parameters,
    /// Inputs.
    pub inputs: Inputs,
}

/// A variator behind the FMI.
#[derive(Clone, Debug)]
pub struct VariatorUnit {
    variator: Variator,
}

/// The content of `modelDescription.xml`.
#[must_use]
pub fn model_description() -> String {
    crate::fmi2::model_description::<VariatorUnit>()
}

/// The model identifier: name of the FMU and of the binary in it.
#[must_use]
pub fn model_identifier() -> &'static str {
    VariatorUnit::IDENTITY.name
}

impl VariatorUnit {
    fn pass_messages(&mut self, remarks: &mut Vec<Remark>) {
        let messages = self.variator.take_messages();
        remarks.extend(messages.into_iter().map(|message| Remark {
            warning: message.warning,
            text: message.text,
        }));
    }
}

impl Unit for VariatorUnit {
    type Settings = Settings;
    type Readings = Outputs;

    const IDENTITY: Identity = Identity {
        name: "PushbeltVariator",
        description: "Pushbelt CVT variator: steel ring in reference dynamics (ALE), push elements, wedge contact, tilting sheaves",
        version: env!("CARGO_PKG_VERSION"),
        author: "The pushbelt developers",
        license: env!("CARGO_PKG_LICENSE"),
        stop_time: 1.0,
        step_size: 1e-3,
        tolerance: 1e-4,
        longest_step: 1000.0,
    };

    fn table() -> Table<Settings, Outputs> {
        table::table()
    }

    fn check(settings: &Settings) -> Result<(), String> {
        let parameters = settings.parameters.validate();
        let checked = parameters.and_then(|()| settings.inputs.validate());
        checked.map_err(|error| error.to_string())
    }

    fn start(
        settings: &Settings,
        experiment: &Experiment,
        remarks: &mut Vec<Remark>,
    ) -> Result<Self, String> {
        let mut parameters = settings.parameters.clone();
        if let Some(tolerance) = experiment.tolerance {
            let (min, max) = validation::range_of("solver.tolerance").unwrap_or((0.0, 1.0));
            parameters.solver.tolerance = tolerance.clamp(min, max);
            if tolerance < min || tolerance > max {
                remarks.push(Remark {
                    warning: true,
                    text: format!(
                        "the experiment's tolerance {tolerance} is out of range: {min} to {max}; {} is used",
                        parameters.solver.tolerance
                    ),
                });
            }
        }
        let variator = Variator::new(parameters).map_err(|error| error.to_string())?;
        let mut unit = Self { variator };
        let started = unit.variator.initialise(experiment.start, &settings.inputs);
        unit.pass_messages(remarks);
        started.map_err(|error| error.to_string())?;
        Ok(unit)
    }

    fn advance(
        &mut self,
        to: f64,
        settings: &Settings,
        remarks: &mut Vec<Remark>,
    ) -> Result<(), StepFailure> {
        let wanted = &settings.parameters.friction;
        let present = &self.variator.parameters().friction;
        if (wanted.pulley, wanted.ring) != (present.pulley, present.ring) {
            let changed = self.variator.set_friction(wanted.pulley, wanted.ring);
            changed.map_err(|error| StepFailure::Setting(error.to_string()))?;
        }
        let advanced = self.variator.advance(to, &settings.inputs);
        self.pass_messages(remarks);
        advanced.map_err(|error| match error {
            StepError::Input(error) => StepFailure::Setting(error.to_string()),
            stalled @ StepError::Stalled { .. } => StepFailure::Discarded(stalled.to_string()),
        })
    }

    fn time(&self) -> f64 {
        self.variator.time()
    }

    fn readings(&mut self) -> &Outputs {
        self.variator.outputs()
    }
}
