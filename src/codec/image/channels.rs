//! Selects the colour, depth and alpha channels of a file, by common names or by a given name.
//!
//! A channel has its own name and, in a file of several layers (parts), the full name `layer.name`. The tables are searched in
//! order, first by full name, then by the channel's own name. An ambiguous name is an error that lists the candidates. A given
//! name is the name of a channel, or else of a layer, part or stereo view, in which the tables are then searched.

use std::collections::{BTreeSet, HashSet};

use crate::error::{Error, Result};

/// Depth channel names in order of preference, compared first exactly, then ignoring case.
pub const DEPTH_CHANNELS: &[&str] = &[
    "Z",
    "depth.Z",
    "depth.V",
    "depth.Y",
    "Depth.Z",
    "Depth.V",
    "Depth.Y",
    "Depth",
    "depth",
    "ViewLayer.Depth.Z",
    "ViewLayer.Depth.V",
    "View Layer.Depth.Z",
    "View Layer.Depth.V",
    "RenderLayer.Depth.Z",
    "RenderLayer.Z",
    "distance",
    "distance.Y",
    "distance.V",
    "distance.T",
    "dist",
    "dist.Y",
    "dist.V",
    "dist.T",
    "depth.T",
    "dd.T",
    "Pz",
];

/// Names of layers (last component) that hold depth three times, as R, G and B; compared ignoring case.
pub const DEPTH_LAYERS: &[&str] = &["VRayZDepth", "ZDepth", "Depth", "Z"];

/// Suffixes of depth channels, used if exactly one channel of the file has one.
pub const DEPTH_ENDINGS: &[&str] = &[".depth.z", ".depth.v", ".depth.y", ".depth.t", ".depth"];

/// Colour layers (prefixes of channel names) in order of preference; the first entry is no prefix.
pub const COLOR_LAYERS: &[&str] = &[
    "",
    "rgba",
    "rgb",
    "color",
    "beauty",
    "C",
    "Combined",
    "ViewLayer.Combined",
    "View Layer.Combined",
    "RenderLayer.Combined",
    "Composite.Combined",
    "Image",
];

/// Names of the three colour components in a layer.
pub const COLOR_COMPONENTS: &[[&str; 3]] = &[["R", "G", "B"], ["r", "g", "b"], ["red", "green", "blue"]];

/// Names of channels that are read as gray if there is no RGB.
pub const GRAY_CHANNELS: &[&str] = &["Y", "L", "luminance", "gray"];

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum ChannelSelect {
    /// The channels of [`DEPTH_CHANNELS`] for depth, of [`COLOR_LAYERS`] and [`COLOR_COMPONENTS`] for colour.
    #[default]
    Auto,
    /// For depth, the name of a channel, layer, part or view. For colour, the name of a layer, part or view, three
    /// comma-separated channel names, or the name of a channel that is read as gray.
    Named(String),
}

impl ChannelSelect {
    pub fn words(&self) -> String {
        match self {
            ChannelSelect::Auto => "the usual ones".to_owned(),
            ChannelSelect::Named(name) => name.clone(),
        }
    }
}

impl ChannelSelect {
    /// Replaces `{probe}` and `{face}` in the name by the names of a probe and a face.
    #[must_use]
    pub fn of_image(&self, probe: &str, face: &str) -> ChannelSelect {
        match self {
            ChannelSelect::Auto => ChannelSelect::Auto,
            ChannelSelect::Named(name) => ChannelSelect::Named(name.replace("{probe}", probe).replace("{face}", face)),
        }
    }
}

impl From<Option<String>> for ChannelSelect {
    fn from(name: Option<String>) -> Self {
        name.map_or(ChannelSelect::Auto, ChannelSelect::Named)
    }
}

#[derive(Debug, Clone)]
pub struct ChannelName {
    /// Name of the layer (part) of the channel; empty if the part has none.
    pub layer: String,
    pub part: usize,
    /// Stereo view of the part, or of the channel if the part holds several; empty if the file has none.
    pub view: String,
    pub name: String,
}

/// Indices of the channels that hold depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthChannels {
    pub channel: usize,
    /// Two more channels of a layer that holds depth three times; their samples must equal those of `channel`.
    pub copies: Option<[usize; 2]>,
}

