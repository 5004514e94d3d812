//! Account of a dataset: the settings that affect pixels, and the files, channels and probes that are used.

use std::collections::{BTreeMap, BTreeSet};

use super::shape::Shape;
use super::{Source, SourceGroup};
use crate::account::{Account, listed};
use crate::dataset::manifest::{Manifest, NORMAL_CHANNELS};
use crate::image_files::{ColorSpace, exr, png};
use codec::error::Result;
use codec::image::channels::{ChannelName, find_alpha, find_color, find_depth, find_named};
use codec::image::{ChannelSelect, StereoLayout, StreamKind};

/// Returns the places of the channels that a stream reads from an EXR file.
fn read_channels(names: &[ChannelName], kind: StreamKind, select: &ChannelSelect, material: [&str; 3]) -> Vec<usize> {
    match kind {
        // Alpha is read where it is below 1.
        StreamKind::Color => find_color(names, select)
            .map(|rgb| rgb.into_iter().chain(find_alpha(names, rgb[0])).collect())
            .unwrap_or_default(),
        StreamKind::Depth => find_depth(names, select)
            .map(|depth| [depth.channel].into_iter().chain(depth.copies.into_iter().flatten()).collect())
            .unwrap_or_default(),
        StreamKind::Material => material.iter().filter_map(|name| find_named(names, name).ok()).collect(),
        StreamKind::Alpha => Vec::new(),
    }
}

impl Manifest {
    /// Returns the account of what the manifest names: file patterns and probes.
    pub fn account(&self) -> Account {
        let mut account = Account::default();
        let patterns = StreamKind::ALL.into_iter().filter_map(|kind| self.files.get(kind));
        account.add("file pattern", patterns.chain(self.files.normal.as_deref()).map(str::to_owned));
        account.add("probe", self.probes.iter().map(|probe| probe.name.clone()));
        account
    }
}

impl Source {
    /// Names and values of all settings that affect pixels. Sources with equal values read equal pixels from equal files.
    pub fn reading_rules(&self) -> Vec<(&'static str, String)> {
        let range = self.manifest.as_ref().and_then(|manifest| manifest.depth.as_ref());
        vec![
            ("what an image shows", self.content.words().to_owned()),
            ("the place of the eyes", self.stereo.map_or("none", StereoLayout::name).to_owned()),
            ("the size of the image files", self.sizes_in_words(|shape| shape.file_size)),
            ("the size of depth files", format!("{:?}", range.and_then(|depth| depth.size))),
            ("the size of the faces", self.sizes_in_words(|shape| shape.delivered_size)),
            ("`background`", self.rules.background.to_string()),
            ("`depth_scale`", self.rules.scale.to_string()),
            ("the disparity", format!("{:?}", self.rules.disparity)),
            ("`invalid_depth`", self.rules.invalid.name().to_owned()),
            ("`invalid_color`", self.invalid_color.name().to_owned()),
            ("`missing`", self.missing.name().to_owned()),
            ("the kind of depth", format!("{} as {}", self.depth_in_files.name(), self.depth_stored.name())),
            ("near in the manifest", words_of(range.and_then(|depth| depth.near), "none")),
            ("far in the manifest", words_of(range.and_then(|depth| depth.far), "none")),
            ("the source of the depth scale", if self.scale_stated { "a statement" } else { "the default" }.to_owned()),
            ("`color_space`", words_of(self.color_space.map(ColorSpace::name), "that of the files")),
            ("the primaries of colour", format!("{:?}", self.primaries.to_array())),
            ("the choice of color channels", self.color_channel.words()),
            ("the depth channel", self.depth_channel.words()),
            ("the choice of material channels", self.material_channels.join(", ")),
            ("the choice of the alpha channel", self.alpha_channel.words()),
        ]
    }

