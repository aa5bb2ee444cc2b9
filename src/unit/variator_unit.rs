//! The calls that lead from the FMI layer to the variator and back.

use super::settings::Settings;
use super::table;
use crate::fmi::Table;
use crate::fmi::stepping::OwnSteps;
use crate::fmi::unit::{Experiment, Identity, Moment, Remark, StepFailure, Unit};
use crate::tape::Tape;
use crate::variator::run::{CommunicationStep, Event, StepError, Variator};
use crate::variator::settings::{Inputs, Parameters, Readings, range_of};

/// A variator behind the FMI layer.
#[derive(Clone, Debug)]
pub struct VariatorUnit {
    variator: Variator,
}

/// The content of `modelDescription.xml` of FMI 2.0.
#[must_use]
pub fn model_description() -> String {
    crate::fmi::model_description::<VariatorUnit>()
}

/// The content of `modelDescription.xml` of FMI 3.0.
#[must_use]
pub fn model_description3() -> String {
    crate::fmi::fmi3::model_description::<VariatorUnit>()
}

impl VariatorUnit {
    fn build(settings: &Settings, experiment: &Experiment, remarks: &mut Vec<Remark>) -> Result<Self, String> {
        let mut parameters = settings.parameters.clone();
        if let Some(tolerance) = experiment.tolerance {
            parameters.solver.tolerance = choose_tolerance(parameters.solver.tolerance, tolerance, remarks);
        }
        let variator = Variator::new(parameters).map_err(|error| error.to_string())?;
        Ok(Self { variator })
    }

    /// The variator itself.
    pub(super) fn variator(&mut self) -> &mut Variator {
        &mut self.variator
    }

    /// Brings the tunable parameters into force.
    fn tune(&mut self, settings: &Settings) -> Result<(), StepFailure> {
        let wanted = &settings.parameters.friction;
        let present = &self.variator.parameters().friction;
        if (wanted.pulley, wanted.ring) != (present.pulley, present.ring) {
            let changed = self.variator.set_friction(wanted.pulley, wanted.ring);
            changed.map_err(|error| StepFailure::Setting(error.to_string()))?;
        }
        Ok(())
    }

    /// Moves the variator's messages to the remarks.
    fn move_messages(&mut self, remarks: &mut Vec<Remark>) {
        let messages = self.variator.take_messages();
        remarks.extend(messages.into_iter().map(|message| Remark {
            warning: message.warning,
            text: message.text,
        }));
    }
}

impl Unit for VariatorUnit {
    type Settings = Settings;
    type Readings = Readings;

    const IDENTITY: Identity = Identity {
        name: "PushbeltVariator",
        description: "Pushbelt CVT variator: steel ring in reference dynamics (ALE), push elements, wedge contact, tilting sheaves",
        version: env!("CARGO_PKG_VERSION"),
        author: "The pushbelt developers",
        license: env!("CARGO_PKG_LICENSE"),
        generation_tool: concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")),
        stop_time: 1.0,
        step_size: 1e-3,
        tolerance: 1e-4,
        longest_step: 1000.0,
    };

    fn table() -> Table<Settings, Readings> {
        table::table()
    }

    fn check(settings: &Settings) -> Result<(), String> {
        let parameters = settings.parameters.validate();
        let checked = parameters.and_then(|()| settings.inputs.validate());
        checked.map_err(|error| error.to_string())
    }

    fn start(settings: &Settings, experiment: &Experiment, remarks: &mut Vec<Remark>) -> Result<Self, String> {
        let mut unit = Self::build(settings, experiment, remarks)?;
        let started = unit.variator.initialise(experiment.start, &settings.inputs);
        unit.move_messages(remarks);
        started.map_err(|error| error.to_string())?;
        Ok(unit)
    }

    fn advance(
        &mut self,
        to: f64,
        settings: &Settings,
        rates: Option<&Settings>,
        remarks: &mut Vec<Remark>,
    ) -> Result<(), StepFailure> {
        self.tune(settings)?;
        let rates = rates.map_or(Inputs::ZERO, |rates| rates.inputs);
        let advanced = self.variator.advance_along(to, &settings.inputs, &rates);
        self.move_messages(remarks);
        advanced.map_err(failure)
    }

    fn time(&self) -> f64 {
        self.variator.time()
    }

