//! A part of a source: one shard of an encode, which a farm spreads over machines, or the whole with scans made before.

use std::path::PathBuf;

use crate::container::Attributes;
use crate::dataset::{ProbeInfo, SourceGroup};
use crate::encode::order::Order;
use crate::encode::scan::Scans;
use crate::encode::shard::{Shard, ShardBy, groups_of_shard};
use crate::encode::shard_choice::ShardChoice;
use crate::encode::source::FrameSource;
use crate::encode::{EncodeSettings, configuration};
use crate::error::Result;
use crate::fingerprint::{digest, digest_bytes};
use crate::image::{AlphaPlane, ColorPlane, DepthKind, DepthPlane, MaterialPlane, Primaries, Projection, StreamKind};
use crate::streams::shard::{SHARD, ShardEntry, WholeStream};

/// Groups of a source, or some frames of these.
pub struct Part<'a> {
    pub(super) source: &'a dyn FrameSource,
    pub(super) groups: Vec<SourceGroup>,
    scans: Scans,
    pub(super) shard: Option<ShardEntry>,
}

impl<'a> Part<'a> {
    /// The whole source, with scans that were made before.
    pub fn whole(source: &'a dyn FrameSource, scans: Scans) -> Part<'a> {
        Part { source, groups: source.groups().to_vec(), scans, shard: None }
    }

    /// One shard without scans.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] where the source cannot be cut into so many.
    pub fn shard(
        source: &'a dyn FrameSource,
        settings: &EncodeSettings,
        shard: Shard,
        by: ShardBy,
    ) -> Result<Part<'a>> {
        let order = Order::of(source, settings);
        let groups = groups_of_shard(&order, |kind| settings.segment_frames(kind), shard, by)?;
        Part::of_groups(source, settings, (&order, groups), shard)
    }

    /// One shard, of which is said what it has, without scans. Whether all shards together have everything once is found
    /// where they are joined.
    ///
    /// # Errors
    /// As [`ShardChoice::groups`].
    pub fn chosen(
        source: &'a dyn FrameSource,
        settings: &EncodeSettings,
        shard: Shard,
        choice: &ShardChoice,
    ) -> Result<Part<'a>> {
        let order = Order::of(source, settings);
        let groups = choice.groups(source, &order, |kind| settings.segment_frames(kind))?;
        Part::of_groups(source, settings, (&order, groups), shard)
    }

    fn of_groups(
        source: &'a dyn FrameSource,
        settings: &EncodeSettings,
        (order, groups): (&Order<'_>, Vec<SourceGroup>),
        Shard { number, count }: Shard,
    ) -> Result<Part<'a>> {
        let streams = order.0.iter().enumerate().flat_map(|(at, ordered)| {
            let SourceGroup { kind, probe, faces, frames, .. } = ordered.group.group;
            faces.iter().map(move |&face| WholeStream {
                kind: *kind as u8,
                probe: *probe as u16,
                face: face as u8,
                group: at as u32,
                first_frame: frames.first,
                frame_count: frames.count() as u32,
            })
        });
        let job = digest_bytes(&configuration::to_bytes(&configuration::of(source, settings).0)?);
        let entry = ShardEntry { job, number, count, streams: streams.collect() };
        Ok(Part { source, groups, scans: Scans::default(), shard: Some(entry) })
    }

    /// Whether it is one shard.
    pub fn is_shard(&self) -> bool {
        self.shard.is_some()
    }

    /// Numbers of the probes of which it has depth, ascending.
    pub fn probes_of_depth(&self) -> Vec<usize> {
        let of_depth = self.groups.iter().filter(|group| group.kind == StreamKind::Depth);
        let mut probes: Vec<usize> = of_depth.map(|group| group.probe).collect();
        probes.dedup();
        probes
    }

    /// The same with scans of its probes.
    #[must_use]
    pub fn with_scans(self, scans: Scans) -> Part<'a> {
        Part { scans, ..self }
    }
}

impl FrameSource for Part<'_> {
    fn name(&self) -> &str {
        self.source.name()
    }

    fn fps(&self) -> f64 {
        self.source.fps()
    }

    fn projection(&self) -> Projection {
        self.source.projection()
    }

    fn probes(&self) -> &[ProbeInfo] {
        self.source.probes()
    }

    fn groups(&self) -> &[SourceGroup] {
        &self.groups
    }

    fn background(&self) -> f32 {
        self.source.background()
    }

    fn depth_kind(&self) -> DepthKind {
        self.source.depth_kind()
    }

    fn stated_range(&self) -> [Option<f32>; 2] {
        self.source.stated_range()
    }

    fn reading_bytes(&self, group: &SourceGroup) -> u64 {
        self.source.reading_bytes(group)
    }

    fn primaries(&self) -> Primaries {
        self.source.primaries()
    }

    fn missing_frames(&self, group: &SourceGroup) -> Vec<(u32, Option<u32>)> {
        let mut missing = self.source.missing_frames(group);
        missing.retain(|(frame, _)| group.frames.contains(*frame));
        missing
    }

    fn read_depth(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>> {
        self.source.read_depth(group, frame)
    }

    fn read_color(&self, group: &SourceGroup, frame: u32) -> Result<Vec<ColorPlane>> {
        self.source.read_color(group, frame)
    }

    fn read_material(&self, group: &SourceGroup, frame: u32) -> Result<Vec<MaterialPlane>> {
        self.source.read_material(group, frame)
    }

    fn read_alpha(&self, group: &SourceGroup, frame: u32) -> Result<Vec<AlphaPlane>> {
        self.source.read_alpha(group, frame)
    }

    fn files(&self, group: &SourceGroup, frame: u32) -> Result<Vec<PathBuf>> {
        self.source.files(group, frame)
    }

    fn scans(&self) -> Option<&Scans> {
        Some(&self.scans)
    }

    fn attributes(&self) -> Attributes {
        let mut attributes = self.source.attributes();
        if let Some(shard) = &self.shard {
            attributes.set(SHARD, shard.write());
        }
        attributes
    }

    fn configuration(&self) -> Vec<(&'static str, String)> {
        let mut fields = self.source.configuration();
        fields.push(("the scan", digest(format!("{:?}", self.scans).as_bytes())));
        if let Some(ShardEntry { number, count, .. }) = &self.shard {
            fields.push(("`shard`", format!("{number}/{count}")));
        }
        fields
    }
}
