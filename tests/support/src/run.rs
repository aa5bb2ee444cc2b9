//! Runs with the energy balance and the balance of the element content.

use pushbelt::archive::Archive;
use pushbelt::variator::ring_models::BeltRing;
use pushbelt::variator::run::{Message, Variator};
use pushbelt::variator::settings::{Inputs, Outputs, Parameters};
use std::sync::Arc;

/// A variator in its start state.
pub fn started(parameters: Parameters, inputs: &Inputs) -> Variator {
    let mut variator = Variator::new(parameters).expect("valid parameters");
    variator.initialise(0.0, inputs).expect("a start");
    variator
}

/// The residuals that a start takes, and its error.
pub fn tried(parameters: Parameters, inputs: &Inputs) -> (u64, Option<String>) {
    let mut variator = Variator::new(parameters).expect("valid parameters");
    let error = variator.initialise(0.0, inputs).err();
    (variator.start_work().residuals, error.map(|error| error.to_string()))
}

/// A new variator with these parameters and the state of another one, through its bytes.
pub fn restored(variator: &mut Variator, parameters: Parameters) -> Variator {
    let mut restored = Variator::new(parameters).expect("valid parameters");
    let mut archive = Archive::writer();
    variator.serialize(&mut archive);
    let bytes = archive.into_bytes();
    let mut archive = Archive::reader(&bytes);
    restored.serialize(&mut archive);
    assert_eq!(archive.finish(), Ok(()));
    restored
}

/// Copies of a variator and its stored state continue with the same bits for 20 steps, to the times
/// and with the inputs of `given`.
pub fn assert_continues_alike(
    variator: &mut Variator,
    parameters: Parameters,
    mut given: impl FnMut(&Variator) -> (f64, Inputs),
) {
    let (mut copy, mut restored) = (variator.clone(), restored(variator, parameters));
    for _ in 0..20 {
        let (time, inputs) = given(variator);
        for run in [&mut *variator, &mut copy, &mut restored] {
            run.advance(time, &inputs).expect("a step");
        }
        assert_eq!(variator.state(), copy.state());
        assert_eq!(variator.state(), restored.state());
        assert_eq!(variator.outputs(), restored.outputs());
    }
}

/// A run with the balances of energy and element content at every output point.
#[derive(Clone, Debug)]
pub struct Run {
    pub variator: Variator,
    /// Inputs, constant until changed.
    pub inputs: Inputs,
    /// Largest |energy residual| relative to its bound 2e-3·∫|power| dt + 1e-3·(largest stored
    /// energy).
    pub residual: f64,
    /// Largest relative change of the element content.
    pub amount_change: f64,
    pub messages: Vec<Message>,
    largest_energy: f64,
    content: f64,
}

impl Run {
    pub fn new(parameters: Parameters, inputs: Inputs) -> Self {
        let ring = parameters.ring_of_model();
        Self::with_ring(parameters, ring, inputs)
    }

    /// Initialises with a ring other than that of the parameters.
    pub fn with_ring(parameters: Parameters, ring: Arc<dyn BeltRing>, inputs: Inputs) -> Self {
        let mut variator = Variator::with_ring(parameters, ring).expect("valid parameters");
        variator.initialise(0.0, &inputs).expect("a state to start from");
        let mut run = Self {
            content: content(&variator),
            variator,
            inputs,
            residual: 0.0,
            amount_change: 0.0,
            messages: Vec::new(),
            largest_energy: 0.0,
        };
        run.record();
        run
    }

    pub fn outputs(&mut self) -> Outputs {
        self.variator.outputs().clone()
    }

    fn record(&mut self) {
        let moved = self.variator.energy_balance().moved;
        let time = self.variator.time();
        let o = self.variator.outputs();
        for (value, name) in [
            (o.thrust_ratio, "thrust ratio"),
            (o.slip, "slip"),
            (o.primary.speed, "primary speed"),
            (o.secondary.speed, "secondary speed"),
            (o.push_force_max, "push force"),
            (o.ring_tension_max, "ring tension"),
        ] {
            assert!(value.is_finite(), "{name} = {value} at {time} s");
        }
        self.largest_energy = self.largest_energy.max(o.stored_energy);
        let allowed = 2.0e-3 * moved + 1.0e-3 * self.largest_energy;
        self.residual = self.residual.max(o.energy_residual.abs() / allowed);
        let change = (content(&self.variator) / self.content - 1.0).abs();
        self.amount_change = self.amount_change.max(change);
        self.messages.extend(self.variator.take_messages());
    }

    /// Advances by `span` in communication steps of `step`; `see` is called after each.
    pub fn watch(&mut self, span: f64, step: f64, mut see: impl FnMut(f64, &Outputs)) {
        let from = self.variator.time();
        let steps = (span / step).round().max(1.0) as u32;
        for k in 1..=steps {
            let to = from + span * f64::from(k) / f64::from(steps);
            self.variator.advance(to, &self.inputs).expect("a step");
            self.record();
            see(to, self.variator.outputs());
        }
    }

    /// Advances by `span` in communication steps of `step`; the outputs at the end.
    pub fn go(&mut self, span: f64, step: f64) -> Outputs {
        self.watch(span, step, |_, _| {});
        self.outputs()
    }

    /// Advances by `span` in communication steps of `step` with inputs that change at `rates`.
    pub fn ramp(&mut self, span: f64, step: f64, rates: &Inputs) {
        let from = self.variator.time();
        let steps = (span / step).round().max(1.0) as u32;
        let start = self.inputs;
        let after = |time: f64| start.after(time, rates);
        for k in 0..steps {
            let at = |k: u32| span * f64::from(k) / f64::from(steps);
            self.variator
                .advance_along(from + at(k + 1), &after(at(k)), rates)
                .expect("a step");
            self.record();
        }
        self.inputs = after(span);
    }

    pub fn warnings(&self, text: &str) -> usize {
        let warnings = self.messages.iter().filter(|message| message.warning);
        warnings.filter(|message| message.text.contains(text)).count()
    }

    pub fn warned(&self, text: &str) -> bool {
        self.warnings(text) > 0
    }

    /// Whether a message, warning or remark, contains `text`.
    pub fn reported(&self, text: &str) -> bool {
        self.messages.iter().any(|m| m.text.contains(text))
    }

    /// The balances of energy and of the element content, at every output point so far.
    #[track_caller]
    pub fn assert_balances(&self) {
        self.assert_amount();
        assert!(
            self.residual <= 1.0,
            "energy residual {:.2} times its bound",
            self.residual
        );
    }

    /// No element is lost.
    #[track_caller]
    pub fn assert_amount(&self) {
        let change = self.amount_change;
        assert!(change <= 1.0e-10, "the content of elements changed by {change:e}");
    }
}

/// Element content Σ N, m.
fn content(v: &Variator) -> f64 {
    v.system().belt.cells_at.iter().map(|at| v.state().y[at.content]).sum()
}
