//! Part of a source: one shard of an encode that is distributed over machines, or the whole source with an earlier scan.

use std::path::PathBuf;

use crate::dataset::{ProbeInfo, SourceGroup};
use crate::encode::footage::Footage;
use crate::encode::plan::Plan;
use crate::encode::scan::Scans;
use crate::encode::scan_file::{probe_images, scan_probes};
use crate::encode::shard::{Shard, ShardBy, ShardChoice, groups_of_shard};
use crate::encode::source::FrameSource;
use crate::encode::{EncodeSettings, configuration};
use crate::fingerprint::{digest, digest_bytes};
use codec::container::Attributes;
use codec::error::Result;
use codec::image::{AlphaPlane, ColorPlane, DepthKind, DepthPlane, MaterialPlane, Primaries, Projection, StreamKind};
use codec::monitor::Monitor;
use codec::streams::StartView;
use codec::streams::shard::{FootageDigests, SHARD, SHARD_FOOTAGE, ShardEntry, WholeStream};

const SCAN: &str = "the scan";
const CONTENT: &str = "the content of the footage";
/// Configuration fields of a part that depend on the footage.
pub(super) const OF_FOOTAGE: [&str; 2] = [SCAN, CONTENT];

/// Groups of a source, or some of their frames.
pub struct Part<'a> {
    pub(super) source: &'a dyn FrameSource,
    pub(super) groups: Vec<SourceGroup>,
    scans: Scans,
    footage: Footage,
    pub(super) shard: Option<OneShard>,
}

/// A shard, in the form of its container attributes.
pub(super) struct OneShard {
    pub entry: ShardEntry,
    /// Groups of the complete encode.
    whole: Vec<SourceGroup>,
    footage: FootageDigests,
}

impl<'a> Part<'a> {
    /// Returns the complete source with the digests of an earlier scan, without scans of depth.
    pub fn whole(source: &'a dyn FrameSource, footage: Footage) -> Part<'a> {
        Part { source, groups: source.groups().to_vec(), scans: Scans::default(), footage, shard: None }
    }

    /// Returns one of `shard.count` shards of about the same size, without scans and footage digests.
    ///
    /// # Errors
    /// [`codec::error::Error::Usage`] if the source cannot be cut into so many shards.
    pub fn shard(
        source: &'a dyn FrameSource,
        settings: &EncodeSettings,
        shard: Shard,
        by: ShardBy,
    ) -> Result<Part<'a>> {
        let plan = Plan::new(source, settings);
        Part::of_groups(source, &plan, groups_of_shard(&plan, shard, by)?, shard)
    }

