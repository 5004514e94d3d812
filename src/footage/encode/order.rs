//! The order in which groups are encoded. It determines the stream numbers.

use crate::dataset::SourceGroup;
use crate::encode::EncodeSettings;
use crate::encode::source::{FrameSource, GroupRef, selected_groups};
use codec::container::SafeChunks;
use codec::image::Face;

/// Groups sorted by probe, then by kind.
pub(super) struct Order<'a>(pub Vec<OrderedGroup<'a>>);

#[derive(Clone, Copy)]
pub(super) struct OrderedGroup<'a> {
    pub group: GroupRef<'a>,
    pub first_stream: u32,
}

impl OrderedGroup<'_> {
    pub fn streams(&self) -> std::ops::Range<u32> {
        self.first_stream..self.first_stream + self.group.group.faces.len() as u32
    }
}

impl<'a> Order<'a> {
    pub fn of(source: &'a dyn FrameSource, settings: &EncodeSettings) -> Order<'a> {
        let mut groups = selected_groups(source, settings);
        groups.sort_by_key(|group| (group.group.probe, group.group.kind));
        let mut next = 0;
        let numbered = groups.into_iter().map(|group| {
            let first_stream = next;
            next += group.group.faces.len() as u32;
            OrderedGroup { group, first_stream }
        });
        Order(numbered.collect())
    }

    pub fn stream(&self, stream: u32) -> Option<(&'a SourceGroup, Face)> {
        let found = self.0.iter().rfind(|group| group.first_stream <= stream)?;
        let group = found.group.group;
        Some((group, *group.faces.get((stream - found.first_stream) as usize)?))
    }

    pub fn describe(&self, source: &dyn FrameSource, safe: SafeChunks) -> Option<String> {
        let SafeChunks { count, last } = safe;
        let last = last?;
        let (group, face) = self.stream(last.stream)?;
        let probe = &source.probes()[group.probe].name;
        let chunks = if count == 1 { "1 chunk".to_owned() } else { format!("{count} chunks, the last") };
        let (kind, first_frame, last_frame) = (group.kind.name(), last.first_frame, last.last_frame());
        Some(format!("{chunks} of frames {first_frame}-{last_frame} of probe {probe}, {kind} {}", face.name()))
    }
}
