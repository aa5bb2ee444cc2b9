//! The unit of the FMU: steps, outputs, stored states.
//!
//! Steps are those of an L-stable method of second order (SDIRK2, γ = 1 − 1/√2), at most 10 ms
//! long, with linear inputs.

use std::path::Path;
use std::sync::Arc;

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::solver::sdirk::GAMMA;
use pushbelt::unit::VariatorUnit;
use pushbelt::variator::run::InputProfile;
use pushbelt::variator::settings::{Axial, Drive, Inputs, Losses, Outputs, PulleyOutputs, SPEED_LAG};
use pushbelt_fmi::Archive;
use pushbelt_fmi::table::Table;
use pushbelt_fmi::unit::{Experiment, Identity, Message, Unit};

use crate::file::THRUST_RATIO;
use crate::law::{Law, Point, State};
use crate::settings::{self, Readings, Settings};
use crate::tables::Tables;
use crate::tuning::{LONGEST, MAX_STORED_INPUT, MAX_STORED_SPEED, MOST_PER_LONGEST, MOST_STEPS, SHORTEST};

/// A variator from maps.
#[derive(Clone, Debug)]
pub struct MapUnit {
    pub(crate) law: Law,
    pub(crate) state: State,
    time: f64,
    /// Inputs at the present time.
    pub(crate) inputs: Inputs,
    /// Whether it was logged that the state is beyond the tables, that a pressure opens a pulley,
    /// and that one acts on no area.
    outside: bool,
    opened: bool,
    idle: PerPulley<bool>,
    readings: Readings,
}

impl MapUnit {
    /// Loads and values of the tables in the present state.
    pub(crate) fn present(&self) -> Point {
        self.law.point(&self.state, &self.inputs)
    }

    /// One step over a time, s, with inputs that vary linearly to `to`. Nothing has changed if
    /// there is no solution.
    fn step(&mut self, duration: f64, to: &Inputs) -> Option<()> {
        let (start, k) = (self.state, GAMMA * duration);
        let change = to.after(-1.0, &self.inputs);
        let first = self.law.stage(&self.inputs.after(GAMMA, &change), &start, k, &start)?;
        // base = y + h (1 − γ) f₁, with h γ f₁ = Y₁ − y.
        let extrapolated = |start: f64, first: f64| start + (1.0 - GAMMA) / GAMMA * (first - start);
        let base = State {
            speeds: PerPulley::from_fn(|j| extrapolated(start.speeds[j], first.speeds[j])),
            log_ratio: extrapolated(start.log_ratio, first.log_ratio),
            ..start
        };
        (self.state, self.inputs) = (self.law.stage(to, &base, k, &first)?, *to);
        if self.law.parameters.secondary.axial == Axial::Held {
            self.state.thrust_ratio = self.present().thrust_ratio;
        }
        Some(())
    }

