//! A whole FMU of both versions of FMI: a first-order lag, T·dy/dt + y = u.
//! `cargo build --example lag` builds its library, `cargo run --example lag_description` prints its
//! model description.

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

/// Time since the start, and the state y, which is the output.
#[derive(Clone)]
pub struct Lag {
    time: f64,
    y: f64,
}

impl Unit for Lag {
    type Settings = Settings;
    type Readings = f64;
    type Step = ();

    const IDENTITY: Identity = Identity::new("Lag", "A first-order lag");

    fn table() -> Table<Settings, f64> {
        use Causality::{Input, Output, Parameter};
        type V = Variable<Settings, f64>;
        const UNITS: &[UnitDefinition] =
            &[UnitDefinition::new("1", &[]), UnitDefinition::new("s", &[("s", 1)])];
        let variables = vec![
            V::real(1, "y", "Output", Output, "1", Access::Reading(|output| *output)),
            V::real(2, "u", "Input", Input, "1", setting!(input)),
            V::real(3, "T", "Time constant", Parameter, "s", setting!(time_constant))
                .with_range(Range::from(1e-6)),
            V::real(4, "start", "Output at the start", Parameter, "1", setting!(start)),
        ];
        Table::new(UNITS, &[], variables)
    }

    fn start(settings: &Settings, _: &Experiment, _: &mut Vec<Message>) -> Result<Self, String> {
        let (time, y) = (0.0, settings.start);
        Ok(Self { time, y })
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn readings(&mut self, _: bool) -> &f64 {
        &self.y
    }

    fn begin(&mut self, _to: f64, _: &Settings, _: Option<&Settings>) -> Result<(), String> {
        Ok(())
    }

    /// The exact solution for an input that is held.
    fn advance(
        &mut self,
        to: f64,
        (): &mut (),
        settings: &Settings,
        _: &mut Vec<Message>,
    ) -> Result<(), String> {
        let decay = (-(to - self.time) / settings.time_constant).exp();
        self.y = settings.input + (self.y - settings.input) * decay;
        self.time = to;
        Ok(())
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.time);
        archive.real(&mut self.y);
    }
}

pushbelt_fmi::export!(Lag);
