//! Derivatives of inputs and outputs with respect to time.

use std::mem::MaybeUninit;

use super::calls::FmuInstance;
use super::snapshot::zero_rates;
use super::values::{Type, check_count, find};
use super::{Outcome, refused};
use crate::state::Call;
use crate::table::{Causality, Value, Variable, not_finite};
use crate::unit::Unit;

impl<U: Unit> FmuInstance<U> {
    /// Sets derivatives of inputs, in FMI 2.0: the inputs change in proportion to time during the
    /// next step, and are held after it. Either all derivatives are set or none.
    ///
    /// # Errors
    /// The unit holds its inputs, a variable is no real input, an order is not 1, or a value is not
    /// finite.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome {
        self.allow(Call::Set)?;
        if !U::INTERPOLATES_INPUTS {
            return refused("not supported: inputs are held during a step (canInterpolateInputs is false)");
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let variable = find(&self.table, reference, Type::Real)?;
            check(variable, Causality::Input, order)?;
            if !value.is_finite() {
                // The standard lets values be discarded, but not derivatives.
                return refused(not_finite(&format!("the derivative of {}", variable.name), value));
            }
        }
        let rates = self.now.rates.get_or_insert_with(|| zero_rates(&self.table));
        for (&reference, &value) in references.iter().zip(values) {
            find(&self.table, reference, Type::Real)?.write(rates, Value::Real(value));
        }
        Ok(())
    }

    /// Time derivatives of outputs at the present time.
    ///
    /// # Errors
    /// The unit has no derivatives, a variable is no real output or an element of an array, an
    /// order is not 1, the number of values is wrong, or a derivative is not finite.
    pub fn get_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [MaybeUninit<f64>],
    ) -> Outcome {
        self.allow(Call::GetOutputDerivatives)?;
        self.allow_intermediate(references)?;
        check_count(references.len(), values.len(), references.len())?;
        for (&reference, &order) in references.iter().zip(orders) {
            let variable = find(&self.table, reference, Type::Real)?;
            check(variable, Causality::Output, order)?;
            if self.table.array_of(variable.reference).is_some() {
                return refused(format!(
                    "{} is an element of an array: these have no derivatives",
                    variable.name
                ));
            }
        }
        let Some(unit) = &mut self.now.unit else {
            return refused("there are no calculated values after a failed start");
        };
        if references.is_empty() {
            return Ok(());
        }
        let Some((moment, span)) = unit.moment() else {
            return refused("not supported: outputs have no derivatives (maxOutputDerivativeOrder is 0)");
        };
        for (&reference, value) in references.iter().zip(values) {
            let variable = find(&self.table, reference, Type::Real)?;
            let read = |readings| {
                variable
                    .value(&self.now.settings, Some(readings))
                    .and_then(Value::number)
            };
            let [before, after] = moment.each_ref().map(|at| read(at).unwrap_or(f64::NAN));
            let found: f64 = (after - before) / span;
            if !found.is_finite() {
                let name = format!("the derivative of {}", variable.name);
                return refused(not_finite(&name, found));
            }
            value.write(found);
        }
        Ok(())
    }
}

/// Checks that a variable is an input or output, and that the order of its derivative is 1.
fn check<S, R>(variable: &Variable<S, R>, causality: Causality, order: i32) -> Outcome {
    let name = &variable.name;
    if variable.causality != causality {
        let what = format!("{causality:?}").to_lowercase();
        return refused(format!("{name} is not an {what}"));
    }
    if order != 1 {
        return refused(format!("{name}: the order of a derivative is 1, not {order}"));
    }
    Ok(())
}
