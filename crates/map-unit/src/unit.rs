//! The unit of the FMU: start, steps, outputs, stored states.
//!
//! Steps are those of an L-stable method of second order (SDIRK2, γ = 1 − 1/√2), at most 10 ms long. Inputs are linear over each step.

use std::path::Path;
use std::sync::Arc;

use pushbelt::pulley::Pulley;
use pushbelt::shaft::FADING_SPEED;
use pushbelt::solver::sdirk::GAMMA;
use pushbelt::variator::run::InputProfile;
use pushbelt::variator::settings::{Axial, Drive, Inputs, Losses, Outputs, Parameters, PulleyOutputs, SPEED_LAG};
use pushbelt_fmi::Tape;
use pushbelt_fmi::table::Table;
use pushbelt_fmi::unit::{Experiment, Identity, Remark, StepFailure, Unit};

use crate::file::THRUST_RATIO;
use crate::law::{Frame, Law, Point, Radii, State};
use crate::settings::{self, Readings, Settings};
use crate::stage::Stage;
use crate::tables::Tables;

/// Longest step, s.
const LONGEST: f64 = 1e-2;
/// Shortest step, s: a step that does not converge is divided down to it.
const SHORTEST: f64 = 1e-7;
/// Times closer than this are the same, s.
const INSTANT: f64 = 1e-12;
/// Steps that a communication step may take, and how many times as many as of the longest ones.
const MOST_STEPS: f64 = 1e5;
const MOST_PER_LONGEST: f64 = 100.0;
/// Largest speed and input in a stored state, SI units, far beyond what a shaft stands.
const LARGEST: f64 = 1e9;

/// A variator from maps.
#[derive(Clone, Debug)]
pub struct MapUnit {
    tables: Arc<Tables>,
    radii: Arc<Radii>,
    settings: Settings,
    state: State,
    time: f64,
    /// The inputs that act at the present time.
    acting: Inputs,
    /// Thrust ratio of the last step, from which a held secondary sheave gets its force.
    thrust_ratio: f64,
    /// Whether it has been logged that the state is beyond the tables, and that a pressure opens a pulley.
    logged: bool,
    opened: bool,
    readings: Readings,
}

/// A communication step: its end, s, and the inputs over it.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    to: f64,
    inputs: InputProfile,
}

impl MapUnit {
    fn blank_with(settings: &Settings) -> Result<Self, String> {
        let tables = settings.own.clone().ok_or("the unit has no tables")?;
        check(settings)?;
        let radii = Arc::new(Radii::new(&settings.parameters)?);
        Ok(Self {
            tables,
            radii,
            settings: settings.clone(),
            state: State {
                primary: 0.0,
                secondary: 0.0,
                log_ratio: 0.0,
            },
            time: 0.0,
            acting: settings.inputs,
            thrust_ratio: 1.0,
            logged: false,
            opened: false,
            readings: Readings::default(),
        })
    }

