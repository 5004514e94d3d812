//! Quilts: the views of a light field as tiles of one image, for Looking Glass displays.
//!
//! View 0 is the leftmost view of the scene and the bottom left tile; views are ordered left to right, then bottom to top. The
//! file name states the layout: `name_qs8x6a0.75.png` has 8 columns, 6 rows and views of aspect ratio (width / height) 0.75.
//! Tiles are never resampled.

use std::cmp::Reverse;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use codec::error::{Error, Result};

use codec::image::plane::Plane;

/// A display, and the quilt layout that its manufacturer recommends.
struct Device {
    name: &'static str,
    columns: u32,
    rows: u32,
    size: [u32; 2],
    /// Width and height of the display.
    aspect: [u32; 2],
}

const fn device(name: &'static str, [columns, rows]: [u32; 2], size: [u32; 2], aspect: [u32; 2]) -> Device {
    Device { name, columns, rows, size, aspect }
}

/// Landscape and portrait displays.
const WIDE: [u32; 2] = [16, 9];
const HIGH: [u32; 2] = [9, 16];

/// Source: "Quilt Settings by Device", docs.lookingglassfactory.com/keyconcepts/quilts, as of 2026. Displays of the second
/// generation, `-gen2`, are listed in earlier editions of that page and in lookingglassfactory.com/tutorial/what-is-a-quilt.
const DEVICES: [Device; 9] = [
    device("portrait", [8, 6], [3360, 3360], [3, 4]),
    device("go", [11, 6], [4092, 4092], HIGH),
    device("16", [7, 7], [5999, 5999], WIDE),
    device("16-portrait", [11, 6], [5995, 6000], HIGH),
    device("16-gen2", [5, 9], [4096, 4096], WIDE),
    device("32", [7, 7], [8190, 8190], WIDE),
    device("32-portrait", [11, 6], [8184, 8184], HIGH),
    device("32-gen2", [5, 9], [8192, 8192], WIDE),
    device("65", [8, 9], [8192, 8192], WIDE),
];

/// Maximum number of columns, and of rows.
const MAX_TILES: u32 = 4096;
/// Maximum number of pixels of a quilt: 4 GiB of 8-bit RGBA.
const MAX_PIXELS: u64 = 1 << 30;
/// Maximum ratio of the sides of the image at which a layout without blank tiles is preferred to one nearer to a square.
const LONGEST_RATIO: f64 = 3.0;
/// Tolerance between the aspect ratio in a file name and that of the views: the manufacturer writes 16:9 as 1.777.
const ASPECT_TOLERANCE: f64 = 0.001;
const SUFFIX: &str = "_qs";

/// Columns and rows of tiles, each 1 to 4096.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuiltLayout {
    pub columns: u32,
    pub rows: u32,
    /// Width and height in pixels of the image that a device expects; `None` without a device.
    pub size: Option<[u32; 2]>,
}

impl QuiltLayout {
    /// Returns a layout without a device. Fails if a count is 0 or more than 4096.
    pub fn new(columns: u32, rows: u32) -> Result<QuiltLayout> {
        for count in [columns, rows] {
            if !(1..=MAX_TILES).contains(&count) {
                let message =
                    format!("a quilt of {columns}x{rows} tiles: 1 to {MAX_TILES} columns and rows were expected");
                return Err(Error::Usage(message));
            }
        }
        Ok(QuiltLayout { columns, rows, size: None })
    }

