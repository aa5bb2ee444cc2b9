//! The variator as a unit of the FMI layer.

use super::rings::{Rings, Settings, StandardRings};
use super::table;
use crate::archive::Archive;
use crate::fmi::unit::{Experiment, Identity, Message, Unit};
use crate::fmi::{Table, Version};
use crate::variator::run::{CommunicationStep, Event, Variator};
use crate::variator::settings::{Inputs, Mesh, Parameters, Readings, range_of};
use std::marker::PhantomData;

/// The unit of the FMU, with the rings `ALE0` and `ALE`.
pub type VariatorUnit = UnitWith<StandardRings>;

/// A variator with the rings `R` behind the FMI layer.
#[derive(Clone, Debug)]
pub struct UnitWith<R> {
    pub(super) variator: Variator,
    rings: PhantomData<R>,
}

/// The content of `modelDescription.xml` of a version of FMI.
#[must_use]
pub fn model_description(version: Version) -> String {
    crate::fmi::model_description::<VariatorUnit>(version, None)
}

impl<R: Rings> UnitWith<R> {
    fn build(
        settings: &Settings<R>,
        experiment: &Experiment,
        remarks: &mut Vec<Message>,
    ) -> Result<Self, String> {
        let mut parameters = settings.parameters.clone();
        if let Some(tolerance) = experiment.tolerance {
            parameters.solver.tolerance = choose_tolerance(parameters.solver.tolerance, tolerance, remarks);
        }
        let ring = settings.own.ring(&parameters).map_err(text)?;
        find_memory(&parameters.mesh)?;
        let variator = Variator::with_ring(parameters, ring).map_err(text)?;
        let rings = PhantomData;
        Ok(Self { variator, rings })
    }

    fn started(mut self, settings: &Settings<R>, remarks: &mut Vec<Message>) -> Result<Self, String> {
        let started = self.variator.initialise(0.0, &settings.inputs);
        self.move_messages(remarks);
        started.map(|()| self).map_err(text)
    }

    fn move_messages(&mut self, remarks: &mut Vec<Message>) {
        remarks.extend(self.variator.take_messages());
    }
}

impl<R: Rings> Unit for UnitWith<R> {
    type Settings = Settings<R>;
    type Readings = Readings;
    type Step = CommunicationStep;

    const INTERPOLATES_INPUTS: bool = true;
    const OUTPUT_DERIVATIVES: bool = true;
    const IDENTITY: Identity = R::IDENTITY;

    fn table() -> Table<Settings<R>, Readings> {
        table::table()
    }

    fn check(settings: &Settings<R>) -> Result<(), String> {
        let parameters = &settings.parameters;
        let ring = settings.own.ring(parameters);
        let checked = ring.and_then(|ring| Variator::check(parameters, &*ring));
        let checked = checked.and_then(|()| settings.inputs.validate());
        checked.map_err(text)
    }

    fn start(
        settings: &Settings<R>,
        experiment: &Experiment,
        remarks: &mut Vec<Message>,
    ) -> Result<Self, String> {
        Self::build(settings, experiment, remarks)?.started(settings, remarks)
    }

    fn start_near(
        near: &Self,
        settings: &Settings<R>,
        experiment: &Experiment,
        remarks: &mut Vec<Message>,
    ) -> Result<Self, String> {
        let mut unit = Self::build(settings, experiment, remarks)?;
        unit.variator.start_near(&near.variator);
        unit.started(settings, remarks)
    }

    fn begin(
        &mut self,
        to: f64,
        settings: &Settings<R>,
        rates: Option<&Settings<R>>,
    ) -> Result<CommunicationStep, String> {
        let rates = rates.map_or(Inputs::ZERO, |rates| rates.inputs);
        let step = CommunicationStep::begin(&mut self.variator, to, &settings.inputs, &rates);
        let step = step.map_err(text)?;
        // After the beginning, so that a step that can't be done goes back to the friction of
        // before.
        let wanted = &settings.parameters.friction;
        let tuned = self.variator.set_friction(wanted.pulley, wanted.ring);
        tuned.map(|()| step).map_err(text)
    }

