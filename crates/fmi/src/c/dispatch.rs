//! Forwarding to a variant of the library for newer processors.
//!
//! A portable build has two libraries for x86-64: `Name`, which runs everywhere, and `Name-avx2` in
//! the same folder. The first instance that `Name` creates there opens `Name-avx2`, those beside it
//! share it, because they exchange stored states, and the last one closes it: a host that unloads
//! `Name` leaves nothing loaded. A function is looked up at each call: 0.1 µs.
//!
//! `Name` runs by itself, with a warning that says why, if the processor lacks AVX2, if the
//! environment variable `PUSHBELT_AVX2` is "0", or if `Name-avx2` is not the file of its build: to
//! open a damaged or strange library can already end the host, so its hash is compared before.

use std::cell::Cell;
use std::ffi::c_void;
use std::fs;
use std::path::Path;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use super::entry::contain;
use super::library::{self, Library};
use crate::hash;
use crate::unit::Message;

/// Environment variable: "0" makes the library run by itself.
const SWITCH: &str = "PUSHBELT_AVX2";

/// The function by which a variant is told that it is one.
const HANDSHAKE: &str = "pushbeltVariant";

/// Why the library of a portable build runs.
static MESSAGE: Mutex<Option<Message>> = Mutex::new(None);

/// The variant, while instances are in it.
static VARIANT: Mutex<Weak<Library>> = Mutex::new(Weak::new());

static INSTANCES: AtomicUsize = AtomicUsize::new(0);

fn now<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What the log of a new instance has about the choice of the library.
pub(crate) fn message() -> Option<Message> {
    now(&MESSAGE).clone()
}

/// Another library opens this one as its variant.
pub fn handshake() {
    let (warning, text) = (false, "the library for processors with AVX2 runs".to_owned());
    *now(&MESSAGE) = Some(Message { warning, text });
}

/// What a host has as an instance of a library with a variant.
struct Handle {
    instance: *mut c_void,
    /// The library of the instance, if it is not this one.
    variant: Option<Arc<Library>>,
    is_in_call: Cell<bool>,
}

impl Handle {
    /// A function of the variant; null for an instance of this library.
    fn function(&self, name: &str) -> *mut c_void {
        self.variant.as_ref().map_or(null_mut(), |library| library.find(name))
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        let mut variant = now(&VARIANT);
        self.variant = None;
        if variant.strong_count() == 0 {
            // Its memory is freed, since the host may unload this library now.
            *variant = Weak::new();
        }
    }
}

/// Creates an instance in the variant whose file has this hash, or here. `call` makes the call, of
/// a function of the variant or, if that is null, of this library.
pub fn create(hash: &str, name: &str, call: impl FnOnce(*mut c_void) -> *mut c_void) -> *mut c_void {
    let mut handle = Handle {
        instance: null_mut(),
        variant: contain(None, || choose(hash)),
        is_in_call: Cell::new(false),
    };
    handle.instance = call(handle.function(name));
    contain(null_mut(), || {
        if handle.instance.is_null() {
            return null_mut();
        }
        INSTANCES.fetch_add(handle.variant.is_none().into(), SeqCst);
        Box::into_raw(Box::new(handle)).cast()
    })
}

/// Makes a call on an instance: `call` gets it as its library has it, and the function as in
/// [`create`].
///
/// # Safety
/// `c` is null, or comes from [`create`] and has not been freed.
pub unsafe fn on<T>(c: *mut c_void, name: &str, call: impl FnOnce(*mut c_void, *mut c_void) -> T) -> T {
    // SAFETY: the caller grants that it is null or a boxed handle. The references of two calls at
    // once, of which one is in a callback of the other, are both shared: `is_in_call` is a cell.
    let Some(handle) = (unsafe { c.cast::<Handle>().as_ref() }) else {
        return call(null_mut(), null_mut());
    };
    let outer = handle.is_in_call.replace(true);
    let result = call(handle.instance, handle.function(name));
    handle.is_in_call.set(outer);
    result
}

/// Frees an instance; null is legal. In a callback of a call on the instance nothing happens.
///
/// # Safety
/// As for [`on`].
pub unsafe fn free(c: *mut c_void, name: &str, call: impl FnOnce(*mut c_void, *mut c_void)) {
    let handle = c.cast::<Handle>();
    // SAFETY: the caller grants that it is null or a boxed handle.
    if unsafe { handle.as_ref() }.is_some_and(|handle| !handle.is_in_call.get()) {
        // SAFETY: the same handle.
        unsafe { on(c, name, call) };
        contain((), || {
            // SAFETY: it is not null, so it is from `Box::into_raw` in `create`, and has not been
            // freed. No call on it is in progress, and none follows.
            let handle = unsafe { Box::from_raw(handle) };
            INSTANCES.fetch_sub(handle.variant.is_none().into(), SeqCst);
        });
    }
}