impl ChannelName {
    /// Returns `layer.name`, or the name alone if the layer has no name or the name already starts with it.
    pub fn full(&self) -> String {
        let repeats = self.name.strip_prefix(&self.layer).is_some_and(|rest| rest.starts_with('.'));
        if self.layer.is_empty() || repeats { self.name.clone() } else { format!("{}.{}", self.layer, self.name) }
    }

    /// Returns true if [`Self::full`] equals `wanted`. Compares in place, since allocating a name for each of thousands of
    /// channels is slow.
    fn is_called(&self, wanted: &str, same: Same) -> bool {
        let repeats = self.name.strip_prefix(&self.layer).is_some_and(|rest| rest.starts_with('.'));
        if self.layer.is_empty() || repeats {
            return same(&self.name, wanted);
        }
        let split = wanted.split_at_checked(self.layer.len());
        let parts = split.and_then(|(layer, rest)| Some((layer, rest.strip_prefix('.')?)));
        parts.is_some_and(|(layer, name)| same(name, &self.name) && same(layer, &self.layer))
    }
}

/// Settings that name a depth channel or layer, for messages.
const DEPTH_KEY: &str = "`depth_channel` or the manifest's depth.channel";
/// Settings that name a colour layer or channels, for messages.
const COLOR_KEY: &str = "`color_channel` or the manifest's color.layer";
/// Settings that name an alpha channel, for messages.
const ALPHA_KEY: &str = "`alpha_channel` or the manifest's alpha.channel";
/// How messages ask for other channels to be named.
const OTHER_KEY: &str = "its full name";

const LISTED: usize = 24;

fn list(names: &[ChannelName]) -> String {
    if names.is_empty() {
        return "none".into();
    }
    let mut text: Vec<String> = names.iter().take(LISTED).map(ChannelName::full).collect();
    if names.len() > LISTED {
        text.push(format!("and {} more", names.len() - LISTED));
    }
    text.join(", ")
}

#[derive(Clone, Copy)]
enum By {
    Full,
    Plain,
}

type Same = fn(&str, &str) -> bool;

/// Order of comparisons: full names before own names, exact before ignoring case.
const TRIES: [(By, Same); 4] = [
    (By::Full, str::eq),
    (By::Full, str::eq_ignore_ascii_case),
    (By::Plain, str::eq),
    (By::Plain, str::eq_ignore_ascii_case),
];

/// Returns the index of the channel with that name, or `None`. Fails if several layers have a channel with that name.
fn lookup(names: &[ChannelName], wanted: &str, (by, same): (By, Same), key: &str) -> Result<Option<usize>> {
    if let By::Full = by {
        return Ok(names.iter().position(|channel| channel.is_called(wanted, same)));
    }
    let plain: Vec<usize> = (0..names.len()).filter(|&i| same(&names[i].name, wanted)).collect();
    match plain.as_slice() {
        [] => Ok(None),
        [one] => Ok(Some(*one)),
        _ => Err(Error::invalid(format!(
            "several layers have a channel {wanted}: select one of {} with {key}",
            plain.iter().map(|&i| names[i].full()).collect::<Vec<_>>().join(", ")
        ))),
    }
}

fn named(names: &[ChannelName], wanted: &str, key: &str) -> Result<Option<usize>> {
    match lookup(names, wanted, (By::Full, str::eq), key)? {
        None => lookup(names, wanted, (By::Plain, str::eq), key),
        found => Ok(found),
    }
}

fn none_of_that_name(names: &[ChannelName], wanted: &str, what: &str) -> Error {
    Error::invalid(format!("there is no {what} {wanted}; the channels are: {}", list(names)))
}

pub fn find_named(names: &[ChannelName], wanted: &str) -> Result<usize> {
    named(names, wanted, OTHER_KEY)?.ok_or_else(|| none_of_that_name(names, wanted, "channel"))
}