    /// Chooses the layout for `views` views of `view_size` pixels. The first choice is the layout of a device with that number
    /// and size of tiles. The second is the layout nearest to a square among those without blank tiles and with sides of at most
    /// 3:1. The third is the layout nearest to a square, with blank tiles.
    pub fn choose(views: u32, view_size: [u32; 2]) -> Result<QuiltLayout> {
        let fits = |device: &QuiltLayout| device.tiles() == u64::from(views) && device.view_size() == Some(view_size);
        if let Some(device) = DEVICES.iter().map(Device::layout).find(fits) {
            return Ok(device);
        }
        let ratio = |[columns, rows]: [u32; 2]| {
            let sides = [columns, rows].map(f64::from);
            let [width, height] = [0, 1].map(|axis| sides[axis] * f64::from(view_size[axis]));
            width.max(height) / width.min(height)
        };
        // Ties are broken by fewer tiles, then by more columns.
        let nearest = |layouts: &mut dyn Iterator<Item = [u32; 2]>| {
            let key = |layout: &[u32; 2]| (layout[0] * layout[1], Reverse(layout[0]));
            layouts.min_by(|a, b| ratio(*a).total_cmp(&ratio(*b)).then_with(|| key(a).cmp(&key(b))))
        };
        let all = || {
            let layouts = (1..=views.min(MAX_TILES)).map(|columns| [columns, views.div_ceil(columns)]);
            layouts.filter(|layout| layout[1] <= MAX_TILES)
        };
        let whole =
            nearest(&mut all().filter(|layout| views.is_multiple_of(layout[0]) && ratio(*layout) <= LONGEST_RATIO));
        let Some([columns, rows]) = whole.or_else(|| nearest(&mut all())) else {
            return Err(Error::Usage(format!("{views} views: 1 to {MAX_TILES} x {MAX_TILES} fit a quilt")));
        };
        QuiltLayout::new(columns, rows)
    }

    pub fn tiles(self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }

    /// Returns the name of the device that the layout belongs to.
    pub fn device(self) -> Option<&'static str> {
        DEVICES.iter().find(|device| device.layout() == self).map(|device| device.name)
    }

    /// Returns width / height of a view as displayed: that of the device, whose tiles need not have it, since their pixels are
    /// stretched; else that of `view_size` in pixels.
    pub fn aspect(self, view_size: [u32; 2]) -> f64 {
        let device = DEVICES.iter().find(|device| device.layout() == self);
        let [width, height] = device.map_or(view_size, |device| device.aspect).map(f64::from);
        width / height
    }

    /// Returns the width and height in pixels of the views that the device expects, rounded down.
    pub fn view_size(self) -> Option<[u32; 2]> {
        self.size.map(|[width, height]| [width / self.columns, height / self.rows])
    }

    /// Returns the width and height in pixels of a quilt with views of that size. Fails if it has more than 2^30 pixels.
    pub fn picture_size(self, view_size: [u32; 2]) -> Result<[u32; 2]> {
        let sides = [self.columns.checked_mul(view_size[0]), self.rows.checked_mul(view_size[1])];
        let fits = |size: &[u32; 2]| u64::from(size[0]) * u64::from(size[1]) <= MAX_PIXELS;
        let size = sides[0].zip(sides[1]).map(<[u32; 2]>::from).filter(fits);
        size.ok_or_else(|| {
            let [width, height] = view_size;
            let message = format!("{self} tiles of {width}x{height} pixels: a quilt has at most {MAX_PIXELS} pixels");
            Error::Usage(format!("{message}; use fewer or smaller views"))
        })
    }

    /// Returns the top left pixel of a view's tile, rows counted from the top of the image; `None` if there is no such tile.
    pub fn corner(self, view: u32, view_size: [u32; 2]) -> Option<[u32; 2]> {
        let from_bottom = view / self.columns;
        let row = self.rows.checked_sub(from_bottom + 1)?;
        Some([(view % self.columns).checked_mul(view_size[0])?, row.checked_mul(view_size[1])?])
    }

    /// Returns notes for the user: the number of blank tiles, and the size that the device expects if it differs. Fails if the
    /// views do not fit the tiles.
    pub fn notes(self, views: u32, view_size: [u32; 2]) -> Result<Vec<String>> {
        let [width, height] = self.picture_size(view_size)?;
        let Some(blank) = self.tiles().checked_sub(views.into()) else {
            let tiles = self.tiles();
            return Err(Error::Usage(format!(
                "`quilt` {self} has {tiles} tiles, but there are {views} views: use more columns and rows, or fewer \
                `views`"
            )));
        };
        let mut notes = Vec::new();
        if blank > 0 {
            let are = if blank == 1 { "is" } else { "are" };
            notes.push(format!("{blank} of {} tiles {are} black: there are {views} views", self.tiles()));
        }
        if let (Some(name), Some(size), Some(view)) = (self.device(), self.size, self.view_size())
            && size != [width, height]
        {
            notes.push(format!(
                "{name} expects {}x{} pixels, views of {}x{}; this quilt has {width}x{height}, views of {}x{}",
                size[0], size[1], view[0], view[1], view_size[0], view_size[1]
            ));
        }
        Ok(notes)
    }
}

