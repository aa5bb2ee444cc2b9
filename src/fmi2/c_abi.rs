//! The C functions of FMI 2.0 for co-simulation, and the only `unsafe` code of the project.
//!
//! Here raw pointers become references and slices, and nothing else happens: what a call does is told in
//! [`slave`](super::slave). Names and signatures are the standard's (`fmi2FunctionTypes.h`). No panic leaves a
//! function. What is asked of every caller, beyond what each function says:
//!
//! - a component comes from [`fmi2Instantiate`], has not been freed, and is used by one call at a time
//!   (not from within its own logger callback either);
//! - an array argument is null or points to as many elements as its count says; a string is null or ends with a zero;
//! - a pointer for a result is null or points to writable memory;
//! - a pointer is aligned for its type, and memory that comes from beyond the boundary holds some value or other.
//!
//! Null pointers where the standard wants a value are answered with an error.

use std::ffi::{CStr, CString};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use libc::{c_char, c_int, c_uint, c_void, size_t};

use super::log::{Category, Sink, Status};
use super::processor;
use super::resources;
use super::slave::{Slave, StatusKind};
use super::snapshot::Snapshot;
use super::state::Call;
use super::unit::Experiment;

/// The unit behind the exported functions: the one line that ties this layer to a model.
use crate::unit::VariatorUnit as Model;

type Instance = Slave<Model>;

/// `fmi2Component`: an instance.
pub type Component = *mut c_void;
/// `fmi2FMUstate`: a stored state.
pub type FmuState = *mut c_void;

/// `fmi2CallbackLogger`: environment, instance name, status, category, message format, arguments of the format.
pub type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`. Only the logger is used: memory is the library's own, and steps finish before they return.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CallbackFunctions {
    /// Takes messages; may be null.
    pub logger: Option<Logger>,
    /// Unused.
    pub allocate_memory: Option<unsafe extern "C" fn(size_t, size_t) -> *mut c_void>,
    /// Unused.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Unused.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// First argument of the logger.
    pub component_environment: *mut c_void,
}

/// The importer's logger, with what it wants to hear with every message.
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

/// Runs `body` and answers a panic with `instead`.
fn contain<T>(instead: T, body: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(body)).unwrap_or(instead)
}

/// Runs a call on an instance.
///
/// # Safety
/// `component` is null or an instance that no other call is using.
unsafe fn with(component: Component, body: impl FnOnce(&mut Instance) -> Status) -> Status {
    contain(Status::Error, || {
        // SAFETY: not null means a `Box<Instance>` released by `fmi2Instantiate`; the caller grants sole use.
        match unsafe { component.cast::<Instance>().as_mut() } {
            Some(instance) => body(instance),
            None => Status::Error,
        }
    })
}

fn is_usable<T>(pointer: *const T, count: size_t) -> bool {
    !pointer.is_null()
        && pointer.is_aligned()
        && count
            .checked_mul(size_of::<T>())
            .is_some_and(|bytes| isize::try_from(bytes).is_ok())
}

/// An array argument; `None` if it is null though it should have elements.
///
/// # Safety
/// `pointer` is null or points to `count` elements that stay untouched for `'a`.
unsafe fn array<'a, T>(pointer: *const T, count: size_t) -> Option<&'a [T]> {
    if count == 0 {
        return Some(&[]);
    }
    // SAFETY: not null, aligned, not longer than an allocation can be; the caller vouches for the elements.
    is_usable(pointer, count).then(|| unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// An array for results; `None` if it is null though it should have elements.
///
/// # Safety
/// `pointer` is null or points to `count` elements, writable and not otherwise used for `'a`. They are plain numbers
/// that hold some value or other.
unsafe fn array_mut<'a, T>(pointer: *mut T, count: size_t) -> Option<&'a mut [T]> {
    if count == 0 {
        return Some(&mut []);
    }
    // SAFETY: not null, aligned, not longer than an allocation can be; the caller vouches for the elements.
    is_usable(pointer, count).then(|| unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// A string argument, with what is not UTF-8 replaced.
///
/// # Safety
/// `pointer` is null or points to a string that ends with a zero.
unsafe fn text(pointer: *const c_char) -> Option<String> {
    // SAFETY: not null; the caller vouches for the zero at the end.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned())
}

const NULL_ARRAY: &str = "an array argument is null, misaligned or too long";
const NULL_RESULT: &str = "the pointer for the result is null";

// ---- Platform and version -----------------------------------------------------------------------------------------

/// Sizes of the types of the interface.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// Version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Chooses what is logged.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: Component,
    logging_on: c_int,
    n_categories: size_t,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| {
            let function = "fmi2SetDebugLogging";
            let Some(categories) = array(categories, n_categories) else {
                return slave.refuse(function, NULL_ARRAY);
            };
            let names: Option<Vec<String>> = categories.iter().map(|name| text(*name)).collect();
            let Some(names) = names else {
                return slave.refuse(function, "a category is null");
            };
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            slave.set_debug_logging(logging_on != 0, &names)
        })
    }
}

// ---- Creation and destruction -------------------------------------------------------------------------------------

/// Creates an instance; null if the arguments don't fit this FMU.
///
/// # Safety
/// The strings and `functions` are null or valid during the call; the logger in it can be called, with the environment
/// beside it, until the instance is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
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
    unsafe { instantiate(instance_name, fmu_type, guid, resource_location, functions, logging_on) }
}