/// Returns the channels of a layer or part, with their names in that layer, and their indices in `names`. If there is no such
/// layer or part, returns the channels of the stereo view called `wanted`, with the view removed from their names.
fn inside(names: &[ChannelName], wanted: &str) -> (Vec<usize>, Vec<ChannelName>) {
    let of_layer = |channel: &ChannelName| {
        let full = channel.full();
        let name = full.strip_prefix(wanted)?.strip_prefix('.')?.to_owned();
        Some(ChannelName { layer: String::new(), name, ..channel.clone() })
    };
    let of_view = |channel: &ChannelName| {
        let parts: Vec<&str> = channel.name.split('.').filter(|part| *part != wanted).collect();
        (channel.view == wanted).then(|| ChannelName { name: parts.join("."), ..channel.clone() })
    };
    let choose = |of: &dyn Fn(&ChannelName) -> Option<ChannelName>| -> (Vec<usize>, Vec<ChannelName>) {
        names.iter().enumerate().filter_map(|(at, channel)| Some((at, of(channel)?))).unzip()
    };
    match choose(&of_layer) {
        (found, _) if found.is_empty() => choose(&of_view),
        found => found,
    }
}

/// Returns true if the channel is a vector coordinate, such as the Z of a normal or position.
fn is_coordinate(names: &[ChannelName], index: usize) -> bool {
    let channel = &names[index];
    let Some(stem) = channel.name.strip_suffix(['Z', 'z']) else { return false };
    ["X", "Y"].iter().all(|axis| {
        let sibling = format!("{stem}{axis}");
        names.iter().any(|other| other.part == channel.part && other.name.eq_ignore_ascii_case(&sibling))
    })
}

/// Returns the index of the alpha channel in the layer of a red or gray channel.
pub fn find_alpha(names: &[ChannelName], red: usize) -> Option<usize> {
    let red = names.get(red)?;
    let prefix = &red.name[..red.name.rfind('.').map_or(0, |dot| dot + 1)];
    let is_alpha = |channel: &ChannelName| {
        let own = channel.name.strip_prefix(prefix).filter(|_| channel.part == red.part);
        own.is_some_and(|own| ["a", "alpha"].iter().any(|alpha| own.eq_ignore_ascii_case(alpha)))
    };
    names.iter().position(is_alpha)
}

/// Returns the index of the alpha channel: the one that `select` names, else the one in the layer of colour, and in a file
/// without colour the only channel `A`.
pub fn find_alpha_channel(names: &[ChannelName], select: &ChannelSelect, color: &ChannelSelect) -> Result<usize> {
    if let ChannelSelect::Named(wanted) = select {
        return named(names, wanted, ALPHA_KEY)?.ok_or_else(|| none_of_that_name(names, wanted, "channel"));
    }
    let found = match find_color(names, color) {
        Ok([red, ..]) => find_alpha(names, red),
        Err(_) => lookup(names, "A", (By::Plain, str::eq_ignore_ascii_case), ALPHA_KEY)?,
    };
    found.ok_or_else(|| {
        let listed = list(names);
        Error::invalid(format!(
            "the colour layer has no alpha; the channels are: {listed}: select one with {ALPHA_KEY}"
        ))
    })
}

/// Returns the indices of red, green and blue of a rendered image. No setting names its channels, so errors mention none.
pub fn find_picture_color(names: &[ChannelName]) -> Result<[usize; 3]> {
    find_color(names, &ChannelSelect::Auto).map_err(|_| {
        Error::invalid(format!("one picture with channels R, G and B was expected; the channels are: {}", list(names)))
    })
}

pub fn find_depth(names: &[ChannelName], select: &ChannelSelect) -> Result<DepthChannels> {
    let ChannelSelect::Named(wanted) = select else { return usual_depth(names) };
    if let Some(channel) = named(names, wanted, DEPTH_KEY)? {
        return Ok(DepthChannels { channel, copies: None });
    }
    let (places, inner) = inside(names, wanted);
    if inner.is_empty() {
        return Err(none_of_that_name(names, wanted, "channel, layer or view"));
    }
    let found = match find_layer(&inner, "", (By::Full, str::eq), DEPTH_KEY)? {
        // The layer holds only depth, three times.
        Some([r, g, b]) if usual_depth(&inner).is_err() => DepthChannels { channel: r, copies: Some([g, b]) },
        _ => usual_depth(&inner)?,
    };
    let copies = found.copies.map(|copies| copies.map(|copy| places[copy]));
    Ok(DepthChannels { channel: places[found.channel], copies })
}