    fn law(&self) -> Law<'_> {
        Law {
            tables: &self.tables,
            radii: &self.radii,
            parameters: self.parameters(),
        }
    }

    fn parameters(&self) -> &Parameters {
        &self.settings.parameters
    }

    /// The state at the start.
    fn initialise(&mut self, remarks: &mut Vec<Remark>) {
        let mut warn = |text: String| remarks.push(Remark { warning: true, text });
        let [least, most] = self.radii.stops;
        let initial = self.parameters().initial.clone();
        let wanted = initial.ratio.ln();
        self.state.log_ratio = wanted.clamp(least, most);
        // The detailed unit accepts a start up to 6 % beyond, where a loaded belt rests.
        if (self.state.log_ratio - wanted).abs() > 0.06 {
            let [least, most] = self.radii.stops.map(f64::exp);
            warn(format!(
                "initial.ratio = {} is beyond the end stops: {least:.4} to {most:.4}; the run starts at the stop",
                initial.ratio
            ));
        }
        let drive = [self.parameters().primary.drive, self.parameters().secondary.drive];
        self.state.primary = match drive[0] {
            Drive::Speed => self.acting.primary.speed_setpoint,
            Drive::Torque => initial.primary_speed,
        };
        self.thrust_ratio = self.tables.belt(&self.frame().place, 0.0).thrust_ratio;
        self.settle(drive, &mut warn);
        if initial.steady && initial.equilibrium && !self.parameters().holds_a_sheave() {
            self.balance(drive, &mut warn);
        }
        self.update_thrust_ratio();
    }

    /// Sets the secondary speed at the present ratio: that of the steady slip, of the set point, or without slip.
    fn settle(&mut self, drive: [Drive; 2], warn: &mut impl FnMut(String)) {
        let ratio = self.state.log_ratio.exp();
        if drive[1] == Drive::Speed {
            self.state.secondary = self.acting.secondary.speed_setpoint;
            if drive[0] == Drive::Torque {
                self.state.primary = self.acting.secondary.speed_setpoint * ratio;
            }
        } else {
            self.state.secondary = self.state.primary / ratio;
        }
        if !self.parameters().initial.steady || drive == [Drive::Speed; 2] || self.state.primary == 0.0 {
            return;
        }
        // The speed of the shaft that is not given follows from the slip. Torque, loss and bearing load are iterated.
        for _ in 0..30 {
            let frame = self.frame();
            let wanted = self.steady_torque(&frame, drive) / frame.torque.max(1e-9);
            let Some(slip) = self.slip_at(&frame, wanted) else {
                warn(format!(
                    "the belt does not carry a torque utilisation of {wanted:.3}: the run starts without slip"
                ));
                return;
            };
            // s = v/q; the slip is that of running speed.
            let sliding = slip * frame.speed / frame.radius;
            let before = self.state;
            if drive[1] == Drive::Speed {
                self.state.primary = ratio * self.state.secondary + sliding;
            } else {
                self.state.secondary = (self.state.primary - sliding) / ratio;
            }
            let change = (self.state.primary - before.primary).abs() + (self.state.secondary - before.secondary).abs();
            if change <= 1e-12 * self.state.primary.abs() {
                break;
            }
        }
    }

    /// The torque T_P with which the slip stays constant, N·m: the free shafts accelerate together.
    fn steady_torque(&self, frame: &Frame, drive: [Drive; 2]) -> f64 {
        let law = self.law();
        let State { primary, secondary, .. } = self.state;
        let sliding = frame.radius * (primary - frame.ratio * secondary);
        let point = law.point(frame, sliding);
        let load = point.bearing_load();
        let lost = (primary / FADING_SPEED).tanh() * point.torque_loss();
        let Parameters {
            primary: of_primary,
            secondary: of_secondary,
            ..
        } = self.parameters();
        let into = self.acting.primary.torque - of_primary.drag.at(primary, [load, 0.0]).torque;
        let out = self.acting.secondary.torque - of_secondary.drag.at(secondary, [load, 0.0]).torque;
        let i = frame.ratio;
        match drive {
            [Drive::Torque, Drive::Speed] => into,
            [Drive::Speed, _] => lost - out / i,
            // (into − T)/J_P = i (out + i (T − lost))/J_S
            [Drive::Torque, Drive::Torque] => {
                let (j_p, j_s) = (of_primary.inertia, of_secondary.inertia);
                (into * j_s - i * (out - i * lost) * j_p) / (j_s + i * i * j_p)
            }
        }
    }

    /// The slip s at a utilisation; none beyond the capacity.
    fn slip_at(&self, frame: &Frame, wanted: f64) -> Option<f64> {
        let law = self.law();
        let at = |slip: f64| law.traction(frame, slip * frame.speed);
        let (mut low, mut high) = (-1.0, 1.0);
        // Beyond the capacity the traction falls: only the rising part is searched.
        while at(low).macro_slip && low < -1e-6 {
            low *= 0.98;
        }
        while at(high).macro_slip && high > 1e-6 {
            high *= 0.98;
        }
        if wanted < at(low).value || wanted > at(high).value {
            return None;
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if at(middle).value < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(0.5 * (low + high))
    }

    /// Moves the ratio to the equilibrium of the clamping forces, or to an end stop.
    fn balance(&mut self, drive: [Drive; 2], warn: &mut impl FnMut(String)) {
        let mut unheard = |_: String| {};
        let [mut low, mut high] = self.radii.stops;
        for _ in 0..60 {
            self.state.log_ratio = 0.5 * (low + high);
            self.settle(drive, &mut unheard);
            self.update_thrust_ratio();
            // Too small a primary force: the ratio grows.
            let [closing, other] = self.closing();
            if closing < self.thrust_ratio * other {
                low = self.state.log_ratio;
            } else {
                high = self.state.log_ratio;
            }
        }
        self.settle(drive, warn);
    }

    /// The thrust ratio from which a held secondary sheave gets its force.
    fn held_thrust_ratio(&self) -> Option<f64> {
        (self.parameters().secondary.axial == Axial::Held).then_some(self.thrust_ratio)
    }

    /// Forces of clamps and cylinders on the primary and the secondary sheave at present, without seals, N.
    fn closing(&self) -> [f64; 2] {
        self.law().closing(&self.state, &self.acting)
    }

    /// The secondary force, N: of clamp and cylinder, or with a held sheave what the primary force requires.
    fn force(&self) -> f64 {
        let [closing, own] = self.closing();
        self.held_thrust_ratio().map_or(own, |ratio| closing / ratio)
    }

    fn frame(&self) -> Frame {
        self.law().frame(&self.state, self.force())
    }

    fn sliding(&self, frame: &Frame) -> f64 {
        frame.radius * (self.state.primary - frame.ratio * self.state.secondary)
    }

    fn update_thrust_ratio(&mut self) {
        let frame = self.frame();
        self.thrust_ratio = self.law().point(&frame, self.sliding(&frame)).thrust_ratio();
    }

    /// One step over a time, s, with inputs that vary linearly to `to`. Nothing has changed if there is no solution.
    fn step(&mut self, duration: f64, to: &Inputs) -> bool {
        let from = self.acting;
        let change = to.after(-1.0, &from);
        let k = GAMMA * duration;
        let law = self.law();
        let start = self.state;
        let inputs = from.after(GAMMA, &change);
        let stage = Stage {
            law: &law,
            inputs,
            held_thrust_ratio: self.held_thrust_ratio(),
        };
        let Some(first) = stage.solve(&start, k, &start) else {
            return false;
        };
        // base = y + h (1 − γ) f₁, with h γ f₁ = Y₁ − y.
        let share = (1.0 - GAMMA) / GAMMA;
        let ahead = |start: f64, first: f64| start + share * (first - start);
        let base = State {
            primary: ahead(start.primary, first.primary),
            secondary: ahead(start.secondary, first.secondary),
            log_ratio: ahead(start.log_ratio, first.log_ratio),
        };
        let inputs = *to;
        let stage = Stage {
            law: &law,
            inputs,
            held_thrust_ratio: self.held_thrust_ratio(),
        };
        let Some(second) = stage.solve(&base, k, &first) else {
            return false;
        };
        self.state = second;
        self.acting = *to;
        if self.parameters().secondary.axial == Axial::Held {
            self.update_thrust_ratio();
        }
        true
    }

    /// Steps to a time, s, at which the inputs are `to`.
    fn run_to(&mut self, end: f64, to: &Inputs) -> Result<(), StepFailure> {
        let mut longest = LONGEST;
        let whole = end - self.time;
        let mut left = whole;
        // A count, so that the loop ends whatever the tables and inputs are.
        let most = MOST_STEPS + MOST_PER_LONGEST * whole / LONGEST;
        let mut steps = 0.0;
        while left > INSTANT {
            let count = (left / longest - 1e-9).ceil().max(1.0);
            let duration = left / count;
            let share = if count > 1.0 { duration / left } else { 1.0 };
            let next = if count > 1.0 {
                self.acting.after(share, &to.after(-1.0, &self.acting))
            } else {
                *to
            };
            steps += 1.0;
            if self.step(duration, &next) {
                left = if count > 1.0 { left - duration } else { 0.0 };
                longest = (2.0 * longest).min(LONGEST);
            } else {
                longest = 0.5 * duration;
            }
            if longest < SHORTEST || steps > most {
                return Err(StepFailure::Discarded(format!(
                    "the equations have no solution at {} s in steps of {longest:.1e} s: set loads that the belt can carry",
                    end - left
                )));
            }
        }
        self.acting = *to;
        self.time = end;
        Ok(())
    }

    /// Advances over a communication step.
    fn advance_to(&mut self, step: &Step) -> Result<(), StepFailure> {
        for segment in step.inputs.segments() {
            self.acting = segment.at(segment.from);
            let end = segment.until.min(step.to);
            self.run_to(end, &segment.at(end))?;
        }
        Ok(())
    }

    /// Logs once that a cylinder opens its pulley.
    fn log_opening(&mut self, remarks: &mut Vec<Remark>) {
        for (force, pulley) in self.closing().into_iter().zip([Pulley::Primary, Pulley::Secondary]) {
            let (name, given) = (pulley.name(), self.acting.pulley(pulley));
            let is_free = self.parameters().pulley(pulley).axial == Axial::Force;
            if !self.opened && is_free && force <= 0.0 && force < given.clamping_force {
                self.opened = true;
                remarks.push(Remark {
                    warning: true,
                    text: format!(
                        "at {} s {name}.pressure = {} Pa opens the {name} pulley: with clampingForce = {} N, spring and rotating oil the \
                         force on its sheave is {force:.1} N",
                        self.time, given.pressure, given.clamping_force
                    ),
                });
            }
        }
    }

    /// Logs once each that the state is beyond the tables and that a pulley opens.
    fn log_outside(&mut self, remarks: &mut Vec<Remark>) {
        self.log_opening(remarks);
        if self.logged {
            return;
        }
        let frame = self.frame();
        if frame.place.outside {
            self.logged = true;
            remarks.push(Remark {
                warning: true,
                text: format!(
                    "the state is beyond the tables, whose values at the border are used: ratio {:.4}, primary speed {:.1} rad/s, \
                     secondary force {:.0} N; map.outside shows it from now on",
                    frame.ratio,
                    self.state.primary,
                    self.force()
                ),
            });
        }
    }

    /// Speeds of the primary and the secondary sheave at present, closing positive, m/s.
    fn sheave_velocities(&self, frame: &Frame, point: &Point) -> [f64; 2] {
        if self.parameters().holds_a_sheave() {
            return [0.0; 2];
        }
        let (rate, _) = self.law().shift(frame, point, &self.state, &self.acting);
        let [least, most] = self.radii.stops;
        let at_stop = self.state.log_ratio <= least && rate < 0.0 || self.state.log_ratio >= most && rate > 0.0;
        let rate = if at_stop { 0.0 } else { rate };
        let positions = self.radii.positions(self.state.log_ratio);
        positions.map(|(_, slope)| slope * rate)
    }

    fn read(&self) -> Readings {
        let law = self.law();
        let frame = self.frame();
        let force = self.force();
        let State { primary, secondary, .. } = self.state;
        let sliding = self.sliding(&frame);
        let point = law.point(&frame, sliding);
        let traction = point.traction;
        let torque = frame.torque * traction.value;
        let load = point.bearing_load();
        let lost = point.torque_loss();
        let on_secondary = frame.ratio * (torque - (primary / FADING_SPEED).tanh() * lost);
        let holding = point.thrust_ratio();
        let pulleys = [&self.parameters().primary, &self.parameters().secondary];
        let drag = [(pulleys[0], primary), (pulleys[1], secondary)]
            .map(|(pulley, speed)| pulley.drag.at(speed, [load, 0.0]).torque);
        let velocities = self.sheave_velocities(&frame, &point);
        let drags = law.rubbing(velocities);
        let axial = match pulleys[0].axial {
            Axial::Held => holding * force,
            Axial::Force => self.closing()[0] - drags[0],
        };
        let force = force - drags[1];
        let seal_loss = drags[0] * velocities[0] + drags[1] * velocities[1];
        let setpoint = |speed: f64, pulley: usize, from_belt: f64| {
            let (of, given) = (pulleys[pulley], [&self.acting.primary, &self.acting.secondary][pulley]);
            match of.drive {
                Drive::Torque => given.torque,
                Drive::Speed => of.inertia * (given.speed_setpoint - speed) / SPEED_LAG - from_belt + drag[pulley],
            }
        };
        let belt_powers = [torque * primary, -on_secondary * secondary];
        let shaft_powers = [belt_powers[0] + drag[0] * primary, belt_powers[1] + drag[1] * secondary];
        let shaft_loss = drag[0] * primary + drag[1] * secondary;
        let slip_speed = 1e-3;
        let pulley = |k: usize, speed: f64, radius: f64, shaft_torque: f64| PulleyOutputs {
            speed,
            radius,
            axial_force: [axial, force][k],
            clamping_force_total: [axial, force][k],
            sheave_velocity: velocities[k],
            flow: pulleys[k].cylinder.area * velocities[k],
            shaft_torque,
            external_torque: setpoint(speed, k, shaft_torque),
            power: belt_powers[k],
            ..PulleyOutputs::default()
        };
        let outputs = Outputs {
            thrust_ratio: if force < 1.0 { 0.0 } else { axial / force },
            belt_speed: 0.5 * frame.radius * (primary + frame.ratio * secondary),
            ratio_speed: if secondary == 0.0 { 0.0 } else { primary / secondary },
            ratio_geometric: frame.ratio,
            slip: if primary.abs() < slip_speed {
                0.0
            } else {
                (1.0 - secondary / primary * frame.ratio).clamp(-2.0, 2.0)
            },
            efficiency: efficiency(shaft_powers),
            belt_efficiency: efficiency(belt_powers),
            torque_utilisation: traction.value.abs(),
            macro_slip: traction.macro_slip,
            losses: Losses {
                // Maps have the belt's loss as a whole.
                other: belt_powers[0] + belt_powers[1],
                shafts: shaft_loss,
                seals: seal_loss,
                ..Losses::default()
            },
            stored_energy: 0.5 * (pulleys[0].inertia * primary * primary + pulleys[1].inertia * secondary * secondary),
            primary: pulley(0, primary, frame.radius, -torque),
            secondary: pulley(1, secondary, frame.ratio * frame.radius, on_secondary),
            ..Outputs::default()
        };
        Readings {
            outputs,
            outside: frame.place.outside,
        }
    }
}

