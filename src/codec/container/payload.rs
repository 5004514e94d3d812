//! Bytes of a chunk: in their own memory, or a range of a container in shared memory.

use std::ops::{Deref, Range};
use std::sync::Arc;

#[derive(Debug, Clone)]
enum Backing {
    Own(Vec<u8>),
    Shared(Arc<Vec<u8>>),
}

#[derive(Debug, Clone)]
pub struct Payload {
    backing: Backing,
    range: Range<usize>,
}

impl Payload {
    /// Returns a range of shared memory; `range` must lie inside it.
    pub fn shared(memory: &Arc<Vec<u8>>, range: Range<usize>) -> Payload {
        Payload { backing: Backing::Shared(Arc::clone(memory)), range }
    }

    /// Returns the first `length` bytes of `memory`, all of which is kept for reuse.
    pub fn front_of(memory: Vec<u8>, length: usize) -> Payload {
        let length = length.min(memory.len());
        Payload { backing: Backing::Own(memory), range: 0..length }
    }

    /// Removes the first `bytes` bytes.
    #[must_use]
    pub fn skip(mut self, bytes: usize) -> Payload {
        self.range.start = (self.range.start + bytes).min(self.range.end);
        self
    }

    /// Splits the payload into consecutive parts of these lengths, which share its memory. Parts end at the end of the
    /// payload.
    pub fn split(self, lengths: impl Iterator<Item = usize>) -> Vec<Payload> {
        let Range { mut start, end } = self.range;
        let memory = match self.backing {
            Backing::Own(memory) => Arc::new(memory),
            Backing::Shared(memory) => memory,
        };
        let next = |length: usize| {
            let part = start..(start + length).min(end);
            start = part.end;
            Payload::shared(&memory, part)
        };
        lengths.map(next).collect()
    }

    /// Returns the memory, for reuse by the next chunk; empty if it is shared.
    pub fn into_spare(self) -> Vec<u8> {
        match self.backing {
            Backing::Own(memory) => memory,
            Backing::Shared(_) => Vec::new(),
        }
    }

    pub fn into_vec(self) -> Vec<u8> {
        match self.backing {
            Backing::Own(mut memory) => {
                memory.truncate(self.range.end);
                memory.drain(..self.range.start);
                memory
            }
            Backing::Shared(memory) => memory[self.range].to_vec(),
        }
    }
}

impl From<Vec<u8>> for Payload {
    fn from(memory: Vec<u8>) -> Payload {
        let length = memory.len();
        Payload::front_of(memory, length)
    }
}

impl Deref for Payload {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match &self.backing {
            Backing::Own(memory) => &memory[self.range.clone()],
            Backing::Shared(memory) => &memory[self.range.clone()],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_show_just_their_bytes() {
        let memory = Arc::new(vec![1, 2, 3, 4, 5]);
        let shared = Payload::shared(&memory, 1..3);
        assert_eq!(*shared, [2, 3]);
        assert_eq!(shared.clone().into_vec(), [2, 3]);
        assert!(shared.into_spare().is_empty());
        let parts = Payload::from(vec![1, 2, 3]).skip(1).split([0, 1, 2].into_iter());
        assert_eq!(parts.into_iter().map(Payload::into_vec).collect::<Vec<_>>(), [vec![], vec![2], vec![3]]);
        let front = Payload::front_of(vec![9, 8, 7], 2);
        assert_eq!(*front, [9, 8]);
        assert_eq!(front.clone().into_spare(), [9, 8, 7]);
        assert_eq!(*front.clone().skip(1), [8]);
        assert!(front.clone().skip(3).is_empty());
        assert_eq!(front.clone().skip(1).into_vec(), [8]);
        assert_eq!(front.into_vec(), [9, 8]);
    }
}