    fn advance(
        &mut self,
        _: f64,
        step: &mut CommunicationStep,
        settings: &Settings<R>,
        remarks: &mut Vec<Message>,
    ) -> Result<(), String> {
        let advanced = match step.set_inputs(&settings.inputs) {
            Ok(()) => step.advance(&mut self.variator),
            refused => {
                step.discard(&mut self.variator);
                refused
            }
        };
        self.move_messages(remarks);
        advanced.map_err(text)
    }

    fn is_over(&self, _: f64, step: &CommunicationStep) -> bool {
        step.is_over()
    }

    fn event(&self, step: &CommunicationStep) -> Option<String> {
        step.event(&self.variator).map(Event::text)
    }

    fn end_at(&mut self, to: f64, step: &mut CommunicationStep) {
        step.end_at(&self.variator, to);
    }

    fn finish(&mut self, step: &CommunicationStep, remarks: &mut Vec<Message>) {
        step.finish(&mut self.variator);
        self.move_messages(remarks);
    }

    fn time(&self) -> f64 {
        self.variator.time()
    }

    fn blank(settings: &Settings<R>, experiment: &Experiment) -> Result<Self, String> {
        Self::build(settings, experiment, &mut Vec::new())
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.variator.serialize(archive);
    }

    fn readings(&mut self, elements: bool) -> &Readings {
        self.variator.readings(elements)
    }

    fn moment(&mut self) -> Option<([Readings; 2], f64)> {
        let moment = self.variator.moment();
        let readings = [moment.before, moment.after].map(|outputs| (*outputs).into());
        Some((readings, moment.span))
    }
}

fn text(error: impl ToString) -> String {
    error.to_string()
}

/// Memory of a cell with its share of the matrices, bytes, twice for the copy of a start (measured
/// with 16 cells in an element).
const CELL: usize = 24_000;

/// Checks for the memory of a mesh, since a failed allocation in the model would end the process.
fn find_memory(mesh: &Mesh) -> Result<(), String> {
    let elements = [mesh.primary_arc, mesh.secondary_arc, mesh.strand, mesh.strand];
    let count = |count: i32| usize::try_from(count).unwrap_or_default();
    let elements: usize = elements.into_iter().map(count).sum();
    let bytes = (CELL * count(mesh.cells_per_element)).saturating_mul(elements);
    let found = Vec::<u8>::new().try_reserve_exact(bytes);
    found.map_err(|_| {
        format!(
            "mesh.primaryArc, mesh.secondaryArc, mesh.strand and mesh.cellsPerElement make {elements} elements, for which there is no \
             memory of {} MB: choose fewer",
            bytes / 1_000_000
        )
    })
}

/// The tolerance from the parameter or the experiment. Importers pass the default experiment's
/// tolerance without an action of the user, so a changed parameter takes precedence.
fn choose_tolerance(parameter: f64, experiment: f64, remarks: &mut Vec<Message>) -> f64 {
    let mut remark = |warning, text| remarks.push(Message { warning, text });
    if parameter != Parameters::default().solver.tolerance {
        if parameter != experiment {
            let over = format!("takes precedence over the experiment's tolerance {experiment}");
            remark(false, format!("solver.tolerance = {parameter} was set and {over}"));
        }
        return parameter;
    }
    let range = range_of("solver.tolerance").unwrap_or(0.0..=1.0);
    let (min, max) = range.into_inner();
    let tolerance = experiment.clamp(min, max);
    if tolerance != experiment {
        let text = format!(
            "the experiment's tolerance {experiment} is out of range: {min} to {max}; {tolerance} is used"
        );
        remark(true, text);
    }
    tolerance
}

#[cfg(test)]
mod tests {
    use super::choose_tolerance;

    #[test]
    fn a_tolerance_is_chosen() {
        for (parameter, experiment, expected, remark) in [
            (1e-4, 1e-6, 1e-6, None),
            (1e-5, 1e-4, 1e-5, Some((false, "solver.tolerance = 0.00001"))),
            (1e-4, 1e-300, 1e-10, Some((true, "0.0000000001 is used"))),
        ] {
            let mut remarks = Vec::new();
            assert_eq!(choose_tolerance(parameter, experiment, &mut remarks), expected);
            assert_eq!(remarks.len(), usize::from(remark.is_some()));
            if let Some((warning, text)) = remark {
                assert!(
                    remarks[0].warning == warning && remarks[0].text.contains(text),
                    "{remarks:?}"
                );
            }
        }
    }
}
