//! Creation and end of an instance, for both versions.

use std::ffi::CString;
use std::path::PathBuf;
use std::ptr;

use libc::{c_char, c_void};

use super::entry::{contain, text};
use super::{dispatch, library};
use crate::description;
use crate::description::Version;
use crate::instance::{FmuInstance, Importer};
use crate::log::{Category, Log, Sink, Status};
use crate::resources;
use crate::start_file;
use crate::state::Call;
use crate::unit::Unit;

/// The texts that an `instantiate` function is given.
pub(crate) struct Texts<T> {
    /// Name of the instance.
    pub name: T,
    /// GUID of FMI 2.0 or instantiation token of FMI 3.0.
    pub token: T,
    /// Resource location: a URI or a path.
    pub location: T,
}

/// A string of C, without the zeros in it.
pub(crate) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// An instance, as a `Box<FmuInstance<U>>`; null after a message if the arguments don't fit this
/// FMU. `messages` is given the name. `importer` returns what the importer handles, or why there is
/// no instance.
///
/// # Safety
/// Each of the texts is null or ends with a zero.
pub(crate) unsafe fn create<U: Unit>(
    version: Version,
    texts: Texts<*const c_char>,
    debug: bool,
    messages: impl FnOnce(&str) -> Option<Sink>,
    importer: impl FnOnce(&dyn Fn(&str)) -> Result<Importer, String>,
) -> *mut c_void {
    contain(ptr::null_mut(), || {
        // SAFETY: it is one of the texts, for which the caller grants this.
        let read = |pointer| unsafe { text(pointer) }.map_err(|error| error.to_string());
        let Texts { name, token, location } = texts;
        let (name, token, location) = (read(name), read(token), read(location));
        let texts = Texts { name, token, location };
        let sink = messages(texts.name.as_ref().ok().and_then(Option::as_deref).unwrap_or_default());
        let function = match version {
            Version::Two => "fmi2Instantiate",
            Version::Three => "fmi3InstantiateCoSimulation",
        };
        let log = Log::new(sink, debug);
        let report =
            |status, category, text: &str| log.send(status, category, &format!("{function}: {text}"));
        let started = start::<U>(version, texts, importer, &|text| {
            report(Status::Warning, Category::Warning, text)
        });
        let Ok((importer, start)) = started.map_err(|why| report(Status::Error, Category::Error, &why))
        else {
            return ptr::null_mut();
        };
        let instance = FmuInstance::<U>::new(importer, log, start);
        instance.log_messages(dispatch::message().as_slice());
        Box::into_raw(Box::new(instance)).cast()
    })
}

/// Frees an instance; null is legal. Within `fmi3DoStep`, in intermediate update mode, nothing
/// happens.
///
/// # Safety
/// `instance` is null or a `Box<FmuInstance<U>>` released by an `instantiate` function, which is
/// not used any more.
pub(crate) unsafe fn free_instance<U: Unit>(instance: *mut c_void) {
    contain((), || {
        let pointer = instance.cast::<FmuInstance<U>>();
        // SAFETY: the caller grants that it is null or an instance, and that no other call uses it.
        // During a callback of `fmi3DoStep` there is no other reference either (`fmi3::steps`).
        let instance = unsafe { pointer.as_ref() };
        if instance.is_some_and(|instance| instance.allow(Call::Always).is_ok()) {
            // SAFETY: it is not null, so it is from `Box::into_raw` in `create`, with the same `U`:
            // a library has one unit. The reference above is not used any more, nor the pointer by
            // the caller.
            drop(unsafe { Box::from_raw(pointer) });
        }
    });
}

/// What the importer handles, and the start values of the instance; or why there is none.
fn start<U: Unit>(
    version: Version,
    texts: Texts<Result<Option<String>, String>>,
    importer: impl FnOnce(&dyn Fn(&str)) -> Result<Importer, String>,
    warn: &dyn Fn(&str),
) -> Result<(Importer, U::Settings), String> {
    let name = texts.name?.unwrap_or_default();
    if name.is_empty() || version == Version::Three && name.trim().is_empty() {
        return Err("the instance name is missing".to_owned());
    }
    let what = match version {
        Version::Two => "GUID",
        Version::Three => "instantiation token",
    };
    let token = texts.token?.ok_or_else(|| format!("the {what} is missing"))?;
    let importer = importer(warn)?;
    // A location that means no folder is a warning: without start values in its resources an FMU
    // works too.
    let folders = resources::folders(&texts.location?.unwrap_or_default());
    let mut folders = folders.map_err(|why| warn(&why)).unwrap_or_default();
    folders.extend(library::own_path().and_then(|path| resources::resources_of(&path)));
    let defaults = load::<U>(&folders)?;
    let own = description::token::<U>(version, U::data(&defaults));
    let is_copy = start_file::is_of_copy(&token, &own).ok_or_else(|| {
        format!(
            "the {what} {token} is not that of this binary, {own}: the model description belongs \
             to another binary"
        )
    })?;
    let start = start_file::find::<U>(&folders, is_copy, &defaults)?;
    Ok((importer, start.unwrap_or(defaults)))
}

/// The settings of a new instance with the data of the first folder that has them.
fn load<U: Unit>(folders: &[PathBuf]) -> Result<U::Settings, String> {
    let mut found = folders.iter().map(|folder| U::load(Some(folder)));
    let first = found.next().unwrap_or_else(|| U::load(None));
    first.or_else(|why| found.find_map(Result::ok).ok_or(why))
}