/// [`fmi2Instantiate`] on a processor that has what the code is compiled for. Never inlined: nothing of it may run
/// before that is known.
///
/// # Safety
/// As there.
#[inline(never)]
unsafe fn instantiate(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resource_location: *const c_char,
    functions: *const CallbackFunctions,
    logging_on: c_int,
) -> Component {
    const CO_SIMULATION: c_int = 1;
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
        let expected = super::guid::<Model>();
        let objection = if name.is_none_or(|name| name.is_empty()) {
            Some("the instance name is missing".to_string())
        } else if fmu_type != CO_SIMULATION {
            Some("this FMU is for co-simulation only".to_string())
        } else {
            match guid {
                None => Some("the GUID is missing".to_string()),
                Some(guid) if guid != expected => Some(format!(
                    "the GUID {guid} is not that of this binary, {expected}: the model description belongs to another one"
                )),
                Some(_) => None,
            }
        };
        if let Some(objection) = objection {
            if let Some(importer) = &importer {
                let text = format!("fmi2Instantiate: {objection}");
                importer.send(Status::Error, Category::Error, &text);
            }
            return ptr::null_mut();
        }
        // Nothing is read from the resources: a location that can't be used is worth a remark, not a refusal.
        if let Some(Err(remark)) = location.as_deref().map(resources::path)
            && let Some(importer) = &importer
        {
            let text = format!("fmi2Instantiate: {remark}");
            importer.send(Status::Warning, Category::Warning, &text);
        }
        let sink = importer.map(|importer| Box::new(importer) as Box<dyn Sink>);
        Box::into_raw(Box::new(Instance::new(sink, logging_on != 0))).cast()
    })
}

/// Frees an instance; null is legal.
///
/// # Safety
/// `c` is null or an instance, which is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: Component) {
    contain((), || {
        if !c.is_null() {
            // SAFETY: a `Box<Instance>` released by `fmi2Instantiate`, which the caller gives back.
            drop(unsafe { Box::from_raw(c.cast::<Instance>()) });
        }
    });
}

// ---- Set-up, initialisation, end ----------------------------------------------------------------------------------

/// Tells tolerance, start and stop time.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: Component,
    tolerance_defined: c_int,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: c_int,
    stop_time: f64,
) -> Status {
    let experiment = Experiment {
        tolerance: (tolerance_defined != 0).then_some(tolerance),
        start: start_time,
        stop: (stop_time_defined != 0).then_some(stop_time),
    };
    // SAFETY: as the caller grants.
    unsafe { with(c, |slave| slave.setup_experiment(experiment)) }
}

