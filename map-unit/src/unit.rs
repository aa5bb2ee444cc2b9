//! The unit of the FMU: steps, outputs, stored states.
//!
//! Steps are those of an L-stable method of second order (SDIRK2, γ = 1 − 1/√2), at most 10 ms long. Inputs are linear over each step.

use std::path::Path;
use std::sync::Arc;

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::solver::sdirk::GAMMA;
use pushbelt::unit::VariatorUnit;
use pushbelt::variator::run::InputProfile;
use pushbelt::variator::settings::{Axial, Drive, Inputs, Losses, Outputs, PulleyOutputs, SPEED_LAG};
use pushbelt_fmi::Archive;
use pushbelt_fmi::table::Table;
use pushbelt_fmi::unit::{Experiment, Identity, Remark, Unit};

use crate::file::THRUST_RATIO;
use crate::law::{Acting, Frame, Law, Point, State};
use crate::settings::{self, Readings, Settings};
use crate::tables::Tables;
use crate::tuning::{LARGEST, LONGEST, MOST_PER_LONGEST, MOST_STEPS, SHORTEST};

/// A variator from maps.
#[derive(Clone, Debug)]
pub struct MapUnit {
    pub(crate) law: Law,
    pub(crate) state: State,
    time: f64,
    /// What acts at the present time; the thrust ratio is that of the last step.
    pub(crate) acting: Acting,
    /// Whether it has been logged that the state is beyond the tables, and that a pressure opens a pulley.
    logged: bool,
    opened: bool,
    readings: Readings,
}

impl MapUnit {
    /// Frame, and what the tables give, in the present state.
    pub(crate) fn present(&self) -> (Frame, Point) {
        let frame = self.law.frame(&self.state, &self.acting);
        (frame, self.law.point(&frame, frame.sliding(self.state.speeds)))
    }

    /// One step over a time, s, with inputs that vary linearly to `to`. Nothing has changed if there is no solution.
    fn step(&mut self, duration: f64, to: &Inputs) -> Option<()> {
        let (start, acting, k) = (self.state, self.acting.inputs, GAMMA * duration);
        let change = to.after(-1.0, &acting);
        let stage =
            |inputs, base: &State, guess: &State| self.law.stage(&Acting { inputs, ..self.acting }, base, k, guess);
        let first = stage(acting.after(GAMMA, &change), &start, &start)?;
        // base = y + h (1 − γ) f₁, with h γ f₁ = Y₁ − y.
        let share = (1.0 - GAMMA) / GAMMA;
        let ahead = |start: f64, first: f64| start + share * (first - start);
        let base = State {
            speeds: PerPulley::from_fn(|j| ahead(start.speeds[j], first.speeds[j])),
            log_ratio: ahead(start.log_ratio, first.log_ratio),
        };
        let second = stage(*to, &base, &first)?;
        (self.state, self.acting.inputs) = (second, *to);
        if self.law.parameters.secondary.axial == Axial::Held {
            self.acting.thrust_ratio = self.present().1.thrust_ratio;
        }
        Some(())
    }

    /// Advances over a communication step.
    fn advance_to(&mut self, to: f64, inputs: &InputProfile) -> Result<(), String> {
        self.acting.inputs = inputs.at(self.time);
        for end in [inputs.kink.max(self.time).min(to), to] {
            // A count, so that the loop ends whatever the tables and inputs are.
            let most = MOST_STEPS + MOST_PER_LONGEST * (end - self.time) / LONGEST;
            let (mut longest, mut steps) = (LONGEST, 0.0);
            while end > self.time {
                let left = end - self.time;
                let count = (left / longest - 1e-9).ceil().max(1.0);
                let next = if count == 1.0 { end } else { self.time + left / count };
                steps += 1.0;
                if self.step(next - self.time, &inputs.at(next)).is_some() {
                    self.time = next;
                    longest = (2.0 * longest).min(LONGEST);
                } else {
                    longest = 0.5 * (next - self.time);
                }
                if longest < SHORTEST || steps > most {
                    return Err(format!(
                        "the equations have no solution at {} s in steps of {longest:.1e} s: set loads that the belt can carry",
                        self.time
                    ));
                }
            }
            (self.acting.inputs, self.time) = (inputs.at(end), end);
        }
        Ok(())
    }

