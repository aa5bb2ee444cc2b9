//! Shared libraries at run time: the path of this one, and another one.

use std::ffi::{CStr, c_void};
use std::path::{Path, PathBuf};

/// A shared library that stays loaded until it is dropped.
pub struct Library(*mut c_void);

// SAFETY: a handle belongs to the process, and the functions on it may be called by any thread.
unsafe impl Send for Library {}

impl Library {
    /// Loads a library.
    ///
    /// # Errors
    /// The reason of the operating system.
    ///
    /// # Safety
    /// The initialisation of the library is sound.
    pub unsafe fn open(path: &Path) -> Result<Self, String> {
        // SAFETY: as the caller grants.
        unsafe { system::open(path) }.map(Self)
    }

    /// The address of an exported function; null if there is none.
    pub fn find(&self, name: &CStr) -> *mut c_void {
        system::find(self.0, name)
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        system::close(self.0);
    }
}

/// The folder of the library, or of the program, that contains this code: the real one, on which neither a link to the library nor the
/// working directory has an effect.
///
/// # Errors
/// The operating system has no path for it.
pub fn own_folder() -> Result<PathBuf, String> {
    let path = own_path();
    let folder = path.as_deref().and_then(Path::parent).map(Path::to_owned);
    folder.ok_or_else(|| "the path of this library is unknown".to_owned())
}

/// A byte of this library, whose address identifies the library.
static HERE: u8 = 0;

/// The path of the file that the library was loaded from, without links. `dladdr` has the path that the host gave to `dlopen`,
/// which may be relative to another working directory than that of today.
#[cfg(target_os = "linux")]
fn own_path() -> Option<PathBuf> {
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

/// The path that the system has kept since the library was loaded, without links. A relative one is of no use.
#[cfg(not(target_os = "linux"))]
fn own_path() -> Option<PathBuf> {
    system::own_path()
        .filter(|path| path.is_absolute())?
        .canonicalize()
        .ok()
}

#[cfg(unix)]
mod system {
    use std::ffi::{CStr, CString, c_void};
    use std::os::unix::ffi::OsStrExt as _;
    use std::path::Path;

    pub unsafe fn open(path: &Path) -> Result<*mut c_void, String> {
        let path = CString::new(path.as_os_str().as_bytes()).map_err(|error| error.to_string())?;
        // SAFETY: the path ends with a zero; the caller grants that the initialisation is sound. The text of `dlerror` is valid
        // until the next call on this thread.
        unsafe {
            let handle = libc::dlopen(path.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL);
            if !handle.is_null() {
                return Ok(handle);
            }
            let why = libc::dlerror();
            Err(if why.is_null() {
                "it can't be loaded".to_owned()
            } else {
                CStr::from_ptr(why).to_string_lossy().into_owned()
            })
        }
    }

    pub fn find(handle: *mut c_void, name: &CStr) -> *mut c_void {
        // SAFETY: the handle is open, and the name ends with a zero.
        unsafe { libc::dlsym(handle, name.as_ptr()) }
    }

    pub fn close(handle: *mut c_void) {
        // SAFETY: the handle is open and not used any more.
        unsafe { libc::dlclose(handle) };
    }

    #[cfg(not(target_os = "linux"))]
    pub fn own_path() -> Option<std::path::PathBuf> {
        let mut found = std::mem::MaybeUninit::<libc::Dl_info>::zeroed();
        // SAFETY: `dladdr` fills the structure, or returns zero. The name ends with a zero and is valid while the library is loaded.
        unsafe {
            let known = libc::dladdr((&raw const super::HERE).cast(), found.as_mut_ptr()) != 0;
            let name = found.assume_init().dli_fname;
            (known && !name.is_null()).then(|| std::ffi::OsStr::from_bytes(CStr::from_ptr(name).to_bytes()).into())
        }
    }
}

#[cfg(windows)]
mod system {
    use std::ffi::{CStr, OsString, c_char, c_void};
    use std::os::windows::ffi::{OsStrExt as _, OsStringExt as _};
    use std::path::{Path, PathBuf};
    use std::ptr;

    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn LoadLibraryExW(path: *const u16, file: *mut c_void, flags: u32) -> *mut c_void;
        fn GetProcAddress(module: *mut c_void, name: *const c_char) -> *mut c_void;
        fn FreeLibrary(module: *mut c_void) -> i32;
        fn GetModuleHandleExW(flags: u32, address: *const c_void, module: *mut *mut c_void) -> i32;
        fn GetModuleFileNameW(module: *mut c_void, path: *mut u16, size: u32) -> u32;
    }

    /// `LOAD_LIBRARY_SEARCH_SYSTEM32`: what the library needs is Windows' own.
    const OF_SYSTEM: u32 = 0x800;
    /// `GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS` and `…_UNCHANGED_REFCOUNT`.
    const BY_ADDRESS: u32 = 0x4 | 0x2;
    /// No path of Windows has more characters.
    const LONGEST: u32 = 0x8000;

    pub unsafe fn open(path: &Path) -> Result<*mut c_void, String> {
        let path: Vec<u16> = path.as_os_str().encode_wide().chain([0]).collect();
        // SAFETY: the path ends with a zero; the caller grants that the initialisation is sound.
        let module = unsafe { LoadLibraryExW(path.as_ptr(), ptr::null_mut(), OF_SYSTEM) };
        if module.is_null() {
            return Err(std::io::Error::last_os_error().to_string());
        }
        Ok(module)
    }

    pub fn find(module: *mut c_void, name: &CStr) -> *mut c_void {
        // SAFETY: the module is loaded, and the name ends with a zero.
        unsafe { GetProcAddress(module, name.as_ptr()) }
    }

    pub fn close(module: *mut c_void) {
        // SAFETY: the module is loaded and not used any more.
        unsafe { FreeLibrary(module) };
    }

    pub fn own_path() -> Option<PathBuf> {
        let mut module = ptr::null_mut();
        let mut path = vec![0; LONGEST as usize];
        // SAFETY: the address is in this module, which stays loaded while its code runs; the array has the given size.
        let length = unsafe {
            if GetModuleHandleExW(BY_ADDRESS, (&raw const super::HERE).cast(), &raw mut module) == 0 {
                return None;
            }
            GetModuleFileNameW(module, path.as_mut_ptr(), LONGEST)
        };
        (0 < length && length < LONGEST).then(|| OsString::from_wide(&path[..length as usize]).into())
    }
}
