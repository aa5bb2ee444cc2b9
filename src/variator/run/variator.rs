//! A run of a variator: build from parameters, initialise, advance, read.

use crate::archive::Archive;
use crate::pulley::PerPulley;
use crate::solver::State;
use crate::solver::newton::Counts;
use crate::variator::belt::ring::BeltRing;
use crate::variator::diagnostics::belt::{BeltDiagnostics, BeltSums};
use crate::variator::diagnostics::energy_balance::EnergyBalance;
use crate::variator::diagnostics::observe::{Context, Observer};
use crate::variator::pulleys::loads::LinearInputs;
use crate::variator::pulleys::rows::External;
use crate::variator::run::checkpoint::Checkpoint;
use crate::variator::run::hints::Hints;
use crate::variator::run::outcome::{InitialisationError, Message, Moment};
use crate::variator::run::pace::Pace;
use crate::variator::run::plant::Plant;
use crate::variator::run::real_time::RealTime;
use crate::variator::run::start::find_start;
use crate::variator::run::stepper::{Accurate, COLD_STEP, Stepper};
use crate::variator::settings::error::ParameterError;
use crate::variator::settings::parameters::{Mode, Parameters};
use crate::variator::settings::signals::{Inputs, Outputs, Profile, Readings, StartState, Work};
use crate::variator::steady::solve::geometric_ratio;
use crate::variator::system::VariatorSystem;
use std::sync::Arc;

/// Time without net compression in a strand after which it is logged again, s: a strand at the limit does not fill the log.
const QUIET: f64 = 1.0;

/// Time after which a change between gripping and slipping through is logged again, s.
const CHATTER: f64 = 0.1;

/// Half the distance in time over which outputs are differentiated, s: the loads of the flanks are linear over it, and
/// it leaves nine digits of a difference.
const MOMENT: f64 = 1.0e-6;

/// A variator: parameters, mesh and the whole dynamic state in one place. A clone is a snapshot that continues
/// bit for bit as the original does.
///
/// ```
/// use pushbelt::variator::{Variator, settings::{Inputs, Parameters}};
/// let mut variator = Variator::new(Parameters::default())?;
/// let inputs = Inputs::default();
/// variator.initialise(0.0, &inputs)?;
/// variator.advance(1e-3, &inputs)?;
/// assert!((1.0..1.6).contains(&variator.outputs().thrust_ratio));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Variator {
    pub(super) plant: Plant,
    pub(super) stepper: Box<dyn Stepper>,
    start_state: StartState,
    pub(super) macro_slip: bool,
    /// Last time at which a strand was in net compression, s.
    buckled: f64,
    /// Last time at which the belt began or ceased to slip through, s.
    slipped: f64,
    initial_energy: f64,
    pub(super) external: PerPulley<External>,
    pub(super) work: Work,
    pub(super) pace: Pace,
    hints: Hints,
    pub(super) checkpoint: Checkpoint,
    observer: Observer,
    readings: Box<Readings>,
    pub(super) stale: bool,
    profile_stale: bool,
    messages: Vec<Message>,
}

/// The stepper that the parameters choose, for the plant's state and time.
fn stepper(plant: &Plant, first_step: f64) -> Box<dyn Stepper> {
    match plant.system.parameters.solver.mode {
        Mode::Accurate => Box::new(Accurate::new(&plant.system, first_step)),
        Mode::RealTime => Box::new(RealTime::new(plant)),
    }
}

impl Variator {
    /// A variator with these parameters and the ring of [`Parameters::ring_model`], not yet initialised.
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
    /// The first parameter that is out of its range or does not fit the ring.
    pub fn with_ring(parameters: Parameters, ring: Arc<dyn BeltRing>) -> Result<Self, ParameterError> {
        Self::check(&parameters, &*ring)?;
        let plant = Plant::new(&parameters, ring);
        Ok(Self {
            stepper: stepper(&plant, COLD_STEP),
            checkpoint: Checkpoint::new(&plant),
            plant,
            start_state: StartState::Unloaded,
            macro_slip: false,
            buckled: f64::NEG_INFINITY,
            slipped: f64::NEG_INFINITY,
            initial_energy: 0.0,
            external: PerPulley::default(),
            work: Work::default(),
            pace: Pace::default(),
            hints: Hints::NONE,
            observer: Observer::default(),
            readings: Box::default(),
            stale: true,
            profile_stale: true,
            messages: Vec::new(),
        })
    }

