//! A stored state as bytes, for `fmi2SerializeFMUstate` and back.
//!
//! ```text
//! "FMUstate"  version  GUID hash  length of the content  content            checksum
//! 8 bytes     4        16         8                      length             16
//! ```
//! Numbers are little-endian. The GUID identifies the variable table and so the meaning of the settings. The
//! checksum covers all bytes before it. Bytes that do not fit are refused with the reason.

use crate::hash;

/// The first bytes of a stored state.
const MAGIC: &[u8; 8] = b"FMUstate";
/// Version of the layout, to be raised with every change of what is stored.
const VERSION: u32 = 15;
/// Bytes before the content.
const HEAD: usize = 8 + 4 + 16 + 8;
/// Bytes of the checksum.
const CHECKSUM: usize = 16;

/// The content as a stored state of the FMU with this GUID.
///
/// # Errors
/// There is no content, or no memory for a copy.
pub(super) fn seal(guid: &str, content: &[u8]) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let size = HEAD + content.len() + CHECKSUM;
    if content.is_empty() || bytes.try_reserve_exact(size).is_err() {
        return Err("there is no memory for the bytes of the state".to_owned());
    }
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&hash::of_bytes(guid.as_bytes()).to_le_bytes());
    bytes.extend_from_slice(&(content.len() as u64).to_le_bytes());
    bytes.extend_from_slice(content);
    let checksum = hash::of_words(&bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    Ok(bytes)
}

/// The content, if the bytes are complete and a state of this FMU.
///
/// # Errors
/// The reason, as a sentence.
pub(super) fn open<'a>(guid: &str, bytes: &'a [u8]) -> Result<&'a [u8], String> {
    let too_short = || format!("{} bytes are not a stored state: they end too early", bytes.len());
    let (magic, rest) = bytes.split_first_chunk::<8>().ok_or_else(too_short)?;
    if magic != MAGIC {
        return Err("these bytes are not a stored state of an FMU of this kind".into());
    }
    let (version, rest) = rest.split_first_chunk().ok_or_else(too_short)?;
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        return Err(format!(
            "the stored state has version {version} of the layout, but this FMU reads version {VERSION}"
        ));
    }
    let (owner, rest) = rest.split_first_chunk().ok_or_else(too_short)?;
    if u128::from_le_bytes(*owner) != hash::of_bytes(guid.as_bytes()) {
        return Err(format!("the stored state is from an FMU whose GUID is not {guid}"));
    }
    let (length, rest) = rest.split_first_chunk().ok_or_else(too_short)?;
    let expected = u64::from_le_bytes(*length).checked_add(CHECKSUM as u64);
    if expected != Some(rest.len() as u64) {
        return Err(format!(
            "the stored state is incomplete or followed by other bytes: {} bytes",
            bytes.len()
        ));
    }
    let (content, checksum) = rest.split_last_chunk().ok_or_else(too_short)?;
    if u128::from_le_bytes(*checksum) != hash::of_words(&bytes[..HEAD + content.len()]) {
        return Err("the stored state is damaged: its checksum is wrong".into());
    }
    Ok(content)
}