impl fmt::Display for QuiltLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.columns, self.rows)
    }
}

impl FromStr for QuiltLayout {
    type Err = Error;

    /// Parses the name of a device, or columns and rows such as `8x6`.
    fn from_str(text: &str) -> Result<Self> {
        if let Some(device) = DEVICES.iter().find(|device| device.name == text) {
            return Ok(device.layout());
        }
        let number = |text: &str| whole_number(text).map(|(number, rest)| (number, rest.is_empty()));
        match text.split_once('x').and_then(|(columns, rows)| number(columns).zip(number(rows))) {
            Some(((columns, true), (rows, true))) => QuiltLayout::new(columns, rows),
            _ => {
                let names = DEVICES.map(|device| device.name).join(", ");
                let message = format!("\"{text}\": a device ({names}) or columns and rows such as 8x6 were expected");
                Err(Error::Usage(message))
            }
        }
    }
}

impl Device {
    fn layout(&self) -> QuiltLayout {
        QuiltLayout { columns: self.columns, rows: self.rows, size: Some(self.size) }
    }
}

/// Layout stated by the file name of a quilt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuiltName {
    pub columns: u32,
    pub rows: u32,
    /// Width / height of a view as displayed; `None` if the name does not state it.
    pub aspect: Option<f64>,
}

/// Parses the layout of a file name such as `name_qs8x6a0.75.png`, `name_QS8x6.png` or `name_qs8x6a0.75_0001.png`; `None` if the
/// stem has no layout. Of several, the last counts.
pub fn parse_quilt_name(path: &Path) -> Option<QuiltName> {
    let stem = path.file_stem()?.to_str()?.to_ascii_lowercase();
    let (_, suffix) = stem.rsplit_once(SUFFIX)?;
    let (columns, rest) = whole_number(suffix)?;
    let (rows, rest) = whole_number(rest.strip_prefix('x')?)?;
    let (aspect, rest) = match rest.strip_prefix('a') {
        Some(text) if text.starts_with(|c: char| c.is_ascii_digit()) => {
            let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
            let aspect = text[..end].parse::<f64>().ok().filter(|aspect| *aspect > 0.0 && aspect.is_finite())?;
            (Some(aspect), &text[end..])
        }
        _ => (None, rest),
    };
    let ends = !rest.starts_with(|c: char| c.is_alphanumeric());
    (ends && columns > 0 && rows > 0).then_some(QuiltName { columns, rows, aspect })
}

/// Splits a text into the number at its start and the remaining text.
fn whole_number(text: &str) -> Option<(u32, &str)> {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    Some((text[..end].parse().ok()?, &text[end..]))
}

/// Returns the path with the layout in the file name, as the manufacturer's programs expect it: `quilt.png` becomes
/// `quilt_qs8x6a0.75.png`. A name that already states the layout is kept. Fails if the name states another layout. `aspect` is
/// the width / height of a view.
pub fn quilt_path(path: &Path, layout: QuiltLayout, aspect: f64) -> Result<PathBuf> {
    let words = aspect_words(aspect);
    if !aspect.is_finite() || words == "0" {
        return Err(Error::Usage(format!("views of aspect ratio {aspect}: 0.0001 or more was expected")));
    }
    let suffix = format!("{SUFFIX}{layout}a{words}");
    let Some(stem) = path.file_stem() else {
        return Err(Error::Usage(format!("\"{}\" is not a file name", path.display())));
    };
    let Some(name) = parse_quilt_name(path) else {
        let mut name = stem.to_os_string();
        name.push(suffix);
        if let Some(extension) = path.extension() {
            name.push(".");
            name.push(extension);
        }
        return Ok(path.with_file_name(name));
    };
    let says = |found: String, made: String| {
        let message = format!("the file name states {found}, but the quilt has {made}");
        Error::Usage(format!(
            "{}: {message}: leave out {SUFFIX} and the rest, or change it to {suffix}",
            path.display()
        ))
    };
    if [name.columns, name.rows] != [layout.columns, layout.rows] {
        return Err(says(format!("{}x{} tiles", name.columns, name.rows), layout.to_string()));
    }
    match name.aspect {
        Some(said) if (said - aspect).abs() > ASPECT_TOLERANCE => {
            Err(says(format!("views of aspect ratio {said}"), words))
        }
        _ => Ok(path.to_path_buf()),
    }
}

