//! Payloads that no encoder writes, for tests: an [`Author`] takes the place of a region's coder (color.md 6.4) and writes a
//! legal symbol, chosen by the caller or at random, for each symbol that the region reads.

use std::ops::Range;

use crate::color::transform::basis::LENGTHS;
use crate::color::transform::blocks::{Block, regions};
use crate::color::transform::coder::{Coder, SourceCoder};
use crate::color::transform::contexts::TableSet;
use crate::color::transform::contexts::{
    FAMILIES, LAST, LATER_PIXEL, LEVELS, NODE, PALETTE_COLOR, PALETTE_SIZE, PIXEL, PLANES,
};
use crate::color::transform::payload::Header;
use crate::color::transform::region::{PARTS, QUARTERS, Region, Setting, TRANSFORM};
use crate::color::transform::steps::DELTAS;
use crate::color::transform::{Keyed, Tables};
use crate::entropy::{Encoder, Family};
use crate::error::{Error, Result};

/// Probabilities of random symbols.
#[derive(Debug, Clone, Copy)]
pub struct Taste {
    /// Weights of the kinds of nodes, in the order of their symbols.
    pub nodes: [u32; 4],
    /// Range of values: limited so that nothing wraps, or any.
    pub values: Values,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Values {
    Usual,
    Any,
}

pub const USUAL: Taste = Taste { nodes: [6, 3, 2, 1], values: Values::Usual };
pub const ANY: Taste = Taste { nodes: [6, 3, 2, 1], values: Values::Any };
/// Blocks are split only if they must be.
pub const WHOLE: Taste = Taste { nodes: [100, 0, 0, 0], values: Values::Usual };
pub const PALETTES: Taste = Taste { nodes: [1, 3, 1, 12], values: Values::Usual };

/// Returns a random number below its argument.
pub type RandomBelow<'a> = &'a mut dyn FnMut(u32) -> u32;

/// Coder that writes the symbols that a region reads.
pub struct Author<'a, P> {
    pub stream: &'a mut Encoder,
    pub tables: &'a TableSet,
    pub pick: P,
    /// Family of the last symbol, and the symbol.
    last: (Family, usize),
    colors: usize,
    /// True if the chosen symbol was not legal, or no symbol was.
    strayed: bool,
}

/// A value that an author chooses.
#[derive(Debug)]
pub enum Question<'a> {
    /// A symbol of a context, one of these legal ones.
    Symbol(usize, &'a [usize]),
    /// Raw bits: a number below this.
    Bits(u32),
    /// The number of raw bits of a number, below this.
    Length(u32),
}

impl<'a, P: FnMut(Question<'_>) -> u32> Author<'a, P> {
    pub fn new(stream: &'a mut Encoder, tables: &'a TableSet, pick: P) -> Author<'a, P> {
        Author { stream, tables, pick, last: (NODE, 0), colors: 0, strayed: false }
    }
}

fn family_of(context: usize) -> Family {
    FAMILIES.into_iter().find(|family| contexts_of(*family).contains(&context)).unwrap_or(NODE)
}

pub fn contexts_of(family: Family) -> Range<usize> {
    family.first_context..family.first_context + family.contexts
}

/// True if the format allows a symbol, regardless of its frequency.
fn is_legal(context: usize, symbol: usize) -> bool {
    if !contexts_of(NODE).contains(&context) {
        return true;
    }
    let lengths = LENGTHS.len() + 1;
    let (size, length) = ((context - NODE.first_context) / lengths, (context - NODE.first_context) % lengths);
    match symbol {
        TRANSFORM => length < LENGTHS.len(),
        QUARTERS => size > 0,
        PARTS => length > 0,
        _ => true,
    }
}

