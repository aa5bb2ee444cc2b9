//! A run of a variator: build from parameters, initialise, advance, read.

use super::outcome::{Event, InitialisationError, Moment, TimeError};
use super::plausibility::PlausibilityWarnings;
use super::real_time_monitor::RealTimeMonitor;
use super::simulation::Simulation;
use super::steady_start::SteadyTangent;
use super::stepper::Stepper;
use super::tuning::{COLD_STEP, FIRST_STEP, MESSAGE_TIME, MOMENT};
use crate::archive::Archive;
use crate::fmi::unit::Message;
use crate::solver::State;
use crate::solver::newton::Counts;
use crate::variator::belt::ring::BeltRing;
use crate::variator::diagnostics::belt::BeltDiagnostics;
use crate::variator::diagnostics::energy_balance::EnergyBalance;
use crate::variator::diagnostics::observe::Observer;
use crate::variator::pulleys::loads::InputProfile;
use crate::variator::settings::{
    Inputs, Outputs, ParameterError, Parameters, Profile, Readings, StartState, Work,
};
use crate::variator::system::VariatorSystem;
use std::sync::Arc;

/// A variator: parameters, mesh and the whole dynamic state in one place. A clone is a snapshot
/// that continues bit for bit as the original does. [An example](crate).
#[derive(Clone, Debug)]
pub struct Variator {
    pub(super) simulation: Simulation,
    pub(super) stepper: Stepper,
    start_state: StartState,
    pub(super) macro_slip: bool,
    /// Last time at which the belt began or ceased to slip through, s.
    slipped: f64,
    pub(super) work: Work,
    pub(super) pace: RealTimeMonitor,
    hints: PlausibilityWarnings,
    /// Values where the present communication step began.
    saved: Saved,
    observer: Observer,
    readings: Box<Readings>,
    pub(super) stale: bool,
    profile_stale: bool,
}

/// Values as bytes, with room for an open step of bounded work; also in a copy, so that its steps
/// allocate nothing.
#[derive(Debug, Default)]
struct Saved(Vec<u8>);

impl Clone for Saved {
    fn clone(&self) -> Self {
        let mut bytes = Vec::with_capacity(self.0.capacity());
        bytes.extend_from_slice(&self.0);
        Self(bytes)
    }
}

