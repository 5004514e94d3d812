//! Colour lookup tables in `.cube` files, as OpenColorIO writes them (`iridas_cube`, `resolve_cube`).
//!
//! Takes RGB, returns RGB. A file has a table of one dimension, of three, or both, where that of one dimension is applied first.
//! Each maps a range of input values, given by `DOMAIN_MIN` and `DOMAIN_MAX` or by `LUT_1D_INPUT_RANGE` and
//! `LUT_3D_INPUT_RANGE`, 0 to 1 by default; values outside are clamped to it. Interpolation is linear in one dimension, and
//! tetrahedral in three.

use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::files::open_regular;
use codec::error::{Error, Result};

/// Maximum number of entries of a table of one dimension.
const MAX_ENTRIES: usize = 65_536;
/// Maximum number of entries along a side of a table of three dimensions.
const MAX_SIDE: usize = 129;
/// Maximum number of bytes of a line.
const MAX_LINE: usize = 4096;

/// Input values of the first and of the last entry of a channel.
type Range = [f64; 2];

/// A lookup table.
#[derive(Debug, Clone, PartialEq)]
pub struct LookupTable {
    curves: Option<Grid>,
    cube: Option<Grid>,
}

/// A table of one or three dimensions.
#[derive(Debug, Clone, PartialEq)]
struct Grid {
    /// Number of entries along a side.
    side: usize,
    /// Ranges of red, green and blue.
    ranges: [Range; 3],
    /// In three dimensions red varies fastest.
    entries: Vec<[f32; 3]>,
}

/// Reads a `.cube` file. Errors name the line.
pub fn read_cube(path: &Path) -> Result<LookupTable> {
    let file = open_regular(path)?;
    parse(&mut BufReader::new(file)).map_err(|error| error.in_file(path))
}

/// Parses a `.cube` file.
pub fn parse(text: &mut dyn BufRead) -> Result<LookupTable> {
    let mut parser = Parser::default();
    for number in 1.. {
        let mut bytes = Vec::new();
        let read = std::io::Read::take(&mut *text, MAX_LINE as u64 + 1).read_until(b'\n', &mut bytes);
        if read.map_err(|error| Error::io("", error))? == 0 {
            break;
        }
        let at = |message: String| Error::invalid(format!("line {number}: {message}"));
        let line = str::from_utf8(&bytes).ok().filter(|_| bytes.len() <= MAX_LINE);
        let line = line.ok_or_else(|| at("a line of text was expected".to_owned()))?;
        let line = line.trim_start_matches('\u{feff}').trim();
        if !line.is_empty() && !line.starts_with('#') {
            parser.add(line).map_err(at)?;
        }
    }
    parser.finish().map_err(Error::invalid)
}

#[derive(Debug)]
struct Parser {
    curve_side: Option<usize>,
    cube_side: Option<usize>,
    domain: [[f64; 3]; 2],
    curve_range: Option<Range>,
    cube_range: Option<Range>,
    entries: Vec<[f32; 3]>,
}

impl Default for Parser {
    fn default() -> Parser {
        let (sides, ranges) = ([None; 2], [None; 2]);
        let ([curve_side, cube_side], [curve_range, cube_range]) = (sides, ranges);
        Parser { curve_side, cube_side, domain: [[0.0; 3], [1.0; 3]], curve_range, cube_range, entries: Vec::new() }
    }
}

impl Parser {
    fn add(&mut self, line: &str) -> Result<(), String> {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if !key.starts_with(|c: char| c.is_ascii_alphabetic()) || ["nan", "inf"].contains(&key) {
            return self.add_entry(line);
        }
        if !self.entries.is_empty() {
            return Err(format!("{} after the first entry, where three numbers were expected", shown(key)));
        }
        match key {
            "TITLE" => {}
            "LUT_1D_SIZE" => self.curve_side = Some(side(key, rest, MAX_ENTRIES)?),
            "LUT_3D_SIZE" => self.cube_side = Some(side(key, rest, MAX_SIDE)?),
            "LUT_1D_INPUT_RANGE" => self.curve_range = Some(numbers(key, rest)?),
            "LUT_3D_INPUT_RANGE" => self.cube_range = Some(numbers(key, rest)?),
            "DOMAIN_MIN" => self.domain[0] = numbers(key, rest)?,
            "DOMAIN_MAX" => self.domain[1] = numbers(key, rest)?,
            _ => return Err(format!("{}: a key of a .cube file, or three numbers, were expected", shown(key))),
        }
        Ok(())
    }

    /// Returns the number of entries of the table of one dimension, and of that of three.
    fn counts(&self) -> [usize; 2] {
        [self.curve_side.unwrap_or(0), self.cube_side.map_or(0, |side| side.pow(3))]
    }

    fn add_entry(&mut self, line: &str) -> Result<(), String> {
        let all: usize = self.counts().iter().sum();
        if all == 0 {
            return Err("an entry before LUT_1D_SIZE or LUT_3D_SIZE, which tell how many there are".to_owned());
        }
        if self.entries.len() == all {
            return Err(format!("more entries than the {all} of the size"));
        }
        let entry: [f64; 3] = numbers("an entry", line)?;
        self.entries.push(entry.map(|value| value as f32));
        Ok(())
    }

