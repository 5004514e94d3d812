//! Payloads of the transform codec by hand (formats/color.md 6): a test chooses every symbol and raw bit.

use std::collections::BTreeSet;
use std::ops::Range;

use lightfold::color::transform::blocks::{Block, regions};
use lightfold::color::transform::coder::{Coder, SourceCoder};
use lightfold::color::transform::contexts::{
    ALPHABETS, FAMILIES, Family, LAST, LATER_PIXEL, LEVELS, NODE, PALETTE_COLOR, PALETTE_SIZE, PIXEL, PLANES,
};
use lightfold::color::transform::domain::ChromaSlopes;
use lightfold::color::transform::payload::Header;
use lightfold::color::transform::region::{Content, Region};
use lightfold::color::transform::steps::StepIndices;
use lightfold::color::transform::tables::TableSet;
use lightfold::color::transform::{Keyed, Tables};
use lightfold::container::fields::Fields;
use lightfold::container::serialize::PutFields;
use lightfold::entropy::Encoder;

use crate::samples::Random;

/// How symbols are chosen.
#[derive(Debug, Clone, Copy)]
pub struct Taste {
    /// Weights of the kinds of nodes, in the order of their symbols.
    pub nodes: [u32; 4],
    /// Values are such that nothing wraps, or any.
    pub values: Values,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Values {
    Usual,
    Any,
}

pub const USUAL: Taste = Taste { nodes: [6, 3, 2, 1], values: Values::Usual };
pub const ANY: Taste = Taste { nodes: [6, 3, 2, 1], values: Values::Any };
/// Blocks are not split where they need not be.
pub const WHOLE: Taste = Taste { nodes: [100, 0, 0, 0], values: Values::Usual };
pub const PALETTES: Taste = Taste { nodes: [1, 3, 1, 12], values: Values::Usual };

/// Writes what a region's reader asks for.
pub struct Author<'a, P> {
    pub stream: &'a mut Encoder,
    pub tables: &'a TableSet,
    pub pick: P,
    /// Family of the last symbol, and the symbol.
    last: (usize, usize),
    colors: usize,
}

/// What an author chooses among.
#[derive(Debug)]
pub enum Question<'a> {
    /// A symbol of a context: the legal ones.
    Symbol(usize, &'a [usize]),
    /// Raw bits: a number below this.
    Bits(u32),
    /// The number of raw bits of a number: below this.
    Length(u32),
}

impl<'a, P: FnMut(Question<'_>) -> u32> Author<'a, P> {
    pub fn new(stream: &'a mut Encoder, tables: &'a TableSet, pick: P) -> Author<'a, P> {
        Author { stream, tables, pick, last: (0, 0), colors: 0 }
    }
}

fn family_of(context: usize) -> usize {
    FAMILIES.iter().position(|family| contexts_of(*family).contains(&context)).expect("a context of a family")
}

pub fn contexts_of(family: Family) -> Range<usize> {
    family.first_context..family.first_context + family.contexts
}

/// Whether the format allows a symbol, whatever its frequency.
fn is_legal(context: usize, symbol: usize) -> bool {
    if !contexts_of(NODE).contains(&context) {
        return true;
    }
    let (size, length) = ((context - NODE.first_context) / 10, (context - NODE.first_context) % 10);
    [length < 9, size > 0, length > 0, true][symbol]
}

