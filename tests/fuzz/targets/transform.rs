//! Payloads of the transform codec, with the table sets of their streams (formats/color.md 6 and 7).

use codec::color::HalfKey;
use codec::color::transform::region::held_bytes;
use codec::color::transform::{Keyed, Tables, TransformChunk};
use codec::container::fields::Fields;
use lightfold::Result;

use super::stream::Front;
use super::{Judged, Verdict, refused};

/// Maximum width and height of cells.
const MAX_SIDE: usize = 72;

/// A payload and the parameters of its decoder.
#[derive(Debug, Clone, Default)]
pub struct Case {
    pub is_half: bool,
    pub size: [usize; 2],
    pub frames: u32,
    /// Own table sets as in a codec header; empty for none.
    pub own_sets: Vec<u8>,
    pub payload: Vec<u8>,
}

impl Case {
    /// Parses a case; any bytes are valid.
    fn read(bytes: &[u8]) -> Case {
        let mut front = Front(bytes);
        let is_half = front.u8() & 1 == 1;
        let size = std::array::from_fn(|_| 1 + usize::from(front.u8()) % MAX_SIDE);
        let frames = 1 + u32::from(front.u8()) % 100;
        let count = usize::from(front.u16());
        let own_sets = front.bytes(count).to_vec();
        Case { is_half, size, frames, own_sets, payload: front.0.to_vec() }
    }

    pub fn write(&self) -> Vec<u8> {
        let mut out = vec![u8::from(self.is_half)];
        out.extend(self.size.map(|side| side as u8 - 1));
        out.push(self.frames as u8 - 1);
        out.extend_from_slice(&(self.own_sets.len() as u16).to_le_bytes());
        out.extend_from_slice(&self.own_sets);
        out.extend_from_slice(&self.payload);
        out
    }

    fn tables(&self) -> Result<Tables> {
        if self.own_sets.is_empty() {
            return Ok(Tables::default());
        }
        let mut fields = Fields::new(&self.own_sets, 0, "entropy.md 4");
        let count = fields.u8()?;
        let tables = Tables::read(&mut fields, count)?;
        fields.finish()?;
        Ok(tables)
    }

    /// Decodes frames in sequence and separately; both must give the same samples.
    fn decode<S: Keyed>(&self) -> Judged {
        let chunk =
            match self.tables().and_then(|of| TransformChunk::parse::<S>(&self.payload, self.size, self.frames, &of)) {
                Ok(chunk) => chunk,
                Err(error) => return refused(&error),
            };
        let samples = 3 * self.size[0] * self.size[1];
        let (mut shown, mut before) = (vec![S::default(); samples], None);
        for frame in [0, self.frames / 2, self.frames - 1, 0].map(|frame| frame as usize) {
            let mut alone = vec![S::default(); samples];
            chunk.show(frame, None, &mut alone);
            chunk.show(frame, before.replace(frame), &mut shown);
            if shown != alone {
                return Err(format!("frame {frame} differs after another frame"));
            }
        }
        Ok(Verdict::Accepted)
    }
}

pub fn run(bytes: &[u8]) -> Judged {
    let case = Case::read(bytes);
    if case.is_half { case.decode::<HalfKey>() } else { case.decode::<u8>() }
}

/// Returns the bytes held by a parsed chunk (container.md 2), and 4 MiB for tables and frames.
pub fn bound(bytes: &[u8]) -> u64 {
    let case = Case::read(bytes);
    (4 << 20) + held_bytes(case.payload.len() as u64, case.size, case.frames)
}
