//! Variables by the types of FMI 3.0: whole numbers have 32 bits, enumerations 64.

use super::instance::Slave;
use crate::log::Status;
use crate::table::{Access, Inadmissible, Kind, Variable};
use crate::unit::Unit;

impl<U: Unit> Slave<U> {
    /// `fmi3GetInt32`, for whole numbers.
    pub fn get_int32(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        self.call("fmi3GetInt32", |slave| {
            slave.get(references, values, integer_access, |v| v)
        })
    }

    /// `fmi3SetInt32`. Either all values are taken or none.
    pub fn set_int32(&mut self, references: &[u32], values: &[i32]) -> Status {
        self.call("fmi3SetInt32", |slave| {
            slave.set(
                references,
                values,
                integer_access,
                |variable, value| variable.admit_integer(value),
                |v| v,
            )
        })
    }

    /// `fmi3GetInt64`, for enumerations.
    pub fn get_int64(&mut self, references: &[u32], values: &mut [i64]) -> Status {
        self.call("fmi3GetInt64", |slave| {
            slave.get(references, values, enumeration_access, i64::from)
        })
    }

    /// `fmi3SetInt64`, for enumerations. Either all values are taken or none.
    pub fn set_int64(&mut self, references: &[u32], values: &[i64]) -> Status {
        self.call("fmi3SetInt64", |slave| {
            slave.set(references, values, enumeration_access, admit_choice, |v| {
                i32::try_from(v).unwrap_or_default()
            })
        })
    }
}

/// Checks the number of a choice; one beyond 32 bits is none of them.
fn admit_choice<S, R>(variable: &Variable<S, R>, value: i64) -> Result<i64, Inadmissible> {
    let admitted = variable.admit_integer(i32::try_from(value).unwrap_or(i32::MIN));
    admitted.map(|_| value).map_err(|error| match error {
        #[expect(clippy::cast_precision_loss, reason = "for a message")]
        Inadmissible::OutOfRange { name, range, .. } => Inadmissible::OutOfRange {
            name,
            value: value as f64,
            range,
        },
        other => other,
    })
}

/// Where a whole number lives.
fn integer_access<S, R>(kind: &Kind<S, R>) -> Option<&Access<S, R, i32>> {
    match kind {
        Kind::Integer { access, .. } => Some(access),
        _ => None,
    }
}

/// Where the number of an enumeration lives.
fn enumeration_access<S, R>(kind: &Kind<S, R>) -> Option<&Access<S, R, i32>> {
    match kind {
        Kind::Enumeration { access, .. } => Some(access),
        _ => None,
    }
}