    /// Returns the size of all probes in words, or that of each, in their order.
    fn sizes_in_words(&self, size_of: impl Fn(&Shape) -> (u32, u32)) -> String {
        let mut sizes: Vec<String> = (0..self.probes.len())
            .map(|probe| size_of(self.shapes.of(probe)))
            .map(|(width, height)| format!("{width}x{height}"))
            .collect();
        if sizes.iter().all(|size| *size == sizes[0]) {
            sizes.truncate(1);
        }
        sizes.join(", ")
    }

    /// Returns the account of the first file of each probe and kind: patterns, channels and probes. Channels that no kind reads are
    /// left out.
    ///
    /// # Errors
    /// Fails if a file cannot be read.
    pub fn account(&self) -> Result<Account> {
        let mut account = Account::default();
        let mut unused = BTreeMap::new();
        let mut seen = BTreeSet::new();
        for group in self.groups.iter().filter(|group| seen.insert((group.kind, group.probe))) {
            let pattern = self.manifest.as_ref().and_then(|manifest| manifest.files.get(group.kind));
            account.add("file pattern", pattern.map(str::to_owned));
            account.add("probe", [self.probes[group.probe].name.clone()]);
            let path = self.file(group, group.frames.first)?.filter(|path| !png::has_codes(path));
            let Some(path) = path else { continue };
            let names = exr::read_header(&path, &self.limits)?.channels;
            let used = self.used_channels(group, &names);
            account.add("channel", used.iter().cloned());
            let all = || -> BTreeSet<String> { names.iter().map(ChannelName::full).collect() };
            let (_, left) = unused.entry(path).or_insert_with(|| (pattern.unwrap_or_default(), all()));
            left.retain(|name| !used.contains(name));
        }
        let normal = self.manifest.as_ref().and_then(|manifest| manifest.files.normal.clone());
        if normal.is_some() {
            account.add("channel", NORMAL_CHANNELS.map(str::to_owned));
        }
        for (pattern, names) in unused.into_values().collect::<BTreeSet<_>>() {
            let unused = names.iter().filter(|name| !self.is_normal(pattern, name));
            let names: Vec<&str> = unused.map(String::as_str).collect();
            let [channel, was] = if names.len() == 1 { ["channel", "was"] } else { ["channels", "were"] };
            if !names.is_empty() {
                account.left_out.push(format!("{channel} {} of {pattern} {was} left out", listed(&names)));
            }
        }
        account.add("file pattern", normal);
        Ok(account)
    }

    /// Returns the full names of the channels that a group reads from an EXR file.
    fn used_channels(&self, group: &SourceGroup, names: &[ChannelName]) -> Vec<String> {
        let channels = match group.kind {
            StreamKind::Color => &self.color_channel,
            StreamKind::Depth => &self.depth_channel,
            StreamKind::Material | StreamKind::Alpha => &self.alpha_channel,
        };
        let places = match (group.kind, self.select(channels, group)) {
            (StreamKind::Alpha, ChannelSelect::Named(name)) => find_named(names, &name).into_iter().collect(),
            (StreamKind::Alpha, ChannelSelect::Auto) => {
                let color = find_color(names, &self.select(&self.color_channel, group)).ok();
                color.and_then(|rgb| find_alpha(names, rgb[0])).into_iter().collect()
            }
            (kind, select) => {
                read_channels(names, kind, &select, self.material_channels.each_ref().map(String::as_str))
            }
        };
        places.into_iter().map(|at| names[at].full()).collect()
    }

    /// True if normals are read from this channel of a pattern.
    fn is_normal(&self, pattern: &str, name: &str) -> bool {
        let normal = self.manifest.as_ref().and_then(|manifest| manifest.files.normal.as_deref());
        normal == Some(pattern) && NORMAL_CHANNELS.contains(&name)
    }
}

fn words_of(value: Option<impl std::fmt::Display>, without: &str) -> String {
    value.map_or_else(|| without.to_owned(), |value| value.to_string())
}