    fn finish(mut self) -> Result<LookupTable, String> {
        let [curves, cubes] = self.counts();
        if self.entries.len() < curves + cubes {
            return Err(format!("its size needs {} entries, and it has {}", curves + cubes, self.entries.len()));
        }
        let [low, high] = self.domain;
        let domain: [Range; 3] = std::array::from_fn(|channel| [low[channel], high[channel]]);
        // The second table of a file takes the values of the first, whatever the domain.
        let usual = if self.curve_side.is_some() { [[0.0, 1.0]; 3] } else { domain };
        let of_cube = self.cube_range.map_or(usual, |range| [range; 3]);
        let of_curves = self.curve_range.map_or(domain, |range| [range; 3]);
        if let Some([low, high]) = of_curves.iter().chain(&of_cube).find(|[low, high]| low >= high) {
            return Err(format!("a range of {low} to {high}: the lower value first was expected"));
        }
        let of_three = self.entries.split_off(curves);
        let grid = |side: usize, ranges, entries| Grid { side, ranges, entries };
        let table = LookupTable {
            cube: self.cube_side.map(|side| grid(side, of_cube, of_three)),
            curves: self.curve_side.map(|side| grid(side, of_curves, self.entries)),
        };
        match table.cube.is_none() && table.curves.is_none() {
            true => Err("neither LUT_1D_SIZE nor LUT_3D_SIZE: a .cube file was expected".to_owned()),
            false => Ok(table),
        }
    }
}

fn side(key: &str, text: &str, most: usize) -> Result<usize, String> {
    let side = text.trim().parse().ok().filter(|side| (2..=most).contains(side));
    side.ok_or_else(|| format!("{key} {}: 2 to {most} was expected", shown(text)))
}

fn numbers<const N: usize>(key: &str, text: &str) -> Result<[f64; N], String> {
    let number = |word: &str| word.parse().ok().filter(|value: &f64| (*value as f32).is_finite());
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
    let numbers = numbers.and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
    numbers.ok_or_else(|| format!("{key}: {N} numbers were expected, not {}", shown(text)))
}

/// Returns the start of a text of a file, for a message.
fn shown(text: &str) -> String {
    let start: String = text.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).take(40).collect();
    format!("'{start}'")
}

impl LookupTable {
    /// Returns the values of the table for an input; NaN is the lower end of the range.
    pub fn apply(&self, rgb: [f32; 3]) -> [f32; 3] {
        let rgb = self.curves.as_ref().map_or(rgb, |curves| curves.each(rgb));
        self.cube.as_ref().map_or(rgb, |cube| cube.tetrahedron(rgb))
    }
}

impl Grid {
    /// Returns the entry at or before an input value of a channel, and the fraction of the way to the next one.
    fn place(&self, channel: usize, value: f32) -> (usize, f64) {
        let [low, high] = self.ranges[channel];
        let last = (self.side - 1) as f64;
        let place = ((f64::from(value) - low) / (high - low) * last).clamp(0.0, last);
        // The cast converts NaN to 0.
        let before = (place as usize).min(self.side - 2);
        (before, (place - before as f64).max(0.0))
    }

