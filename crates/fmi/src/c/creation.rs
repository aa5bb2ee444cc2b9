//! Creation and end of an instance, for both versions.

use std::ffi::CString;
use std::path::PathBuf;
use std::ptr;

use libc::{c_char, c_void};

use super::entry::{contain, text};
use super::{dispatch, library};
use crate::description;
use crate::log::{Category, Log, Sink, Status};
use crate::resources;
use crate::slave::{Master, Slave, Version};
use crate::start_file;
use crate::state::Call;
use crate::unit::Unit;

/// A string of C, without the zeros in it.
pub(crate) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// An instance, as a `Box<Slave<U>>`; null after a message if the arguments don't fit this FMU. `texts` are name, token and resource
/// location, a URI or a path. `messages` is given the name. `master` returns what the master handles, and passes
/// on warnings; or why there is no instance.
///
/// # Safety
/// The texts are null or end with a zero.
pub(crate) unsafe fn create<U: Unit>(
    version: Version,
    texts: [*const c_char; 3],
    debug: bool,
    messages: impl FnOnce(&str) -> Option<Sink>,
    master: impl FnOnce(&dyn Fn(&str)) -> Result<Master, String>,
) -> *mut c_void {
    contain(ptr::null_mut(), || {
        let texts = texts.map(|pointer| text(pointer).map_err(|error| error.to_string()));
        let sink = messages(texts[0].as_ref().ok().and_then(Option::as_deref).unwrap_or_default());
        let function = match version {
            Version::Two => "fmi2Instantiate",
            Version::Three => "fmi3InstantiateCoSimulation",
        };
        let log = Log::new(sink, debug);
        let report = |status, category, text: &str| log.send(status, category, &format!("{function}: {text}"));
        let started = start::<U>(version, texts, master, &|text| {
            report(Status::Warning, Category::Warning, text)
        });
        let Ok((master, start)) = started.map_err(|why| report(Status::Error, Category::Error, &why)) else {
            return ptr::null_mut();
        };
        let slave = Slave::<U>::with(master, log, start);
        slave.log_remarks(dispatch::remark().as_slice());
        Box::into_raw(Box::new(slave)).cast()
    })
}

/// Frees an instance; null is legal. Within `fmi3DoStep`, in intermediate update mode, nothing happens.
///
/// # Safety
/// `instance` is null or a `Box<Slave<U>>` released by an `instantiate` function, which is not used any more.
pub(crate) unsafe fn free_instance<U: Unit>(instance: *mut c_void) {
    contain((), || {
        let pointer = instance.cast::<Slave<U>>();
        if pointer.as_ref().is_some_and(|slave| slave.allow(Call::Always).is_ok()) {
            drop(Box::from_raw(pointer));
        }
    });
}

/// What the master handles, and the start values of the instance; or why there is none.
fn start<U: Unit>(
    version: Version,
    [name, token, location]: [Result<Option<String>, String>; 3],
    master: impl FnOnce(&dyn Fn(&str)) -> Result<Master, String>,
    warn: &dyn Fn(&str),
) -> Result<(Master, U::Settings), String> {
    let name = name?.unwrap_or_default();
    if name.is_empty() || version == Version::Three && name.trim().is_empty() {
        return Err("the instance name is missing".to_owned());
    }
    let what = match version {
        Version::Two => "GUID",
        Version::Three => "instantiation token",
    };
    let token = token?.ok_or_else(|| format!("the {what} is missing"))?;
    let master = master(warn)?;
    // A location that means no place is a warning: without start values in its resources an FMU works too.
    let places = resources::places(&location?.unwrap_or_default());
    let mut places = places.map_err(|why| warn(&why)).unwrap_or_default();
    places.extend(library::own_path().and_then(|path| resources::beside(&path)));
    let defaults = load::<U>(&places)?;
    let own = description::token::<U>(version, U::data(&defaults));
    let is_copy = start_file::is_of_copy(&token, &own).ok_or_else(|| {
        format!("the {what} {token} is not that of this binary, {own}: the model description belongs to another binary")
    })?;
    let start = start_file::find::<U>(&places, is_copy, &defaults)?;
    Ok((master, start.unwrap_or(defaults)))
}

/// The settings of a new instance with the data of the first folder that has them.
fn load<U: Unit>(folders: &[PathBuf]) -> Result<U::Settings, String> {
    let mut found = folders.iter().map(|folder| U::load(Some(folder)));
    let first = found.next().unwrap_or_else(|| U::load(None));
    first.or_else(|why| found.find_map(Result::ok).ok_or(why))
}
