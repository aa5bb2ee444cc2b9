//! The unit of the FMU: start, steps, outputs, stored states.
//!
//! Steps are those of an L-stable method of second order (SDIRK2, γ = 1 − 1/√2), at most 10 ms long. Inputs are linear over each step.

use std::path::Path;
use std::sync::Arc;

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::solver::sdirk::GAMMA;
use pushbelt::unit::VariatorUnit;
use pushbelt::variator::run::InputProfile;
use pushbelt::variator::settings::{
    Axial, BEYOND_STOP, Drive, Inputs, Losses, Outputs, Parameters, PulleyOutputs, SPEED_LAG, bisected,
};
use pushbelt_fmi::Archive;
use pushbelt_fmi::table::Table;
use pushbelt_fmi::unit::{Experiment, Identity, Remark, StepFailure, Unit};

use crate::file::THRUST_RATIO;
use crate::law::{Frame, Law, Point, Radii, State};
use crate::settings::{self, Readings, Settings};
use crate::stage::Stage;
use crate::tables::Tables;
use crate::tuning::{LARGEST, LONGEST, MOST_PER_LONGEST, MOST_STEPS, SHORTEST};

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
    fn parameters(&self) -> &Parameters {
        &self.settings.parameters
    }

    fn drives(&self) -> (Drive, Drive) {
        (self.parameters().primary.drive, self.parameters().secondary.drive)
    }

    fn law(&self) -> Law<'_> {
        let held = self.parameters().secondary.axial == Axial::Held;
        Law {
            tables: &self.tables,
            radii: &self.radii,
            parameters: self.parameters(),
            held_thrust_ratio: held.then_some(self.thrust_ratio),
        }
    }

    fn frame(&self) -> Frame {
        self.law().frame(&self.state, &self.acting)
    }

    /// What the tables give in the present state.
    fn point(&self, frame: &Frame) -> Point {
        self.law().point(frame, frame.sliding(self.state.speeds))
    }

    /// Drag torques of the shafts, N·m.
    fn drags(&self, point: &Point) -> PerPulley<f64> {
        let drag = |j| {
            self.parameters()
                .pulley(j)
                .drag
                .at(self.state.speeds[j], [point.bearing_load, 0.0])
        };
        PerPulley::from_fn(|j| drag(j).torque)
    }

    fn update_thrust_ratio(&mut self) {
        self.thrust_ratio = self.point(&self.frame()).thrust_ratio;
    }

    /// The state at the start.
    fn initialise(&mut self, remarks: &mut Vec<Remark>) {
        let [least, most] = self.radii.stops;
        let initial = self.parameters().initial.clone();
        let wanted = initial.ratio.ln();
        self.state.log_ratio = wanted.clamp(least, most);
        if (self.state.log_ratio - wanted).abs() > BEYOND_STOP.ln() {
            let [least, most] = self.radii.stops.map(f64::exp);
            remarks.push(Remark::warning(format!(
                "initial.ratio = {} is beyond the end stops: {least:.4} to {most:.4}; the run starts at the stop",
                initial.ratio
            )));
        }
        self.state.speeds.primary = match self.drives().0 {
            Drive::Speed => self.acting.primary.speed_setpoint,
            Drive::Torque => initial.primary_speed,
        };
        let ([without_torque, ..], _) = self.tables.belt.at(&self.frame().place, 0.0);
        self.thrust_ratio = without_torque;
        let settled = self.settle();
        let settled = if initial.steady && initial.equilibrium && !self.parameters().holds_a_sheave() {
            self.balance()
        } else {
            settled
        };
        remarks.extend(settled.err().map(Remark::warning));
        self.update_thrust_ratio();
    }

    /// Sets the speed of the shaft that is not given at the present ratio: that of the steady slip, of the set point, or without slip.
    ///
    /// # Errors
    /// The reason why it is without slip though it should not be.
    fn settle(&mut self) -> Result<(), String> {
        let ratio = self.state.log_ratio.exp();
        let (drives, setpoint) = (self.drives(), self.acting.secondary.speed_setpoint);
        let speeds = &mut self.state.speeds;
        match drives {
            (_, Drive::Torque) => speeds.secondary = speeds.primary / ratio,
            (Drive::Torque, Drive::Speed) => {
                *speeds = PerPulley {
                    primary: setpoint * ratio,
                    secondary: setpoint,
                }
            }
            (Drive::Speed, Drive::Speed) => {
                speeds.secondary = setpoint;
                return Ok(());
            }
        }
        if !self.parameters().initial.steady || self.state.speeds.primary == 0.0 {
            return Ok(());
        }
        let (without, frame) = (self.state.speeds, self.frame());
        // Beyond the capacity the traction falls: only the rising part is searched.
        let law = self.law();
        let range = [-0.99, 0.99].map(|mut end: f64| {
            while law.traction(&frame, end * frame.speed).macro_slip && end.abs() > 1e-6 {
                end *= 0.98;
            }
            end
        });
        // Utilisation of the belt at a slip, less that at which this slip would be steady.
        let mut excess = |slip: f64| {
            // s = v/q; where the secondary speed is given, q is that of running speed.
            let speeds = &mut self.state.speeds;
            if drives.1 == Drive::Speed {
                speeds.primary = without.primary / (1.0 - slip * without.primary.signum());
            } else {
                speeds.secondary = (without.primary - slip * frame.speed / frame.radius) / ratio;
            }
            let frame = self.frame();
            self.point(&frame).traction.value - self.steady_torque(&frame) / frame.torque.max(1e-9)
        };
        if excess(range[0]) <= 0.0 && excess(range[1]) >= 0.0 {
            let slip = bisected(range, |slip| excess(slip) < 0.0);
            excess(slip);
            return Ok(());
        }
        self.state.speeds = without;
        let wanted = self.steady_torque(&frame) / frame.torque.max(1e-9);
        Err(format!(
            "the belt does not carry a torque utilisation of {wanted:.3}: the run starts without slip"
        ))
    }

    /// The torque T_P with which the slip stays constant, N·m: the free shafts accelerate together.
    fn steady_torque(&self, frame: &Frame) -> f64 {
        let point = self.point(frame);
        let (lost, i) = (point.torque_loss, frame.ratio);
        let drags = self.drags(&point);
        let [out, into] = Pulley::BOTH.map(|j| self.acting.pulley(j).torque - drags[j]);
        match self.drives() {
            (Drive::Torque, Drive::Speed) => into,
            (Drive::Speed, _) => lost - out / i,
            // (into − T)/J_P = i (out + i (T − lost))/J_S
            (Drive::Torque, Drive::Torque) => {
                let (j_p, j_s) = (self.parameters().primary.inertia, self.parameters().secondary.inertia);
                (into * j_s - i * (out - i * lost) * j_p) / (j_s + i * i * j_p)
            }
        }
    }

    /// Moves the ratio to the equilibrium of the clamping forces, or to an end stop.
    fn balance(&mut self) -> Result<(), String> {
        let found = bisected(self.radii.stops, |log_ratio| {
            self.state.log_ratio = log_ratio;
            // What a ratio on the way does not carry is of no interest.
            let _ = self.settle();
            self.update_thrust_ratio();
            // Too small a primary force: the ratio grows.
            let closing = self.frame().closing;
            closing.primary < self.thrust_ratio * closing.secondary
        });
        self.state.log_ratio = found;
        self.settle()
    }

    /// One step over a time, s, with inputs that vary linearly to `to`. Nothing has changed if there is no solution.
    fn step(&mut self, duration: f64, to: &Inputs) -> bool {
        let change = to.after(-1.0, &self.acting);
        let k = GAMMA * duration;
        let law = &self.law();
        let start = self.state;
        let stage = |inputs: Inputs| Stage { law, inputs };
        let Some(first) = stage(self.acting.after(GAMMA, &change)).solve(&start, k, &start) else {
            return false;
        };
        // base = y + h (1 − γ) f₁, with h γ f₁ = Y₁ − y.
        let share = (1.0 - GAMMA) / GAMMA;
        let ahead = |start: f64, first: f64| start + share * (first - start);
        let base = State {
            speeds: PerPulley::from_fn(|j| ahead(start.speeds[j], first.speeds[j])),
            log_ratio: ahead(start.log_ratio, first.log_ratio),
        };
        let Some(second) = stage(*to).solve(&base, k, &first) else {
            return false;
        };
        (self.state, self.acting) = (second, *to);
        if self.parameters().secondary.axial == Axial::Held {
            self.update_thrust_ratio();
        }
        true
    }

    /// Advances over a communication step.
    fn advance_to(&mut self, step: &Step) -> Result<(), StepFailure> {
        let inputs = &step.inputs;
        self.acting = inputs.at(self.time);
        for end in [inputs.kink.max(self.time).min(step.to), step.to] {
            // A count, so that the loop ends whatever the tables and inputs are.
            let most = MOST_STEPS + MOST_PER_LONGEST * (end - self.time) / LONGEST;
            let (mut longest, mut steps) = (LONGEST, 0.0);
            while end > self.time {
                let left = end - self.time;
                let count = (left / longest - 1e-9).ceil().max(1.0);
                let next = if count == 1.0 { end } else { self.time + left / count };
                steps += 1.0;
                if self.step(next - self.time, &inputs.at(next)) {
                    self.time = next;
                    longest = (2.0 * longest).min(LONGEST);
                } else {
                    longest = 0.5 * (next - self.time);
                }
                if longest < SHORTEST || steps > most {
                    return Err(StepFailure::Discarded(format!(
                        "the equations have no solution at {} s in steps of {longest:.1e} s: set loads that the belt can carry",
                        self.time
                    )));
                }
            }
            (self.acting, self.time) = (inputs.at(end), end);
        }
        Ok(())
    }

    /// Logs once each that a cylinder opens its pulley and that the state is beyond the tables.
    fn log_limits(&mut self, remarks: &mut Vec<Remark>) {
        let frame = self.frame();
        for j in [Pulley::Primary, Pulley::Secondary] {
            let is_free = self.parameters().pulley(j).axial == Axial::Force;
            if !self.opened
                && is_free
                && let Some(text) = self.acting.pulley(j).opening(j, self.time, frame.closing[j])
            {
                self.opened = true;
                remarks.push(Remark::warning(text));
            }
        }
        if frame.place.outside && !self.logged {
            self.logged = true;
            remarks.push(Remark::warning(format!(
                "the state is beyond the tables, whose values at the border are used: ratio {:.4}, primary speed {:.1} rad/s, \
                 secondary force {:.0} N; map.outside shows it from now on",
                frame.ratio, self.state.speeds.primary, frame.force
            )));
        }
    }

    /// Speeds of the sheaves at present, closing positive, m/s.
    fn sheave_velocities(&self, frame: &Frame, point: &Point) -> PerPulley<f64> {
        let (rate, _) = self.law().shift(frame, point);
        let ([least, most], log_ratio) = (self.radii.stops, self.state.log_ratio);
        let at_stop = log_ratio <= least && rate < 0.0 || log_ratio >= most && rate > 0.0;
        let rate = if at_stop { 0.0 } else { rate };
        frame.ways.map(|way| way * rate)
    }

    fn read(&self) -> Readings {
        let (frame, of) = (self.frame(), self.parameters());
        let (point, speeds) = (self.point(&frame), self.state.speeds);
        let torque = frame.torque * point.traction.value;
        // Torques of the shafts on the belt, and of their drag.
        let into = PerPulley {
            primary: torque,
            secondary: -frame.ratio * (torque - point.torque_loss),
        };
        let drags = self.drags(&point);
        let velocities = self.sheave_velocities(&frame, &point);
        let rubbing = self.law().rubbing(velocities);
        let axial = PerPulley {
            primary: match of.primary.axial {
                Axial::Held => point.thrust_ratio * frame.force,
                Axial::Force => frame.closing.primary - rubbing.primary,
            },
            secondary: frame.force - rubbing.secondary,
        };
        let sum = |of: &dyn Fn(Pulley) -> f64| of(Pulley::Primary) + of(Pulley::Secondary);
        let pulley = |j: Pulley| {
            let (of, given) = (of.pulley(j), self.acting.pulley(j));
            PulleyOutputs {
                speed: speeds[j],
                radius: match j {
                    Pulley::Primary => frame.radius,
                    Pulley::Secondary => frame.ratio * frame.radius,
                },
                axial_force: axial[j],
                clamping_force_total: axial[j],
                sheave_velocity: velocities[j],
                flow: of.cylinder.area * velocities[j],
                shaft_torque: -into[j],
                external_torque: match of.drive {
                    Drive::Torque => given.torque,
                    Drive::Speed => of.inertia * (given.speed_setpoint - speeds[j]) / SPEED_LAG + into[j] + drags[j],
                },
                power: into[j] * speeds[j],
                ..PulleyOutputs::default()
            }
        };
        let mut outputs = Outputs {
            belt_speed: 0.5 * frame.radius * (speeds.primary + frame.ratio * speeds.secondary),
            torque_utilisation: point.traction.value.abs(),
            macro_slip: point.traction.macro_slip,
            losses: Losses {
                // Maps have the belt's loss as a whole.
                other: sum(&|j| into[j] * speeds[j]),
                shafts: sum(&|j| drags[j] * speeds[j]),
                seals: sum(&|j| rubbing[j] * velocities[j]),
                ..Losses::default()
            },
            stored_energy: 0.5 * sum(&|j| of.pulley(j).inertia * speeds[j] * speeds[j]),
            primary: pulley(Pulley::Primary),
            secondary: pulley(Pulley::Secondary),
            ..Outputs::default()
        };
        outputs.set_quotients(PerPulley::from_fn(|j| -into[j] - drags[j]));
        let outside = frame.place.outside;
        Readings { outputs, outside }
    }
}

