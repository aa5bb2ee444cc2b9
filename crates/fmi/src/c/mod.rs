//! Common parts of the C functions of both versions.
//!
//! Each C function is one row of a table: `fmi2_functions!` and `fmi3_functions!`. A row has the name, the signature
//! and, after `=`, the body, or after `=>` the instance and the call on its slave. A table passes its rows to another macro. `define!` makes a generic function of each row; `export_fmi2!` and
//! `export_fmi3!` make the exported functions for one unit, which call the generic ones.
//!
//! | file | content |
//! |---|---|
//! | `entry` | the entry of every C function; pointers to slices, references and strings |
//! | `floating_point` | the floating-point environment of the host, and the default one |
//! | `creation` | creation and end of an instance |
//! | `stored` | stored states |
//! | `dispatch` | forwarding of calls to a variant of the library for newer processors |
//! | `library` | shared libraries at run time |

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
                $(= $body:expr)? $(=> $c:ident, $call:expr)?;
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
            #[allow(unused_variables, unused_unsafe, dead_code, reason = "some rows need no unit, pointer or name")]
            #[allow(clippy::too_many_arguments, clippy::extra_unused_type_parameters, reason = "the standard's")]
            pub unsafe fn $name<U: Unit>($($argument: $type),*) $(-> $result)? {
                const FUNCTION: &str = stringify!($name);
                // SAFETY: as the caller grants.
                unsafe { $($body)? $(enter::<U, _>($c, FUNCTION, $call))? }
            }
        )*
    };
}

pub(super) use define;

/// Exports C functions, each with a list of arguments, a result and a body, and lists their names in `NAMES`: functions of an FMU
/// beyond the standard. The first argument of a function on an instance has the name `c`. The calls of these go to the variant of
/// the library that [`Dispatch`](crate::dispatch::Dispatch) has chosen.
///
/// To be called in a module that allows `unsafe` code and names in C's style.
#[macro_export]
macro_rules! export_functions {
    (
        $dispatch:expr;
        $($(#[$attribute:meta])* $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? = $body:expr;)*
    ) => {
        /// Names of the C functions.
        pub const NAMES: &[&str] = &[$(stringify!($name)),*];

        $(
            $(#[$attribute])*
            #[cfg_attr(not(test), unsafe(no_mangle))]
            pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                // SAFETY: as the caller grants.
                $crate::__here_or_in_variant! { $dispatch, $name($($argument: $type),*) $(-> $result)?, unsafe { $body } }
            }
        )*
    };
}

/// Exports a generic function for each row of a table under the row's name.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_for {
    (
        $version:ident $unit:ty, $dispatch:expr;
        $(
            $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?
                $(= $body:expr)? $(=> $c:ident, $call:expr)?;
        )*
    ) => {
        $(
            /// The standard's function of this name.
            ///
            /// # Safety
    #[doc = concat!("The caller grants what the documentation of `pushbelt_fmi::", stringify!($version), "` lists.")]
            #[allow(clippy::too_many_arguments, reason = "the standard's")]
            #[cfg_attr(not(test), unsafe(no_mangle))]
            pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                // SAFETY: the caller grants what the function that is called requires.
                $crate::__here_or_in_variant! { $dispatch, $name($($argument: $type),*) $(-> $result)?,
                    unsafe { $crate::$version::functions::$name::<$unit>($($argument),*) }
                }
            }
        )*
    };
}

/// Whether the first argument is an instance.
#[doc(hidden)]
#[macro_export]
macro_rules! __takes_instance {
    (c $($others:ident)*) => {
        true
    };
    ($($others:ident)*) => {
        false
    };
}

/// The body of an exported function: a call in this library, or in its variant. Builds without variant have no code for it.
#[doc(hidden)]
#[macro_export]
macro_rules! __here_or_in_variant {
    ($dispatch:expr, $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?, $here:expr) => {
        if const { option_env!("PUSHBELT_VARIANT").is_some() } {
            static FORWARD: $crate::dispatch::Forward = $crate::dispatch::Forward::new(
                $crate::dispatch::c_string(concat!(stringify!($name), "\0")),
                $crate::dispatch::Kind::of(stringify!($name), $crate::__takes_instance!($($argument)*)),
            );
            $crate::dispatch::through($dispatch, &FORWARD, |function| {
                if function.is_null() {
                    return $here;
                }
                type Function = unsafe extern "C" fn($($type),*) $(-> $result)?;
                // SAFETY: the variant is compiled from the same sources, so its function has this type and the same requirements. It
                // is open, because it has the instance of the call.
                unsafe { std::mem::transmute::<*mut $crate::libc::c_void, Function>(function)($($argument),*) }
            })
        } else {
            $here
        }
    };
}

/// Exports the function by which a library opens its variant: `pushbeltVariant`.
#[doc(hidden)]
#[macro_export]
macro_rules! export_variant {
    () => {
        /// For a library of the FMU that opens another one: the number of instances of this library.
        #[cfg_attr(not(test), unsafe(no_mangle))]
        pub extern "C" fn pushbeltVariant() -> *const $crate::libc::c_void {
            $crate::dispatch::handshake()
        }
    };
}

/// Exports the C functions of FMI 2.0 and FMI 3.0 for the given [`Unit`](crate::Unit). To be called once in a library.
#[macro_export]
macro_rules! export {
    ($unit:ty) => {
        #[allow(unsafe_code, non_snake_case, reason = "C functions of the standard")]
        const _: () = {
            static DISPATCH: $crate::dispatch::Dispatch = $crate::dispatch::Dispatch::new(
                <$unit as $crate::Unit>::IDENTITY.name,
                option_env!("PUSHBELT_VARIANT"),
            );
            const _: () = {
                $crate::export_fmi2!($unit, Some(&DISPATCH));
            };
            const _: () = {
                $crate::export_fmi3!($unit, Some(&DISPATCH));
            };
            $crate::export_variant!();
        };
    };
}
