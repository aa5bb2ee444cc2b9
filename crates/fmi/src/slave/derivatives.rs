//! Derivatives of inputs and outputs with respect to time.

use super::instance::Slave;
use super::outcome::{Outcome, refused};
use super::values::{find, real_access};
use crate::log::Status;
use crate::snapshot::zero_rates;
use crate::state::Call;
use crate::table::{Access, Causality, Inadmissible};
use crate::unit::Unit;

impl<U: Unit> Slave<U> {
    /// `fmi2SetRealInputDerivatives`: the inputs change in proportion to time during the next step, and are held again
    /// after it. Either all derivatives are taken or none.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Status {
        self.call("fmi2SetRealInputDerivatives", |slave| {
            slave.allow(Call::Set)?;
            for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
                slave.check_input_derivative(reference, order, value)?;
            }
            let rates = slave.now.rates.get_or_insert_with(|| zero_rates(&slave.table));
            for (&reference, &value) in references.iter().zip(values) {
                if let (_, Access::Setting { set, .. }) = find(&slave.table, reference, real_access)? {
                    set(rates, value);
                }
            }
            Ok(())
        })
    }

    fn check_input_derivative(&self, reference: u32, order: i32, value: f64) -> Outcome {
        let (variable, _) = find(&self.table, reference, real_access)?;
        let name = &variable.name;
        if variable.causality != Causality::Input {
            return refused(format!("{name} is no input"));
        }
        if order != 1 {
            return refused(format!(
                "{name}: inputs change in proportion to time, so the order of a derivative is 1, not {order}"
            ));
        }
        if !value.is_finite() {
            // The standard lets values be discarded, but not derivatives.
            let name = format!("the derivative of {name}");
            return refused(Inadmissible::NotFinite { name, value }.to_string());
        }
        Ok(())
    }

    /// `fmi2GetRealOutputDerivatives`: time derivatives of outputs at the present time.
    pub fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Status {
        self.call("fmi2GetRealOutputDerivatives", |slave| {
            slave.allow(Call::GetOutputDerivatives)?;
            for (&reference, &order) in references.iter().zip(orders) {
                slave.check_output_derivative(reference, order)?;
            }
            let Some(unit) = &mut slave.now.unit else {
                return refused("there are no calculated values after a failed start");
            };
            if references.is_empty() {
                return Ok(());
            }
            let moment = unit.moment();
            for (&reference, value) in references.iter().zip(values) {
                let (_, access) = find(&slave.table, reference, real_access)?;
                let change = match access {
                    Access::Reading(get) => get(&moment.after) - get(&moment.before),
                    Access::Element(..) | Access::Setting { .. } => 0.0,
                };
                *value = change / moment.span;
            }
            Ok(())
        })
    }

    fn check_output_derivative(&self, reference: u32, order: i32) -> Outcome {
        let (variable, access) = find(&self.table, reference, real_access)?;
        let name = &variable.name;
        if variable.causality != Causality::Output {
            return refused(format!("{name} is no output"));
        }
        if matches!(access, Access::Element(..)) {
            return refused(format!(
                "{name} is an element of an array, and elements have no derivatives"
            ));
        }
        if order != 1 {
            return refused(format!(
                "{name}: the order of an output's derivative is 1 (maxOutputDerivativeOrder), not {order}"
            ));
        }
        Ok(())
    }
}