impl Unit for MapUnit {
    type Settings = Settings;
    type Readings = Readings;
    type Step = Step;

    const IDENTITY: Identity = Identity {
        name: "PushbeltMap",
        description: "Pushbelt CVT variator from maps of the detailed model: speeds of both shafts and ratio as states. SI units; \
                      torques are positive in the direction of positive speed.",
        author: "pushbelt",
        stop_time: 10.0,
        step_size: 1e-2,
        ..VariatorUnit::IDENTITY
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
        if settings.parameters.holds_both_sheaves() {
            let text =
                "primary.axial and secondary.axial are both Held: maps have no forces for that, one must be Force";
            return Err(text.to_owned());
        }
        let checked = settings.parameters.validate_friction();
        checked.map_err(|error| error.to_string())
    }

    fn start(settings: &Settings, experiment: &Experiment, remarks: &mut Vec<Remark>) -> Result<Self, String> {
        let mut unit = Self::blank(settings, experiment)?;
        unit.initialise(remarks);
        unit.log_limits(remarks);
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
        let friction = self.settings.parameters.friction.pulley;
        let before = (self.state, self.time, self.acting, self.thrust_ratio);
        self.settings.parameters.friction.pulley = settings.parameters.friction.pulley;
        let advanced = self.advance_to(step);
        if advanced.is_err() {
            (self.state, self.time, self.acting, self.thrust_ratio) = before;
            self.settings.parameters.friction.pulley = friction;
        }
        advanced?;
        self.log_limits(remarks);
        Ok(())
    }

