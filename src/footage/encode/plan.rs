//! Plan of an encode: everything that is known before the first frame is read.

use crate::dataset::SourceGroup;
use crate::encode::EncodeSettings;
use crate::encode::budget::{GroupNeed, ScanLimits};
use crate::encode::source::{FrameSource, selected_groups};
use codec::container::SafeChunks;
use codec::error::{Error, Result};
use codec::image::{Face, StreamKind};

/// Source and settings of an encode, with its groups of streams in the order in which they are encoded.
pub struct Plan<'a> {
    pub(super) source: &'a dyn FrameSource,
    pub(super) settings: &'a EncodeSettings,
    /// Near and far in metres: those of the settings, or else those of the source. `None` is found in the images.
    pub(super) given_range: [Option<f32>; 2],
    /// Groups by probe, then by kind.
    pub(super) groups: Vec<GroupPlan<'a>>,
    /// Size in bytes of the tables that all groups are read with.
    table_bytes: u64,
}

/// A group of streams that are read together.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroupPlan<'a> {
    /// Index in [`FrameSource::groups`].
    pub at: usize,
    pub group: &'a SourceGroup,
    /// Number of the stream of the first face; the streams of the other faces follow.
    pub first_stream: u32,
    pub need: GroupNeed,
}

impl GroupPlan<'_> {
    pub fn streams(&self) -> std::ops::Range<u32> {
        self.first_stream..self.first_stream + self.group.faces.len() as u32
    }

    pub fn images(&self) -> u64 {
        self.group.frames.count() * self.group.faces.len() as u64
    }
}

impl<'a> Plan<'a> {
    /// Plans an encode of the streams of `source` that the settings select. [`Self::check`] reports an impossible plan.
    pub fn new(source: &'a dyn FrameSource, settings: &'a EncodeSettings) -> Plan<'a> {
        let table_bytes = source.table_bytes(&selected_groups(source, settings));
        let given_range = given_range(source, settings);
        let mut plan = Plan { source, settings, given_range, groups: Vec::new(), table_bytes };
        let mut groups: Vec<_> = source.groups().iter().enumerate().collect();
        groups.retain(|(_, group)| settings.kinds.contains(&group.kind));
        groups.sort_by_key(|(_, group)| (group.probe, group.kind));
        let mut first_stream = 0;
        for (at, group) in groups {
            plan.groups.push(GroupPlan { at, group, first_stream, need: plan.need(group) });
            first_stream += group.faces.len() as u32;
        }
        plan
    }

    /// Number of images of all streams.
    pub fn images(&self) -> u64 {
        self.groups.iter().map(GroupPlan::images).sum()
    }

    /// Fails if settings are out of range, the source lacks the requested streams, or the memory budget is too small.
    pub fn check(&self) -> Result<()> {
        let Plan { source, settings, .. } = self;
        settings.check()?;
        // Report the group that needs the most, so that the command fails only once.
        let most = self.groups.iter().max_by_key(|planned| (planned.need.min_bytes(), planned.at));
        let Some(GroupPlan { group, need, .. }) = most else {
            return Err(Error::Usage(format!("'{}' has no stream of the selected kinds", source.name())));
        };
        let what = format!("encoding the {} of probe {}", group.kind.name(), source.probes()[group.probe].name);
        need.batch_frames(settings.memory, &what).map(|_| ())
    }

    /// Memory that a group, or some frames of one, needs under the settings.
    pub(super) fn need(&self, group: &SourceGroup) -> GroupNeed {
        GroupNeed::new(group, self.settings, self.table_bytes, self.source.reading_bytes(group))
    }

    /// Limits of a scan of depth groups.
    pub(super) fn scan_limits(&self, groups: &[GroupPlan<'_>]) -> Result<ScanLimits> {
        let mut limits = ScanLimits { finds_levels: self.settings.finds_levels(), ..ScanLimits::default() };
        for GroupPlan { need, .. } in groups {
            limits.keep_bytes = limits.keep_bytes.min(need.keep);
            limits.frames_at_once = need.scanned_at_once(self.settings.memory, limits.frames_at_once)?;
        }
        Ok(limits)
    }

    /// Returns true if near or far has to be found in the images.
    pub(super) fn finds_range(&self) -> bool {
        self.given_range.contains(&None)
    }

    /// Depth groups of a probe.
    pub(super) fn depth_of(&self, probe: usize) -> Vec<GroupPlan<'a>> {
        let is_depth = |of: &&GroupPlan<'_>| (of.group.probe, of.group.kind) == (probe, StreamKind::Depth);
        self.groups.iter().filter(is_depth).copied().collect()
    }

    /// Returns the group and the face of a stream.
    pub(super) fn stream(&self, stream: u32) -> Option<(&'a SourceGroup, Face)> {
        let GroupPlan { group, first_stream, .. } = self.groups.iter().rfind(|of| of.first_stream <= stream)?;
        Some((group, *group.faces.get((stream - first_stream) as usize)?))
    }

    /// Describes the number of complete chunks and the position of the last one; `None` if there are none.
    pub fn describe(&self, SafeChunks { count, last }: SafeChunks) -> Option<String> {
        let last = last?;
        let (group, face) = self.stream(last.stream)?;
        let probe = &self.source.probes()[group.probe].name;
        let chunks = if count == 1 { "1 chunk".to_owned() } else { format!("{count} chunks, the last") };
        let (kind, first_frame, last_frame) = (group.kind.name(), last.first_frame, last.last_frame());
        Some(format!("{chunks} of frames {first_frame}-{last_frame} of probe {probe}, {kind} {}", face.name()))
    }
}

/// Near and far in metres: those of the settings, or else those of the source.
pub(super) fn given_range(source: &dyn FrameSource, settings: &EncodeSettings) -> [Option<f32>; 2] {
    let [near, far] = source.stated_range();
    [settings.near_m.or(near), settings.far_m.or(far)]
}