    /// Finds the state to start from at `time`.
    ///
    /// A state that can't be solved for is replaced by the nearest one, with a warning that names it and the reason.
    ///
    /// # Errors
    /// Inputs out of range, or no state found.
    pub fn initialise(&mut self, time: f64, inputs: &Inputs) -> Result<(), InitialisationError> {
        inputs.validate()?;
        (self.buckled, self.slipped) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let (start_state, first_step) = find_start(&mut self.plant, &mut self.messages, time, inputs)?;
        self.start_state = start_state;
        let plant = &mut self.plant;
        plant.state.y_dot.fill(0.0);
        self.stepper = stepper(plant, first_step);
        self.work = Work::default();
        self.pace = Pace::new(inputs);
        plant.apply(LinearInputs::constant(time, inputs));
        plant.energy = EnergyBalance::open(&plant.system, plant.state.view());
        self.initial_energy =
            plant.energy.last.belt_energy(&plant.system.belt) + plant.system.pulleys().energy(plant.state.view());
        self.macro_slip = plant.slips(false);
        self.warn_of_layers();
        self.warn_of_slip();
        self.warn_of_loads(true);
        self.update_outputs();
        Ok(())
    }

    /// Makes outputs those of the present, in an ongoing communication step.
    pub fn update_outputs(&mut self) {
        let Plant {
            system, energy, state, ..
        } = &self.plant;
        let boundary = system.boundary(self.plant.time);
        let BeltSums {
            shaft_torque, axial, ..
        } = energy.last.sums;
        self.external = system.pulleys().external(&boundary, state.view(), shaft_torque, axial);
        self.stale = true;
    }

    pub(super) fn log(&mut self, warning: bool, text: String) {
        self.messages.push(Message { warning, text });
    }

    /// Warns of stiffness and mass of a ring with other layers.
    fn warn_of_layers(&mut self) {
        let parameters = &self.plant.system.parameters;
        if let Some((modulus, density)) = parameters.steel_of_other_layers() {
            let text = format!(
                "ring.axialStiffness, ring.bendingStiffness and ring.massPerLength do not follow from ring.layers, \
                 ring.layerThickness and ring.layerWidth: steel of {:.0} GPa and {density:.0} kg/m3; set them together",
                1e-9 * modulus
            );
            self.log(true, text);
        }
    }

    /// Warns of loads and speeds that can hardly be meant. `starts`: in the state that the run starts from.
    pub(super) fn warn_of_loads(&mut self, starts: bool) {
        for hint in self.hints.new_at(&self.plant, starts) {
            self.log(true, hint);
        }
    }

    /// Warns where the belt slips through from the start.
    fn warn_of_slip(&mut self) {
        if !self.macro_slip {
            return;
        }
        let Plant { system, state, .. } = &self.plant;
        let speeds = system.belt.shaft_speeds(state.view());
        let text = format!(
            "the belt slips through (macro-slip) in the state that the run starts from: {:.4} rad/s at the primary \
             pulley, {:.4} rad/s at the secondary, geometric ratio {:.4}",
            speeds.primary,
            speeds.secondary,
            geometric_ratio(system, state.view())
        );
        self.log(true, text);
    }

    /// Logs when the belt begins to slip through, and when it grips again.
    pub(super) fn report_slip(&mut self) {
        let to = self.plant.time;
        let slips = self.plant.slips(self.macro_slip);
        if slips != self.macro_slip {
            self.macro_slip = slips;
            if to - self.slipped > CHATTER {
                let what = if slips {
                    "begins to slip through (macro-slip)"
                } else {
                    "grips again"
                };
                self.log(false, format!("at {to} s the belt {what}"));
            }
            self.slipped = to;
        }
    }

    /// Warns of a strand whose net force is compression.
    pub(super) fn report_buckling(&mut self) {
        let to = self.plant.time;
        let force = self.plant.energy.last.sums.strand_force;
        if force < 0.0 {
            if to - self.buckled > QUIET {
                let real = if self.plant.system.belt.law.is_chain() {
                    "chain would be slack"
                } else {
                    "push strand would buckle"
                };
                self.log(
                    true,
                    format!(
                        "at {to} s the net force in a strand is {force:.0} N: a real {real} (repeated only after {QUIET} s \
                         without)"
                    ),
                );
            }
            self.buckled = to;
        }
    }

    /// Outputs on both sides of the present, for their time derivatives: the state moves along y' = ẏ, q' = y, and ẏ as
    /// it did between the stages of the last step. Allocates.
    pub fn moment(&mut self) -> Moment {
        let [before, after] = [-MOMENT, MOMENT].map(|after| {
            let Plant { system, time, .. } = &self.plant;
            let mut state = self.plant.state.clone();
            for i in 0..state.y.len() {
                state.q[i] += after * state.y[i];
                state.y[i] += after * state.y_dot[i];
                state.y_dot[i] += after * self.stepper.slope_rate(i);
            }
            let boundary = system.boundary(time + after);
            let diagnostics = BeltDiagnostics::of(system, state.view());
            let BeltSums {
                shaft_torque, axial, ..
            } = diagnostics.sums;
            let context = self.context(system.pulleys().external(&boundary, state.view(), shaft_torque, axial));
            let mut outputs = Box::<Outputs>::default();
            self.observer
                .observe(system, state.view(), &diagnostics, &context, &mut outputs);
            outputs
        });
        Moment {
            before,
            after,
            span: 2.0 * MOMENT,
        }
    }