/// Enters initialisation mode.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with(c, Slave::enter_initialization_mode) }
}

/// Leaves initialisation mode.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with(c, Slave::exit_initialization_mode) }
}

/// Ends the run.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with(c, Slave::terminate) }
}

/// Brings the instance back to where it was instantiated.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with(c, Slave::reset) }
}

// ---- Values -------------------------------------------------------------------------------------------------------

/// Reads reals.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: Component, vr: *const c_uint, nvr: size_t, value: *mut f64) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (array(vr, nvr), array_mut(value, nvr)) {
            (Some(references), Some(values)) => slave.get_real(references, values),
            _ => slave.refuse("fmi2GetReal", NULL_ARRAY),
        })
    }
}

/// Reads integers and enumerations.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: Component, vr: *const c_uint, nvr: size_t, value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (array(vr, nvr), array_mut(value, nvr)) {
            (Some(references), Some(values)) => slave.get_integer(references, values),
            _ => slave.refuse("fmi2GetInteger", NULL_ARRAY),
        })
    }
}

/// Reads Booleans.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: Component, vr: *const c_uint, nvr: size_t, value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (array(vr, nvr), array_mut(value, nvr)) {
            (Some(references), Some(values)) => slave.get_boolean(references, values),
            _ => slave.refuse("fmi2GetBoolean", NULL_ARRAY),
        })
    }
}

/// Reads strings; there are none.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: Component,
    vr: *const c_uint,
    nvr: size_t,
    _value: *mut *const c_char,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match array(vr, nvr) {
            Some(references) => slave.no_strings("fmi2GetString", Call::Get, references),
            None => slave.refuse("fmi2GetString", NULL_ARRAY),
        })
    }
}

/// Writes reals.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: Component, vr: *const c_uint, nvr: size_t, value: *const f64) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (array(vr, nvr), array(value, nvr)) {
            (Some(references), Some(values)) => slave.set_real(references, values),
            _ => slave.refuse("fmi2SetReal", NULL_ARRAY),
        })
    }
}

/// Writes integers and enumerations.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: Component, vr: *const c_uint, nvr: size_t, value: *const c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (array(vr, nvr), array(value, nvr)) {
            (Some(references), Some(values)) => slave.set_integer(references, values),
            _ => slave.refuse("fmi2SetInteger", NULL_ARRAY),
        })
    }
}

/// Writes Booleans.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: Component, vr: *const c_uint, nvr: size_t, value: *const c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (array(vr, nvr), array(value, nvr)) {
            (Some(references), Some(values)) => slave.set_boolean(references, values),
            _ => slave.refuse("fmi2SetBoolean", NULL_ARRAY),
        })
    }
}

/// Writes strings; there are none.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: Component,
    vr: *const c_uint,
    nvr: size_t,
    _value: *const *const c_char,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match array(vr, nvr) {
            Some(references) => slave.no_strings("fmi2SetString", Call::Set, references),
            None => slave.refuse("fmi2SetString", NULL_ARRAY),
        })
    }
}

// ---- Stored states ------------------------------------------------------------------------------------------------

/// Stores the state, in a new object if `*state` is null, otherwise in the object that it points to.
///
/// # Safety
/// `*state` is null or a state from this function that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: Component, state: *mut FmuState) -> Status {
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>` released below.
    unsafe {
        with(c, |slave| {
            let Some(state) = state.as_mut() else {
                return slave.refuse("fmi2GetFMUstate", NULL_RESULT);
            };
            let (status, saved) = slave.save();
            if let Some(saved) = saved {
                match state.cast::<Snapshot<Model>>().as_mut() {
                    Some(existing) => *existing = saved,
                    None => *state = Box::into_raw(Box::new(saved)).cast(),
                }
            }
            status
        })
    }
}

/// Goes back to a stored state, which stays as it is.
///
/// # Safety
/// `state` is null or a state from [`fmi2GetFMUstate`] that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: Component, state: FmuState) -> Status {
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>`.
    unsafe {
        with(c, |slave| match state.cast::<Snapshot<Model>>().as_ref() {
            Some(snapshot) => slave.restore(snapshot),
            None => slave.refuse("fmi2SetFMUstate", NULL_STATE),
        })
    }
}