fn usual_depth(names: &[ChannelName]) -> Result<DepthChannels> {
    // The Z of a normal would be chosen before the depth channel beside it, so vectors are excluded first.
    let candidates: Vec<usize> = (0..names.len()).filter(|&i| !is_coordinate(names, i)).collect();
    let kept: Vec<ChannelName> = candidates.iter().map(|&i| names[i].clone()).collect();
    let alone = |channel: usize| Ok(DepthChannels { channel, copies: None });
    for how in TRIES {
        for wanted in DEPTH_CHANNELS {
            if let Some(found) = lookup(&kept, wanted, how, DEPTH_KEY)? {
                return alone(candidates[found]);
            }
        }
    }
    let ending = |channel: &ChannelName| {
        let full = channel.full().to_ascii_lowercase();
        DEPTH_ENDINGS.iter().any(|ending| full.ends_with(ending))
    };
    let found: Vec<usize> = candidates.iter().copied().filter(|&i| ending(&names[i])).collect();
    match (found.as_slice(), names) {
        ([one], _) => return alone(*one),
        ([], [_only]) => return alone(0),
        _ => {}
    }
    let (layers, all) = (layers(names), names.iter().map(ChannelName::full).collect::<HashSet<_>>());
    for wanted in DEPTH_LAYERS {
        let is_one = |layer: &&String| {
            let is_named = layer.rsplit('.').next().is_some_and(|last| last.eq_ignore_ascii_case(wanted));
            let has = |component: &&str| all.contains(&format!("{layer}.{component}"));
            is_named && COLOR_COMPONENTS.iter().any(|components| components.iter().all(has))
        };
        let mut found = Vec::new();
        for layer in layers.iter().filter(is_one) {
            found.extend(find_layer(names, layer, (By::Full, str::eq), DEPTH_KEY)?);
        }
        if let [[r, g, b]] = found.as_slice() {
            return Ok(DepthChannels { channel: *r, copies: Some([*g, *b]) });
        }
    }
    Err(Error::invalid(format!(
        "no depth channel with a common name (Z, depth.Z, Depth, ...) was found: select one with {DEPTH_KEY}; the \
        channels are: {}",
        list(names)
    )))
}

/// Returns the channel names up to their last dot, sorted, without duplicates.
fn layers(names: &[ChannelName]) -> BTreeSet<String> {
    names.iter().filter_map(|channel| channel.full().rsplit_once('.').map(|(layer, _)| layer.to_string())).collect()
}

fn find_layer(names: &[ChannelName], layer: &str, how: (By, Same), key: &str) -> Result<Option<[usize; 3]>> {
    for components in COLOR_COMPONENTS {
        let mut found = [None; 3];
        for (slot, component) in found.iter_mut().zip(components) {
            let wanted = if layer.is_empty() { (*component).to_string() } else { format!("{layer}.{component}") };
            *slot = lookup(names, &wanted, how, key)?;
        }
        if let [Some(r), Some(g), Some(b)] = found {
            return Ok(Some([r, g, b]));
        }
    }
    Ok(None)
}

/// Returns the indices of red, green and blue; the same index three times for gray.
pub fn find_color(names: &[ChannelName], select: &ChannelSelect) -> Result<[usize; 3]> {
    let ChannelSelect::Named(wanted) = select else { return usual_color(names) };
    if let [r, g, b] = wanted.split(',').map(str::trim).collect::<Vec<_>>().as_slice() {
        return Ok([find_named(names, r)?, find_named(names, g)?, find_named(names, b)?]);
    }
    for by in [By::Full, By::Plain] {
        if let Some(found) = find_layer(names, wanted, (by, str::eq), COLOR_KEY)? {
            return Ok(found);
        }
    }
    if let Some(gray) = named(names, wanted, COLOR_KEY)? {
        return Ok([gray; 3]);
    }
    let (places, inner) = inside(names, wanted);
    if inner.is_empty() {
        return Err(none_of_that_name(names, wanted, "layer, channel or view"));
    }
    usual_color(&inner).map(|found| found.map(|at| places[at]))
}

