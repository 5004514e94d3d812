//! Selects the next keyframe of a cell, and the weights of the frames before it.
//!
//! Based on: CALF 5.1, equations 9 to 12: the next keyframe is as far away as the quality of every frame in between allows.
//! The condition of equation 12 is not monotone (a far keyframe can suffice where a nearer one does not), so the search
//! depends on the effort.

use std::cell::OnceCell;

use crate::color::blend::Sample;
use crate::color::quality::Quality;
use crate::effort::Effort;

#[derive(Debug)]
pub struct Candidates<'a, S, Q> {
    pictures: Vec<&'a [S]>,
    quality: &'a Q,
    max_squared_error: u64,
    /// Σ (pictureₓ − keyframe)² over keys, computed on demand.
    energy: Vec<OnceCell<i64>>,
}

impl<'a, S: Sample, Q: Quality<S>> Candidates<'a, S, Q> {
    pub fn new(pictures: Vec<&'a [S]>, quality: &'a Q, min_psnr_db: f64) -> Self {
        let samples = pictures.first().map_or(0, |picture| picture.len());
        let max_squared_error = quality.max_squared_error(min_psnr_db, samples);
        let energy = pictures.iter().map(|_| OnceCell::new()).collect();
        Candidates { pictures, quality, max_squared_error, energy }
    }

    pub fn keyframe_serves_all(&self) -> bool {
        let keyframe = self.pictures[0];
        self.pictures[1..].iter().all(|picture| {
            let limit = self.max_squared_error;
            self.quality.squared_error(keyframe, keyframe, 0, picture, limit) <= limit
        })
    }

    /// Returns the index of the next keyframe, at least 1: the farthest found for which every picture before it reaches the
    /// quality. There must be at least two pictures; the nearest always suffices.
    pub fn next_keyframe(&self, effort: Effort) -> usize {
        let last = self.pictures.len() - 1;
        // The picture that failed last is tested first, because it is likely to fail again.
        let mut suspect = 1;
        let mut serves = |next: usize| self.serves(next, &mut suspect);
        if effort == Effort::Exhaustive {
            return (2..=last).rev().find(|&next| serves(next)).unwrap_or(1);
        }
        let (mut good, mut bad, mut step) = (1, last + 1, 1);
        while good < last {
            let next = (good + step).min(last);
            if !serves(next) {
                bad = next;
                break;
            }
            good = next;
            step *= 2;
        }
        if effort == Effort::Fast {
            while bad - good > 1 {
                let middle = good.midpoint(bad);
                if serves(middle) {
                    good = middle;
                } else {
                    bad = middle;
                }
            }
            return good;
        }
        (good + 1..bad).rev().find(|&next| serves(next)).unwrap_or(good)
    }

    fn serves(&self, next: usize, suspect: &mut usize) -> bool {
        let first = *suspect;
        let order = (1..next).filter(|&at| at == first).chain((1..next).filter(|&at| at != first));
        for at in order {
            let limit = self.max_squared_error;
            let [low, high] = self.weights(at, next).unwrap_or([0, 0]);
            let ok = !self.certainly_fails(at, next)
                && (self.error(at, next, low) <= limit || (high != low && self.error(at, next, high) <= limit));
            if !ok {
                *suspect = at;
                return false;
            }
        }
        true
    }

    /// Returns the weight in 255ths of picture `at` between the keyframe and picture `next`, and the squared error: the
    /// better of the two bytes around the closed-form optimum.
    pub fn best_weight(&self, at: usize, next: usize) -> (u8, u64) {
        let Some([low, high]) = self.weights(at, next) else { return (0, self.error(at, next, 0)) };
        let (low_error, high_error) = (self.error(at, next, low), self.error(at, next, high));
        // If the early exit makes the two errors incomparable, both are above the limit, and the result is not used.
        if high_error < low_error { (high, high_error) } else { (low, low_error) }
    }

    /// Returns the weights of all pictures between the keyframe and the last, or the first picture for which no weight
    /// suffices.
    pub fn weights_of_all(&self) -> Result<Vec<u8>, usize> {
        let next = self.pictures.len() - 1;
        let weight = |at| {
            let (weight, error) = self.best_weight(at, next);
            if error <= self.max_squared_error { Ok(weight) } else { Err(at) }
        };
        (1..next).map(weight).collect()
    }

    fn error(&self, at: usize, next: usize, weight: u8) -> u64 {
        let [a, b, source] = [self.pictures[0], self.pictures[next], self.pictures[at]];
        self.quality.squared_error(a, b, weight, source, self.max_squared_error)
    }

    /// Returns the bytes below and above 255·⟨x − m, n − m⟩ / |n − m|²; `None` if n equals m.
    fn weights(&self, at: usize, next: usize) -> Option<[u8; 2]> {
        let energy = self.energy(next);
        if energy == 0 {
            return None;
        }
        let t = (self.product(at, next) as f64 / energy as f64).clamp(0.0, 1.0) * 255.0;
        Some([t.floor() as u8, t.ceil() as u8])
    }