impl<P: FnMut(Question<'_>) -> u32> Coder for Author<'_, P> {
    fn symbol(&mut self, context: usize, _: usize) -> usize {
        let family = family_of(context);
        let distribution = self.tables.distribution(context);
        let is_possible = |&symbol: &usize| distribution.frequency(symbol) > 0 && is_legal(context, symbol);
        let possible: Vec<usize> = (0..family.alphabet).filter(is_possible).collect();
        let symbol = (self.pick)(Question::Symbol(context, &possible)) as usize;
        if possible.contains(&symbol) {
            self.stream.symbol(distribution, symbol);
        } else {
            self.strayed = true;
        }
        self.last = (family, symbol);
        if contexts_of(PALETTE_SIZE).contains(&context) {
            self.colors = symbol + 1;
        }
        symbol
    }

    fn bits(&mut self, _: u32, count: u32) -> u32 {
        let is = |family: Family| family.first_context == self.last.0.first_context;
        let is_length = self.last.1 == 15 && (is(LEVELS) || is(PLANES));
        let value = match count {
            5 if is_length => {
                self.last.1 = 0;
                (self.pick)(Question::Length(32))
            }
            _ if is(PIXEL) || is(LATER_PIXEL) => (self.pick)(Question::Bits(self.colors as u32)),
            _ => (self.pick)(Question::Bits(1 << count)),
        };
        self.stream.bits(value, count);
        value
    }
}

impl<P: FnMut(Question<'_>) -> u32> SourceCoder for Author<'_, P> {
    fn is_short(&self) -> bool {
        self.strayed
    }

    fn is_finished(&self) -> bool {
        !self.strayed
    }
}

impl Taste {
    /// Chooses a value at random.
    fn answer(self, question: Question<'_>, random_below: RandomBelow<'_>) -> u32 {
        match question {
            Question::Symbol(context, possible) => self.symbol(context, possible, random_below) as u32,
            Question::Bits(below) => random_below(below),
            Question::Length(below) => random_below(if self.values == Values::Any { below } else { 2 }),
        }
    }

    fn symbol(self, context: usize, possible: &[usize], random_below: RandomBelow<'_>) -> usize {
        let Some(&last) = possible.last() else { return 0 };
        let is_in = |family: Family| contexts_of(family).contains(&context);
        let any = possible[random_below(possible.len() as u32) as usize];
        // Each symbol in turn is chosen with the same probability, given that those before it were not.
        let mut falling = |percent: u32| possible.iter().copied().find(|_| random_below(100) < percent).unwrap_or(last);
        if is_in(NODE) {
            let weighted: Vec<usize> =
                possible.iter().flat_map(|&kind| vec![kind; self.nodes[kind] as usize]).collect();
            return weighted.get(random_below(weighted.len().max(1) as u32) as usize).copied().unwrap_or(any);
        }
        match self.values {
            Values::Any => any,
            Values::Usual if is_in(LEVELS) => falling(70),
            Values::Usual if is_in(PLANES) => falling(35),
            Values::Usual if is_in(LAST) => falling(30),
            Values::Usual if is_in(PALETTE_COLOR) => {
                if falling(50) == possible[0] {
                    last
                } else {
                    any
                }
            }
            Values::Usual => any,
        }
    }
}

/// Maximum number of trees that are tried for a region; few have more leaves than their bytes allow.
const MAX_TRIES: usize = 1000;

/// Returns a legal payload with this header and random deltas and substreams.
pub fn random_payload<S: Keyed>(
    size: [usize; 2],
    frames: usize,
    header: &Header,
    tables: &Tables,
    (taste, random_below): (Taste, RandomBelow<'_>),
) -> Result<Vec<u8>> {
    let set = &tables.sets()[header.set];
    let (mut deltas, mut substreams) = (Vec::new(), Vec::new());
    for [_, _, width, height] in regions(size) {
        let delta = *DELTAS.start() + random_below(DELTAS.len() as u32) as i8;
        let setting = Setting { header, delta, domain: &S::DOMAIN };
        deltas.push(delta);
        substreams.push(random_substream(
            Block::root([width, height], frames),
            setting,
            set,
            (taste, &mut *random_below),
        )?);
    }
    Ok(header.write::<S>(&deltas, &substreams))
}

/// Returns a random substream of a region that decoders accept.
fn random_substream(
    root: Block,
    setting: Setting<'_>,
    set: &TableSet,
    (taste, random_below): (Taste, RandomBelow<'_>),
) -> Result<Vec<u8>> {
    for _ in 0..MAX_TRIES {
        let mut stream = Encoder::default();
        let author = Author::new(&mut stream, set, |question: Question<'_>| taste.answer(question, random_below));
        Region::read_by(author, u64::MAX, root, setting).map_err(Error::invalid)?;
        let bytes = stream.finish();
        if Region::read((&bytes, 0), root, setting, set).is_ok() {
            return Ok(bytes);
        }
    }
    Err(Error::invalid("no random tree of blocks is legal"))
}
