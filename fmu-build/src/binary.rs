//! Properties of a compiled shared library: the glibc that it needs, and its time stamp.

use anyhow::Context;
use object::endian::Endianness;
use object::read::elf::{ElfFile64, FileHeader as _, SectionTable};

/// The newest glibc version among the symbols that a Linux library needs; none if it is not a Linux
/// library or needs no glibc at all.
///
/// # Errors
/// The symbol table can't be read.
pub fn newest_glibc(library: &[u8]) -> anyhow::Result<Option<(u32, u32)>> {
    if !library.starts_with(b"\x7fELF") {
        return Ok(None);
    }
    let file = ElfFile64::<Endianness>::parse(library).context("the library can't be read")?;
    let endian = file.endian();
    let sections: SectionTable<'_, _, _> = file.elf_header().sections(endian, library)?;
    let Some((mut needs, names)) = sections.gnu_verneed(endian, library)? else {
        return Ok(None);
    };
    let names = sections.strings(endian, library, names)?;
    let mut newest = None;
    while let Some((_, mut versions)) = needs.next()? {
        while let Some(version) = versions.next()? {
            let name = version.name(endian, names)?;
            newest = newest.max(glibc_version(&String::from_utf8_lossy(name)));
        }
    }
    Ok(newest)
}

/// Sets the time stamp in the header of a Windows library to zero, so that the same code gives the
/// same bytes.
pub fn clear_time_stamp(library: &mut [u8]) {
    if !library.starts_with(b"MZ") {
        return;
    }
    // The head begins with "PE\0\0", machine and number of sections; its offset is at 0x3c.
    let place = library.get(0x3c..0x40).and_then(|bytes| bytes.try_into().ok());
    let head = place.map(|bytes| u32::from_le_bytes(bytes) as usize);
    if let Some(stamp) = head.and_then(|head| library.get_mut(head + 8..head + 12)) {
        stamp.fill(0);
    }
}

/// Major and minor number of `GLIBC_x.y` or `GLIBC_x.y.z`.
fn glibc_version(name: &str) -> Option<(u32, u32)> {
    let mut numbers = name.strip_prefix("GLIBC_")?.split('.');
    Some((numbers.next()?.parse().ok()?, numbers.next()?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn version_names_are_read() {
        assert_eq!(glibc_version("GLIBC_2.2.5"), Some((2, 2)));
        assert_eq!(glibc_version("GLIBC_2.34"), Some((2, 34)));
        assert_eq!(glibc_version("GCC_3.0"), None);
    }

    #[test]
    fn the_time_stamp_of_a_windows_library_is_cleared() {
        let mut library = vec![0xff_u8; 0x100];
        library[..2].copy_from_slice(b"MZ");
        library[0x3c..0x40].copy_from_slice(&0x80_u32.to_le_bytes());
        let before = library.clone();
        clear_time_stamp(&mut library);
        let changed: Vec<_> = (0..library.len()).filter(|&i| library[i] != before[i]).collect();
        assert_eq!(changed, [0x88, 0x89, 0x8a, 0x8b]);
        clear_time_stamp(&mut b"MZ".to_vec());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_program_needs_some_glibc() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        let needed = newest_glibc(&program).unwrap();
        assert!(cfg!(not(target_env = "gnu")) || needed >= Some((2, 2)), "{needed:?}");
        assert_eq!(newest_glibc(b"MZ").unwrap(), None);
    }
}