/// Driven / driving power, 0 to 1; 0 without power flow.
fn efficiency(powers: [f64; 2]) -> f64 {
    let driving: f64 = powers.iter().filter(|power| **power > 0.0).sum();
    let driven: f64 = powers.iter().filter(|power| **power < 0.0).sum();
    if driving > 0.0 {
        (-driven / driving).min(1.0)
    } else {
        0.0
    }
}

/// Settings that do not fit each other.
fn check(settings: &Settings) -> Result<(), String> {
    if settings.parameters.holds_both_sheaves() {
        return Err(
            "primary.axial and secondary.axial are both Held: maps have no forces for that, one must be Force"
                .to_owned(),
        );
    }
    settings
        .parameters
        .validate_friction()
        .map_err(|error| error.to_string())
}

impl Unit for MapUnit {
    type Settings = Settings;
    type Readings = Readings;
    type Step = Step;

    const IDENTITY: Identity = Identity {
        name: "PushbeltMap",
        description: "Pushbelt CVT variator from maps of the detailed model: speeds of both shafts and ratio as states. SI units; \
                      torques are positive in the direction of positive speed.",
        version: env!("CARGO_PKG_VERSION"),
        author: "pushbelt",
        license: env!("CARGO_PKG_LICENSE"),
        generation_tool: concat!("pushbelt ", env!("CARGO_PKG_VERSION")),
        stop_time: 10.0,
        step_size: 1e-2,
        tolerance: 1e-4,
        longest_step: 1e3,
    };
    const INTERPOLATES_INPUTS: bool = true;

