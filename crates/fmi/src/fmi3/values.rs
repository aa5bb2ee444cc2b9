//! Reading and writing of variables.

use libc::size_t;

use super::boundary::{NULL_ARRAY, array, array_mut, with, with_any};
use super::layout::Layout;
use super::types::{Binary, Boolean, Instance, Reference, Text};
use crate::log::Status;
use crate::state::Call;
use crate::stepping::OwnSteps;

/// `fmi3GetFloat64`: reads reals and the time; also in intermediate update mode, the variables announced for it.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_float64<U: OwnSteps>(
    c: Instance,
    vr: *const Reference,
    nvr: size_t,
    values: *mut f64,
    n_values: size_t,
) -> Status {
    let function = "fmi3GetFloat64";
    // SAFETY: as the caller grants.
    unsafe {
        with_any::<U, _>(c, function, Status::Error, |instance| {
            let (Some(references), Some(values)) = (array(vr, nvr), array_mut(values, n_values)) else {
                return instance.slave.refuse(function, NULL_ARRAY);
            };
            if let Some(why) = instance.not_announced(references) {
                return instance.slave.refuse(function, &why);
            }
            let layout = match Layout::of(instance.slave.table(), references, values.len()) {
                Ok(layout) => layout,
                Err(why) => return instance.slave.refuse(function, &why),
            };
            let status = layout.read(references, values, |references, values| {
                instance.slave.get_real(references, values)
            });
            if status == Status::Ok {
                let time = if instance.asking {
                    instance.slave.own_time()
                } else {
                    instance.slave.time()
                };
                layout.write_time(values, time);
            }
            status
        })
    }
}

/// `fmi3SetFloat64`: writes reals; also in intermediate update mode, the inputs announced for it.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn set_float64<U: OwnSteps>(
    c: Instance,
    vr: *const Reference,
    nvr: size_t,
    values: *const f64,
    n_values: size_t,
) -> Status {
    let function = "fmi3SetFloat64";
    // SAFETY: as the caller grants.
    unsafe {
        with_any::<U, _>(c, function, Status::Error, |instance| {
            let (Some(references), Some(values)) = (array(vr, nvr), array(values, n_values)) else {
                return instance.slave.refuse(function, NULL_ARRAY);
            };
            let refused = instance
                .not_announced(references)
                .or_else(|| instance.not_for_setting());
            if let Some(why) = refused {
                return instance.slave.refuse(function, &why);
            }
            match Layout::of(instance.slave.table(), references, values.len()) {
                Ok(layout) if layout.has_time() => instance.slave.refuse(function, "time can't be set"),
                Ok(layout) => instance.slave.set_real(layout.elements(references), values),
                Err(why) => instance.slave.refuse(function, &why),
            }
        })
    }
}

/// Text of an error where there are not as many values as variables.
fn wrong_count(nvr: usize, n_values: usize) -> String {
    format!("{n_values} values for {nvr} variables of one value each")
}

/// Functions for scalars of a type that variables have.
macro_rules! scalars {
    ($($name:ident, $function:literal, $slave:ident, $many:ident, *$mutability:ident $type:ty, $text:literal;)*) => {$(
        #[doc = concat!("`", $function, "`: ", $text, ".")]
        ///
        /// # Safety
        /// The caller grants what [the head of this room](super) lists.
        pub unsafe fn $name<U: OwnSteps>(
            c: Instance,
            vr: *const Reference,
            nvr: size_t,
            values: *$mutability $type,
            n_values: size_t,
        ) -> Status {
            // SAFETY: as the caller grants.
            unsafe {
                with::<U>(c, $function, |instance| match (array(vr, nvr), $many(values, n_values)) {
                    (Some(references), Some(values)) if references.len() == values.len() => {
                        instance.slave.$slave(references, values)
                    }
                    (Some(_), Some(_)) => instance.slave.refuse($function, &wrong_count(nvr, n_values)),
                    _ => instance.slave.refuse($function, NULL_ARRAY),
                })
            }
        }
    )*};
}

scalars! {
    get_int32, "fmi3GetInt32", get_int32, array_mut, *mut i32, "reads whole numbers";
    set_int32, "fmi3SetInt32", set_int32, array, *const i32, "writes whole numbers";
    get_int64, "fmi3GetInt64", get_int64, array_mut, *mut i64, "reads enumerations";
    set_int64, "fmi3SetInt64", set_int64, array, *const i64, "writes enumerations";
    get_boolean, "fmi3GetBoolean", get_boolean, array_mut, *mut Boolean, "reads Booleans";
    set_boolean, "fmi3SetBoolean", set_boolean, array, *const Boolean, "writes Booleans";
}

