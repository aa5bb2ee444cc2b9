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
        Self {
            time_constant: 2.0,
            start: 0.0,
            input: 1.0,
        }
    }
}

/// The state y, which is the output.
#[derive(Clone)]
pub struct Lag(f64);

impl SimpleModel for Lag {
    type Settings = Settings;
    type Readings = f64;

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

    fn start(settings: &Settings, _time: f64) -> Result<Self, String> {
        Ok(Self(settings.start))
    }

    fn readings(&mut self) -> &f64 {
        &self.0
    }

    /// The exact solution for an input that is held.
    fn advance(&mut self, settings: &Settings, from: f64, to: f64) -> Result<(), StepFailure> {
        let decay = (-(to - from) / settings.time_constant).exp();
        self.0 = settings.input + (self.0 - settings.input) * decay;
        Ok(())
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.0);
    }
}

pushbelt_fmi::export!(SimpleUnit<Lag>);
