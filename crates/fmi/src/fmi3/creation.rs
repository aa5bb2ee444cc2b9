//! Creation and destruction of an instance.

use std::ffi::CString;
use std::path::Path;
use std::ptr;

use libc::{c_int, size_t};

use super::boundary::{NULL_ARRAY, array, contain, text};
use super::description::{instantiation_token, is_intermediate};
use super::instance::{Instance3, Watch};
use super::types::{Boolean, Environment, Instance, IntermediateUpdate, LogMessage, Reference, Text};
use crate::log::{Category, Log, Sink, Status};
use crate::slave::{Slave, Version};
use crate::stepping::OwnSteps;
use crate::table::Causality;
use crate::{processor, start_values};

/// The importer's function for messages, with its environment.
struct Importer {
    log_message: LogMessage,
    environment: Environment,
}

impl Sink for Importer {
    fn send(&self, status: Status, category: Category, message: &str) {
        let category = CString::new(category.name()).unwrap_or_default();
        // A number sign stands for the name of a variable, two for itself.
        let message = CString::new(message.replace('\0', " ").replace('#', "##")).unwrap_or_default();
        // SAFETY: the importer gave this function, with this environment, for the lifetime of the instance. The strings end with
        // a zero and live through the call.
        unsafe {
            (self.log_message)(self.environment, status as c_int, category.as_ptr(), message.as_ptr());
        }
    }
}

/// Whether the processor has what the code is compiled for; if not, says so. Never more: nothing else of the code may run before.
///
/// # Safety
/// The function for messages is null or can be called with the environment.
unsafe fn processor_suffices(environment: Environment, log_message: Option<LogMessage>) -> bool {
    if processor::suffices() {
        return true;
    }
    if let Some(log_message) = log_message {
        let (category, message) = (c"logStatusError".as_ptr(), processor::OBJECTION3.as_ptr());
        // SAFETY: as the caller grants.
        unsafe { log_message(environment, Status::Error as c_int, category, message) };
    }
    false
}

/// `fmi3InstantiateCoSimulation`: creates an instance; null if the arguments don't fit this FMU.
///
/// # Safety
/// The strings and the array are null or valid during the call; the callbacks are null or can be called, with the environment,
/// until the instance is freed.
#[expect(clippy::too_many_arguments, reason = "the standard's")]
pub unsafe fn instantiate_co_simulation<U: OwnSteps>(
    instance_name: Text,
    instantiation_token: Text,
    resource_path: Text,
    _visible: Boolean,
    logging_on: Boolean,
    event_mode_used: Boolean,
    early_return_allowed: Boolean,
    required_intermediate_variables: *const Reference,
    n_required_intermediate_variables: size_t,
    environment: Environment,
    log_message: Option<LogMessage>,
    intermediate_update: Option<IntermediateUpdate>,
) -> Instance {
    // SAFETY: as the caller grants.
    unsafe {
        if !processor_suffices(environment, log_message) {
            return ptr::null_mut();
        }
        create::<U>(
            (instance_name, instantiation_token, resource_path),
            (required_intermediate_variables, n_required_intermediate_variables),
            [logging_on, event_mode_used, early_return_allowed],
            environment,
            log_message,
            intermediate_update,
        )
    }
}

/// [`instantiate_co_simulation`] on a processor that has what the code is compiled for. Never inlined: nothing of it may run
/// before that is known.
///
/// # Safety
/// As there.
#[inline(never)]
unsafe fn create<U: OwnSteps>(
    (name, token, resources): (Text, Text, Text),
    (required, n_required): (*const Reference, size_t),
    [logging_on, event_mode_used, early_return_allowed]: [Boolean; 3],
    environment: Environment,
    log_message: Option<LogMessage>,
    update: Option<IntermediateUpdate>,
) -> Instance {
    contain(ptr::null_mut(), || {
        let importer = log_message.map(|log_message| Importer {
            log_message,
            environment,
        });
        // SAFETY: null or valid, as the caller grants.
        let (name, token, resources, required) =
            unsafe { (text(name), text(token), text(resources), array(required, n_required)) };
        let say = |status, category, why: &str| {
            if let Some(importer) = &importer {
                importer.send(status, category, &format!("fmi3InstantiateCoSimulation: {why}"));
            }
        };
        let watch = objection::<U>(name.as_deref(), token.as_deref())
            .map_or(Ok(()), Err)
            .and_then(|()| required_variables::<U>(required.ok_or_else(|| NULL_ARRAY.to_owned())?));
        let watch = match watch {
            Ok((required, sets_inputs)) => Watch {
                events: event_mode_used != 0,
                early_return: early_return_allowed != 0,
                update: update.map(|update| (update, environment)),
                required,
                sets_inputs,
            },
            Err(objection) => {
                say(Status::Error, Category::Error, &objection);
                return ptr::null_mut();
            }
        };
        let debug = logging_on != 0;
        // An ordinary FMU needs nothing from its resources: a path that can't be used is worth a remark, not a refusal.
        let folder = resources.as_deref().map(Path::new);
        if let Some(path) = folder.filter(|path| !path.is_absolute() && debug) {
            let remark = format!("the resource path {path:?} is not absolute");
            say(Status::Warning, Category::Warning, &remark);
        }
        let start = folder
            .filter(|path| path.is_absolute())
            .map_or(Ok(None), |folder| start_values::read::<U>(folder));
        let start = match start {
            Ok(start) => start.unwrap_or_default(),
            Err(why) => {
                say(Status::Error, Category::Error, &why);
                return ptr::null_mut();
            }
        };
        let sink = importer.map(|importer| Box::new(importer) as Box<dyn Sink>);
        let version = Version::Three { events: watch.events };
        let slave = Slave::<U>::of(version, Log::silent_without_debug(sink, debug), debug).starting_from(start);
        Box::into_raw(Box::new(Instance3::new(slave, watch))).cast()
    })
}

