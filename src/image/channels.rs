//! Selects the colour and depth channels of a file: common names, or a given one.
//!
//! A channel has its own name and, in a file of several layers (parts), `layer.name`. The tables are searched in order,
//! first by full name, then by the channel's own name. An ambiguous name is an error that lists the candidates.

use std::collections::BTreeSet;

use crate::error::{Error, Result};

/// Names of depth in order of preference: first as written, then ignoring case.
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
];

/// Suffixes of depth channels, used where exactly one channel of the file has one.
pub const DEPTH_ENDINGS: &[&str] = &[".depth.z", ".depth.v", ".depth.y", ".depth"];

/// Layers (prefixes of channel names) of colour in order of preference; the first is no prefix.
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

/// Names of the three colour components inside a layer.
pub const COLOR_COMPONENTS: &[[&str; 3]] = &[["R", "G", "B"], ["r", "g", "b"], ["red", "green", "blue"]];

/// Names of a channel that is read as gray where there is no RGB.
pub const GRAY_CHANNELS: &[&str] = &["Y", "L", "luminance", "gray"];

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum ChannelSelect {
    /// [`DEPTH_CHANNELS`] for depth, [`COLOR_LAYERS`] and [`COLOR_COMPONENTS`] for colour.
    #[default]
    Auto,
    /// For depth the name of a channel. For colour the name of a layer with R, G and B, three names separated by commas, or
    /// the name of a channel that is read as gray.
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

impl From<Option<String>> for ChannelSelect {
    fn from(name: Option<String>) -> Self {
        name.map_or(ChannelSelect::Auto, ChannelSelect::Named)
    }
}

#[derive(Debug, Clone)]
pub(crate) struct ChannelName {
    /// Name of its layer (part); empty where the file has none.
    pub layer: String,
    pub part: usize,
    pub name: String,
}

impl ChannelName {
    /// `layer.name`, or the name alone where the layer has no name or the name already starts with it.
    fn full(&self) -> String {
        let repeats = self.name.strip_prefix(&self.layer).is_some_and(|rest| rest.starts_with('.'));
        if self.layer.is_empty() || repeats { self.name.clone() } else { format!("{}.{}", self.layer, self.name) }
    }
}

const OPTIONS: &str = "`channel` (`depth_channel` or `color_channel` for a dataset)";

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

/// Order of comparison: full before plain names, as written before ignoring case.
const TRIES: [(By, Same); 4] = [
    (By::Full, str::eq),
    (By::Full, str::eq_ignore_ascii_case),
    (By::Plain, str::eq),
    (By::Plain, str::eq_ignore_ascii_case),
];

/// Index of the channel of that name; `None` when there is none, an error when several layers have it.
fn lookup(names: &[ChannelName], wanted: &str, by: By, same: Same) -> Result<Option<usize>> {
    if let By::Full = by {
        return Ok(names.iter().position(|channel| same(&channel.full(), wanted)));
    }
    let plain: Vec<usize> = (0..names.len()).filter(|&i| same(&names[i].name, wanted)).collect();
    match plain.as_slice() {
        [] => Ok(None),
        [one] => Ok(Some(*one)),
        _ => Err(Error::invalid(format!(
            "several layers have a channel {wanted}: name one of {} with {OPTIONS}",
            plain.iter().map(|&i| names[i].full()).collect::<Vec<_>>().join(", ")
        ))),
    }
}

pub(crate) fn find_named(names: &[ChannelName], wanted: &str) -> Result<usize> {
    let found = match lookup(names, wanted, By::Full, str::eq)? {
        None => lookup(names, wanted, By::Plain, str::eq)?,
        found => found,
    };
    found.ok_or_else(|| Error::invalid(format!("there is no channel {wanted}; the channels are: {}", list(names))))
}

/// Whether the channel is a coordinate of a vector, as the Z of a normal or a position.
fn is_coordinate(names: &[ChannelName], index: usize) -> bool {
    let channel = &names[index];
    let Some(stem) = channel.name.strip_suffix(['Z', 'z']) else { return false };
    ["X", "Y"].iter().all(|axis| {
        let sibling = format!("{stem}{axis}");
        names.iter().any(|other| other.part == channel.part && other.name.eq_ignore_ascii_case(&sibling))
    })
}

/// Index of the alpha channel beside a channel of red or gray, of the same layer.
pub(crate) fn find_alpha(names: &[ChannelName], red: usize) -> Option<usize> {
    let red = names.get(red)?;
    let prefix = &red.name[..red.name.rfind('.').map_or(0, |dot| dot + 1)];
    let is_alpha = |channel: &ChannelName| {
        let own = channel.name.strip_prefix(prefix).filter(|_| channel.part == red.part);
        own.is_some_and(|own| ["a", "alpha"].iter().any(|alpha| own.eq_ignore_ascii_case(alpha)))
    };
    names.iter().position(is_alpha)
}

/// Indices of red, green and blue of a rendered picture, whose channels nobody names.
pub(crate) fn find_picture_color(names: &[ChannelName]) -> Result<[usize; 3]> {
    find_color(names, &ChannelSelect::Auto).map_err(|_| {
        Error::invalid(format!("one picture with channels R, G and B was expected; the channels are: {}", list(names)))
    })
}

pub(crate) fn find_depth(names: &[ChannelName], select: &ChannelSelect) -> Result<usize> {
    if let ChannelSelect::Named(wanted) = select {
        return find_named(names, wanted);
    }
    // A normal's Z would win over the depth beside it; such triples are set aside first.
    let candidates: Vec<usize> = (0..names.len()).filter(|&i| !is_coordinate(names, i)).collect();
    let kept: Vec<ChannelName> = candidates.iter().map(|&i| names[i].clone()).collect();
    for (by, same) in TRIES {
        for wanted in DEPTH_CHANNELS {
            if let Some(found) = lookup(&kept, wanted, by, same)? {
                return Ok(candidates[found]);
            }
        }
    }
    let ending = |channel: &ChannelName| {
        let full = channel.full().to_ascii_lowercase();
        DEPTH_ENDINGS.iter().any(|ending| full.ends_with(ending))
    };
    let found: Vec<usize> = candidates.iter().copied().filter(|&i| ending(&names[i])).collect();
    match (found.as_slice(), names) {
        ([one], _) => Ok(*one),
        ([], [_only]) => Ok(0),
        _ => Err(Error::invalid(format!(
            "no channel has a usual name of depth (Z, depth.Z, Depth, ...): name one with {OPTIONS}; the channels are: {}",
            list(names)
        ))),
    }
}

fn find_layer(names: &[ChannelName], layer: &str, by: By, same: Same) -> Result<Option<[usize; 3]>> {
    for components in COLOR_COMPONENTS {
        let mut found = [None; 3];
        for (slot, component) in found.iter_mut().zip(components) {
            let wanted = if layer.is_empty() { (*component).to_string() } else { format!("{layer}.{component}") };
            *slot = lookup(names, &wanted, by, same)?;
        }
        if let [Some(r), Some(g), Some(b)] = found {
            return Ok(Some([r, g, b]));
        }
    }
    Ok(None)
}

/// Indices of red, green and blue; the same index three times for gray.
pub(crate) fn find_color(names: &[ChannelName], select: &ChannelSelect) -> Result<[usize; 3]> {
    if let ChannelSelect::Named(wanted) = select {
        if let [r, g, b] = wanted.split(',').map(str::trim).collect::<Vec<_>>().as_slice() {
            return Ok([find_named(names, r)?, find_named(names, g)?, find_named(names, b)?]);
        }
        let layer = match find_layer(names, wanted, By::Full, str::eq)? {
            None => find_layer(names, wanted, By::Plain, str::eq)?,
            found => found,
        };
        return match layer {
            Some(found) => Ok(found),
            None => find_named(names, wanted).map(|gray| [gray; 3]),
        };
    }
    for (by, same) in TRIES {
        for layer in COLOR_LAYERS {
            if let Some(found) = find_layer(names, layer, by, same)? {
                return Ok(found);
            }
        }
    }
    let layers: BTreeSet<String> = names
        .iter()
        .filter_map(|channel| channel.full().rsplit_once('.').map(|(layer, _)| layer.to_string()))
        .collect();
    let mut found = Vec::new();
    for layer in &layers {
        found.extend(find_layer(names, layer, By::Full, str::eq)?);
    }
    if let [one] = found.as_slice() {
        return Ok(*one);
    }
    if found.is_empty() {
        if names.iter().any(|channel| matches!(channel.name.as_str(), "RY" | "BY")) {
            return Err(Error::unsupported(
                "the colour is stored as luminance and chroma (Y, RY, BY), which is not read: save it as R, G, B",
            ));
        }
        for wanted in GRAY_CHANNELS {
            if let Some(gray) = lookup(names, wanted, By::Plain, str::eq_ignore_ascii_case)? {
                return Ok([gray; 3]);
            }
        }
    }
    Err(Error::invalid(format!(
        "no usual names of colour (R, G, B): name a layer or three channels with {OPTIONS}; the channels are: {}",
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
                    ChannelName { layer: layer.into(), part, name: name.into() }
                }
                None => ChannelName { layer: String::new(), part: 0, name: (*text).into() },
            })
            .collect()
    }

    fn depth(all: &[&str]) -> Result<usize> {
        find_depth(&names(all), &ChannelSelect::Auto)
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
        assert!(message.contains("`channel`") && message.contains("`depth_channel`"), "{message}");
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