/// Frees a stored state and sets it to null; null is legal.
///
/// # Safety
/// `*state` is null or a state from [`fmi2GetFMUstate`] that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: Component, state: *mut FmuState) -> Status {
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>`, which the caller gives back.
    unsafe {
        with(c, |_| {
            if let Some(state) = state.as_mut()
                && !state.is_null()
            {
                let freed = std::mem::replace(state, ptr::null_mut());
                drop(Box::from_raw(freed.cast::<Snapshot<Model>>()));
            }
            Status::Ok
        })
    }
}

const NULL_STATE: &str = "the state is null";

/// Number of bytes that a stored state takes.
///
/// # Safety
/// `state` is null or a state from [`fmi2GetFMUstate`] or [`fmi2DeSerializeFMUstate`] that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: Component, state: FmuState, size: *mut size_t) -> Status {
    let function = "fmi2SerializedFMUstateSize";
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>`.
    unsafe {
        with(c, |slave| {
            let Some(snapshot) = state.cast::<Snapshot<Model>>().as_ref() else {
                return slave.refuse(function, NULL_STATE);
            };
            let Some(size) = size.as_mut() else {
                return slave.refuse(function, NULL_RESULT);
            };
            let (status, bytes) = slave.serialize(function, snapshot);
            if let Some(bytes) = bytes {
                *size = bytes.len();
            }
            status
        })
    }
}

