//! What the stages did, and what threads spent on them.

use serde::Serialize;

use super::source::{MAX_LAYERS, SourceView};
use super::stages::Stages;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    pub source_views: u64,
    /// Of the source view with the most.
    pub source_layers: u64,
    /// Pixels of all layers of all source views.
    pub source_pixels: u64,
    /// Surfaces that lie so close behind another one that no view sees them.
    pub offset_skipped: u64,
    /// Surfaces behind a pixel that hides them from all views.
    pub masked_pixels: u64,
    /// Primitives that each view draws: lines, and runs of lines that move together as one.
    pub lines: u64,
    /// Pixels of sources that share the primitive of a run, beside the first of each run.
    pub coalesced_pixels: u64,
    /// Pixels of output views that lines and the spans between them cover, once for each.
    pub fragments: u64,
    /// Fragments that were nearer than all before them; on a device, where fragments have no order, pixels that are covered.
    pub depth_tests_won: u64,
    /// Places along lines where highlights are computed.
    pub splits: u64,
    /// Pixels that nothing covers.
    pub hole_pixels: u64,
    /// Pixels that are ray cast in an output view: holes, mirrors and glass.
    pub traced_pixels: u64,
    /// Pixels of output views that show each layer of a source; 0 on devices.
    #[serde(skip)]
    pub pixels_by_layer: [u64; MAX_LAYERS],
    /// What threads spent on stages that they do scanline by scanline, summed.
    #[serde(skip)]
    pub threads: Stages,
}

impl Counters {
    /// With those of source views.
    #[must_use]
    pub fn of_sources(self, sources: &[SourceView]) -> Counters {
        Counters {
            source_views: sources.len() as u64,
            source_layers: sources.iter().map(|source| u64::from(source.layers)).max().unwrap_or(0),
            source_pixels: sources.iter().map(SourceView::pixel_count).sum(),
            ..self
        }
    }

    pub fn add(&mut self, other: &Counters) {
        // Destructured so that a new field is not forgotten here.
        let Counters {
            source_views,
            source_layers,
            source_pixels,
            offset_skipped,
            masked_pixels,
            lines,
            coalesced_pixels,
            fragments,
            depth_tests_won,
            splits,
            hole_pixels,
            traced_pixels,
            pixels_by_layer,
            threads,
        } = other;
        self.source_views += source_views;
        self.source_layers = self.source_layers.max(*source_layers);
        self.source_pixels += source_pixels;
        self.offset_skipped += offset_skipped;
        self.masked_pixels += masked_pixels;
        self.lines += lines;
        self.coalesced_pixels += coalesced_pixels;
        self.fragments += fragments;
        self.depth_tests_won += depth_tests_won;
        self.splits += splits;
        self.hole_pixels += hole_pixels;
        self.traced_pixels += traced_pixels;
        self.pixels_by_layer.iter_mut().zip(pixels_by_layer).for_each(|(sum, count)| *sum += count);
        self.threads = self.threads + *threads;
    }
}
