//! Common parts of the C functions of both versions.
//!
//! Each C function is one row of a table: `fmi2_functions!` and `fmi3_functions!`. A row has the name, the signature
//! and the body, and a table passes its rows to another macro. `define!` makes a generic function of each row; `export_fmi2!` and
//! `export_fmi3!` make the exported functions for one unit, which call the generic ones.
//!
//! | file | content |
//! |---|---|
//! | `entry` | the entry of every C function; pointers to slices, references and strings |
//! | `floating_point` | the floating-point environment of the host, and the default one |
//! | `library` | the file of this library |
//! | `creation` | creation of an instance |
//! | `stored` | stored states |

pub(super) mod creation;
pub(super) mod entry;
pub(super) mod floating_point;
mod library;
pub(super) mod stored;

/// Defines a generic function for each row of a table, and the list of their names.
macro_rules! define {
    ($($name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? = $body:expr;)*) => {
        /// Names of the C functions.
        pub const NAMES: &[&str] = &[$(stringify!($name)),*];

        $(
            #[doc = concat!("`", stringify!($name), "` for any unit.")]
            ///
            /// # Safety
            /// The caller grants what [the head of this module](super) lists.
            #[allow(non_snake_case, reason = "the standard's name")]
            #[allow(unused_variables, unused_unsafe, dead_code, reason = "some rows need no unit, pointer or name")]
            #[allow(clippy::too_many_arguments, clippy::extra_unused_type_parameters, reason = "the standard's")]
            pub unsafe fn $name<U: Unit>($($argument: $type),*) $(-> $result)? {
                const FUNCTION: &str = stringify!($name);
                // SAFETY: as the caller grants.
                unsafe { $body }
            }
        )*
    };
}

pub(super) use define;

/// Exports C functions, each with a list of arguments, a result and a body, and lists their names in `NAMES`: functions of an FMU
/// beyond the standard.
///
/// To be called in a module that allows `unsafe` code and names in C's style.
#[macro_export]
macro_rules! export_functions {
    ($($(#[$attribute:meta])* $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? = $body:expr;)*) => {
        /// Names of the C functions.
        pub const NAMES: &[&str] = &[$(stringify!($name)),*];

        $(
            $(#[$attribute])*
            #[cfg_attr(not(test), unsafe(no_mangle))]
            pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                // SAFETY: as the caller grants.
                unsafe { $body }
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
        $($name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? = $body:expr;)*
    ) => {$(
        /// The standard's function of this name.
        ///
        /// # Safety
#[doc = concat!("The caller grants what the documentation of `pushbelt_fmi::", stringify!($version), "` lists.")]
        #[allow(clippy::too_many_arguments, reason = "the standard's")]
        #[cfg_attr(not(test), unsafe(no_mangle))]
        pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
            // SAFETY: the caller grants what the function that is called requires.
            unsafe { $crate::$version::functions::$name::<$unit>($($argument),*) }
        }
    )*};
}

/// Exports the C functions of FMI 2.0 and FMI 3.0 for the given [`Unit`](crate::Unit). To be called once in a library.
#[macro_export]
macro_rules! export {
    ($unit:ty) => {
        #[allow(unsafe_code, non_snake_case, reason = "C functions of the standard")]
        const _: () = {
            $crate::export_fmi2!($unit);
        };
        #[allow(unsafe_code, non_snake_case, reason = "C functions of the standard")]
        const _: () = {
            $crate::export_fmi3!($unit);
        };
    };
}