/// Why no instance is created for these arguments, if they don't fit this FMU.
fn objection<U: OwnSteps>(name: Option<&str>, token: Option<&str>) -> Option<String> {
    if name.is_none_or(|name| name.trim().is_empty()) {
        return Some("the instance name is missing".to_string());
    }
    let Some(token) = token else {
        return Some("the instantiation token is missing".to_string());
    };
    let expected = instantiation_token::<U>();
    (token != expected).then(|| {
        format!(
            "the instantiation token {token} is not that of this binary, {expected}: the model description belongs to another one"
        )
    })
}

/// The variables that the master sets and reads in intermediate update mode, and whether inputs are among them.
fn required_variables<U: OwnSteps>(required: &[u32]) -> Result<(Vec<u32>, bool), String> {
    let table = U::table();
    let mut sets_inputs = false;
    for &reference in required {
        let Some(variable) = table.by_reference(reference) else {
            return Err(format!(
                "no variable has the value reference {reference}, which is among the required intermediate variables"
            ));
        };
        if !is_intermediate(variable) {
            return Err(format!(
                "{} can't be set or read in intermediate update mode: only real inputs and outputs can",
                variable.name
            ));
        }
        sets_inputs |= variable.causality == Causality::Input;
    }
    Ok((required.to_vec(), sets_inputs))
}

/// `fmi3InstantiateModelExchange` and `fmi3InstantiateScheduledExecution`: null, with a message: this FMU is for co-simulation.
///
/// # Safety
/// The function for messages is null or can be called with the environment.
unsafe fn other_interface(function: &str, environment: Environment, log_message: Option<LogMessage>) -> Instance {
    contain(ptr::null_mut(), || {
        if let Some(log_message) = log_message {
            let importer = Importer {
                log_message,
                environment,
            };
            let why = format!("{function}: this FMU is for co-simulation only");
            importer.send(Status::Error, Category::Error, &why);
        }
        ptr::null_mut()
    })
}

/// `fmi3InstantiateModelExchange`: null, with a message.
///
/// # Safety
/// As [`instantiate_co_simulation`].
#[expect(
    clippy::extra_unused_type_parameters,
    reason = "exported functions are all of one unit"
)]
pub unsafe fn instantiate_model_exchange<U: OwnSteps>(
    _instance_name: Text,
    _instantiation_token: Text,
    _resource_path: Text,
    _visible: Boolean,
    _logging_on: Boolean,
    environment: Environment,
    log_message: Option<LogMessage>,
) -> Instance {
    // SAFETY: as the caller grants.
    unsafe { other_interface("fmi3InstantiateModelExchange", environment, log_message) }
}

/// `fmi3InstantiateScheduledExecution`: null, with a message.
///
/// # Safety
/// As [`instantiate_co_simulation`].
#[expect(clippy::too_many_arguments, reason = "the standard's")]
#[expect(
    clippy::extra_unused_type_parameters,
    reason = "exported functions are all of one unit"
)]
pub unsafe fn instantiate_scheduled_execution<U: OwnSteps>(
    _instance_name: Text,
    _instantiation_token: Text,
    _resource_path: Text,
    _visible: Boolean,
    _logging_on: Boolean,
    environment: Environment,
    log_message: Option<LogMessage>,
    _clock_update: *const libc::c_void,
    _lock_preemption: *const libc::c_void,
    _unlock_preemption: *const libc::c_void,
) -> Instance {
    // SAFETY: as the caller grants.
    unsafe { other_interface("fmi3InstantiateScheduledExecution", environment, log_message) }
}

/// `fmi3FreeInstance`: frees an instance; null is legal. In intermediate update mode nothing happens: the instance is still at work.
///
/// # Safety
/// `c` is null or an instance, which is not used any more.
pub unsafe fn free_instance<U: OwnSteps>(c: Instance) {
    contain((), || {
        // SAFETY: a `Box<Instance3<U>>` released by `create`, which the caller gives back.
        unsafe {
            let pointer = c.cast::<Instance3<U>>();
            if pointer.as_ref().is_some_and(|instance| !instance.asking) {
                drop(Box::from_raw(pointer));
            }
        }
    });
}