    fn blank(settings: &Settings, experiment: &Experiment) -> Result<Self, String> {
        Self::build(settings, experiment, &mut Vec::new())
    }

    fn serialize(&mut self, tape: &mut Tape<'_>) {
        self.variator.serialize(tape);
    }

    fn readings(&mut self, elements: bool) -> &Readings {
        self.variator.readings(elements)
    }

    fn moment(&mut self) -> Moment<Readings> {
        let moment = self.variator.moment();
        Moment {
            before: (*moment.before).into(),
            after: (*moment.after).into(),
            span: moment.span,
        }
    }
}

impl OwnSteps for VariatorUnit {
    type Way = CommunicationStep;

    fn set_out(
        &mut self,
        to: f64,
        settings: &Settings,
        rates: Option<&Settings>,
    ) -> Result<CommunicationStep, StepFailure> {
        self.tune(settings)?;
        let rates = rates.map_or(Inputs::ZERO, |rates| rates.inputs);
        let step = CommunicationStep::begin(&mut self.variator, to, &settings.inputs, &rates);
        step.map_err(failure)
    }

    fn is_over(&self, way: &CommunicationStep) -> bool {
        way.is_over()
    }

    fn own_step(
        &mut self,
        way: &mut CommunicationStep,
        settings: &Settings,
        remarks: &mut Vec<Remark>,
    ) -> Result<(), StepFailure> {
        let given = way.set_inputs(&mut self.variator, &settings.inputs);
        let stepped = given.and_then(|()| way.advance(&mut self.variator));
        self.move_messages(remarks);
        stepped.map_err(failure)?;
        self.variator.update_outputs();
        Ok(())
    }

    fn event(&self, way: &CommunicationStep) -> Option<String> {
        way.event(&self.variator).map(Event::text)
    }

    fn end_at(&mut self, way: &mut CommunicationStep, time: f64) {
        way.end_at(&mut self.variator, time);
    }

    fn arrive(&mut self, way: &CommunicationStep, remarks: &mut Vec<Remark>) {
        way.finish(&mut self.variator);
        self.move_messages(remarks);
    }
}

fn failure(error: StepError) -> StepFailure {
    match error {
        StepError::Input(error) => StepFailure::Setting(error.to_string()),
        stalled @ StepError::Stalled { .. } => StepFailure::Discarded(stalled.to_string()),
    }
}

/// Tolerance to work with, from the parameter and from the experiment. Masters pass the default experiment's tolerance
/// without being asked to, so a parameter that was changed is the user's word.
fn choose_tolerance(parameter: f64, experiment: f64, remarks: &mut Vec<Remark>) -> f64 {
    let mut remark = |warning, text| remarks.push(Remark { warning, text });
    if parameter != Parameters::default().solver.tolerance {
        if parameter != experiment {
            let text = format!(
                "solver.tolerance = {parameter} was set and comes before the experiment's tolerance {experiment}"
            );
            remark(false, text);
        }
        return parameter;
    }
    let (min, max) = range_of("solver.tolerance").unwrap_or((0.0, 1.0));
    let tolerance = experiment.clamp(min, max);
    if tolerance != experiment {
        let text =
            format!("the experiment's tolerance {experiment} is out of range: {min} to {max}; {tolerance} is used");
        remark(true, text);
    }
    tolerance
}

#[cfg(test)]
mod tests {
    use super::choose_tolerance;

    #[test]
    fn a_tolerance_of_the_experiment_replaces_the_default() {
        let mut remarks = Vec::new();
        assert_eq!(choose_tolerance(1e-4, 1e-6, &mut remarks), 1e-6);
        assert!(remarks.is_empty());
    }

    #[test]
    fn a_parameter_that_was_set_comes_first() {
        let mut remarks = Vec::new();
        assert_eq!(choose_tolerance(1e-5, 1e-4, &mut remarks), 1e-5);
        assert!(!remarks[0].warning);
        assert!(remarks[0].text.contains("solver.tolerance = 0.00001"));
    }

    #[test]
    fn a_tolerance_that_no_one_can_keep_is_moved_into_range() {
        let mut remarks = Vec::new();
        assert_eq!(choose_tolerance(1e-4, 1e-300, &mut remarks), 1e-10);
        assert!(remarks[0].warning);
    }
}
