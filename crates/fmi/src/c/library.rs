//! The file that this code was loaded from: the shared library of the FMU.

use std::path::PathBuf;

/// Its absolute path; `None` if the system does not say.
#[cfg(unix)]
pub(crate) fn path() -> Option<PathBuf> {
    use std::ffi::{CStr, OsStr};
    use std::mem::MaybeUninit;
    use std::os::unix::ffi::OsStrExt;

    let mut found = MaybeUninit::<libc::Dl_info>::uninit();
    // SAFETY: the function writes to `found`, and returns zero if it has not.
    if unsafe { libc::dladdr(path as *const libc::c_void, found.as_mut_ptr()) } == 0 {
        return None;
    }
    // SAFETY: written, as the result says. The name belongs to the library, which is loaded while its code runs.
    let name = unsafe {
        let name = found.assume_init().dli_fname;
        if name.is_null() {
            return None;
        }
        CStr::from_ptr(name)
    };
    std::fs::canonicalize(OsStr::from_bytes(name.to_bytes())).ok()
}

/// Its absolute path; `None` if the system does not say.
#[cfg(windows)]
pub(crate) fn path() -> Option<PathBuf> {
    use std::ffi::{OsString, c_void};
    use std::os::windows::ffi::OsStringExt;
    use std::ptr::null_mut;

    // `GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS` and `GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT`.
    const FROM_ADDRESS: u32 = 4;
    const UNCHANGED_REFCOUNT: u32 = 2;
    /// Characters of the longest path.
    const LONGEST: usize = 1 << 15;

    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn GetModuleHandleExW(flags: u32, address: *const c_void, module: *mut *mut c_void) -> i32;
        fn GetModuleFileNameW(module: *mut c_void, name: *mut u16, size: u32) -> u32;
    }

    let mut module = null_mut();
    // SAFETY: with these flags the second argument is an address within a module, and the module's use is not counted.
    let known = unsafe {
        GetModuleHandleExW(
            FROM_ADDRESS | UNCHANGED_REFCOUNT,
            path as *const c_void,
            &raw mut module,
        )
    };
    let mut name = vec![0_u16; LONGEST];
    let size = u32::try_from(LONGEST).ok()?;
    // SAFETY: a module, and as many characters as the size.
    let length = match known {
        0 => 0,
        _ => unsafe { GetModuleFileNameW(module, name.as_mut_ptr(), size) },
    };
    let length = usize::try_from(length)
        .ok()
        .filter(|length| (1..LONGEST).contains(length))?;
    Some(PathBuf::from(OsString::from_wide(&name[..length])))
}

/// Its absolute path: this system does not say.
#[cfg(not(any(unix, windows)))]
pub(crate) fn path() -> Option<PathBuf> {
    None
}

#[cfg(test)]
mod tests {
    use super::path;

    #[test]
    fn the_code_of_a_test_is_in_its_program() {
        let program = std::env::current_exe().expect("a test has a path");
        assert_eq!(path(), Some(program.canonicalize().expect("it exists")));
    }
}
