//! The state at the start of a run.

use pushbelt::pulley::PerPulley;
use pushbelt::variator::settings::{Axial, BEYOND_STOP, Drive, bisected};
use pushbelt_fmi::unit::Message;

use crate::tuning::{START_ITERATIONS, START_TOLERANCE};
use crate::unit::MapUnit;

impl MapUnit {
    /// Sets the state at the start, or returns the reason why there is none.
    pub(crate) fn initialise(&mut self, remarks: &mut Vec<Message>) -> Result<(), String> {
        let initial = self.law.parameters.initial.clone();
        let ratio = initial.ratio;
        let (least, most) = self.law.stops.clone().into_inner();
        self.state.log_ratio = ratio.ln().clamp(least, most);
        if (self.state.log_ratio - ratio.ln()).abs() > BEYOND_STOP.ln() {
            let [least, most] = [least, most].map(f64::exp);
            remarks.push(Message::warning(format!(
                "initial.ratio = {ratio} is beyond the end stops: {least:.4} to {most:.4}; the run starts at the stop"
            )));
        }
        self.state.speeds.primary = match self.law.parameters.primary.drive {
            Drive::Speed => self.inputs.primary.speed_setpoint,
            Drive::Torque => initial.primary_speed,
        };
        let [thrust, ..] = self.law.tables.belt.interpolate(&self.present().position, 0, 0.0);
        self.state.thrust_ratio = thrust.value;
        let mut settled = self.solve_equilibrium();
        // The force on a held secondary sheave follows from the thrust ratio, which depends on the
        // slip.
        if self.law.parameters.secondary.axial == Axial::Held {
            for _ in 0..START_ITERATIONS {
                let found = self.present().thrust_ratio;
                if (found - self.state.thrust_ratio).abs() < START_TOLERANCE {
                    break;
                }
                self.state.thrust_ratio = found;
                settled = self.solve_equilibrium();
            }
        }
        if initial.steady && initial.equilibrium && !self.law.parameters.holds_a_sheave() {
            settled = self.balance();
        }
        match settled {
            Err(why) if initial.strict => {
                return Err(format!("{why}; with initial.strict = true this start is an error"));
            }
            other => remarks.extend(other.err().map(Message::warning)),
        }
        self.state.thrust_ratio = self.present().thrust_ratio;
        Ok(())
    }

    /// Moves the ratio to the equilibrium of the clamping forces, or to an end stop.
    fn balance(&mut self) -> Result<(), String> {
        self.state.log_ratio = bisected(self.law.stops.clone(), |log_ratio| {
            self.state.log_ratio = log_ratio;
            // At such a ratio the belt may slip through.
            let _ = self.solve_equilibrium();
            let point = self.present();
            // Under too small a primary force the ratio grows.
            point.clamping.primary < point.thrust_ratio * point.clamping.secondary
        });
        self.solve_equilibrium()
    }

    /// Sets the speed of the free shaft at the present ratio: with the steady slip, of the set
    /// point, or without slip. An error is the reason why there is no steady slip.
    fn solve_equilibrium(&mut self) -> Result<(), String> {
        let of = &self.law.parameters;
        let [primary_led, secondary_led] =
            [&of.primary, &of.secondary].map(|pulley| pulley.drive == Drive::Speed);
        let (steady, ratio) = (of.initial.steady, self.state.log_ratio.exp());
        let speeds = &mut self.state.speeds;
        if secondary_led {
            speeds.secondary = self.inputs.secondary.speed_setpoint;
        }
        match (primary_led, secondary_led) {
            (true, true) => return Ok(()),
            (false, true) => speeds.primary = speeds.secondary * ratio,
            (_, false) => speeds.secondary = speeds.primary / ratio,
        }
        if !steady || speeds.primary == 0.0 {
            return Ok(());
        }
        let (without, point) = (self.state.speeds, self.present());
        // Utilisation at a slip less that at which it is steady, and whether the belt slips
        // through.
        let mut excess = |slip: f64| {
            // s = v/q; where the secondary speed is given, q is that of running speed.
            let speeds = &mut self.state.speeds;
            if secondary_led {
                speeds.primary = without.primary / (1.0 - slip * without.primary.signum());
            } else {
                speeds.secondary = (without.primary - slip * point.speed / point.radius) / ratio;
            }
            let point = self.present();
            (point.traction.value - self.steady_utilisation(), point.macro_slip())
        };
        // Beyond the capacity the traction falls: only the rising part is searched.
        let slip = bisected(-0.99..=0.99, |slip| match excess(slip) {
            (_, true) => slip < 0.0,
            (excess, false) => excess < 0.0,
        });
        if excess(slip).0.abs() < START_TOLERANCE {
            return Ok(());
        }
        self.state.speeds = without;
        let wanted = self.steady_utilisation();
        Err(format!(
            "the belt does not carry a torque utilisation of {wanted:.3}: the run starts without slip"
        ))
    }

    /// The utilisation with which the slip stays constant: the free shafts accelerate together.
    fn steady_utilisation(&self) -> f64 {
        let point = self.present();
        let drags = self.law.drags(&point);
        let mut torques = PerPulley::from_fn(|j| self.inputs.pulley(j).torque - drags[j].torque);
        torques.secondary -= point.ratio * point.torque_loss;
        let of_belt = self.law.parameters.steady_torque(torques, point.ratio);
        -of_belt.unwrap_or_default() / point.full_slip.max(1e-9)
    }
}