    /// Logs once each that a cylinder opens its pulley and that the state is beyond the tables.
    fn log_limits(&mut self, remarks: &mut Vec<Remark>) {
        let frame = self.law.frame(&self.state, &self.acting);
        let opening = || {
            self.law
                .parameters
                .opening(&self.acting.inputs, frame.closing, self.time)
        };
        if let Some(text) = (!self.opened).then(opening).flatten() {
            self.opened = true;
            remarks.push(Remark::warning(text));
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
        let (rate, _) = self.law.shift(frame, point);
        let ([least, most], log_ratio) = (self.law.radii.stops, self.state.log_ratio);
        let at_stop = log_ratio <= least && rate < 0.0 || log_ratio >= most && rate > 0.0;
        frame.ways.map(|way| if at_stop { 0.0 } else { way * rate })
    }

    fn read(&self) -> Readings {
        let ((frame, point), speeds, of) = (self.present(), self.state.speeds, &self.law.parameters);
        let torque = frame.torque * point.traction.value;
        // Torques of the shafts on the belt, and of their drag.
        let into = PerPulley {
            primary: torque,
            secondary: -frame.ratio * (torque - point.torque_loss),
        };
        let drags = self.law.drags(speeds, &point).map(|drag| drag.torque);
        let velocities = self.sheave_velocities(&frame, &point);
        let rubbing = self.law.rubbing(velocities);
        let axial = PerPulley {
            primary: match of.primary.axial {
                Axial::Held => point.thrust_ratio * frame.force,
                Axial::Force => frame.closing.primary - rubbing.primary,
            },
            secondary: frame.force - rubbing.secondary,
        };
        let sum = |of: &dyn Fn(Pulley) -> f64| of(Pulley::Primary) + of(Pulley::Secondary);
        let pulley = |j: Pulley, radius: f64| {
            let (of, given) = (of.pulley(j), self.acting.inputs.pulley(j));
            PulleyOutputs {
                speed: speeds[j],
                radius,
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
            primary: pulley(Pulley::Primary, frame.radius),
            secondary: pulley(Pulley::Secondary, frame.ratio * frame.radius),
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
    /// The inputs over it.
    type Step = InputProfile;

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

    fn begin(&mut self, to: f64, settings: &Settings, rates: Option<&Settings>) -> Result<InputProfile, String> {
        let rates = rates.map_or(Inputs::ZERO, |rates| rates.inputs);
        let (ramp, present) = (settings.parameters.solver.input_ramp, &self.acting.inputs);
        let span = [self.time, to];
        Ok(InputProfile::new(ramp, span, present, &settings.inputs, &rates))
    }

    fn advance(
        &mut self,
        to: f64,
        inputs: &mut InputProfile,
        settings: &Settings,
        remarks: &mut Vec<Remark>,
    ) -> Result<(), String> {
        let wanted = settings.parameters.friction.pulley;
        let friction = std::mem::replace(&mut self.law.parameters.friction.pulley, wanted);
        let before = (self.state, self.time, self.acting);
        let advanced = self.advance_to(to, inputs);
        if advanced.is_err() {
            (self.state, self.time, self.acting) = before;
            self.law.parameters.friction.pulley = friction;
        }
        advanced?;
        self.log_limits(remarks);
        Ok(())
    }

    fn blank(settings: &Settings, _: &Experiment) -> Result<Self, String> {
        Self::check(settings)?;
        Ok(Self {
            law: Law::new(settings)?,
            state: State::default(),
            time: 0.0,
            acting: Acting {
                inputs: settings.inputs,
                thrust_ratio: 1.0,
            },
            logged: false,
            opened: false,
            readings: Readings::default(),
        })
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        let PerPulley { primary, secondary } = &mut self.state.speeds;
        archive.within(primary, -LARGEST, LARGEST);
        archive.within(secondary, -LARGEST, LARGEST);
        let [least, most] = self.law.radii.stops;
        archive.within(&mut self.state.log_ratio, least, most);
        archive.real(&mut self.time);
        let [least, most] = THRUST_RATIO;
        archive.within(&mut self.acting.thrust_ratio, least, most);
        for value in self.acting.inputs.each_mut() {
            archive.within(value, -LARGEST, LARGEST);
        }
        archive.flag(&mut self.logged);
        archive.flag(&mut self.opened);
    }
}