impl<P: FnMut(Question<'_>) -> u32> Coder for Author<'_, P> {
    fn symbol(&mut self, context: usize, _: usize) -> usize {
        let family = family_of(context);
        let distribution = self.tables.distribution(context);
        let is_possible = |&symbol: &usize| distribution.frequency(symbol) > 0 && is_legal(context, symbol);
        let possible: Vec<usize> = (0..FAMILIES[family].alphabet).filter(is_possible).collect();
        assert!(!possible.is_empty(), "context {context} has no legal symbol");
        let symbol = (self.pick)(Question::Symbol(context, &possible)) as usize;
        assert!(possible.contains(&symbol));
        self.stream.symbol(distribution, symbol);
        self.last = (family, symbol);
        if contexts_of(PALETTE_SIZE).contains(&context) {
            self.colors = symbol + 1;
        }
        symbol
    }

    fn bits(&mut self, _: u32, count: u32) -> u32 {
        let family = FAMILIES[self.last.0];
        let is = |other: Family| other.first_context == family.first_context;
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
        false
    }

    fn is_finished(&self) -> bool {
        true
    }
}

impl Taste {
    /// Answers a question by chance.
    pub fn answer(self, question: Question<'_>, random: &mut Random) -> u32 {
        match question {
            Question::Symbol(context, possible) => self.symbol(context, possible, random) as u32,
            Question::Bits(below) => random.below(below),
            Question::Length(below) => random.below(if self.values == Values::Any { below } else { 2 }),
        }
    }

    fn symbol(self, context: usize, possible: &[usize], random: &mut Random) -> usize {
        let is_in = |family: Family| contexts_of(family).contains(&context);
        let any = possible[random.below(possible.len() as u32) as usize];
        // The first symbol with one probability, the second with the same of what is left, and so on.
        let mut falling = |percent: u32| {
            possible.iter().copied().find(|_| random.below(100) < percent).unwrap_or(possible[possible.len() - 1])
        };
        if is_in(NODE) {
            let weighted: Vec<usize> =
                possible.iter().flat_map(|&kind| vec![kind; self.nodes[kind] as usize]).collect();
            return weighted.get(random.below(weighted.len().max(1) as u32) as usize).copied().unwrap_or(any);
        }
        match self.values {
            Values::Any => any,
            Values::Usual if is_in(LEVELS) => falling(70),
            Values::Usual if is_in(PLANES) => falling(35),
            Values::Usual if is_in(LAST) => falling(30),
            Values::Usual if is_in(PALETTE_COLOR) => {
                if falling(50) == possible[0] {
                    possible[possible.len() - 1]
                } else {
                    any
                }
            }
            Values::Usual => any,
        }
    }
}

/// A payload whose symbols are chosen by taste, with no more blocks than its bytes justify.
pub fn payload<S: Keyed>(
    size: [usize; 2],
    frames: usize,
    header: &Header,
    tables: &Tables,
    (taste, random): (Taste, &mut Random),
) -> Vec<u8> {
    let set = &tables.sets()[header.set];
    let mut substream = |[_, _, width, height]: [usize; 4]| loop {
        let mut stream = Encoder::default();
        let root = Block::root([width, height], frames);
        let author = Author::new(&mut stream, set, |question: Question<'_>| taste.answer(question, random));
        Region::read_by(author, u64::MAX, root, header, &S::DOMAIN).unwrap();
        let bytes = stream.finish();
        if Region::read((&bytes, 0), root, header, set, &S::DOMAIN).is_ok() {
            return bytes;
        }
    };
    let substreams: Vec<Vec<u8>> = regions(size).map(&mut substream).collect();
    header.write::<S>(&substreams)
}

/// A header with steps and slopes that are usual for samples of `bytes` bytes.
pub fn usual_header(bytes: usize) -> Header {
    let luma = if bytes == 1 { 84 } else { 180 };
    Header {
        set: 0,
        steps: StepIndices { luma, chroma: luma + 5 },
        slopes: ChromaSlopes { green: 3, orange: -7 },
        colors: Vec::new(),
    }
}

/// Own table sets by chance: every third symbol or so has no slot.
pub fn own_sets(count: u8, random: &mut Random) -> Tables {
    let mut bytes = vec![count];
    for _ in 0..count {
        for (cluster, alphabet) in ALPHABETS.into_iter().enumerate() {
            let certain = cluster >= NODE.clusters && random.below(9) == 0;
            let mut left = 4096;
            for _ in 1..alphabet {
                // Symbols of nodes keep a slot each, so that every block has a legal one.
                let spared = if cluster < NODE.clusters { 1 } else { 0 };
                let frequency = match random.below(3) {
                    _ if certain => 0,
                    0 => spared,
                    _ => (1 + random.below(left / 3)).max(spared),
                };
                bytes.put_varint(frequency.into());
                left -= frequency;
            }
        }
    }
    Tables::read(&mut Fields::new(&bytes, 0, "")).unwrap()
}

/// Tables with one set of a stream's own: the frequencies of the distributions of each family.
pub fn own_set(frequencies: impl Fn(Family) -> Vec<u16>) -> Tables {
    let mut bytes = vec![1];
    for family in FAMILIES {
        for _ in 0..family.clusters {
            frequencies(family)[..family.alphabet - 1].iter().for_each(|&count| bytes.put_varint(count.into()));
        }
    }
    Tables::read(&mut Fields::new(&bytes, 0, "")).unwrap()
}

/// What occurs in payloads.
#[derive(Debug, Default)]
pub struct Coverage {
    /// Size and length of transformed blocks.
    pub transforms: BTreeSet<(usize, usize)>,
    /// Size and colours of palettes.
    pub palettes: BTreeSet<(usize, usize)>,
    pub regions: usize,
}

impl Coverage {
    pub fn note(&mut self, regions: &[Region]) {
        for region in regions {
            self.regions += 1;
            for leaf in &region.leaves {
                let shape = leaf.block().shape;
                match leaf.content {
                    Content::Transform { .. } => self.transforms.insert((shape.level, shape.frames)),
                    Content::Palette(at) => {
                        self.palettes.insert((shape.level, region.palettes[at as usize].colors.len()))
                    }
                };
            }
        }
    }
}