    /// Writes to an archive, or reads from it, all that later steps and outputs depend on. To read, build a variator from the same
    /// parameters.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let plant = &mut self.plant;
        plant.state.serialize(archive);
        self.stepper.serialize(archive);
        plant.system.serialize(archive);
        let [of_secondary, of_primary] = self.external.each_mut();
        for value in [
            &mut plant.time,
            &mut plant.system.friction_velocity,
            &mut self.initial_energy,
            &mut plant.energy.supplied,
            &mut plant.energy.lost,
            &mut plant.energy.moved,
            &mut of_secondary.torque,
            &mut of_secondary.closing,
            &mut of_primary.torque,
            &mut of_primary.closing,
        ] {
            archive.real(value);
        }
        let friction = &mut plant.system.parameters.friction;
        archive.within(&mut friction.pulley, 0.0, 1.0);
        archive.within(&mut friction.ring, 0.0, 1.0);
        // Times that may lie at −∞.
        for time in [&mut plant.soft_start.from, &mut self.buckled, &mut self.slipped] {
            archive.within(time, f64::NEG_INFINITY, f64::MAX);
        }
        let Work {
            steps,
            jacobians,
            residuals,
            defect,
            behind,
            rollbacks,
        } = &mut self.work;
        for count in [steps, jacobians, residuals, rollbacks] {
            archive.integer(count);
        }
        self.pace.serialize(archive);
        self.hints.serialize(archive);
        archive.real(defect);
        archive.real(behind);
        archive.flag(&mut self.macro_slip);
        let mut start = self.start_state as i32;
        archive.integer(&mut start);
        match StartState::from_number(start) {
            Some(start) => self.start_state = start,
            None => archive.reject(),
        }
        if archive.is_reading() {
            plant.system.restore_derivatives();
            plant.energy.last.update(&plant.system, plant.state.view());
            self.stale = true;
        }
    }

    /// Present time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.plant.time
    }

    /// Parameters in force.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.plant.system.parameters
    }

    /// The assembled system, for reports and tests.
    #[must_use]
    pub fn system(&self) -> &VariatorSystem {
        &self.plant.system
    }

    /// The energy balance, and the belt at the end of the last step, for reports and tests.
    #[must_use]
    pub fn energy_balance(&self) -> &EnergyBalance {
        &self.plant.energy
    }

    /// The dynamic state, for reports and tests.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.plant.state
    }

    /// Work done since the start of the run.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.stepper.counts()
    }

    /// Work of the search for the state that the run started from.
    #[must_use]
    pub fn start_work(&self) -> Counts {
        self.plant.start_work
    }

    /// Changes the two tunable friction coefficients.
    ///
    /// # Errors
    /// A coefficient out of its range; nothing was changed.
    pub fn set_friction(&mut self, pulley: f64, ring: f64) -> Result<(), ParameterError> {
        let plant = &mut self.plant;
        let mut changed = plant.system.parameters.clone();
        changed.friction.pulley = pulley;
        changed.friction.ring = ring;
        changed.validate_friction()?;
        plant.system.parameters.friction = changed.in_force().friction;
        plant.energy.last.update(&plant.system, plant.state.view());
        self.stepper.change_laws();
        // All kept derivatives are of the same law, as in a soft start.
        plant.system.forget_derivatives();
        self.stale = true;
        Ok(())
    }

    /// Values that outputs need beside the state.
    fn context(&self, external: PerPulley<External>) -> Context {
        Context {
            external,
            macro_slip: self.macro_slip,
            supplied: self.plant.energy.supplied,
            lost: self.plant.energy.lost,
            initial_energy: self.initial_energy,
            start_state: self.start_state,
            work: self.work,
        }
    }

    /// Outputs at the present time.
    pub fn outputs(&mut self) -> &Outputs {
        &self.readings(false).outputs
    }

    /// Fields along the belt at the present time.
    pub fn profile(&mut self) -> &Profile {
        &self.readings(true).profile
    }

    /// Outputs at the present time, and if `profile` is set the profile, whose evaluation costs as much as all of them.
    pub(crate) fn readings(&mut self, profile: bool) -> &Readings {
        let Plant {
            system, energy, state, ..
        } = &self.plant;
        let diagnostics = &energy.last;
        if self.stale {
            let context = self.context(self.external);
            let outputs = &mut self.readings.outputs;
            self.observer
                .observe(system, state.view(), diagnostics, &context, outputs);
            (self.stale, self.profile_stale) = (false, true);
        }
        if profile && self.profile_stale {
            let profile = &mut self.readings.profile;
            self.observer
                .profile(&system.belt, state.view(), &diagnostics.sums, profile);
            self.profile_stale = false;
        }
        &self.readings
    }

    /// Returns the messages since the last call, and removes them.
    pub fn take_messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }
}
