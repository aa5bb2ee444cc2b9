//! Creation and destruction of an instance.

use std::ffi::CString;
use std::ptr;

use libc::{c_char, c_int, c_void};

use super::boundary::{contain, text};
use super::resources;
use super::types::{CallbackFunctions, Component, Logger};
use crate::description;
use crate::log::{Category, Sink, Status};
use crate::slave::Slave;
use crate::unit::Unit;
use crate::{processor, start_values};

/// The importer's logger, with the arguments that every message has in common.
struct Importer {
    logger: Logger,
    environment: *mut c_void,
    instance: CString,
}

impl Sink for Importer {
    fn send(&self, status: Status, category: Category, text: &str) {
        let category = CString::new(category.name()).unwrap_or_default();
        let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the importer gave this function as a logger, with this environment, for the lifetime of the
        // instance. The strings end with a zero and live through the call. The message is the argument of "%s", so
        // that a percent sign in it is not taken for a format.
        unsafe {
            (self.logger)(
                self.environment,
                self.instance.as_ptr(),
                status as c_int,
                category.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}

/// `fmi2Instantiate`: creates an instance; null if the arguments don't fit this FMU.
///
/// # Safety
/// The strings and `functions` are null or valid during the call; the logger in it can be called, with the environment
/// beside it, until the instance is freed.
pub unsafe fn instantiate<U: Unit>(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resource_location: *const c_char,
    functions: *const CallbackFunctions,
    _visible: c_int,
    logging_on: c_int,
) -> Component {
    if !processor::suffices() {
        // Not through `Importer`, which is compiled for what is missing.
        // SAFETY: null or valid, as the caller grants; the logger can be called.
        unsafe {
            if let Some(functions) = functions.as_ref()
                && let Some(logger) = functions.logger
            {
                let (environment, category) = (functions.component_environment, c"logStatusError".as_ptr());
                let text = processor::OBJECTION.as_ptr();
                logger(
                    environment,
                    instance_name,
                    Status::Error as c_int,
                    category,
                    c"%s".as_ptr(),
                    text,
                );
            }
        }
        return ptr::null_mut();
    }
    // SAFETY: as the caller grants.
    unsafe { create::<U>(instance_name, fmu_type, guid, resource_location, functions, logging_on) }
}

/// [`instantiate`] on a processor that has what the code is compiled for. Never inlined: nothing of it may run
/// before that is known.
///
/// # Safety
/// As there.
#[inline(never)]
unsafe fn create<U: Unit>(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resource_location: *const c_char,
    functions: *const CallbackFunctions,
    logging_on: c_int,
) -> Component {
    contain(ptr::null_mut(), || {
        // SAFETY: null or valid, as the caller grants.
        let (name, guid, location, functions) = unsafe {
            (
                text(instance_name),
                text(guid),
                text(resource_location),
                functions.as_ref(),
            )
        };
        let importer = functions.and_then(|functions| {
            Some(Importer {
                logger: functions.logger?,
                environment: functions.component_environment,
                instance: CString::new(name.clone().unwrap_or_default()).unwrap_or_default(),
            })
        });
        let say = |status, category, text: &str| {
            if let Some(importer) = &importer {
                importer.send(status, category, &format!("fmi2Instantiate: {text}"));
            }
        };
        let refuse = |why: &str| {
            say(Status::Error, Category::Error, why);
            ptr::null_mut()
        };
        if let Some(objection) = objection::<U>(name.as_deref(), fmu_type, guid.as_deref()) {
            return refuse(&objection);
        }
        // An ordinary FMU needs nothing from its resources: a location that can't be used is worth a remark, not a refusal.
        let folder = location.as_deref().map(resources::path).transpose();
        let start = match folder {
            Ok(folder) => folder.map_or(Ok(None), |folder| start_values::read::<U>(&folder)),
            Err(remark) => {
                say(Status::Warning, Category::Warning, &remark);
                Ok(None)
            }
        };
        let start = match start {
            Ok(start) => start.unwrap_or_default(),
            Err(why) => return refuse(&why),
        };
        let sink = importer.map(|importer| Box::new(importer) as Box<dyn Sink>);
        Box::into_raw(Box::new(Slave::<U>::new(sink, logging_on != 0).starting_from(start))).cast()
    })
}

/// What the standard's `fmi2Type` calls co-simulation.
const CO_SIMULATION: c_int = 1;

/// Why no instance is created for these arguments, if they don't fit this FMU.
fn objection<U: Unit>(name: Option<&str>, fmu_type: c_int, guid: Option<&str>) -> Option<String> {
    if name.is_none_or(str::is_empty) {
        return Some("the instance name is missing".to_string());
    }
    if fmu_type != CO_SIMULATION {
        return Some("this FMU is for co-simulation only".to_string());
    }
    let Some(guid) = guid else {
        return Some("the GUID is missing".to_string());
    };
    let expected = description::guid::<U>();
    (guid != expected).then(|| {
        format!("the GUID {guid} is not that of this binary, {expected}: the model description belongs to another one")
    })
}

/// `fmi2FreeInstance`: frees an instance; null is legal.
///
/// # Safety
/// `c` is null or an instance, which is not used any more.
pub unsafe fn free_instance<U: Unit>(c: Component) {
    contain((), || {
        if !c.is_null() {
            // SAFETY: a `Box<Slave<U>>` released by `fmi2Instantiate`, which the caller gives back.
            drop(unsafe { Box::from_raw(c.cast::<Slave<U>>()) });
        }
    });
}