impl Variator {
    /// A variator with these parameters and the ring of [`Parameters::ring_model`], not yet
    /// initialised.
    ///
    /// # Errors
    /// The first parameter that is out of its range.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        let ring = parameters.ring_of_model();
        Self::with_ring(parameters, ring)
    }

    /// Checks parameters of a variator with this ring.
    ///
    /// # Errors
    /// The first parameter that is out of its range or does not fit the ring.
    pub fn check(parameters: &Parameters, ring: &dyn BeltRing) -> Result<(), ParameterError> {
        parameters.validate()?;
        ring.check(parameters)
    }

    /// A variator with these parameters and this ring, not yet initialised.
    ///
    /// # Errors
    /// As [`Variator::check`].
    pub fn with_ring(parameters: Parameters, ring: Arc<dyn BeltRing>) -> Result<Self, ParameterError> {
        Self::check(&parameters, &*ring)?;
        let simulation = Simulation::new(&parameters, ring);
        Ok(Self {
            stepper: Stepper::new(&simulation, COLD_STEP),
            saved: Saved::default(),
            simulation,
            start_state: StartState::Unloaded,
            macro_slip: false,
            slipped: f64::NEG_INFINITY,
            work: Work::default(),
            pace: RealTimeMonitor::default(),
            hints: PlausibilityWarnings::NONE,
            observer: Observer::default(),
            readings: Box::default(),
            stale: true,
            profile_stale: true,
        })
    }

    /// Seeks the steady state of the next start from that of `other`, if it is in a steady start,
    /// which takes a tenth of the work where they differ by some per cent. Otherwise, and where
    /// they differ by more, the start is as without.
    pub fn start_near(&mut self, other: &Self) {
        self.simulation.near = other.is_steady_start().then(|| other.simulation.neighbour()).flatten();
    }

    /// Whether this is the start of a run from a steady state at the given loads.
    fn is_steady_start(&self) -> bool {
        self.start_state == StartState::Steady && self.counts().steps == 0
    }

    /// The steady state from which the run starts, with its tangent. None where there is none: it is
    /// not the start of a run, the start is not a steady state at these loads, or the belt slips
    /// through or is pressed against a stop.
    #[must_use]
    pub fn tangent(&self) -> Option<SteadyTangent> {
        let grips = !self.macro_slip && !self.simulation.energy.last.sums.past_peak();
        (self.is_steady_start() && grips)
            .then(|| self.simulation.tangent())
            .flatten()
    }

    /// Whether the start is in equilibrium of both clamping forces, and not at a held ratio.
    #[must_use]
    pub fn balances(&self) -> bool {
        self.simulation.balances()
    }

    /// Finds the state to start from at `time`. If it can't be found, the run starts from the
    /// nearest one, with a warning that names it and the reason.
    ///
    /// # Errors
    /// A time or an input that is out of its range, or no state found.
    pub fn initialise(&mut self, time: f64, inputs: &Inputs) -> Result<(), InitialisationError> {
        TimeError::check(None, time)?;
        inputs.validate()?;
        (self.slipped, self.hints) = (f64::NEG_INFINITY, PlausibilityWarnings::NONE);
        let parameters = &self.simulation.system.parameters;
        let idle = parameters.idle_pressures(inputs, &mut self.hints.idle, time);
        idle.into_iter().for_each(|text| self.simulation.log(true, text));
        self.start_state = self.simulation.find_start(time, inputs)?;
        let simulation = &mut self.simulation;
        simulation.state.y_dot.fill(0.0);
        let first_step = match self.start_state {
            StartState::Unloaded | StartState::NotFound | StartState::Clamped => COLD_STEP,
            _ => FIRST_STEP,
        };
        self.stepper = Stepper::new(simulation, first_step);
        self.work = Work::default();
        self.pace = RealTimeMonitor::new(inputs);
        simulation.apply(InputProfile::constant(inputs));
        simulation.energy = EnergyBalance::open(&simulation.system, simulation.state.view());
        self.macro_slip = simulation.slips(false);
        self.warn(true);
        self.stale = true;
        self.save_first();
        Ok(())
    }

    /// Adds the new warnings of the present state. `starts`: the run starts from it.
    pub(super) fn warn(&mut self, starts: bool) {
        for hint in self.hints.new_warnings(&self.simulation, starts) {
            self.simulation.log(true, hint);
        }
    }

    /// Logs when the belt begins to slip through, and when it grips again.
    pub(super) fn report_slip(&mut self) {
        let to = self.simulation.time;
        let slips = self.simulation.slips(self.macro_slip);
        if slips == self.macro_slip {
            return;
        }
        self.macro_slip = slips;
        if to - self.slipped > MESSAGE_TIME {
            self.simulation
                .log(false, format!("at {to} s {}", Event::of_slip(slips).text()));
        }
        self.slipped = to;
    }

    /// Outputs a moment before and after the present: the state moves along y' = ẏ, q' = y, and ẏ
    /// as it did between the stages of the last step. Allocates.
    pub fn moment(&mut self) -> Moment {
        let present = self.outputs().clone();
        let of = &self.simulation;
        let [before, after] = [-MOMENT, MOMENT].map(|after| {
            let mut state = of.state.clone();
            for i in 0..state.y.len() {
                state.q[i] += after * state.y[i];
                state.y[i] += after * state.y_dot[i];
                state.y_dot[i] += after * self.stepper.sdirk.slope_rate(i);
            }
            let (time, view) = (of.time + after, state.view());
            let belt = BeltDiagnostics::new(&of.system, view);
            let mut outputs = Box::new(present.clone());
            self.observer.observe(&of.system, time, view, &belt, &mut outputs);
            outputs.energy_residual = of.energy.residual(outputs.stored_energy);
            outputs
        });
        self.stale = true;
        let span = 2.0 * MOMENT;
        Moment { before, after, span }
    }

    /// Writes to an archive, or reads from it, what later steps and outputs depend on. To read,
    /// build a variator from the same parameters.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.serialize_values(archive);
        self.stepper.sdirk.newton.serialize_factors(archive);
        self.simulation.system.serialize_derivatives(archive);
        if archive.is_reading() {
            self.save_first();
        }
    }

    /// The same without the Jacobian that the solver reuses, for stored states and steps that go
    /// back.
    fn serialize_values(&mut self, archive: &mut Archive<'_>) {
        self.simulation.serialize(archive);
        self.stepper.serialize(archive);
        archive.bounded_real(&mut self.slipped, f64::NEG_INFINITY, f64::MAX);
        let work = &mut self.work;
        for count in [
            &mut work.steps,
            &mut work.jacobians,
            &mut work.residuals,
            &mut work.rollbacks,
        ] {
            archive.integer(count);
        }
        archive.real(&mut work.defect);
        archive.real(&mut work.behind);
        archive.real(&mut work.skipped);
        self.pace.serialize(archive);
        self.hints.serialize(archive);
        archive.flag(&mut self.macro_slip);
        let mut start = self.start_state as i32;
        archive.integer(&mut start);
        match StartState::from_number(start) {
            Some(start) => self.start_state = start,
            None => archive.reject(),
        }
        if archive.is_reading() {
            let of = &mut self.simulation;
            of.energy.last.update(&of.system, of.state.view());
            self.stale = true;
        }
    }

    /// Stores all values where a communication step begins.
    pub(super) fn save(&mut self) {
        let mut archive = Archive::writer_in(std::mem::take(&mut self.saved.0));
        self.serialize_values(&mut archive);
        self.saved.0 = archive.into_bytes();
    }

    /// The same before the first step, with room for an open one, whose stage and residual are as
    /// long as all else.
    fn save_first(&mut self) {
        self.save();
        self.saved.0.reserve(2 * self.saved.0.len());
    }

    /// Restores the values of the begin of the communication step. All readings have the same bits,
    /// and the work since then remains counted. A Jacobian of then is not kept.
    pub(super) fn roll_back(&mut self) {
        let (saved, counts) = (std::mem::take(&mut self.saved), self.stepper.counts());
        self.serialize_values(&mut Archive::reader(&saved.0));
        self.saved = saved;
        let newton = &mut self.stepper.sdirk.newton;
        newton.forget_factors();
        newton.counts = counts;
        self.simulation.system.forget_derivatives();
    }

    /// Present time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.simulation.time
    }

    /// Parameters as set. Those in force are in [`Variator::system`].
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        self.simulation.system.parameters.as_set()
    }

    /// The assembled system, for reports and tests.
    #[must_use]
    pub fn system(&self) -> &VariatorSystem {
        &self.simulation.system
    }

    /// The energy balance, and the belt at the end of the last step, for reports and tests.
    #[must_use]
    pub fn energy_balance(&self) -> &EnergyBalance {
        &self.simulation.energy
    }

    /// The dynamic state, for reports and tests.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.simulation.state
    }

    /// Work done since the start of the run.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.stepper.counts()
    }

    /// Work of the search for the state that the run started from.
    #[must_use]
    pub fn start_work(&self) -> Counts {
        self.simulation.start_work
    }

    /// Sets the two tunable friction coefficients.
    ///
    /// # Errors
    /// A coefficient that is out of its range; nothing was changed.
    pub fn set_friction(&mut self, pulley: f64, ring: f64) -> Result<(), ParameterError> {
        let of = &mut self.simulation;
        if !of.system.parameters.set_friction(pulley, ring)? {
            return Ok(());
        }
        of.energy.last.update(&of.system, of.state.view());
        self.stepper.sdirk.newton.forget_rate();
        // All kept derivatives are of the same law, as in a soft start.
        of.system.forget_derivatives();
        self.stale = true;
        Ok(())
    }

    /// Outputs at the present time.
    pub fn outputs(&mut self) -> &Outputs {
        &self.readings(false).outputs
    }

    /// Fields along the belt at the present time.
    pub fn profile(&mut self) -> &Profile {
        &self.readings(true).profile
    }

    /// Outputs at the present time, and with `profile` the profile, which takes as long as they.
    pub(crate) fn readings(&mut self, profile: bool) -> &Readings {
        let of = &self.simulation;
        let (view, belt) = (of.state.view(), &of.energy.last);
        let (outputs, fields) = (&mut self.readings.outputs, &mut self.readings.profile);
        if self.stale {
            self.observer.observe(&of.system, of.time, view, belt, outputs);
            (outputs.macro_slip, outputs.start_state, outputs.work) =
                (self.macro_slip, self.start_state, self.work);
            outputs.energy_residual = of.energy.residual(outputs.stored_energy);
            (self.stale, self.profile_stale) = (false, true);
        }
        if profile && self.profile_stale {
            self.observer.profile(&of.system.belt, view, &belt.sums, fields);
            self.profile_stale = false;
        }
        &self.readings
    }

    /// Returns the messages since the last call, and removes them.
    pub fn take_messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.simulation.messages)
    }
}
