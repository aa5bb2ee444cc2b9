//! The state at the start of a run.

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::variator::settings::{BEYOND_STOP, Drive, bisected};
use pushbelt_fmi::unit::Remark;

use crate::tuning::TOLERANCE;
use crate::unit::MapUnit;

impl MapUnit {
    fn drives(&self) -> (Drive, Drive) {
        let of = &self.law.parameters;
        (of.primary.drive, of.secondary.drive)
    }

    /// Sets the state at the start.
    pub(crate) fn initialise(&mut self, remarks: &mut Vec<Remark>) {
        let [least, most] = self.law.radii.stops;
        let initial = self.law.parameters.initial.clone();
        let wanted = initial.ratio.ln();
        self.state.log_ratio = wanted.clamp(least, most);
        if (self.state.log_ratio - wanted).abs() > BEYOND_STOP.ln() {
            remarks.push(Remark::warning(format!(
                "initial.ratio = {} is beyond the end stops: {:.4} to {:.4}; the run starts at the stop",
                initial.ratio,
                least.exp(),
                most.exp()
            )));
        }
        self.state.speeds.primary = match self.drives().0 {
            Drive::Speed => self.acting.inputs.primary.speed_setpoint,
            Drive::Torque => initial.primary_speed,
        };
        let place = self.law.frame(&self.state, &self.acting).place;
        let ([without_torque, ..], _) = self.law.tables.belt.at(&place, 0.0);
        self.acting.thrust_ratio = without_torque;
        let mut settled = self.settle();
        if initial.steady && initial.equilibrium && !self.law.parameters.holds_a_sheave() {
            settled = self.balance();
        }
        remarks.extend(settled.err().map(Remark::warning));
        self.acting.thrust_ratio = self.present().1.thrust_ratio;
    }

    /// Moves the ratio to the equilibrium of the clamping forces, or to an end stop.
    fn balance(&mut self) -> Result<(), String> {
        self.state.log_ratio = bisected(self.law.radii.stops, |log_ratio| {
            self.state.log_ratio = log_ratio;
            // What a ratio on the way does not carry is of no interest.
            let _ = self.settle();
            let (frame, point) = self.present();
            // Too small a primary force: the ratio grows.
            frame.closing.primary < point.thrust_ratio * frame.closing.secondary
        });
        self.settle()
    }

    /// Sets the speed of the shaft that is not given at the present ratio: that of the steady slip, of the set point, or without slip.
    ///
    /// # Errors
    /// The reason why it is without slip though it should not be.
    fn settle(&mut self) -> Result<(), String> {
        let (drives, setpoint) = (self.drives(), self.acting.inputs.secondary.speed_setpoint);
        let ratio = self.state.log_ratio.exp();
        let speeds = &mut self.state.speeds;
        match drives {
            (_, Drive::Torque) => speeds.secondary = speeds.primary / ratio,
            (primary, Drive::Speed) => {
                speeds.secondary = setpoint;
                if primary == Drive::Speed {
                    return Ok(());
                }
                speeds.primary = setpoint * ratio;
            }
        }
        if !self.law.parameters.initial.steady || speeds.primary == 0.0 {
            return Ok(());
        }
        let (without, (frame, _)) = (self.state.speeds, self.present());
        // Utilisation of the belt at a slip less that at which this slip would be steady, and whether the belt slips through.
        let mut excess = |slip: f64| {
            // s = v/q; where the secondary speed is given, q is that of running speed.
            let speeds = &mut self.state.speeds;
            if drives.1 == Drive::Speed {
                speeds.primary = without.primary / (1.0 - slip * without.primary.signum());
            } else {
                speeds.secondary = (without.primary - slip * frame.speed / frame.radius) / ratio;
            }
            let traction = self.present().1.traction;
            (traction.value - self.steady_utilisation(), traction.macro_slip)
        };
        // Beyond the capacity the traction falls: only the rising part is searched.
        let slip = bisected([-0.99, 0.99], |slip| match excess(slip) {
            (_, true) => slip < 0.0,
            (excess, false) => excess < 0.0,
        });
        if excess(slip).0.abs() < TOLERANCE {
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
        let (frame, point) = self.present();
        let (lost, i, of) = (point.torque_loss, frame.ratio, &self.law.parameters);
        let drags = self.law.drags(self.state.speeds, &point);
        let PerPulley {
            primary: into,
            secondary: out,
        } = PerPulley::from_fn(|j: Pulley| self.acting.inputs.pulley(j).torque - drags[j].torque);
        let torque = match self.drives() {
            (Drive::Torque, Drive::Speed) => into,
            (Drive::Speed, _) => lost - out / i,
            // (into − T)/J_P = i (out + i (T − lost))/J_S
            (Drive::Torque, Drive::Torque) => {
                let (j_p, j_s) = (of.primary.inertia, of.secondary.inertia);
                (into * j_s - i * (out - i * lost) * j_p) / (j_s + i * i * j_p)
            }
        };
        torque / frame.torque.max(1e-9)
    }
}
