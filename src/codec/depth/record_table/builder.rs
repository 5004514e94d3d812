//! Writes the record table of a chunk and the records after it (depth.md 4).

use crate::container::serialize::PutFields;
use crate::depth::record_table::{ROW_BYTES, Row};
use crate::error::{Error, Result};

#[derive(Debug, Default)]
pub struct TableBuilder {
    rows: Vec<Row>,
    data: Vec<u8>,
}

impl TableBuilder {
    /// Starts the record of a frame; returns the buffer to which its bytes are appended.
    pub fn begin(&mut self, frame: u32) -> &mut Vec<u8> {
        self.rows.push(Row { frame, offset: self.data.len() as u32 });
        &mut self.data
    }

    pub fn bytes(&self) -> usize {
        self.start() + self.data.len()
    }

    fn start(&self) -> usize {
        4 + self.rows.len() * ROW_BYTES
    }

    pub fn finish(self) -> Result<Vec<u8>> {
        let start = self.start();
        if u32::try_from(self.bytes()).is_err() {
            return Err(Error::unsupported(
                "a chunk of more than 4 GiB: use a shorter keyframe interval or more tiles",
            ));
        }
        let mut payload = Vec::with_capacity(self.bytes());
        payload.put_u32(self.rows.len() as u32);
        for row in self.rows {
            payload.put_u32(row.frame);
            payload.put_u32(start as u32 + row.offset);
        }
        payload.extend_from_slice(&self.data);
        Ok(payload)
    }
}