/// Writes a stored state as bytes, `size` of them as [`fmi2SerializedFMUstateSize`] has told.
///
/// # Safety
/// As for [`fmi2SerializedFMUstateSize`]; `bytes` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: Component,
    state: FmuState,
    bytes: *mut c_char,
    size: size_t,
) -> Status {
    let function = "fmi2SerializeFMUstate";
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>`.
    unsafe {
        with(c, |slave| {
            let Some(snapshot) = state.cast::<Snapshot<Model>>().as_ref() else {
                return slave.refuse(function, NULL_STATE);
            };
            let Some(target) = array_mut(bytes.cast::<u8>(), size) else {
                return slave.refuse(function, NULL_ARRAY);
            };
            let (status, bytes) = slave.serialize(function, snapshot);
            let Some(bytes) = bytes else { return status };
            match target.get_mut(..bytes.len()) {
                Some(target) => target.copy_from_slice(&bytes),
                None => {
                    let why = format!("the state takes {} bytes, {size} are not enough", bytes.len());
                    return slave.refuse(function, &why);
                }
            }
            status
        })
    }
}

/// Makes a stored state of bytes. What `*state` was before does not matter: it is not freed.
///
/// # Safety
/// `bytes` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: Component,
    bytes: *const c_char,
    size: size_t,
    state: *mut FmuState,
) -> Status {
    let function = "fmi2DeSerializeFMUstate";
    // SAFETY: as the caller grants; the pointer for the result is written, not read.
    unsafe {
        with(c, |slave| {
            let Some(bytes) = array(bytes.cast::<u8>(), size) else {
                return slave.refuse(function, NULL_ARRAY);
            };
            if state.is_null() {
                return slave.refuse(function, NULL_RESULT);
            }
            let (status, snapshot) = slave.deserialize(bytes);
            if let Some(snapshot) = snapshot {
                state.write(Box::into_raw(Box::new(snapshot)).cast());
            }
            status
        })
    }
}

// ---- Derivatives --------------------------------------------------------------------------------------------------

/// Not offered.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: Component,
    _unknown: *const c_uint,
    _n_unknown: size_t,
    _known: *const c_uint,
    _n_known: size_t,
    _dv_known: *const f64,
    _dv_unknown: *mut f64,
) -> Status {
    let why = "no output depends directly on an input, so every such derivative would be zero \
               (providesDirectionalDerivative is false)";
    // SAFETY: as the caller grants.
    unsafe { with(c, |slave| slave.not_offered("fmi2GetDirectionalDerivative", why)) }
}

/// Lets inputs change in proportion to time during the next step.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: Component,
    vr: *const c_uint,
    nvr: size_t,
    order: *const c_int,
    value: *const f64,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| {
            match (array(vr, nvr), array(order, nvr), array(value, nvr)) {
                (Some(references), Some(orders), Some(values)) => {
                    slave.set_input_derivatives(references, orders, values)
                }
                _ => slave.refuse("fmi2SetRealInputDerivatives", NULL_ARRAY),
            }
        })
    }
}

/// Time derivatives of outputs.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: Component,
    vr: *const c_uint,
    nvr: size_t,
    order: *const c_int,
    value: *mut f64,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| {
            match (array(vr, nvr), array(order, nvr), array_mut(value, nvr)) {
                (Some(references), Some(orders), Some(values)) => {
                    slave.get_output_derivatives(references, orders, values)
                }
                _ => slave.refuse("fmi2GetRealOutputDerivatives", NULL_ARRAY),
            }
        })
    }
}

// ---- Steps --------------------------------------------------------------------------------------------------------

/// Advances by one communication step. Whether the master will come back before this point does not matter here:
/// states are stored on request only.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: Component,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: c_int,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| {
            slave.do_step(current_communication_point, communication_step_size)
        })
    }
}

/// Refused: no step is ever pending.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with(c, Slave::cancel_step) }
}

fn status_kind(kind: c_int) -> Option<StatusKind> {
    match kind {
        0 => Some(StatusKind::DoStep),
        1 => Some(StatusKind::Pending),
        2 => Some(StatusKind::LastSuccessfulTime),
        3 => Some(StatusKind::Terminated),
        _ => None,
    }
}

const UNKNOWN_KIND: &str = "the kind of status is not one of the standard's";

/// How the last step ended.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: Component, kind: c_int, value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (status_kind(kind), value.as_mut()) {
            (Some(kind), Some(value)) => slave.step_status(kind, value),
            (None, _) => slave.refuse("fmi2GetStatus", UNKNOWN_KIND),
            (_, None) => slave.refuse("fmi2GetStatus", NULL_RESULT),
        })
    }
}

/// The last successful time.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: Component, kind: c_int, value: *mut f64) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (status_kind(kind), value.as_mut()) {
            (Some(kind), Some(value)) => slave.real_status(kind, value),
            (None, _) => slave.refuse("fmi2GetRealStatus", UNKNOWN_KIND),
            (_, None) => slave.refuse("fmi2GetRealStatus", NULL_RESULT),
        })
    }
}

/// Nothing can be asked as an integer.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: Component, kind: c_int, _value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match status_kind(kind) {
            Some(kind) => slave.no_status("fmi2GetIntegerStatus", kind),
            None => slave.refuse("fmi2GetIntegerStatus", UNKNOWN_KIND),
        })
    }
}

/// Whether the slave wants the run to end.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: Component, kind: c_int, value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match (status_kind(kind), value.as_mut()) {
            (Some(kind), Some(value)) => slave.boolean_status(kind, value),
            (None, _) => slave.refuse("fmi2GetBooleanStatus", UNKNOWN_KIND),
            (_, None) => slave.refuse("fmi2GetBooleanStatus", NULL_RESULT),
        })
    }
}

/// Nothing can be asked as a string.
///
/// # Safety
/// As the head of this file says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: Component, kind: c_int, _value: *mut *const c_char) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with(c, |slave| match status_kind(kind) {
            Some(kind) => slave.no_status("fmi2GetStringStatus", kind),
            None => slave.refuse("fmi2GetStringStatus", UNKNOWN_KIND),
        })
    }
}
