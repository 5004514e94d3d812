//! Prediction of a pixel, and its reconstruction from a symbol (depth.md 15.4, 15.5). Arithmetic is on 32-bit integers; sums and
//! products wrap if a file was made so that they overflow.

use crate::depth::quantise::FAR_CODE;

/// Number of classes of pixels: residuals -2 to 2, then the classes below.
pub const CLASSES: usize = 9;
/// Class of a residual of 0, and of pixels of planes.
const AS_PREDICTED: u8 = 2;
const ESCAPED: u8 = 5;
const OTHER_SURFACE: u8 = 6;
const KEPT: u8 = 7;
const BACKGROUND: u8 = 8;

/// Symbols 0 to 4 are the residuals 0, 1, -1, 2 and -2; the others follow.
pub const SYMBOL_KEEP: usize = 5;
pub const SYMBOL_BACKGROUND: usize = 6;
pub const SYMBOL_CANDIDATE: usize = 7;
pub const SYMBOL_ABOVE: usize = 10;
pub const SYMBOL_BELOW: usize = 11;
pub const SYMBOLS: usize = 12;
/// Residuals of symbols 0 to 4.
pub const RESIDUALS: [i32; 5] = [0, 1, -1, 2, -2];

const MAX_CONFIDENCE: u8 = 2;
/// Part of a residual, in 256ths, that is added to the slopes, by confidence.
const GAINS: [i32; 3] = [256, 128, 85];
/// Weight of the left prediction, in 256ths, by the confidence of the pixels on the left and above.
const WEIGHTS: [[i32; 3]; 3] = [[128, 85, 64], [171, 128, 102], [192, 154, 128]];
/// Error bound from which every escape resets slopes and confidence.
const MIN_COARSE_BOUND: i32 = 50;
/// Magnitude of an escape, in steps, from which it resets slopes and confidence at any error bound.
const MIN_EDGE: i32 = 64;

/// Middle of the code range, in 256ths: the prediction if no neighbour is known.
pub const MIDDLE: i32 = 32_768 << 8;
const FAR: i32 = (FAR_CODE as i32) << 8;

/// Decoder state of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pixel {
    /// Code without the projection's correction, in 256ths.
    pub value: i32,
    /// Change per pixel to the right and down, in 256ths of a code.
    pub slope: [i32; 2],
    pub class: u8,
    /// Number of corrections of the slopes, at most 2.
    pub confidence: u8,
    /// Magnitude of the residual in steps, at most 255.
    pub magnitude: u8,
}

impl Pixel {
    pub const BACKGROUND: Pixel = Pixel { value: 0, slope: [0; 2], class: BACKGROUND, confidence: 0, magnitude: 0 };

    /// Returns a pixel of a plane.
    #[inline(always)]
    pub fn in_plane(value: i32, slope: [i32; 2]) -> Pixel {
        Pixel { value, slope, class: AS_PREDICTED, confidence: MAX_CONFIDENCE, magnitude: 0 }
    }

    #[inline(always)]
    pub fn is_background(&self) -> bool {
        self.class == BACKGROUND
    }

    #[inline(always)]
    pub fn is_as_predicted(&self) -> bool {
        self.class == AS_PREDICTED
    }

    /// Returns true if the pixel is as predicted, with maximum confidence in its slopes.
    pub fn is_settled(&self) -> bool {
        self.is_as_predicted() && self.confidence == MAX_CONFIDENCE
    }

    /// Returns the code of the pixel; 65535 for background.
    #[inline(always)]
    pub fn code(&self, correction: i32) -> u16 {
        if self.is_background() { u16::MAX } else { code_of(self.value, correction) }
    }
}

/// Returns the code of a value at a pixel with this correction.
#[inline(always)]
pub fn code_of(value: i32, correction: i32) -> u16 {
    (value.wrapping_add(correction).wrapping_add(128) >> 8).clamp(0, FAR_CODE.into()) as u16
}

/// Step and thresholds of an error bound, in 256ths of a code; `bound` itself is in codes.
#[derive(Debug, Clone, Copy)]
pub struct Steps {
    pub bound: i32,
    /// 2E + 1 codes.
    pub step: i32,
    /// Maximum difference of the predictions from the left and from above on one surface.
    same_surface: i32,
    /// Minimum distance of another surface from the prediction, exclusive.
    apart: i32,
}