    /// Returns one shard with the chosen content, without scans and footage digests. Joining shards checks that they cover
    /// everything exactly once.
    ///
    /// # Errors
    /// As for `ShardChoice::groups`.
    pub fn chosen(
        source: &'a dyn FrameSource,
        settings: &EncodeSettings,
        shard: Shard,
        choice: &ShardChoice,
    ) -> Result<Part<'a>> {
        let plan = Plan::new(source, settings);
        Part::of_groups(source, &plan, choice.groups(&plan)?, shard)
    }

    /// Returns the shard of a plan of `source` that has these groups.
    fn of_groups(
        source: &'a dyn FrameSource,
        plan: &Plan<'_>,
        groups: Vec<SourceGroup>,
        Shard { number, count }: Shard,
    ) -> Result<Part<'a>> {
        let streams = plan.groups.iter().enumerate().flat_map(|(at, planned)| {
            let SourceGroup { kind, probe, faces, frames, .. } = planned.group;
            faces.iter().map(move |&face| WholeStream {
                kind: *kind as u8,
                probe: *probe as u16,
                face: face as u8,
                group: at as u32,
                first_frame: frames.first,
                frame_count: frames.count() as u32,
            })
        });
        let job = digest_bytes(&configuration::to_bytes(&configuration::of(source, plan.settings).0)?);
        let entry = ShardEntry { job, number, count, streams: streams.collect() };
        let whole = plan.groups.iter().map(|planned| planned.group.clone()).collect();
        let shard = Some(OneShard { entry, whole, footage: FootageDigests::default() });
        Ok(Part { source, groups, scans: Scans::default(), footage: Footage::default(), shard })
    }

    /// Returns true if the part is a shard.
    pub fn is_shard(&self) -> bool {
        self.shard.is_some()
    }

    /// Numbers of the probes whose depth is in the part, ascending.
    pub fn probes_of_depth(&self) -> Vec<usize> {
        let of_depth = self.groups.iter().filter(|group| group.kind == StreamKind::Depth);
        let mut probes: Vec<usize> = of_depth.map(|group| group.probe).collect();
        probes.dedup();
        probes
    }

    /// Sets the footage digests of the complete encode, which must be equal in all its shards.
    #[must_use]
    pub fn with_footage(mut self, footage: Footage) -> Part<'a> {
        if let Some(OneShard { entry, whole, footage: digests }) = &mut self.shard {
            let of_group = |stream: &WholeStream| footage.of_group(whole.get(stream.group as usize)?);
            digests.0 = entry.streams.iter().map(|stream| of_group(stream).unwrap_or_default()).collect();
            entry.job = digest_bytes(&[&entry.job[..], &digests.write()].concat());
        }
        Part { footage, ..self }
    }

    /// Number of images that [`Self::scan`] reads.
    pub fn images_to_scan(&self, settings: &EncodeSettings) -> u64 {
        probe_images(self.source, settings, &self.probes_of_depth())
    }

    /// Scans all frames of the probes of the part, and checks them against the footage digests.
    ///
    /// # Errors
    /// Fails if a file cannot be read or has changed since its digest was computed; the error names the file.
    pub fn scan(self, settings: &EncodeSettings, monitor: &dyn Monitor) -> Result<Part<'a>> {
        let whole = Part::whole(self.source, self.footage.clone());
        let scans = scan_probes(&whole, settings, &self.probes_of_depth(), monitor)?;
        Ok(self.with_scans(scans))
    }

    /// Sets the scans of the probes.
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

    fn table_bytes(&self, groups: &[&SourceGroup]) -> u64 {
        self.source.table_bytes(groups)
    }

    fn primaries(&self) -> Primaries {
        self.source.primaries()
    }

    fn view(&self) -> Option<StartView> {
        self.source.view()
    }

    fn missing_frames(&self, group: &SourceGroup) -> Vec<(u32, Option<u32>)> {
        let mut missing = self.source.missing_frames(group);
        missing.retain(|(frame, _)| group.frames.contains(*frame));
        missing
    }

    fn read_depth(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>> {
        self.footage.check(self.source, group, frame)?;
        self.source.read_depth(group, frame)
    }

    fn read_color(&self, group: &SourceGroup, frame: u32) -> Result<Vec<ColorPlane>> {
        self.footage.check(self.source, group, frame)?;
        self.source.read_color(group, frame)
    }

    fn read_material(&self, group: &SourceGroup, frame: u32) -> Result<Vec<MaterialPlane>> {
        self.footage.check(self.source, group, frame)?;
        self.source.read_material(group, frame)
    }

    fn read_alpha(&self, group: &SourceGroup, frame: u32) -> Result<Vec<AlphaPlane>> {
        self.footage.check(self.source, group, frame)?;
        self.source.read_alpha(group, frame)
    }

    fn files(&self, group: &SourceGroup, frame: u32) -> Result<Vec<PathBuf>> {
        self.source.files(group, frame)
    }

    fn digest(&self, group: &SourceGroup, frame: u32) -> Result<Option<[u8; 16]>> {
        self.source.digest(group, frame)
    }

    fn scans(&self) -> Option<&Scans> {
        Some(&self.scans)
    }

    fn attributes(&self) -> Attributes {
        let mut attributes = self.source.attributes();
        if let Some(shard) = &self.shard {
            attributes.set(SHARD, shard.entry.write());
            attributes.set(SHARD_FOOTAGE, shard.footage.write());
        }
        attributes
    }

    fn configuration(&self) -> Vec<(&'static str, String)> {
        let mut fields = self.source.configuration();
        fields.push((SCAN, digest(format!("{:?}", self.scans).as_bytes())));
        if let Some(OneShard { entry: ShardEntry { number, count, .. }, footage, .. }) = &self.shard {
            fields.push(("`shard`", format!("{number}/{count}")));
            fields.push((CONTENT, digest(&footage.write())));
        }
        fields
    }
}
