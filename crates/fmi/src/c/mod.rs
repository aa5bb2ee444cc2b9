//! Common parts of the C functions of both versions.
//!
//! Each C function is one row of a table: `fmi2_functions!` and `fmi3_functions!`. A row has the
//! name, the signature and, after `=`, the body, or after `=>` the instance and the call on it.
//! Before `=` a row says what its body does with an instance: `creates`, `on c`, `free c`. A table
//! passes its rows to another macro. `define!` makes a generic function of each row; `export_fmi2!`
//! and `export!` make the exported functions for one unit, which call the generic ones.

pub(super) mod creation;
pub mod dispatch;
pub(super) mod entry;
pub(super) mod floating_point;
pub(super) mod library;
pub(super) mod stored;

/// Defines a generic function for each row of a table, and the list of their names.
macro_rules! define {
    (
        $(
            $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?
                $(, $use:ident $($instance:ident)?)? $(= $body:expr)? $(=> $c:ident, $call:expr)?;
        )*
    ) => {
        /// Names of the C functions.
        pub const NAMES: &[&str] = &[$(stringify!($name)),*];

        $(
            #[doc = concat!("`", stringify!($name), "` for any unit.")]
            ///
            /// # Safety
            /// The caller grants what [the head of this module](super) lists.
            #[allow(non_snake_case, reason = "the standard's name")]
            #[allow(unused_variables, unused_unsafe, dead_code, reason = "not used by some rows")]
            #[allow(clippy::too_many_arguments, clippy::extra_unused_type_parameters, reason = "given")]
            pub unsafe fn $name<U: Unit>($($argument: $type),*) $(-> $result)? {
                const FUNCTION: &str = stringify!($name);
                // SAFETY: the caller grants what the head of the module lists. The body uses each
                // argument for this alone: the instance by `enter` or `free_instance`, a stored
                // state by `stored`, an array with its count by `array` or `array_mut`, a place by
                // `result`, strings and callbacks by `instantiate`.
                unsafe { $($body)? $(enter::<U, _>($c, FUNCTION, $call))? }
            }
        )*
    };
}

pub(super) use define;

/// Exports C functions beyond the standard, and lists their names in `NAMES`. After `, on` stands
/// the argument that is an instance: in a library with a variant the call is made where the
/// instance is.
///
/// To be called in a module that allows `unsafe` code and names in C's style.
#[macro_export]
macro_rules! export_functions {
    ($(
        $(#[$attribute:meta])* $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?
            $(, $use:ident $($instance:ident)?)? = $body:expr;
    )*) => {
        /// Names of the C functions.
        #[allow(dead_code, reason = "those of the standard are known")]
        pub const NAMES: &[&str] = &[$(stringify!($name)),*];

        $(
            $(#[$attribute])*
            #[cfg_attr(not(test), unsafe(no_mangle))]
            pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                // SAFETY: the caller grants what the section `Safety` above asks for, which is what
                // the body needs.
                $crate::__here_or_in_variant! {
                    [$($use $($instance)?)?] $name($($argument: $type),*) $(-> $result)?, unsafe { $body }
                }
            }
        )*
    };
}

/// Exports a generic function for each row of a table under the row's name.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_for {
    (
        $version:ident $unit:ty;
        $(
            $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?
                $(, $use:ident $($instance:ident)?)? $(= $body:expr)? $(=> $c:ident, $call:expr)?;
        )*
    ) => {
        $crate::export_functions! { $(
            /// The standard's function of this name.
            ///
            /// # Safety
    #[doc = concat!("The caller grants what the head of `pushbelt_fmi::", stringify!($version), "` lists.")]
            #[allow(clippy::too_many_arguments, reason = "the standard's")]
            $name($($argument: $type),*) $(-> $result)? $(, $use $($instance)?)? $(, on $c)? =
                $crate::$version::functions::$name::<$unit>($($argument),*);
        )* }
    };
}

/// The body of an exported function: a call in this library, or in its variant. Builds without
/// variant have no code for it.
#[doc(hidden)]
#[macro_export]
macro_rules! __here_or_in_variant {
    ([] $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?, $here:expr) => {
        $here
    };
    ([creates] $name:ident($($argument:ident: $type:ty),*) -> $result:ty, $here:expr) => {
        match option_env!("PUSHBELT_VARIANT") {
            Some(hash) => $crate::dispatch::create(hash, stringify!($name), |function| {
                $crate::__call! { function, ($($argument: $type),*) -> $result, $here }
            }),
            None => $here,
        }
    };
    ([$use:ident $c:ident] $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?, $here:expr) => {
        if const { option_env!("PUSHBELT_VARIANT").is_some() } {
            let call = |$c, function: *mut $crate::libc::c_void| {
                $crate::__call! { function, ($($argument: $type),*) $(-> $result)?, $here }
            };
            // SAFETY: the caller grants that it is null or an instance of this library.
            unsafe { $crate::dispatch::$use($c, stringify!($name), call) }
        } else {
            $here
        }
    };
}

/// A call of a function of the variant, or here if that is null.
#[doc(hidden)]
#[macro_export]
macro_rules! __call {
    ($function:ident, ($($argument:ident: $type:ty),*) $(-> $result:ty)?, $here:expr) => {{
        if $function.is_null() {
            return $here;
        }
        type Function = unsafe extern "C" fn($($type),*) $(-> $result)?;
        // SAFETY: the variant is compiled from the same sources, so its function has this type and
        // the same requirements. It is open.
        unsafe { std::mem::transmute::<*mut $crate::libc::c_void, Function>($function)($($argument),*) }
    }};
}

/// Exports the C functions of FMI 2.0 and FMI 3.0 for the given [`Unit`](crate::Unit), and the
/// function by which a library opens its variant, `pushbeltVariant`. To be called once in a
/// library.
#[macro_export]
macro_rules! export {
    ($unit:ty) => {
        #[allow(unsafe_code, non_snake_case, reason = "C functions of the standard")]
        const _: () = {
            const _: () = {
                $crate::export_fmi2!($unit);
            };
            const _: () = {
                use $crate::fmi3::{
                    Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage,
                    Reference, Text,
                };
                use $crate::libc::{c_char, c_int, c_void};
                use $crate::log::Status;

                $crate::fmi3_functions! { [$crate::__export_for] fmi3 $unit; }
            };

            /// For a library of the FMU that opens this one as its variant.
            #[cfg_attr(not(test), unsafe(no_mangle))]
            pub extern "C" fn pushbeltVariant() {
                $crate::dispatch::handshake();
            }
        };
    };
}