/// Formats the ratio with up to four decimals, without trailing zeros.
fn aspect_words(aspect: f64) -> String {
    format!("{aspect:.4}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A quilt under construction; views may be added in any order.
pub struct Quilt<T> {
    layout: QuiltLayout,
    view_size: [u32; 2],
    picture: Plane<T>,
}

impl<T: Copy> Quilt<T> {
    /// Creates a quilt filled with the colour `blank`; `view_size` is the width and height of a tile in pixels.
    pub fn new(layout: QuiltLayout, view_size: [u32; 2], blank: T) -> Result<Quilt<T>> {
        let [width, height] = layout.picture_size(view_size)?;
        Ok(Quilt { layout, view_size, picture: Plane::filled(width, height, blank) })
    }

    /// Copies a view to its tile. Fails if the view has another size, or if there is no such tile.
    pub fn put(&mut self, view: u32, pixels: &Plane<T>) -> Result<()> {
        let ([width, height], size) = (self.view_size, [pixels.width(), pixels.height()]);
        if size != self.view_size {
            let message = format!("a view of {}x{} pixels, where tiles have {width}x{height}", size[0], size[1]);
            return Err(Error::invalid(message));
        }
        let Some([left, top]) = self.layout.corner(view, self.view_size) else {
            return Err(Error::Usage(format!("view {view} lies beyond the {} tiles of a quilt", self.layout)));
        };
        for y in 0..height {
            let row = self.picture.row_mut(top + y);
            row[left as usize..][..width as usize].copy_from_slice(pixels.row(y));
        }
        Ok(())
    }

    pub fn picture(&self) -> &Plane<T> {
        &self.picture
    }

    pub fn finish(self) -> Plane<T> {
        self.picture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said<T: fmt::Debug>(result: Result<T>) -> String {
        result.unwrap_err().to_string()
    }

    fn chosen(views: u32, view_size: [u32; 2]) -> (String, Option<&'static str>) {
        let layout = QuiltLayout::choose(views, view_size).unwrap();
        (layout.to_string(), layout.device())
    }

    #[test]
    fn devices_are_chosen_by_views_and_their_size() {
        for device in &DEVICES {
            let layout = device.layout();
            let view_size = layout.view_size().unwrap();
            assert_eq!(chosen(device.columns * device.rows, view_size), (layout.to_string(), Some(device.name)));
            assert_eq!(layout, device.name.parse().unwrap());
            assert!([0.75, 0.5625, 16.0 / 9.0].contains(&layout.aspect(view_size)), "{}", device.name);
            let whole = layout.picture_size(view_size).unwrap() == device.size;
            assert_eq!(whole, !["16-gen2", "32-gen2", "65"].contains(&device.name), "{}", device.name);
        }
        assert_eq!(chosen(48, [420, 560]), ("8x6".to_owned(), Some("portrait")));
        assert_eq!(chosen(66, [372, 682]), ("11x6".to_owned(), Some("go")));
        assert_eq!(chosen(48, [421, 560]).1, None);
        assert_eq!(chosen(47, [420, 560]).1, None);
        assert_eq!(QuiltLayout::new(8, 6).unwrap().aspect([420, 210]), 2.0);
    }

    #[test]
    fn other_layouts_are_nearly_square_pictures() {
        let layout = |views, view_size| chosen(views, view_size).0;
        let square =
            [(1, "1x1"), (2, "2x1"), (3, "3x1"), (4, "2x2"), (12, "4x3"), (45, "9x5"), (48, "8x6"), (49, "7x7")];
        for (views, words) in square {
            assert_eq!(layout(views, [10, 10]), words);
        }
        // With blank tiles, if no layout without blank tiles is within 3:1.
        for (views, words) in [(5, "3x2"), (7, "3x3"), (11, "4x3"), (13, "4x4"), (46, "7x7"), (47, "7x7")] {
            assert_eq!(layout(views, [10, 10]), words);
        }
        // Portrait views give more columns, landscape views more rows.
        assert_eq!(layout(48, [30, 40]), "8x6");
        assert_eq!(layout(45, [160, 90]), "5x9");
        assert_eq!(layout(66, [90, 160]), "11x6");
        assert_eq!(layout(5, [10, 50]), "5x1");
        assert_eq!(layout(1, [1000, 1]), "1x1");
        assert!(QuiltLayout::choose(0, [10, 10]).is_err());
        assert!(QuiltLayout::choose(u32::MAX, [10, 10]).is_err());
    }

    #[test]
    fn layouts_are_parsed() {
        assert_eq!("8x6".parse::<QuiltLayout>().unwrap(), QuiltLayout { columns: 8, rows: 6, size: None });
        assert_eq!("portrait".parse::<QuiltLayout>().unwrap().size, Some([3360, 3360]));
        for text in ["", "8", "x6", "8x", "8x6x2", "8X6", "-8x6", " 8x6", "+8x6", "8x6a0.75", "17", "99999999999x1"] {
            assert!(said(text.parse::<QuiltLayout>()).contains("portrait, go, 16, "), "{text}");
        }
        for text in ["0x6", "8x0", "4097x1"] {
            assert!(said(text.parse::<QuiltLayout>()).contains("1 to 4096"), "{text}");
        }
    }

    #[test]
    fn notes_say_what_a_display_would_not_show() {
        let layout = |text: &str| text.parse::<QuiltLayout>().unwrap();
        assert_eq!(layout("portrait").notes(48, [420, 560]).unwrap(), Vec::<String>::new());
        assert_eq!(layout("8x6").notes(48, [1, 2]).unwrap(), Vec::<String>::new());
        let notes = layout("portrait").notes(47, [42, 56]).unwrap();
        assert_eq!(notes[0], "1 of 48 tiles is black: there are 47 views");
        assert_eq!(
            notes[1],
            "portrait expects 3360x3360 pixels, views of 420x560; this quilt has 336x336, views of 42x56"
        );
        assert!(layout("65").notes(72, [1024, 910]).unwrap()[0].contains("this quilt has 8192x8190"));
        assert!(said(layout("8x6").notes(49, [1, 1])).contains("48 tiles, but there are 49 views"));
        assert!(said(layout("4096x4096").notes(1, [9, 9])).contains("at most 1073741824 pixels"));
        assert!(said(layout("4096x1").notes(1, [u32::MAX, 1])).contains("smaller views"));
    }

    #[test]
    fn names_are_parsed() {
        let name = |text: &str| parse_quilt_name(Path::new(text)).map(|name| (name.columns, name.rows, name.aspect));
        assert_eq!(name("a/q_qs8x6a0.75.png"), Some((8, 6, Some(0.75))));
        assert_eq!(name("_qs5x9a1.7778.exr"), Some((5, 9, Some(1.7778))));
        assert_eq!(name("q_qs2x2a1_qs11x6a2.png"), Some((11, 6, Some(2.0))));
        assert_eq!(name("q_qs8x6.webp"), Some((8, 6, None)));
        assert_eq!(name("q_QS8X6A0.75.PNG"), Some((8, 6, Some(0.75))));
        assert_eq!(name("q_qs8x6a0.75_0001.png"), Some((8, 6, Some(0.75))));
        assert_eq!(name("q_qs8x6-left.png"), Some((8, 6, None)));
        let others = [
            "q.png",
            "q_qs.png",
            "my_qsort.png",
            "q_qs8x6a.png",
            "q_qs0x6a1.png",
            "q_qs8x6a0.png",
            "q_qs8x6a-1.png",
            "q_qs8x6ainf.png",
            "q_qs8x6a1e2.png",
            "q_qs8x6aa1.png",
            "qs8x6a1.png",
            "q_qs8xa1.png",
            "q_qs99999999999x6a1.png",
            "q_qs8x6a1.2.3.png",
            "..",
        ];
        for text in others {
            assert_eq!(name(text), None, "{text}");
        }
    }

    #[test]
    fn names_carry_columns_rows_and_aspect() {
        let layout = QuiltLayout::new(8, 6).unwrap();
        let path = |text: &str, aspect| quilt_path(Path::new(text), layout, aspect);
        let named = |text: &str, aspect| path(text, aspect).unwrap().to_str().unwrap().to_owned();
        assert_eq!(named("a/quilt.png", 0.75), "a/quilt_qs8x6a0.75.png");
        assert_eq!(named("quilt.v2.exr", 16.0 / 9.0), "quilt.v2_qs8x6a1.7778.exr");
        assert_eq!(named("q", 1.0), "q_qs8x6a1");
        assert_eq!(named("q.png", 100.0), "q_qs8x6a100.png");
        assert_eq!(named("q.png", 372.0 / 682.0), "q_qs8x6a0.5455.png");
        for (text, aspect) in [("q_qs8x6a0.75.png", 0.75), ("q_qs8x6a1.777.png", 16.0 / 9.0), ("q_qs8x6.png", 0.3)] {
            assert_eq!(named(text, aspect), text);
        }
        let message = said(path("q_qs6x8a0.75.png", 0.75));
        assert!(
            message.starts_with("q_qs6x8a0.75.png: the file name states 6x8 tiles, but the quilt has 8x6"),
            "{message}"
        );
        assert!(message.ends_with("change it to _qs8x6a0.75"), "{message}");
        let message = said(path("q_qs8x6a0.5625.png", 0.5455));
        assert!(message.contains("states views of aspect ratio 0.5625, but the quilt has 0.5455"), "{message}");
        for aspect in [0.0, 0.000_01, f64::NAN, f64::INFINITY] {
            assert!(said(path("q.png", aspect)).contains("0.0001"), "{aspect}");
        }
        assert!(path("..", 1.0).is_err());
    }

    #[test]
    fn names_are_read_back() {
        for (width, height) in [(420, 560), (372, 682), (819, 455), (1024, 910), (1, 3), (2000, 7)] {
            let (layout, aspect) = (QuiltLayout::new(5, 9).unwrap(), f64::from(width) / f64::from(height));
            let path = quilt_path(Path::new("q.png"), layout, aspect).unwrap();
            let name = parse_quilt_name(&path).unwrap();
            assert_eq!((name.columns, name.rows), (5, 9));
            assert!((name.aspect.unwrap() - aspect).abs() < 0.000_05 + 1e-12, "{}", path.display());
            assert_eq!(quilt_path(&path, layout, aspect).unwrap(), path);
        }
    }

    #[test]
    fn view_0_is_at_the_bottom_left() {
        let layout = QuiltLayout::new(3, 2).unwrap();
        let mut quilt = Quilt::new(layout, [2, 1], 99).unwrap();
        for view in [4, 0, 2, 1, 3] {
            quilt.put(view, &Plane::from_fn(2, 1, |x, _| view * 10 + x)).unwrap();
        }
        assert!(said(quilt.put(6, &Plane::filled(2, 1, 0))).contains("beyond the 3x2 tiles"));
        assert!(said(quilt.put(0, &Plane::filled(1, 2, 0))).contains("1x2 pixels, where tiles have 2x1"));
        let picture = quilt.finish();
        assert_eq!((picture.width(), picture.height()), (6, 2));
        assert_eq!(picture.row(0), [30, 31, 40, 41, 99, 99]);
        assert_eq!(picture.row(1), [0, 1, 10, 11, 20, 21]);
    }
}
