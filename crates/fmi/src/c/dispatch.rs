//! Forwarding to a variant of the library for newer processors.
//!
//! A portable build has two libraries for x86-64: `Name`, which runs everywhere and is complete by itself, and `Name-avx2` in the
//! same folder. `Name` opens `Name-avx2` when it creates an instance and has no other instance. Then it forwards calls on
//! instances there, until the last instance is freed; then it closes `Name-avx2`. So an instance is used only by the library
//! that created it, and a host that unloads `Name` after its instances leaves nothing loaded.
//!
//! `Name` runs by itself, with a warning that says why, if the processor lacks AVX2, if the environment variable `PUSHBELT_AVX2` is "0",
//! or if `Name-avx2` is not the file of its build. `Name` contains the hash of that file and compares it before the system opens the
//! file, because to open a damaged or strange library can already end the host.

use std::ffi::{CStr, c_void};
use std::fs;
use std::path::Path;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicPtr, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::entry::contain;
use super::library::{self, Library};
use crate::hash;
use crate::log::{Category, Status};

/// Environment variable: "0" makes the library run by itself.
const SWITCH: &str = "PUSHBELT_AVX2";

/// Instances of this library.
pub(super) static INSTANCES: AtomicUsize = AtomicUsize::new(0);

/// The function by which a library opens its variant: it returns the number of instances.
const HANDSHAKE: &CStr = c"pushbeltVariant";
type Handshake = unsafe extern "C" fn() -> *const AtomicUsize;

/// A message for the log.
type Remark = (Status, Category, String);

/// Why the library of a portable build runs.
static REMARK: Mutex<Option<Remark>> = Mutex::new(None);

/// What the log of a new instance has about the choice of the library.
pub(crate) fn remark() -> Option<Remark> {
    locked(&REMARK).clone()
}

/// What an exported function does with instances.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Creates one.
    Create,
    /// Frees one.
    Free,
    /// Is called on one.
    Call,
    /// Has none. Never forwarded, so it can be called while the variant is closed.
    Without,
}

impl Kind {
    /// The kind of a function, by its name and whether its first argument is an instance.
    #[must_use]
    pub const fn of(name: &str, on_instance: bool) -> Self {
        match name.as_bytes() {
            b"fmi2Instantiate" | b"fmi3InstantiateCoSimulation" => Self::Create,
            b"fmi2FreeInstance" | b"fmi3FreeInstance" => Self::Free,
            _ if on_instance => Self::Call,
            _ => Self::Without,
        }
    }
}

