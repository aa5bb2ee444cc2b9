//! A whole FMU of both versions of FMI: a first-order lag, T·dy/dt + y = u. `cargo build --example lag` builds its library,
//! `cargo run --example lag_description` prints its model description.

use pushbelt_fmi::prelude::*;

/// Parameters and input.
#[derive(Clone)]
pub struct Settings {
    time_constant: f64,
    start: f64,
    input: f64,
}

impl Default for Settings {
    fn default() -> Self {
        let (time_constant, start, input) = (2.0, 0.0, 1.0);
        Self {
            time_constant,
            start,
            input,
        }
    }
}

/// The state.
#[derive(Clone)]
pub struct Lag {
    time: f64,
    output: f64,
}

impl Unit for Lag {
    type Settings = Settings;
    /// The output.
    type Readings = f64;
    type Progress = ();

    const IDENTITY: Identity = Identity::new("Lag", "A first-order lag");

    fn table() -> Table<Settings, f64> {
        use Causality::{Input, Output, Parameter};
        type V = Variable<Settings, f64>;
        const UNITS: &[UnitDefinition] = &[UnitDefinition::new("1", &[]), UnitDefinition::new("s", &[("s", 1)])];
        let variables = vec![
            V::real(1, "y", "Output", Output, "1", Access::Reading(|output| *output)),
            V::real(2, "u", "Input", Input, "1", setting!(input)),
            V::real(3, "T", "Time constant", Parameter, "s", setting!(time_constant)).within(Range::from(1e-6)),
            V::real(4, "start", "Output at the start", Parameter, "1", setting!(start)),
        ];
        Table::new(UNITS, &[], variables)
    }

    fn start(settings: &Settings, experiment: &Experiment, _: &mut Vec<Remark>) -> Result<Self, String> {
        let (time, output) = (experiment.start, settings.start);
        Ok(Self { time, output })
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn readings(&mut self, _: bool) -> &f64 {
        &self.output
    }

    /// The exact solution for an input that is held.
    fn advance(
        &mut self,
        step: &mut CommunicationStep<Self>,
        settings: &Settings,
        _: &mut Vec<Remark>,
    ) -> Result<(), StepFailure> {
        let decay = (-(step.to - self.time) / settings.time_constant).exp();
        self.output = settings.input + (self.output - settings.input) * decay;
        self.time = step.to;
        Ok(())
    }

    fn serialize(&mut self, tape: &mut Tape<'_>) {
        tape.real(&mut self.time);
        tape.real(&mut self.output);
    }
}

pushbelt_fmi::export!(Lag);
