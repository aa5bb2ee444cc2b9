//! Creation of an instance.

use std::collections::BTreeSet;
use std::ptr;

use libc::c_int;

use super::{Environment, Instance, IntermediateUpdate, LogMessage, Reference, Text};
use crate::c::creation::{Texts, c_string, create};
use crate::c::entry::{array, contain};
use crate::c::floating_point::in_hosts;
use crate::description::{TIME, Version};
use crate::instance::{Callback, Importer};
use crate::log::{Category, Sink, Status};
use crate::processor;
use crate::table::Causality;
use crate::unit::Unit;

/// Whether the processor has the instructions that the code is compiled for; if not, logs an error.
/// No other code may run before it, not even the packing of arguments.
///
/// # Safety
/// The function for messages is null or can be called with the environment.
pub(super) unsafe fn processor_suffices(environment: Environment, log_message: Option<LogMessage>) -> bool {
    if processor::suffices() {
        return true;
    }
    // Not through a `Sink`, whose code may need what the processor lacks.
    if let Some(log_message) = log_message {
        let (category, message) = (c"logStatusError".as_ptr(), processor::NO_AVX2.as_ptr());
        // SAFETY: the caller grants that it can be called with the environment. The texts are
        // constants that end with a zero.
        unsafe { log_message(environment, Status::Error as c_int, category, message) };
    }
    false
}

/// What the importer asks for.
pub(super) struct Modes {
    pub logging: bool,
    pub events: bool,
    pub early_return: bool,
}

/// Functions of the importer, and the environment that it gets back with each call.
pub(super) struct Callbacks {
    pub environment: Environment,
    pub log_message: Option<LogMessage>,
    pub intermediate_update: Option<IntermediateUpdate>,
}

/// `fmi3InstantiateCoSimulation`: creates an instance; null if the arguments don't fit this FMU.
/// Never inlined: none of its code may run before [`processor_suffices`].
///
/// # Safety
/// Each of the texts is null or ends with a zero. `required` is null or points to `n_required`
/// value references. The callbacks are null or can be called with the environment until the
/// instance is freed.
#[inline(never)]
pub(super) unsafe fn instantiate<U: Unit>(
    texts: Texts<Text>,
    modes: Modes,
    required: *const Reference,
    n_required: usize,
    callbacks: Callbacks,
) -> Instance {
    let Callbacks {
        environment,
        log_message,
        intermediate_update,
    } = callbacks;
    let messages = |_: &str| log_message.map(|log_message| sink(log_message, environment));
    let importer = |warn: &dyn Fn(&str)| {
        // SAFETY: the caller grants that it is null or points to so many value references, during
        // this call.
        let required = unsafe { array(required, n_required) }.map_err(|error| error.to_string())?;
        let (intermediate, sets_inputs) = intermediate::<U>(required, warn)?;
        Ok(Importer {
            version: Version::Three,
            events: modes.events,
            early_return: modes.early_return,
            update: intermediate_update.map(|function| Callback { function, environment }),
            sets_inputs,
            intermediate,
        })
    };
    // SAFETY: the caller grants this of the texts.
    unsafe { create::<U>(Version::Three, texts, modes.logging, messages, importer) }
}

/// Those of the required variables that the importer may set and read in intermediate update mode,
/// and whether inputs are among them. The others are a warning: some importers name all outputs.
fn intermediate<U: Unit>(required: &[u32], warn: &dyn Fn(&str)) -> Result<(Vec<u32>, bool), String> {
    let table = U::table();
    let (mut usable, mut sets_inputs) = (Vec::new(), false);
    // An importer may name a variable more than once.
    let named: BTreeSet<_> = required.iter().copied().filter(|one| *one != TIME).collect();
    for reference in named {
        let Some(variable) = table.by_reference(reference) else {
            return Err(format!(
                "no variable has the value reference {reference}, which is among the required intermediate \
                 variables"
            ));
        };
        if variable.is_intermediate() {
            usable.push(reference);
            sets_inputs |= variable.causality == Causality::Input;
        } else {
            warn(&format!(
                "{} can't be set or read in intermediate update mode: only real inputs and outputs can",
                variable.name
            ));
        }
    }
    Ok((usable, sets_inputs))
}

/// `fmi3InstantiateModelExchange` and `fmi3InstantiateScheduledExecution`: null, with a message.
///
/// # Safety
/// The function for messages is null or can be called with the environment.
pub(super) unsafe fn refuse_instance(
    function: &str,
    why: &str,
    environment: Environment,
    log_message: Option<LogMessage>,
) -> Instance {
    contain((), || {
        if let Some(log_message) = log_message {
            sink(log_message, environment)(Status::Error, Category::Error, &format!("{function}: {why}"));
        }
    });
    ptr::null_mut()
}

fn sink(log_message: LogMessage, environment: Environment) -> Sink {
    Box::new(move |status, category, text| {
        // By the standard, "#" refers to a variable, and "##" is a number sign.
        let [category, text] = [category.name(), &text.replace('#', "##")].map(c_string);
        let (category, text) = (category.as_ptr(), text.as_ptr());
        // SAFETY: the importer gave the function, with this environment, for the lifetime of the
        // instance, in which the log owns this sink, or for the call of `refuse_instance`. The
        // strings end with a zero and exist during the call.
        in_hosts(|| unsafe { log_message(environment, status as c_int, category, text) });
    })
}