    /// Applies the table of one dimension to each channel.
    fn each(&self, rgb: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|channel| {
            let (before, part) = self.place(channel, rgb[channel]);
            let [low, high] = [before, before + 1].map(|at| f64::from(self.entries[at][channel]));
            (low + part * (high - low)) as f32
        })
    }

    /// Applies the table of three dimensions: walks along the edges of a cell from its first corner to the opposite one, the
    /// channel with the greatest fraction first.
    fn tetrahedron(&self, rgb: [f32; 3]) -> [f32; 3] {
        let places: [(usize, f64); 3] = std::array::from_fn(|channel| self.place(channel, rgb[channel]));
        let steps = [1, self.side, self.side * self.side];
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| places[b].1.total_cmp(&places[a].1));
        let mut at: usize = (0..3).map(|channel| places[channel].0 * steps[channel]).sum();
        // In double precision, in which no difference is infinite.
        let mut value = self.entries[at].map(f64::from);
        for channel in order {
            let before = self.entries[at];
            at += steps[channel];
            let after = self.entries[at];
            for (value, (before, after)) in value.iter_mut().zip(before.into_iter().zip(after)) {
                *value += places[channel].1 * (f64::from(after) - f64::from(before));
            }
        }
        value.map(|value| value as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<LookupTable> {
        parse(&mut text.as_bytes())
    }

    /// Returns a table of three dimensions whose entries are `value` of the input.
    fn cube(side: usize, value: impl Fn([f64; 3]) -> [f64; 3]) -> String {
        let mut text = format!("LUT_3D_SIZE {side}\n");
        let part = |at: usize| at as f64 / (side - 1) as f64;
        for at in 0..side.pow(3) {
            let [r, g, b] = value([at % side, at / side % side, at / side / side].map(part));
            text += &format!("{r} {g} {b}\n");
        }
        text
    }

    #[test]
    fn planes_are_exact_and_channels_are_in_order() {
        // Linear in each channel, and different for each.
        let table = table(&cube(5, |[r, g, b]| [r + 0.5 * g, 2.0 * b, 0.25 * r - b])).unwrap();
        for [r, g, b] in [[0.1, 0.9, 0.3], [0.77, 0.2, 0.5], [0.4, 0.41, 0.99], [0.0, 1.0, 0.25]] {
            let found = table.apply([r, g, b]);
            for (found, expected) in found.into_iter().zip([r + 0.5 * g, 2.0 * b, 0.25 * r - b]) {
                assert!((found - expected).abs() < 1e-6, "{found} {expected}");
            }
        }
        assert_eq!(table.apply([-3.0, f32::INFINITY, f32::NAN]), [0.5, 0.0, 0.0]);
    }

    #[test]
    fn interpolation_is_tetrahedral() {
        // One corner of the cell is 1. On the gray diagonal only the first and the last corner count.
        let corner = |wanted: [f64; 3]| table(&cube(2, |rgb| [f64::from(u8::from(rgb == wanted)); 3])).unwrap();
        assert_eq!(corner([1.0, 1.0, 1.0]).apply([0.5; 3]), [0.5; 3]);
        assert_eq!(corner([1.0, 0.0, 0.0]).apply([0.5; 3]), [0.0; 3]);
        assert_eq!(corner([1.0, 0.0, 0.0]).apply([0.75, 0.5, 0.25]), [0.25; 3]);
        assert_eq!(corner([0.0, 1.0, 1.0]).apply([0.25, 0.5, 0.75]), [0.25; 3]);
    }

    #[test]
    fn curves_come_before_the_cube_and_have_their_own_range() {
        // The curve maps 0..8 to 0..1 by three entries; the cube swaps red and blue.
        let shaper = "# a\nTITLE \"x\"\nLUT_1D_SIZE 3\nLUT_1D_INPUT_RANGE 0 8\n";
        let curve = "0 0 0\n0.7075 0.7075 0.7075\n1 1 1\n";
        let swapped = cube(2, |[r, g, b]| [b, g, r]);
        let (size, entries) = swapped.split_once('\n').unwrap();
        let both = table(&format!("{shaper}{size}\n{curve}{entries}")).unwrap();
        let found = both.apply([8.0, 4.0, 2.0]);
        for (found, expected) in found.into_iter().zip([0.35375, 0.7075, 1.0]) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        let alone = table(&format!("DOMAIN_MIN 0 0 -1\r\nDOMAIN_MAX 8 4 1\r\nLUT_1D_SIZE 3\r\n{curve}")).unwrap();
        assert_eq!(alone.apply([4.0, 4.0, -1.0]), [0.7075, 1.0, 0.0]);
        let ranged = table(&format!("{}LUT_3D_INPUT_RANGE -1 1\n{entries}", "LUT_3D_SIZE 2\n")).unwrap();
        assert_eq!(ranged.apply([1.0, 0.0, -1.0]), [0.0, 0.5, 1.0]);
    }

    #[test]
    fn faults_name_their_line() {
        for (text, words) in [
            ("LUT_3D_SIZE 2\n0 0 0\n0 x 0\n", "line 3: an entry: 3 numbers were expected, not '0 x 0'"),
            ("LUT_3D_SIZE 2\n0 0\n", "line 2: an entry: 3 numbers"),
            ("LUT_3D_SIZE 2\n0 nan 0\n", "line 2"),
            ("LUT_1D_SIZE 2\n0 0 0\n1 1 1\n2 2 2\n", "line 4: more entries than the 2 of the size"),
            ("LUT_1D_SIZE 2\n0 0 0\nTITLE\n", "line 3: 'TITLE' after the first entry"),
            ("0 0 0\n", "line 1: an entry before LUT_1D_SIZE"),
            ("LUT_3D_SIZE 1000\n", "line 1: LUT_3D_SIZE '1000': 2 to 129 was expected"),
            ("LUT_1D_SIZE 1\n", "2 to 65536"),
            ("LUT_2D_SIZE 4\n", "line 1: 'LUT_2D_SIZE': a key of a .cube file"),
            ("DOMAIN_MIN 0 0\n", "line 1: DOMAIN_MIN: 3 numbers"),
            ("LUT_1D_SIZE 2\nLUT_1D_INPUT_RANGE 1 1\n0 0 0\n1 1 1\n", "a range of 1 to 1"),
            ("LUT_1D_SIZE 3\n0 0 0\n", "its size needs 3 entries, and it has 1"),
            ("", "neither LUT_1D_SIZE nor LUT_3D_SIZE"),
        ] {
            let said = table(text).unwrap_err().to_string();
            assert!(said.contains(words), "{text}: {said}");
        }
        assert!(parse(&mut &[0xff, 0xfe, b'\n'][..]).unwrap_err().to_string().contains("line 1: a line of text"));
        assert!(table(&"1".repeat(MAX_LINE + 1)).unwrap_err().to_string().contains("line 1"));
    }
}