impl Steps {
    pub fn new(bound: u16) -> Steps {
        let bound = i32::from(bound);
        let step = (2 * bound + 1) << 8;
        Steps { bound, step, same_surface: (3 * bound + 2) << 8, apart: step * 5 / 2 }
    }

    pub fn step_codes(&self) -> i32 {
        self.step >> 8
    }
}

/// Returns true if |difference| ≤ limit; `difference` may have wrapped.
#[inline(always)]
fn within(difference: i32, limit: i32) -> bool {
    difference.wrapping_add(limit) as u32 <= 2 * limit as u32
}

/// Neighbours from which a prediction comes. They determine the slopes that its residual corrects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Origin {
    Both,
    Left,
    Above,
}

#[derive(Debug, Clone, Copy)]
pub struct Prediction {
    pub value: i32,
    slope: [i32; 2],
    confidence: u8,
    origin: Origin,
}

/// Decoded neighbours of a pixel, and the pixel in the frame before.
#[derive(Debug, Clone, Copy)]
pub struct Around {
    pub left: Pixel,
    pub above: Pixel,
    pub above_left: Pixel,
    pub above_right: Pixel,
    pub before: Pixel,
    /// Correction that the projection adds at this pixel, in 256ths of a code.
    pub correction: i32,
}

impl Around {
    #[inline(always)]
    fn clamped(&self, value: i32) -> i32 {
        value.clamp(-self.correction, FAR - self.correction)
    }

    #[inline(always)]
    fn extended_left(&self) -> i32 {
        self.left.value.wrapping_add(self.left.slope[0])
    }

    #[inline(always)]
    fn extended_above(&self) -> i32 {
        self.above.value.wrapping_add(self.above.slope[1])
    }

    fn extended_above_left(&self) -> i32 {
        let Pixel { value, slope: [x, y], .. } = self.above_left;
        value.wrapping_add(x).wrapping_add(y)
    }

    fn extended_above_right(&self) -> i32 {
        let Pixel { value, slope: [x, y], .. } = self.above_right;
        value.wrapping_sub(x).wrapping_add(y)
    }

    #[inline(always)]
    pub fn predict(&self, steps: &Steps) -> Prediction {
        let (left, above) = (&self.left, &self.above);
        if left.is_background() || above.is_background() {
            return self.predict_beside_background();
        }
        let (from_left, from_above) = (self.extended_left(), self.extended_above());
        let difference = from_left.wrapping_sub(from_above);
        if within(difference, steps.same_surface) {
            let weight = WEIGHTS[usize::from(left.confidence)][usize::from(above.confidence)];
            let part = |difference: i32| (difference >> 4).wrapping_mul(weight) >> 4;
            let slope =
                [0, 1].map(|at| above.slope[at].wrapping_add(part(left.slope[at].wrapping_sub(above.slope[at]))));
            return Prediction {
                value: self.clamped(from_above.wrapping_add(part(difference))),
                slope,
                confidence: left.confidence.max(above.confidence),
                origin: Origin::Both,
            };
        }
        let corner = &self.above_left;
        let goes_on = |to: i32, slope: i32| {
            !corner.is_background() && within(corner.value.wrapping_add(slope).wrapping_sub(to), steps.same_surface)
        };
        // If the corner continues to the left pixel but not to the one above, the edge runs between the left pixel and this one.
        if goes_on(left.value, corner.slope[1]) && !goes_on(above.value, corner.slope[0]) {
            self.predict_from(above, from_above, Origin::Above)
        } else {
            self.predict_from(left, from_left, Origin::Left)
        }
    }

    fn predict_from(&self, pixel: &Pixel, value: i32, origin: Origin) -> Prediction {
        Prediction { value: self.clamped(value), slope: pixel.slope, confidence: pixel.confidence, origin }
    }

