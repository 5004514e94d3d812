//! Lists what a proposed manifest does not use: channels of its files, and whole sequences.

use std::collections::{BTreeMap, BTreeSet};

use super::sequences::{EYES, Found};
use crate::dataset::manifest::MaterialChannels;
use codec::image::channels::{find_alpha, find_color, find_depth, find_named};
use codec::image::{ChannelSelect, StreamKind};

/// Maximum names in one sentence.
const MAX_LISTED: usize = 12;

/// Returns one sentence for each set of channels that is not used, and for each EXR sequence of which nothing is used. `found`
/// has the sequences that are not noted otherwise, `used_as` returns the streams that read a sequence.
pub fn sentences(found: &[&Found], used_as: impl Fn(&Found) -> Vec<StreamKind>) -> Vec<String> {
    let mut channels: BTreeMap<Vec<String>, Vec<&str>> = BTreeMap::new();
    for of in found.iter().filter(|of| of.header.is_some()) {
        let used: BTreeSet<usize> = used_as(of).into_iter().flat_map(|kind| used(of, kind)).collect();
        let names = of.header.iter().flat_map(|header| header.channels.iter().enumerate());
        let left: Vec<String> = names.filter(|(at, _)| !used.contains(at)).map(|(_, name)| name.full()).collect();
        if !left.is_empty() {
            channels.entry(left).or_default().push(&of.text);
        }
    }
    let shown = |names: &[String]| {
        let more = names.len().saturating_sub(MAX_LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("{}{more}", names[..names.len().min(MAX_LISTED)].join(", "))
    };
    let sentence = |(names, texts): (Vec<String>, Vec<&str>)| {
        let others = if texts.len() > 1 { format!(" and {} more", texts.len() - 1) } else { String::new() };
        let (channels, were) = if names.len() == 1 { ("channel", "was") } else { ("channels", "were") };
        format!("{channels} {} of {}{others} {were} left out", shown(&names), texts[0])
    };
    channels.into_iter().map(sentence).collect()
}

/// Returns the channels that a stream reads from a file.
fn used(of: &Found, kind: StreamKind) -> Vec<usize> {
    let names = of.header.as_ref().map_or(&[][..], |header| &header.channels);
    let eyes = if of.has_eyes { EYES.to_vec() } else { Vec::new() };
    let selects = match eyes.is_empty() {
        true => vec![of.select()],
        false => eyes.into_iter().map(|eye| ChannelSelect::Named(eye.into())).collect(),
    };
    let of_select = |select: &ChannelSelect| match kind {
        // Alpha is read where it is below 1.
        StreamKind::Color => find_color(names, select)
            .map(|rgb| rgb.into_iter().chain(find_alpha(names, rgb[0])).collect())
            .unwrap_or_default(),
        StreamKind::Depth => find_depth(names, select)
            .map(|depth| [depth.channel].into_iter().chain(depth.copies.into_iter().flatten()).collect())
            .unwrap_or_default(),
        StreamKind::Material => {
            let of_material = MaterialChannels::default();
            of_material.names().iter().filter_map(|name| find_named(names, name).ok()).collect()
        }
        StreamKind::Alpha => Vec::new(),
    };
    selects.iter().flat_map(of_select).collect::<Vec<usize>>()
}
