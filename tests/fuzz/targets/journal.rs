//! State of an unfinished encode: a journal, and the container that it describes.

use codec::container::journal::recover;

use super::{Judged, Verdict, refused};

/// Splits an input into journal and container. An input is the length of the journal in four bytes, the journal, and the
/// container.
pub fn parts(bytes: &[u8]) -> (&[u8], &[u8]) {
    let Some((length, rest)) = bytes.split_first_chunk() else { return (bytes, &[]) };
    rest.split_at(rest.len().min(u32::from_le_bytes(*length) as usize))
}

/// Recovers a journal and its container, truncates both to the recovered length, and recovers again.
pub fn run(bytes: &[u8]) -> Judged {
    let (journal, container) = parts(bytes);
    let found = match recover(journal, container) {
        Ok(Some(found)) => found,
        Ok(None) => return Ok(Verdict::Refused),
        Err(error) => return refused(&error),
    };
    let (Some(journal), Some(container)) =
        (journal.get(..found.journal_bytes as usize), container.get(..found.container_bytes as usize))
    else {
        return Err(format!("more is sound than there is: {found:?}"));
    };
    let whole =
        |entry: &codec::container::ChunkEntry| entry.offset + u64::from(entry.stored_bytes) <= found.container_bytes;
    if !found.chunks.iter().all(|chunk| whole(&chunk.entry)) {
        return Err(format!("a chunk lies beyond what is sound: {found:?}"));
    }
    match recover(journal, container) {
        Ok(Some(again))
            if again.chunks == found.chunks
                && again.notes == found.notes
                && (again.container_bytes, again.journal_bytes) == (found.container_bytes, found.journal_bytes) =>
        {
            Ok(Verdict::Accepted)
        }
        other => Err(format!("{found:?} becomes {other:?} once it is cut off")),
    }
}

/// A record of 53 bytes becomes a row and an entry in each of two maps, which double in size when they grow.
pub fn bound(bytes: &[u8]) -> u64 {
    (1 << 20) + 16 * bytes.len() as u64
}
