//! Shared libraries at run time: the path of this one, and another one.

use std::ffi::c_void;
use std::path::{Path, PathBuf};
use std::ptr::null_mut;

#[cfg(unix)]
use libloading::os::unix;
#[cfg(windows)]
use libloading::os::windows;

/// A shared library that stays loaded until it is dropped.
pub struct Library(libloading::Library);

impl Library {
    /// Loads a library, whose own libraries must be those of the system.
    ///
    /// # Safety
    /// The initialisation of the library at this path, and its end when it is closed, may run in
    /// this process.
    ///
    /// # Errors
    /// The system can't load it, with the system's reason.
    pub unsafe fn open(path: &Path) -> Result<Self, String> {
        // SAFETY: the caller grants that the library's initialisation may run.
        #[cfg(unix)]
        let opened = unsafe { unix::Library::open(Some(path), unix::RTLD_NOW | unix::RTLD_LOCAL) };
        // SAFETY: the caller grants that the library's initialisation may run.
        #[cfg(windows)]
        let opened =
            unsafe { windows::Library::load_with_flags(path, windows::LOAD_LIBRARY_SEARCH_SYSTEM32) };
        opened
            .map(|library| Self(library.into()))
            .map_err(|error| error.to_string())
    }

    /// The address of an exported function; null if there is none.
    pub fn find(&self, name: &str) -> *mut c_void {
        // SAFETY: it is read as an address, which any symbol has. Nothing is called here, and
        // `self` keeps the library open.
        unsafe { self.0.get(name) }.map_or(null_mut(), |address| *address)
    }
}

/// A byte of this library, whose address identifies the library.
static HERE: u8 = 0;

/// The path of the library, or of the program, that contains this code: the real one, on which
/// neither a link to the library nor the working directory has an effect.
pub fn own_path() -> Option<PathBuf> {
    #[cfg(target_os = "linux")]
    if let Some(path) = mapped_from() {
        return Some(path);
    }
    // The working directory may have changed since.
    loaded_from().filter(|path| path.is_absolute())?.canonicalize().ok()
}

/// The path that the kernel has, if `/proc` can be read.
#[cfg(target_os = "linux")]
fn mapped_from() -> Option<PathBuf> {
    use std::os::unix::ffi::OsStrExt as _;

    let here = (&raw const HERE).addr();
    let maps = std::fs::read("/proc/self/maps").ok()?;
    // `7f0000000000-7f0000001000 r--p 00000000 08:01 1234    /path`
    maps.split(|byte| *byte == b'\n').find_map(|line| {
        let range = std::str::from_utf8(line.split(|byte| *byte == b' ').next()?).ok()?;
        let (from, to) = range.split_once('-')?;
        let number = |text| usize::from_str_radix(text, 16).ok();
        let path = &line[line.iter().position(|byte| *byte == b'/')?..];
        (number(from)?..number(to)?)
            .contains(&here)
            .then(|| std::ffi::OsStr::from_bytes(path).into())
    })
}

/// The path that the host gave.
#[cfg(unix)]
fn loaded_from() -> Option<PathBuf> {
    use std::os::unix::ffi::OsStrExt as _;

    let mut found = std::mem::MaybeUninit::<libc::Dl_info>::zeroed();
    // SAFETY: `dladdr` fills the structure, or returns zero. The name ends with a zero and is valid
    // while the library is loaded.
    unsafe {
        let known = libc::dladdr((&raw const HERE).cast(), found.as_mut_ptr()) != 0;
        let name = found.assume_init().dli_fname;
        (known && !name.is_null())
            .then(|| std::ffi::OsStr::from_bytes(std::ffi::CStr::from_ptr(name).to_bytes()).into())
    }
}

#[cfg(windows)]
fn loaded_from() -> Option<PathBuf> {
    use std::os::windows::ffi::OsStringExt as _;

    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn GetModuleHandleExW(flags: u32, address: *const c_void, module: *mut *mut c_void) -> i32;
        fn GetModuleFileNameW(module: *mut c_void, path: *mut u16, size: u32) -> u32;
    }
    /// `GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS` and `…_UNCHANGED_REFCOUNT`.
    const BY_ADDRESS: u32 = 0x4 | 0x2;
    /// No path of Windows has more characters.
    const LONGEST: u32 = 0x8000;

    let (mut module, mut path) = (null_mut(), vec![0; LONGEST as usize]);
    // SAFETY: the address is in this module, which stays loaded while its code runs; the array has
    // the given size.
    let length = unsafe {
        if GetModuleHandleExW(BY_ADDRESS, (&raw const HERE).cast(), &raw mut module) == 0 {
            return None;
        }
        GetModuleFileNameW(module, path.as_mut_ptr(), LONGEST)
    };
    (0 < length && length < LONGEST).then(|| std::ffi::OsString::from_wide(&path[..length as usize]).into())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_library_of_a_test_is_its_program() {
        let program = std::env::current_exe().and_then(std::fs::canonicalize).ok();
        let loaded = super::loaded_from().and_then(|path| path.canonicalize().ok());
        assert_eq!([super::own_path(), loaded], [program.clone(), program]);
    }
}