    fn advance_to(&mut self, to: f64, inputs: &InputProfile) -> Result<(), String> {
        self.inputs = inputs.evaluate(self.time);
        for end in [inputs.kink.max(self.time).min(to), to] {
            // The loop ends with any tables and inputs.
            let most = MOST_STEPS + MOST_PER_LONGEST * (end - self.time) / LONGEST;
            let (mut longest, mut steps) = (LONGEST, 0.0);
            while end > self.time {
                let rest = end - self.time;
                let count = (rest / longest - 1e-9).ceil().max(1.0);
                let next = if count == 1.0 { end } else { self.time + rest / count };
                steps += 1.0;
                if self.step(next - self.time, &inputs.evaluate(next)).is_some() {
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
        }
        Ok(())
    }

    /// Sets the readings, and logs each of the three warnings once.
    fn observe(&mut self, remarks: &mut Vec<Message>) {
        let (point, of) = (self.present(), &self.law.parameters);
        let opens = of.opening_pressure(&self.inputs, point.clamping, self.time);
        let opens = opens.filter(|_| !self.opened);
        let outside = (point.position.outside && !self.outside).then(|| {
            format!(
                "the state is beyond the tables, whose values at the border are used: ratio {:.4}, primary speed {:.1} rad/s, \
                 secondary force {:.0} N; map.outside shows it from now on",
                point.ratio, self.state.speeds.primary, point.force
            )
        });
        (self.opened, self.outside) = (self.opened | opens.is_some(), self.outside | outside.is_some());
        let idle = of.idle_pressures(&self.inputs, &mut self.idle, self.time);
        remarks.extend([idle, opens, outside].into_iter().flatten().map(Message::warning));
        self.readings = self.read(&point);
    }

    fn read(&self, point: &Point) -> Readings {
        let (speeds, of) = (self.state.speeds, &self.law.parameters);
        // Torques of the shafts on the belt, and of their drag.
        let into = PerPulley {
            primary: point.torque(),
            secondary: -point.ratio * (point.torque() - point.torque_loss),
        };
        let drags = self.law.drags(point).map(|drag| drag.torque);
        let rate = self.law.shift(point).value;
        let (stops, log_ratio) = (&self.law.stops, &self.state.log_ratio);
        let at_stop = log_ratio <= stops.start() && rate < 0.0 || log_ratio >= stops.end() && rate > 0.0;
        // As in the detailed unit the sheaves start at rest.
        let rests = at_stop || self.time == 0.0;
        let velocities = point.ways.map(|way| if rests { 0.0 } else { way * rate });
        let seal_friction = PerPulley::from_fn(|j| of.seal_friction(j, velocities[j]));
        let axial = PerPulley {
            primary: match of.primary.axial {
                Axial::Held => point.thrust_ratio * point.force,
                Axial::Force => point.clamping.primary - seal_friction.primary,
            },
            secondary: point.force - seal_friction.secondary,
        };
        let sum = |of: &dyn Fn(Pulley) -> f64| of(Pulley::Primary) + of(Pulley::Secondary);
        let pulley = |j: Pulley, radius: f64| {
            let (of, given) = (of.pulley(j), self.inputs.pulley(j));
            PulleyOutputs {
                speed: speeds[j],
                radius,
                axial_force: axial[j],
                clamping_force_total: axial[j],
                sheave_velocity: velocities[j],
                flow: of.cylinder.area * velocities[j],
                volume: of.cylinder.area * point.positions[j],
                shaft_torque: -into[j],
                external_torque: match of.drive {
                    Drive::Torque => given.torque,
                    Drive::Speed => {
                        of.inertia * (given.speed_setpoint - speeds[j]) / SPEED_LAG + into[j] + drags[j]
                    }
                },
                power: into[j] * speeds[j],
                ..PulleyOutputs::default()
            }
        };
        let mut outputs = Outputs {
            belt_speed: 0.5 * point.radius * (speeds.primary + point.ratio * speeds.secondary),
            torque_utilisation: point.traction.value.abs(),
            macro_slip: point.macro_slip(),
            past_peak: point.macro_slip(),
            losses: Losses {
                // Maps have the belt's loss as a whole.
                other: sum(&|j| into[j] * speeds[j]),
                shafts: sum(&|j| drags[j] * speeds[j]),
                seals: sum(&|j| seal_friction[j] * velocities[j]),
                ..Losses::default()
            },
            stored_energy: 0.5 * sum(&|j| of.pulley(j).inertia * speeds[j] * speeds[j]),
            primary: pulley(Pulley::Primary, point.radius),
            secondary: pulley(Pulley::Secondary, point.ratio * point.radius),
            ..Outputs::default()
        };
        outputs.set_quotients(PerPulley::from_fn(|j| -into[j] - drags[j]));
        let outside = point.position.outside;
        Readings {
            outputs,
            outside,
            holding_thrust_ratio: point.thrust_ratio,
        }
    }
}

impl Unit for MapUnit {
    type Settings = Settings;
    type Readings = Readings;
    type Step = InputProfile;

    const IDENTITY: Identity = Identity {
        name: "PushbeltMap",
        description: "Pushbelt CVT variator from maps of the detailed model: speeds of both shafts and ratio as states. SI units; \
                      torques are positive in the direction of positive speed.",
        stop_time: 10.0,
        step_size: 1e-2,
        ..VariatorUnit::IDENTITY
    };
    const INTERPOLATES_INPUTS: bool = true;

    fn table() -> Table<Settings, Readings> {
        settings::table()
    }

    fn load(resources: Option<&Path>) -> Result<Settings, String> {
        let resources =
            resources.ok_or("the importer names no folder of resources, and the tables are there")?;
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
            let both = "primary.axial and secondary.axial are both Held";
            return Err(format!("{both}: maps have no forces for that, one must be Force"));
        }
        let checked = settings.parameters.validate_friction();
        checked.map_err(|error| error.to_string())
    }

    fn start(
        settings: &Settings,
        experiment: &Experiment,
        remarks: &mut Vec<Message>,
    ) -> Result<Self, String> {
        let mut unit = Self::blank(settings, experiment)?;
        unit.initialise(remarks)?;
        unit.observe(remarks);
        Ok(unit)
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn readings(&mut self, _: bool) -> &Readings {
        &self.readings
    }

    fn begin(
        &mut self,
        to: f64,
        settings: &Settings,
        rates: Option<&Settings>,
    ) -> Result<InputProfile, String> {
        let rates = rates.map_or(Inputs::ZERO, |rates| rates.inputs);
        let (ramp, span) = (settings.parameters.solver.input_ramp, [self.time, to]);
        Ok(InputProfile::new(ramp, span, &self.inputs, &settings.inputs, &rates))
    }

    fn advance(
        &mut self,
        to: f64,
        inputs: &mut InputProfile,
        settings: &Settings,
        remarks: &mut Vec<Message>,
    ) -> Result<(), String> {
        let before = self.clone();
        let wanted = &settings.parameters.friction;
        let tuned = self.law.parameters.set_friction(wanted.pulley, wanted.ring);
        let advanced = tuned
            .map_err(|error| error.to_string())
            .and_then(|_| self.advance_to(to, inputs));
        if advanced.is_err() {
            *self = before;
            return advanced;
        }
        self.observe(remarks);
        Ok(())
    }

    fn blank(settings: &Settings, _: &Experiment) -> Result<Self, String> {
        Self::check(settings)?;
        Ok(Self {
            law: Law::new(settings)?,
            state: State {
                thrust_ratio: 1.0,
                ..State::default()
            },
            time: 0.0,
            inputs: settings.inputs,
            outside: false,
            opened: false,
            idle: PerPulley::default(),
            readings: Readings::default(),
        })
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        let PerPulley { primary, secondary } = &mut self.state.speeds;
        archive.bounded_real(primary, -MAX_STORED_SPEED, MAX_STORED_SPEED);
        archive.bounded_real(secondary, -MAX_STORED_SPEED, MAX_STORED_SPEED);
        let (least, most) = self.law.stops.clone().into_inner();
        archive.bounded_real(&mut self.state.log_ratio, least, most);
        archive.real(&mut self.time);
        let (least, most) = THRUST_RATIO.into_inner();
        archive.bounded_real(&mut self.state.thrust_ratio, least, most);
        for value in self.inputs.each_mut() {
            archive.bounded_real(value, -MAX_STORED_INPUT, MAX_STORED_INPUT);
        }
        archive.flag(&mut self.outside);
        archive.flag(&mut self.opened);
        self.law.parameters.serialize(archive);
        self.idle.each_mut().into_iter().for_each(|said| archive.flag(said));
        if archive.is_reading() {
            self.readings = self.read(&self.present());
        }
    }
}
