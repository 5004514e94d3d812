//! Counts of the work that the stages did, and the thread time that they took.

use serde::Serialize;

use super::source::{MAX_LAYERS, SourceView};
use super::stages::Stages;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    pub source_views: u64,
    /// Number of layers of the source view that has the most.
    pub source_layers: u64,
    /// Number of pixels in all layers of all source views.
    pub source_pixels: u64,
    /// Number of surfaces that are left out because they lie so close behind another one that no view sees them.
    pub offset_skipped: u64,
    /// Number of pixels that hide everything behind them from all views.
    pub masked_pixels: u64,
    /// Number of primitives that each view draws: single lines, and runs of lines that move together.
    pub lines: u64,
    /// Number of source pixels that were merged into runs, not counting the first pixel of each run.
    pub coalesced_pixels: u64,
    /// Number of output pixels covered by lines and the spans between them, counted once per line or span.
    pub fragments: u64,
    /// Number of fragments that were nearer than all before them. On a device, where fragments have no order: number of covered
    /// pixels.
    pub depth_tests_won: u64,
    /// Number of splits at which highlights are computed.
    pub splits: u64,
    /// Number of output pixels that no line covers.
    pub hole_pixels: u64,
    /// Number of output pixels that are ray cast: holes, mirrors and glass.
    pub traced_pixels: u64,
    /// Number of output pixels that show each layer of a source; 0 on devices.
    #[serde(skip)]
    pub pixels_by_layer: [u64; MAX_LAYERS],
    /// Thread time of the stages that run scanline by scanline, summed over all threads.
    #[serde(skip)]
    pub threads: Stages,
}

impl Counters {
    /// Returns the counters with those of source views set.
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
        // Destructured so that the compiler reports a new field that is not added.
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