    fn predict_beside_background(&self) -> Prediction {
        if !self.left.is_background() {
            self.predict_from(&self.left, self.extended_left(), Origin::Left)
        } else if !self.above.is_background() {
            self.predict_from(&self.above, self.extended_above(), Origin::Above)
        } else if !self.above_right.is_background() {
            self.predict_from(&self.above_right, self.extended_above_right(), Origin::Both)
        } else if !self.above_left.is_background() {
            self.predict_from(&self.above_left, self.extended_above_left(), Origin::Both)
        } else if !self.before.is_background() {
            self.predict_from(&self.before, self.before.value, Origin::Both)
        } else {
            self.predict_from(&Pixel::BACKGROUND, MIDDLE - self.correction, Origin::Both)
        }
    }

    /// Returns candidates for another surface: extrapolated neighbours that differ from the prediction and from each other.
    pub fn candidates(&self, prediction: &Prediction, steps: &Steps) -> Candidates {
        let mut found = Candidates { pixels: [Pixel { value: prediction.value, ..self.left }; 3], count: 0 };
        let all = [
            (&self.left, self.extended_left()),
            (&self.above, self.extended_above()),
            (&self.above_right, self.extended_above_right()),
            (&self.above_left, self.extended_above_left()),
        ];
        for (pixel, value) in all {
            let value = self.clamped(value);
            let is_new = !pixel.is_background()
                && !within(value.wrapping_sub(prediction.value), steps.apart)
                && found.iter().all(|other| !within(value.wrapping_sub(other.value), steps.apart / 2));
            if is_new && found.count < found.pixels.len() {
                found.pixels[found.count] = Pixel { value, ..*pixel };
                found.count += 1;
            }
        }
        found
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Candidates {
    /// Entries from `count` on have the predicted value, with slopes and confidence of the left pixel.
    pub pixels: [Pixel; 3],
    count: usize,
}

impl Candidates {
    pub fn iter(&self) -> impl Iterator<Item = &Pixel> {
        self.pixels[..self.count].iter()
    }
}

impl Prediction {
    /// Returns the pixel with a residual of at most two steps.
    #[inline(always)]
    pub fn with_residual(&self, residual: i32, steps: &Steps) -> Pixel {
        Pixel {
            value: self.value.wrapping_add(residual.wrapping_mul(steps.step)),
            slope: self.corrected(residual, steps),
            class: (i32::from(AS_PREDICTED) + residual) as u8,
            confidence: (self.confidence + 1).min(MAX_CONFIDENCE),
            magnitude: residual.unsigned_abs() as u8,
        }
    }

    #[inline(always)]
    fn corrected(&self, residual: i32, steps: &Steps) -> [i32; 2] {
        let gain = GAINS[usize::from(self.confidence)].wrapping_mul(residual).wrapping_mul(steps.step_codes());
        let [x, y] = self.slope;
        match self.origin {
            Origin::Both => [x.wrapping_add(gain >> 1), y.wrapping_add(gain >> 1)],
            Origin::Left => [x.wrapping_add(gain), y],
            Origin::Above => [x, y.wrapping_add(gain)],
        }
    }

    /// Returns the pixel with a residual of three steps or more.
    pub fn escaped(&self, residual: i32, steps: &Steps) -> Pixel {
        let value = self.value.wrapping_add(residual.wrapping_mul(steps.step));
        let (class, magnitude) = (ESCAPED, residual.unsigned_abs().min(255) as u8);
        if steps.bound < MIN_COARSE_BOUND && residual.abs() < MIN_EDGE {
            Pixel { value, class, magnitude, ..self.with_residual(residual, steps) }
        } else {
            Pixel { value, slope: [0; 2], class, confidence: 0, magnitude }
        }
    }
}

impl Pixel {
    /// Returns a pixel on another surface: this candidate plus a residual in steps.
    pub fn on_surface(&self, residual: i32, steps: &Steps) -> Pixel {
        let value = self.value.wrapping_add(residual.wrapping_mul(steps.step));
        Pixel { value, class: OTHER_SURFACE, magnitude: residual.unsigned_abs().min(255) as u8, ..*self }
    }

    /// Returns the pixel as kept from the frame before; background stays background.
    #[inline(always)]
    pub fn kept(&self) -> Pixel {
        if self.is_background() { *self } else { Pixel { class: KEPT, ..*self } }
    }
}
