//! Selects the modelling function of a node (GDC 3.1; depth.md 7).

use crate::depth::bc4w::search;
use crate::depth::biquadratic::Biquadratic;
use crate::depth::biquadratic::fit::Order;
use crate::depth::block::{Accuracy, Block, BlockMut};
use crate::depth::domain::Domain;
use crate::depth::limit::{Limit, NodeFunction};
use crate::depth::nodes::{COEFFICIENT_BYTES, Function, Node, Place};
use crate::depth::platelet::Platelet;
use crate::depth::runtime::decode_node;
use crate::depth::storage::stored_bytes;
use crate::effort::Effort;

/// PSNR, in dB of 16-bit codes, above which no further function is tried by `Decide::Mse`: BC4w would hardly be closer (GDC 6.4).
pub const GOOD_PSNR_DB: f64 = 85.0;
/// Minimum bytes of a platelet: a head, two numbers and a line.
const MIN_PLATELET_BYTES: usize = 7;
const BC4W_BYTES: usize = 1 + COEFFICIENT_BYTES;

/// Criterion for choosing among the ways to code pixels within the error bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Decide {
    /// Lowest squared error.
    #[default]
    Mse,
    /// Fewest bytes.
    Size,
}

/// Rounding of the coefficients of planes and surfaces, which makes them take fewer bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rounding {
    /// No rounding, for trees from which streams are made at any smaller bound.
    Exact,
    /// Rounding that increases the squared error by at most a tenth and the error of rounding to codes, 1/12 per pixel.
    Slight,
    ToBound,
}

#[derive(Debug, Clone, Copy)]
pub struct Modelling<'a> {
    pub domain: &'a Domain,
    pub bound: u16,
    pub decide: Decide,
    pub rounding: Rounding,
    pub effort: Effort,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Approximation {
    pub node: Node,
    pub accuracy: Accuracy,
}

/// Returns the best function for the block at `place`, whose level is at least 1; `None` if no function is within the bound.
pub fn decide(block: &Block<'_>, place: Place, modelling: &Modelling<'_>) -> Option<Approximation> {
    let mut best = Best { place, modelling, found: None };
    match modelling.decide {
        Decide::Mse => {
            best.biquadratic(block, Order::Full);
            if !best.is_good(block) {
                best.platelet(block);
            }
            if !best.is_good(block) {
                best.bc4w(block);
            }
        }
        Decide::Size => {
            // Functions are tried in ascending number of coefficients; those that cannot be smaller than the best one are
            // skipped.
            for order in [Order::Constant, Order::Plane, Order::Full] {
                best.biquadratic(block, order);
            }
            if best.bytes() > MIN_PLATELET_BYTES {
                best.platelet(block);
            }
            if best.bytes() > BC4W_BYTES {
                best.bc4w(block);
            }
        }
    }
    best.found
}

/// Returns the PSNR, in dB of 16-bit codes, of a squared error summed over `pixels`; infinite for no error.
pub fn psnr_db(squared_error: u64, pixels: usize) -> f64 {
    let peak = f64::from(u16::MAX);
    10.0 * libm::log10(peak * peak * pixels as f64 / squared_error as f64)
}

struct Best<'a> {
    place: Place,
    modelling: &'a Modelling<'a>,
    found: Option<Approximation>,
}

impl Best<'_> {
    fn bytes(&self) -> usize {
        self.found.map_or(usize::MAX, |found| stored_bytes(&found.node))
    }

    fn is_good(&self, block: &Block<'_>) -> bool {
        self.found.is_some_and(|f| psnr_db(f.accuracy.squared_error, block.pixel_count()) > GOOD_PSNR_DB)
    }

    fn offer(&mut self, coefficients: [u8; COEFFICIENT_BYTES], accuracy: Accuracy) {
        let new = Approximation { node: Node { place: self.place, coefficients }, accuracy };
        let rank = |a: &Approximation| match self.modelling.decide {
            Decide::Mse => (a.accuracy.squared_error, 0),
            Decide::Size => (stored_bytes(&a.node) as u64, a.accuracy.squared_error),
        };
        if self.found.as_ref().is_none_or(|found| rank(&new) < rank(found)) {
            self.found = Some(new);
        }
    }

    fn biquadratic(&mut self, block: &Block<'_>, order: Order) {
        self.function(block, Biquadratic::fit(block, self.modelling.domain, self.modelling.bound, order));
    }

    fn platelet(&mut self, block: &Block<'_>) {
        self.function(block, Platelet::fit(block, self.modelling.domain, self.modelling.bound));
    }

    fn function(&mut self, block: &Block<'_>, found: Option<(impl NodeFunction, Accuracy)>) {
        if let Some((exact, accuracy)) = found {
            let (rounded, accuracy) = self.modelling.rounded(block, exact, accuracy);
            self.offer(rounded, accuracy);
        }
    }

    fn bc4w(&mut self, block: &Block<'_>) {
        if self.place.level == 1
            && let Some((blocks, accuracy)) = search::encode_within(block, self.modelling.bound, self.modelling.effort)
        {
            self.offer(*blocks.as_bytes(), accuracy);
        }
    }
}

impl Modelling<'_> {
    fn rounded(
        &self,
        block: &Block<'_>,
        exact: impl NodeFunction,
        accuracy: Accuracy,
    ) -> ([u8; COEFFICIENT_BYTES], Accuracy) {
        let squared_error = match self.rounding {
            Rounding::Exact => return (exact.to_bytes(), accuracy),
            Rounding::Slight => accuracy.squared_error + accuracy.squared_error / 10 + block.pixel_count() as u64 / 12,
            Rounding::ToBound => u64::MAX,
        };
        let (rounded, accuracy) = exact.trim(block, self.domain, Limit { max_error: self.bound, squared_error });
        (rounded.to_bytes(), accuracy)
    }
}

impl Approximation {
    /// Rounds this approximation of `block` as far as `modelling` allows; returns `None` if it exceeds the bound. The error is
    /// measured with the decoder, so the squared error in `self` need not be correct.
    pub fn rounded(&self, block: &Block<'_>, modelling: &Modelling<'_>) -> Option<Approximation> {
        if self.accuracy.max_error > modelling.bound {
            return None;
        }
        let exact = &self.node.coefficients;
        let mut decoded = vec![0; block.pixel_count()];
        let target = &mut BlockMut::of(&mut decoded, block.width, block.level, [0, 0]);
        decode_node(self.node.place, exact, modelling.domain, target);
        let accuracy = block.accuracy(&decoded).filter(|accuracy| accuracy.max_error <= modelling.bound)?;
        let (coefficients, accuracy) = match self.node.function() {
            Function::Biquadratic => modelling.rounded(block, Biquadratic::from_bytes(exact), accuracy),
            Function::Platelet => modelling.rounded(block, Platelet::from_bytes(exact), accuracy),
            Function::Raw | Function::Bc4w => (*exact, accuracy),
        };
        Some(Approximation { node: Node { coefficients, ..self.node }, accuracy })
    }
}