fn usual_color(names: &[ChannelName]) -> Result<[usize; 3]> {
    for how in TRIES {
        for layer in COLOR_LAYERS {
            if let Some(found) = find_layer(names, layer, how, COLOR_KEY)? {
                return Ok(found);
            }
        }
    }
    let mut found = Vec::new();
    for layer in &layers(names) {
        found.extend(find_layer(names, layer, (By::Full, str::eq), COLOR_KEY)?);
    }
    if let [one] = found.as_slice() {
        return Ok(*one);
    }
    if found.is_empty() {
        if names.iter().any(|channel| matches!(channel.name.as_str(), "RY" | "BY")) {
            return Err(Error::unsupported(
                "colour stored as luminance and chroma (Y, RY, BY) is not supported: save it as R, G, B",
            ));
        }
        for wanted in GRAY_CHANNELS {
            if let Some(gray) = lookup(names, wanted, (By::Plain, str::eq_ignore_ascii_case), COLOR_KEY)? {
                return Ok([gray; 3]);
            }
        }
    }
    Err(Error::invalid(format!(
        "no colour channels with common names (R, G, B) were found: select a layer or three channels with \
        {COLOR_KEY}; the channels are: {}",
        list(names)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(all: &[&str]) -> Vec<ChannelName> {
        all.iter()
            .map(|text| match text.split_once('|') {
                Some((layer, name)) => {
                    let part = layer.len();
                    ChannelName { layer: layer.into(), part, view: String::new(), name: name.into() }
                }
                None => ChannelName { layer: String::new(), part: 0, view: String::new(), name: (*text).into() },
            })
            .collect()
    }

    fn depth(all: &[&str]) -> Result<usize> {
        let found = find_depth(&names(all), &ChannelSelect::Auto)?;
        assert_eq!(found.copies, None);
        Ok(found.channel)
    }

    fn depth_of(all: &[&str], select: &str) -> Result<DepthChannels> {
        find_depth(&names(all), &ChannelSelect::Named(select.into()))
    }

    fn views(all: &[&str]) -> Vec<ChannelName> {
        let with_view = |text: &&str| {
            let (view, name) = text.split_once(':').unwrap();
            ChannelName { view: view.into(), ..names(&[name]).remove(0) }
        };
        all.iter().map(with_view).collect()
    }

    #[test]
    fn alpha_is_that_of_the_layer_of_red() {
        let alpha = |all: &[&str]| {
            let names = names(all);
            find_alpha(&names, find_color(&names, &ChannelSelect::Auto).unwrap()[0])
        };
        assert_eq!(alpha(&["A", "B", "G", "R"]), Some(0));
        assert_eq!(alpha(&["B", "G", "R"]), None);
        assert_eq!(alpha(&["x.A", "b", "g", "r", "a"]), Some(4));
        assert_eq!(alpha(&["A", "rgba.A", "rgba.B", "rgba.G", "rgba.R"]), Some(1));
        assert_eq!(alpha(&["other|A", "one|B", "one|G", "one|R"]), None);
        assert_eq!(alpha(&["Y", "A"]), Some(1));
    }

    fn color(all: &[&str], select: &str) -> Result<[usize; 3]> {
        let select = if select.is_empty() { ChannelSelect::Auto } else { ChannelSelect::Named(select.into()) };
        find_color(&names(all), &select)
    }

    #[test]
    fn usual_names_of_depth() {
        assert_eq!(depth(&["B", "G", "R", "Z"]).unwrap(), 3);
        assert_eq!(depth(&["ViewLayer.Combined.R", "ViewLayer.Depth.Z"]).unwrap(), 1);
        assert_eq!(depth(&["Scene.Depth.V", "x.R"]).unwrap(), 0);
        assert_eq!(depth(&["anything"]).unwrap(), 0);
        assert_eq!(depth(&["DEPTH.z", "a"]).unwrap(), 0);
        assert_eq!(depth(&["ViewLayer.Combined|R", "ViewLayer.Depth|Z"]).unwrap(), 1);
        assert_eq!(depth(&["N|X", "N|Y", "N|Z", "Deep|Z"]).unwrap(), 3, "the Z of a normal is not depth");
        assert!(depth(&["N.X", "N.Y", "N.Z"]).is_err());
        let message = depth(&["left|Z", "right!|Z"]).unwrap_err().to_string();
        assert!(message.contains("left.Z") && message.contains("right!.Z"), "{message}");
        assert!(message.contains("`depth_channel`") && message.contains("depth.channel"), "{message}");
        assert_eq!(depth(&["B", "G", "Pz", "R"]).unwrap(), 2);
        assert!(depth(&["Px", "Py", "Pz"]).is_err(), "a position is not depth");
    }

    #[test]
    fn layers_of_depth() {
        let three = |channel, copies| DepthChannels { channel, copies: Some(copies) };
        let one = |channel| DepthChannels { channel, copies: None };
        let vray = ["B", "G", "R", "VRayZDepth.B", "VRayZDepth.G", "VRayZDepth.R"];
        assert_eq!(find_depth(&names(&vray), &ChannelSelect::Auto).unwrap(), three(5, [4, 3]));
        assert_eq!(depth_of(&vray, "VRayZDepth").unwrap(), three(5, [4, 3]));
        assert_eq!(depth_of(&vray, "VRayZDepth.G").unwrap(), one(4));
        assert_eq!(depth_of(&["far.Z", "near.Z", "near.A"], "near").unwrap(), one(1));
        assert_eq!(depth_of(&["R", "aux|distance to eye"], "aux").unwrap(), one(1));
        assert_eq!(depth_of(&["left|R", "left|G", "left|B", "left|Z", "right!|Z"], "left").unwrap(), one(3));
        let message = depth_of(&vray, "Zed").unwrap_err().to_string();
        assert!(message.contains("Zed") && message.contains("VRayZDepth.R"), "{message}");
    }

    #[test]
    fn views_of_stereo_files() {
        let parts = views(&["left:l|R", "left:l|G", "left:l|B", "left:l|Z", "right:rr|R", "right:rr|G", "right:rr|B"]);
        let named = |name: &str| ChannelSelect::Named(name.into());
        assert_eq!(find_color(&parts, &named("left")).unwrap(), [0, 1, 2]);
        assert_eq!(find_color(&parts, &named("rr")).unwrap(), [4, 5, 6]);
        assert_eq!(find_depth(&parts, &named("left")).unwrap().channel, 3);
        assert!(find_color(&parts, &ChannelSelect::Auto).is_err());
        let one_part = views(&["left:R", "left:G", "left:B", "right:right.R", "right:right.G", "right:right.B"]);
        assert_eq!(find_color(&one_part, &named("left")).unwrap(), [0, 1, 2]);
        assert_eq!(find_color(&one_part, &named("right")).unwrap(), [3, 4, 5]);
        assert_eq!(find_color(&one_part, &named("{probe}").of_image("right", "view")).unwrap(), [3, 4, 5]);
    }

    #[test]
    fn usual_names_of_color() {
        let picture = |all: &[&str]| find_picture_color(&names(all));
        assert_eq!(picture(&["A", "B", "G", "R"]).unwrap(), [3, 2, 1]);
        let said = picture(&["left|R", "left|X", "right|X"]).unwrap_err().to_string();
        assert!(said.contains("left.X, right.X") && !said.contains('`'), "{said}");
        assert_eq!(color(&["A", "B", "G", "R"], "").unwrap(), [3, 2, 1]);
        assert_eq!(color(&["a.B", "a.G", "a.R", "Z"], "").unwrap(), [2, 1, 0]);
        assert_eq!(
            color(&["ViewLayer.Combined.B", "ViewLayer.Combined.G", "ViewLayer.Combined.R"], "").unwrap(),
            [2, 1, 0]
        );
        assert_eq!(color(&["Y"], "").unwrap(), [0, 0, 0]);
        assert!(color(&["Y", "RY", "BY"], "").is_err());
        assert!(color(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"], "").is_err());
        assert_eq!(color(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"], "b").unwrap(), [3, 4, 5]);
        assert_eq!(color(&["p", "q", "s"], "s, p,q").unwrap(), [2, 0, 1]);
        assert_eq!(color(&["p", "q"], "q").unwrap(), [1, 1, 1]);
    }
}