/// Functions for types that no variable has.
macro_rules! absent {
    ($($name:ident, $function:literal, $call:ident, $type_name:literal, ($($argument:ident: $type:ty),*);)*) => {$(
        #[doc = concat!("`", $function, "`: no variable is a ", $type_name, ".")]
        ///
        /// # Safety
        /// The caller grants what [the head of this room](super) lists.
        pub unsafe fn $name<U: OwnSteps>(
            c: Instance,
            vr: *const Reference,
            nvr: size_t,
            $($argument: $type),*
        ) -> Status {
            // SAFETY: as the caller grants.
            unsafe {
                with::<U>(c, $function, |instance| match array(vr, nvr) {
                    Some(references) => instance.slave.no_such_type($function, Call::$call, references, $type_name),
                    None => instance.slave.refuse($function, NULL_ARRAY),
                })
            }
        }
    )*};
}

absent! {
    get_float32, "fmi3GetFloat32", Get, "32-bit real", (_values: *mut f32, _n: size_t);
    set_float32, "fmi3SetFloat32", Set, "32-bit real", (_values: *const f32, _n: size_t);
    get_int8, "fmi3GetInt8", Get, "8-bit whole number", (_values: *mut i8, _n: size_t);
    set_int8, "fmi3SetInt8", Set, "8-bit whole number", (_values: *const i8, _n: size_t);
    get_uint8, "fmi3GetUInt8", Get, "8-bit natural number", (_values: *mut u8, _n: size_t);
    set_uint8, "fmi3SetUInt8", Set, "8-bit natural number", (_values: *const u8, _n: size_t);
    get_int16, "fmi3GetInt16", Get, "16-bit whole number", (_values: *mut i16, _n: size_t);
    set_int16, "fmi3SetInt16", Set, "16-bit whole number", (_values: *const i16, _n: size_t);
    get_uint16, "fmi3GetUInt16", Get, "16-bit natural number", (_values: *mut u16, _n: size_t);
    set_uint16, "fmi3SetUInt16", Set, "16-bit natural number", (_values: *const u16, _n: size_t);
    get_uint32, "fmi3GetUInt32", Get, "32-bit natural number", (_values: *mut u32, _n: size_t);
    set_uint32, "fmi3SetUInt32", Set, "32-bit natural number", (_values: *const u32, _n: size_t);
    get_uint64, "fmi3GetUInt64", Get, "64-bit natural number", (_values: *mut u64, _n: size_t);
    set_uint64, "fmi3SetUInt64", Set, "64-bit natural number", (_values: *const u64, _n: size_t);
    get_string, "fmi3GetString", Get, "string", (_values: *mut Text, _n: size_t);
    set_string, "fmi3SetString", Set, "string", (_values: *const Text, _n: size_t);
    get_binary, "fmi3GetBinary", Get, "binary", (_sizes: *mut size_t, _values: *mut Binary, _n: size_t);
    set_binary, "fmi3SetBinary", Set, "binary", (_sizes: *const size_t, _values: *const Binary, _n: size_t);
    get_clock, "fmi3GetClock", Get, "clock", (_values: *mut Boolean);
    set_clock, "fmi3SetClock", Set, "clock", (_values: *const Boolean);
    get_interval_decimal, "fmi3GetIntervalDecimal", Get, "clock", (_intervals: *mut f64, _qualifiers: *mut i32);
    get_interval_fraction, "fmi3GetIntervalFraction", Get, "clock",
        (_counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut i32);
    get_shift_decimal, "fmi3GetShiftDecimal", Get, "clock", (_shifts: *mut f64);
    get_shift_fraction, "fmi3GetShiftFraction", Get, "clock", (_counters: *mut u64, _resolutions: *mut u64);
    set_interval_decimal, "fmi3SetIntervalDecimal", Set, "clock", (_intervals: *const f64);
    set_interval_fraction, "fmi3SetIntervalFraction", Set, "clock", (_counters: *const u64, _resolutions: *const u64);
    set_shift_decimal, "fmi3SetShiftDecimal", Set, "clock", (_shifts: *const f64);
    set_shift_fraction, "fmi3SetShiftFraction", Set, "clock", (_counters: *const u64, _resolutions: *const u64);
}