    fn is_over(&self, step: &Step) -> bool {
        self.time >= step.to
    }

    fn end_at(&mut self, step: &mut Step, time: f64) {
        step.to = step.to.min(time.max(self.time));
    }

    fn blank(settings: &Settings, _: &Experiment) -> Result<Self, String> {
        let tables = settings.own.clone().ok_or("the unit has no tables")?;
        Self::check(settings)?;
        Ok(Self {
            tables,
            radii: Arc::new(Radii::new(&settings.parameters)?),
            settings: settings.clone(),
            state: State::default(),
            time: 0.0,
            acting: settings.inputs,
            thrust_ratio: 1.0,
            logged: false,
            opened: false,
            readings: Readings::default(),
        })
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        let speeds = &mut self.state.speeds;
        for speed in [&mut speeds.primary, &mut speeds.secondary] {
            archive.within(speed, -LARGEST, LARGEST);
        }
        let [least, most] = self.radii.stops;
        archive.within(&mut self.state.log_ratio, least, most);
        archive.real(&mut self.time);
        let [least, most] = THRUST_RATIO;
        archive.within(&mut self.thrust_ratio, least, most);
        for value in self.acting.each_mut() {
            archive.within(value, -LARGEST, LARGEST);
        }
        archive.flag(&mut self.logged);
        archive.flag(&mut self.opened);
    }
}