fn choose(hash: &str) -> Option<Arc<Library>> {
    if INSTANCES.load(SeqCst) > 0 {
        return None;
    }
    let mut variant = now(&VARIANT);
    if let Some(open) = variant.upgrade() {
        return Some(open);
    }
    let found = open(hash).map(Arc::new).map_err(|why| {
        let text = format!("the slower library for all processors runs: {why}");
        *now(&MESSAGE) = Some(Message::warning(text));
    });
    *variant = found.as_ref().map(Arc::downgrade).unwrap_or_default();
    found.ok()
}

/// Opens the variant, or says why this library runs by itself.
fn open(hash: &str) -> Result<Library, String> {
    if !has_avx2() {
        return Err("the processor has no AVX2".to_owned());
    }
    if std::env::var_os(SWITCH).is_some_and(|value| value == "0") {
        return Err(format!("{SWITCH} is 0"));
    }
    let own = library::own_path().ok_or("the path of this library is unknown")?;
    let name = own.file_stem().unwrap_or_default().display();
    let path = own.with_file_name(format!("{name}-avx2{}", std::env::consts::DLL_SUFFIX));
    let opened = check(&path, hash).and_then(|()| load(&path));
    opened.map_err(|why| format!("{}: {why}", path.display()))
}

/// Loads a checked file.
fn load(path: &Path) -> Result<Library, String> {
    // SAFETY: `check` has compared the file's hash with that of the library compiled with this one,
    // whose initialisation is that of Rust's standard library.
    let library = unsafe { Library::open(path) }?;
    let handshake = library.find(HANDSHAKE);
    if handshake.is_null() {
        return Err("it has no handshake".to_owned());
    }
    // SAFETY: it is not null, and `export!` gives the function of this name this type. The library
    // is open.
    unsafe { std::mem::transmute::<*mut c_void, extern "C" fn()>(handshake)() };
    Ok(library)
}

fn check(path: &Path, hash: &str) -> Result<(), String> {
    // Without these checks the message would be that of the operating system, and a pipe would keep
    // the host waiting.
    let found = fs::metadata(path).map_err(|_| "there is no such file")?;
    if !found.is_file() || !hash.starts_with(&format!("{}-", found.len())) {
        let size = found.len();
        return Err(format!("it has {size} bytes and is not the file of this build"));
    }
    if hash::of_file(&fs::read(path).map_err(|error| error.to_string())?) != hash {
        return Err("its content is not that of this build".to_owned());
    }
    Ok(())
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_has_the_size_and_the_content_of_its_build() {
        let path = std::env::temp_dir().join(format!("pushbelt-fmi variant {}", std::process::id()));
        let checked = |content: &[u8]| {
            fs::write(&path, content).expect("a file");
            check(&path, &hash::of_file(b"good")).err()
        };
        assert_eq!(checked(b"good"), None);
        assert!(checked(b"evil").is_some_and(|why| why.contains("content")));
        assert!(checked(b"goods").is_some_and(|why| why.contains("5 bytes")));
        fs::remove_file(&path).expect("there");
        assert!(check(&path, "4-").is_err_and(|why| why.contains("no such file")));
    }

    /// There is no file with this hash, so the instance is one of this library.
    #[test]
    fn an_instance_is_freed_once_and_not_within_a_call_on_it() {
        let (mut value, freed) = (0_u8, Cell::new(0));
        let instance: *mut c_void = (&raw mut value).cast();
        let c = create("0-0", "create", |function| {
            assert!(function.is_null());
            instance
        });
        let own = || INSTANCES.load(SeqCst);
        assert_eq!(own(), 1);
        assert!(message().is_some_and(|why| why.warning && why.text.starts_with("the slower library")));
        // SAFETY: it is from `create`, and null is legal.
        unsafe {
            let free_it = || {
                free(c, "free", |found, _| {
                    freed.set(freed.get() + u8::from(found == instance))
                })
            };
            on(c, "call", |_, _| {
                on(c, "call within it", |_, _| ());
                free_it();
            });
            assert_eq!((freed.get(), own()), (0, 1));
            free_it();
            assert_eq!((freed.get(), own()), (1, 0));
            free(null_mut(), "free", |_, _| panic!("an instance"));
        }
        assert!(create("0-0", "create", |_| null_mut()).is_null() && own() == 0);
    }
}