    fn table() -> Table<Settings, Readings> {
        settings::table()
    }

    fn load(resources: Option<&Path>) -> Result<Settings, String> {
        let resources = resources.ok_or("the importer names no folder of resources, and the tables are there")?;
        let tables = Tables::read(resources)?;
        Ok(Settings {
            parameters: tables.parameters.clone(),
            own: Some(Arc::new(tables)),
            ..Settings::default()
        })
    }

    fn data(settings: &Settings) -> Option<u128> {
        settings.own.as_ref().map(|tables| tables.hash)
    }

    fn check(settings: &Settings) -> Result<(), String> {
        check(settings)
    }

    fn start(settings: &Settings, _: &Experiment, remarks: &mut Vec<Remark>) -> Result<Self, String> {
        let mut unit = Self::blank_with(settings)?;
        unit.initialise(remarks);
        unit.log_outside(remarks);
        Ok(unit)
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn readings(&mut self, _: bool) -> &Readings {
        self.readings = self.read();
        &self.readings
    }

    fn begin(&mut self, to: f64, settings: &Settings, rates: Option<&Settings>) -> Result<Step, StepFailure> {
        let rates = rates.map_or(Inputs::ZERO, |rates| rates.inputs);
        let ramp = settings.parameters.solver.input_ramp;
        let inputs = InputProfile::new(ramp, [self.time, to], &self.acting, &settings.inputs, &rates);
        Ok(Step { to, inputs })
    }

    fn advance(&mut self, step: &mut Step, settings: &Settings, remarks: &mut Vec<Remark>) -> Result<(), StepFailure> {
        let friction = settings.parameters.friction.pulley;
        let own = std::mem::replace(&mut self.settings.parameters.friction.pulley, friction);
        let before = (self.state, self.time, self.acting, self.thrust_ratio);
        let advanced = self.advance_to(step);
        if advanced.is_err() {
            (self.state, self.time, self.acting, self.thrust_ratio) = before;
            self.settings.parameters.friction.pulley = own;
        }
        advanced?;
        self.log_outside(remarks);
        Ok(())
    }

    fn is_over(&self, step: &Step) -> bool {
        self.time >= step.to
    }

    fn end_at(&mut self, step: &mut Step, time: f64) {
        step.to = step.to.min(time.max(self.time));
    }

    fn blank(settings: &Settings, _: &Experiment) -> Result<Self, String> {
        Self::blank_with(settings)
    }

    fn serialize(&mut self, tape: &mut Tape<'_>) {
        let State {
            primary,
            secondary,
            log_ratio,
        } = &mut self.state;
        for speed in [primary, secondary] {
            tape.within(speed, -LARGEST, LARGEST);
        }
        let [least, most] = self.radii.stops;
        tape.within(log_ratio, least, most);
        tape.real(&mut self.time);
        let [least, most] = THRUST_RATIO;
        tape.within(&mut self.thrust_ratio, least, most);
        for value in self.acting.each_mut() {
            tape.within(value, -LARGEST, LARGEST);
        }
        tape.flag(&mut self.logged);
        tape.flag(&mut self.opened);
    }
}
