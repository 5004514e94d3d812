//! Trait of decoders of whole images, and its implementation on the CPU; the one for graphics devices is in `gpu`.

use crate::decode::chunk_source::DecodeCost;
use crate::decode::damage::{DamagedChunk, OnDamage};
use crate::decode::decoder::Decoder;
use crate::decode::face::{FaceDecoder, Picture, UnitFilter};
use crate::error::Result;
use crate::streams::StreamInfo;

pub trait Images {
    fn decode_filtered(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture>;

    /// As [`Self::decode_filtered`], but returns `None` if the image needs a damaged chunk, which [`Self::damaged`] lists.
    fn decode_intact(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Option<Picture>> {
        self.decode_filtered(frame, filter).map(Some)
    }

    fn damaged(&self) -> Vec<DamagedChunk> {
        Vec::new()
    }

    fn selected_pixels(&self) -> u64;

    fn cost(&self) -> DecodeCost;
}

pub trait ImageSource: Sync {
    fn open<'a>(&'a self, decoder: &'a Decoder, stream: &'a StreamInfo) -> Result<Box<dyn Images + 'a>>;
}

#[derive(Debug, Clone, Copy, Default)]
pub struct OnCpu(pub OnDamage);

struct CpuImages<'a> {
    face: FaceDecoder<'a>,
    on_damage: OnDamage,
}

impl ImageSource for OnCpu {
    fn open<'a>(&'a self, decoder: &'a Decoder, stream: &'a StreamInfo) -> Result<Box<dyn Images + 'a>> {
        Ok(Box::new(CpuImages { face: decoder.face(stream), on_damage: self.0 }))
    }
}

impl Images for CpuImages<'_> {
    fn decode_filtered(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture> {
        self.face.decode_filtered(frame, filter)
    }

    fn decode_intact(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Option<Picture>> {
        match self.on_damage {
            OnDamage::Stop => self.decode_filtered(frame, filter).map(Some),
            OnDamage::KeepGoing => self.face.decode_intact(frame, filter),
        }
    }

    fn damaged(&self) -> Vec<DamagedChunk> {
        match self.on_damage {
            OnDamage::Stop => Vec::new(),
            OnDamage::KeepGoing => self.face.damaged(),
        }
    }

    fn selected_pixels(&self) -> u64 {
        self.face.selected_pixels()
    }

    fn cost(&self) -> DecodeCost {
        self.face.cost()
    }
}
