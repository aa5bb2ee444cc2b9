//! A stored state as bytes, for `fmi2SerializeFMUstate` and back.
//!
//! ```text
//! "FMUstate"  version  GUID hash  content  checksum
//! 8 bytes     4        16                  16
//! ```
//! Numbers are little-endian. The GUID identifies the variable table and so the meaning of the
//! settings. The checksum covers all bytes before it. Bytes that do not fit are refused with the
//! reason.

use crate::hash;

/// Version of the layout, to be raised with every change of what is stored.
const VERSION: u32 = 23;

/// The first bytes of a stored state of the FMU with this GUID.
fn head(guid: &str) -> Vec<u8> {
    let guid = hash::of_bytes(guid.as_bytes());
    [&b"FMUstate"[..], &VERSION.to_le_bytes(), &guid.to_le_bytes()].concat()
}

/// The content as a stored state of the FMU with this GUID, if there is content, and memory for a
/// copy.
///
/// # Errors
/// There is none, or no memory.
pub(super) fn seal(guid: &str, content: &[u8]) -> Result<Vec<u8>, String> {
    let (mut bytes, head) = (Vec::new(), head(guid));
    if content.is_empty() || bytes.try_reserve_exact(head.len() + content.len() + 16).is_err() {
        return Err("there is no memory for the bytes of the state".to_owned());
    }
    bytes.extend_from_slice(&head);
    bytes.extend_from_slice(content);
    bytes.extend_from_slice(&hash::of_words(&bytes).to_le_bytes());
    Ok(bytes)
}

/// The content, if the bytes are complete and a state of this FMU.
///
/// # Errors
/// They are of another FMU or layout, incomplete or damaged.
pub(super) fn open<'a>(guid: &str, bytes: &'a [u8]) -> Result<&'a [u8], String> {
    let (head, is_not) = (head(guid), "these bytes are not a stored state");
    let Some(rest) = bytes.strip_prefix(&head[..8]) else {
        return Err(format!("{is_not} of an FMU"));
    };
    if let Some((version, _)) = rest.split_first_chunk()
        && *version != VERSION.to_le_bytes()
    {
        return Err(format!(
            "the stored state has version {} of the layout, and this FMU reads version {VERSION}: store it again with this FMU",
            u32::from_le_bytes(*version)
        ));
    }
    let Some(rest) = rest.strip_prefix(&head[8..]) else {
        return Err(format!(
            "{is_not} of the FMU with the GUID {guid}, but of another version of it, or of another FMU"
        ));
    };
    match rest.split_last_chunk() {
        Some((content, sum)) if hash::of_words(&bytes[..bytes.len() - 16]) == u128::from_le_bytes(*sum) => {
            Ok(content)
        }
        _ => Err("the stored state is incomplete or damaged: its checksum is wrong".to_owned()),
    }
}