/// A text that ends with a zero, in constants too.
///
/// # Panics
/// It ends with no zero.
#[must_use]
pub const fn c_string(text: &'static str) -> &'static CStr {
    match CStr::from_bytes_with_nul(text.as_bytes()) {
        Ok(text) => text,
        Err(_) => panic!("no zero at the end"),
    }
}

/// An exported function of the variant.
pub struct Forward {
    name: &'static CStr,
    kind: Kind,
    /// The opening of the variant in which the function was found, counted from 1; 0 before the first.
    opening: AtomicUsize,
    function: AtomicPtr<c_void>,
}

impl Forward {
    /// A function of a kind, not found yet.
    #[must_use]
    pub const fn new(name: &'static CStr, kind: Kind) -> Self {
        Self {
            name,
            kind,
            opening: AtomicUsize::new(0),
            function: AtomicPtr::new(null_mut()),
        }
    }
}

/// The variant of a library.
pub struct Dispatch {
    model: &'static str,
    /// Identifies the file of the variant, as [`hash::of_file`]; none in a library that has no variant.
    variant: Option<&'static str>,
    /// The present opening of the variant, counted from 1; 0 while it is closed.
    opening: AtomicUsize,
    state: Mutex<State>,
}

struct State {
    /// Running calls that create or free an instance.
    calls: usize,
    /// How often the variant has been opened.
    openings: usize,
    open: Option<Variant>,
}

struct Variant {
    /// Closed when this is dropped.
    library: Library,
    instances: *const AtomicUsize,
}

// SAFETY: the counter is a static of the library, which is open as long as this exists.
unsafe impl Send for Variant {}

impl Dispatch {
    /// The dispatcher of the library of a model; `variant` is the hash of its variant's file ([`hash::of_file`]).
    #[must_use]
    pub const fn new(model: &'static str, variant: Option<&'static str>) -> Self {
        Self {
            model,
            variant,
            opening: AtomicUsize::new(0),
            state: Mutex::new(State {
                calls: 0,
                openings: 0,
                open: None,
            }),
        }
    }

    /// Keeps the choice of the library until [`Self::leave`], and makes one for a call that creates the first instance.
    fn enter(&self, variant: &str, kind: Kind) {
        let mut state = locked(&self.state);
        state.calls += 1;
        let is_first = state.calls == 1 && INSTANCES.load(Ordering::SeqCst) == 0;
        if kind != Kind::Create || state.open.is_some() || !is_first {
            return;
        }
        match self.find(variant) {
            Ok(variant) => {
                state.open = Some(variant);
                state.openings += 1;
                self.opening.store(state.openings, Ordering::Release);
            }
            Err(why) => {
                let text = format!("the slower library for all processors runs: {why}");
                *locked(&REMARK) = Some((Status::Warning, Category::Warning, text));
            }
        }
    }

    /// Closes the variant if it has no instance and no call that creates or frees one.
    fn leave(&self) {
        let mut state = locked(&self.state);
        state.calls -= 1;
        // SAFETY: the variant is open.
        let unused = |variant: &Variant| unsafe { &*variant.instances }.load(Ordering::SeqCst) == 0;
        if state.calls == 0 && state.open.as_ref().is_some_and(unused) {
            self.opening.store(0, Ordering::Release);
            state.open = None;
        }
    }

    /// A function of the variant; null while the variant is closed. It is searched for once in each opening.
    fn function(&self, forward: &Forward) -> *mut c_void {
        let opening = self.opening.load(Ordering::Acquire);
        if opening == 0 {
            return null_mut();
        }
        if forward.opening.load(Ordering::Acquire) != opening {
            let found = locked(&self.state)
                .open
                .as_ref()
                .map(|variant| variant.library.find(forward.name));
            forward.function.store(found.unwrap_or(null_mut()), Ordering::Relaxed);
            forward.opening.store(opening, Ordering::Release);
        }
        forward.function.load(Ordering::Relaxed)
    }

    /// Opens the variant.
    ///
    /// # Errors
    /// Why this library runs by itself.
    fn find(&self, variant: &str) -> Result<Variant, String> {
        if !has_avx2() {
            return Err("the processor has no AVX2".to_owned());
        }
        if std::env::var_os(SWITCH).is_some_and(|value| value == "0") {
            return Err(format!("{SWITCH} is 0"));
        }
        let name = format!("{}-avx2{}", self.model, std::env::consts::DLL_SUFFIX);
        let path = library::own_folder()?.join(name);
        open(&path, variant).map_err(|why| format!("{}: {why}", path.display()))
    }
}

/// Opens a variant if it is the file with this hash.
fn open(path: &Path, variant: &str) -> Result<Variant, String> {
    // Without these checks the message would be that of the operating system, and a pipe would keep the host waiting.
    let found = fs::metadata(path).map_err(|_| "there is no such file")?;
    if !found.is_file() || !variant.starts_with(&format!("{}-", found.len())) {
        return Err(format!(
            "it has {} bytes and is not the file of this build",
            found.len()
        ));
    }
    if hash::of_file(&fs::read(path).map_err(|error| error.to_string())?) != variant {
        return Err("its content is not that of this build".to_owned());
    }
    // SAFETY: it is the library that was compiled with this one. Its initialisation is that of Rust's standard library.
    let library = unsafe { Library::open(path) }?;
    let handshake = library.find(HANDSHAKE);
    if handshake.is_null() {
        return Err("it has no handshake".to_owned());
    }
    // SAFETY: the library exports the function of this name, with this type.
    let instances = unsafe { std::mem::transmute::<*mut c_void, Handshake>(handshake)() };
    Ok(Variant { library, instances })
}

/// The number of instances of this library, for the library whose variant it is.
pub fn handshake() -> *const c_void {
    let text = "the library for processors with AVX2 runs".to_owned();
    *locked(&REMARK) = Some((Status::Ok, Category::Events, text));
    (&raw const INSTANCES).cast()
}

/// Makes the call of an exported function, here or in the variant. A call that creates or frees an instance keeps the variant open.
pub fn through<T>(dispatch: Option<&Dispatch>, forward: &Forward, call: impl FnOnce(*mut c_void) -> T) -> T {
    let Some(dispatch) = dispatch else {
        return call(null_mut());
    };
    let kind = forward.kind;
    let held = dispatch.variant.filter(|_| matches!(kind, Kind::Create | Kind::Free));
    if let Some(variant) = held {
        contain((), || dispatch.enter(variant, kind));
    }
    let result = call(match kind {
        Kind::Without => null_mut(),
        _ => dispatch.function(forward),
    });
    if held.is_some() {
        contain((), || dispatch.leave());
    }
    result
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}