    /// True if no weight can suffice. Only if keys are steps: even the best real weight leaves a distance that cannot be
    /// removed by rounding each sample by at most half a step.
    fn certainly_fails(&self, at: usize, next: usize) -> bool {
        if !Q::KEYS_ARE_STEPS {
            return false;
        }
        let (energy, own) = (self.energy(next) as f64, self.energy(at) as f64);
        let product = self.product(at, next) as f64;
        let removed = if energy > 0.0 { product.max(0.0).powi(2) / energy } else { 0.0 };
        let distance = (own - removed).max(0.0).sqrt();
        let rounding = 0.5 * (self.pictures[0].len() as f64).sqrt();
        // The tolerance covers rounding errors of these operations.
        (distance - rounding) * (1.0 - 1e-9) > (self.max_squared_error as f64).sqrt()
    }

    fn energy(&self, at: usize) -> i64 {
        *self.energy[at].get_or_init(|| dot(self.pictures[0], self.pictures[at], self.pictures[at]))
    }

    fn product(&self, at: usize, next: usize) -> i64 {
        dot(self.pictures[0], self.pictures[at], self.pictures[next])
    }
}

/// Σ (x − m)(n − m) over keys. Exact: a cell has at most 2^28 samples of at most 16 bits.
fn dot<S: Sample>(m: &[S], x: &[S], n: &[S]) -> i64 {
    if S::BYTES == 1 {
        // 2^14 products of two differences of at most 255 sum to less than 2^30 and fit into 32 bits, which is twice as fast.
        let blocks = m.chunks(1 << 14).zip(x.chunks(1 << 14)).zip(n.chunks(1 << 14));
        return blocks
            .map(|((m, x), n)| {
                let products = m.iter().zip(x).zip(n).map(|((m, x), n)| (x.key() - m.key()) * (n.key() - m.key()));
                i64::from(products.sum::<i32>())
            })
            .sum();
    }
    let products = m.iter().zip(x).zip(n);
    products.map(|((m, x), n)| i64::from(x.key() - m.key()) * i64::from(n.key() - m.key())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::quality::EightBit;

    fn ramp(n: usize) -> Vec<Vec<u8>> {
        (0..n).map(|t| (0..48).map(|i| (i + 2 * t) as u8).collect()).collect()
    }

    fn candidates<'a>(pictures: &'a [Vec<u8>], db: f64) -> Candidates<'a, u8, EightBit> {
        Candidates::new(pictures.iter().map(Vec::as_slice).collect(), &EightBit, db)
    }

    #[test]
    fn a_linear_change_needs_only_its_ends() {
        let pictures = ramp(40);
        for effort in [Effort::Fast, Effort::Normal, Effort::Exhaustive] {
            let search = candidates(&pictures, 50.0);
            assert_eq!(search.next_keyframe(effort), 39, "{effort:?}");
            assert!(search.best_weight(20, 39).1 <= search.max_squared_error);
        }
    }

    #[test]
    fn a_cut_ends_a_segment_and_nothing_between_is_worse_than_asked() {
        let mut pictures = ramp(20);
        for picture in &mut pictures[11..] {
            picture.reverse();
        }
        for effort in [Effort::Fast, Effort::Normal, Effort::Exhaustive] {
            let search = candidates(&pictures, 50.0);
            let next = search.next_keyframe(effort);
            assert!((10..=11).contains(&next), "{effort:?} {next}");
            assert!((1..next).all(|at| search.best_weight(at, next).1 <= search.max_squared_error));
        }
    }

    #[test]
    fn more_effort_never_reaches_less_far_and_the_quick_refusal_is_right() {
        let mut seed = 5u32;
        for _ in 0..300 {
            let mut pictures = vec![vec![128u8; 27]];
            for _ in 0..12 {
                let next = pictures[pictures.len() - 1].iter().map(|&value| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    value.wrapping_add(((seed >> 20) % 5) as u8).wrapping_sub(2)
                });
                let next = next.collect();
                pictures.push(next);
            }
            let search = candidates(&pictures, 42.0);
            for next in 2..pictures.len() {
                for at in 1..next {
                    let least = (0..=255).map(|w| {
                        search.quality.squared_error(&pictures[0], &pictures[next], w, &pictures[at], u64::MAX)
                    });
                    let least = least.min().unwrap();
                    assert!(!search.certainly_fails(at, next) || least > search.max_squared_error);
                }
            }
            let reach = [Effort::Fast, Effort::Normal, Effort::Exhaustive].map(|effort| search.next_keyframe(effort));
            assert!(reach[0] <= reach[2] && reach[1] <= reach[2] && reach[0] <= reach[1], "{reach:?}");
        }
    }

    #[test]
    fn equal_pictures_have_weight_zero() {
        let pictures = vec![vec![9u8; 12]; 3];
        let search = candidates(&pictures, 50.0);
        assert_eq!(search.best_weight(1, 2), (0, 0));
        assert!(search.keyframe_serves_all());
        assert_eq!(search.next_keyframe(Effort::Normal), 2);
    }
}
