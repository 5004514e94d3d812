//! Memory budgets, the number of parallel jobs that fit into one, and limits of image files.
//!
//! A budget covers images, chunks and tables, which grow with the footage. The budget of a process also covers its code, its
//! stacks, and memory that allocators retain.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};

/// Overhead of a process in bytes, besides images, chunks and tables: code, fixed tables, and small blocks that the allocator
/// retains.
pub const PROCESS_BYTES: u64 = 30 << 20;
/// Further bytes for each thread of the pool: its stack, and memory that its allocator retains.
const THREAD_BYTES: u64 = 2 << 20;
/// Maximum number of threads that are counted; more are rarely busy at once.
const MAX_BUSY_THREADS: usize = 8;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Budget {
    /// Bytes available for the work; `None` if unlimited.
    pub bytes: Option<u64>,
    /// The original limit, if a part of it is reserved.
    limit: Option<u64>,
    /// Reserved bytes of the limit.
    taken: u64,
}

#[derive(Debug, Clone, Copy)]
pub struct Need<'a> {
    /// Name of the work in errors: `encoding the color of probe 00`.
    pub what: &'a str,
    /// Bytes that do not depend on the number of jobs.
    pub fixed: u64,
    pub each: u64,
    /// Advice other than allowing more memory, such as `` a smaller `lookahead` ``; may be empty.
    pub instead: &'a str,
}

impl Need<'_> {
    /// Bytes for `at_once` parallel jobs.
    pub fn bytes(&self, at_once: usize) -> u64 {
        self.fixed.saturating_add(self.each.saturating_mul(at_once as u64))
    }
}

impl Budget {
    /// No limit, except built-in ones.
    pub const UNLIMITED: Budget = Budget { bytes: None, limit: None, taken: 0 };

    pub fn of(bytes: u64) -> Budget {
        Budget { bytes: Some(bytes), limit: None, taken: 0 }
    }

    /// Reserves `taken` bytes of the budget. Errors still report the original limit.
    #[must_use]
    pub fn less(self, taken: u64) -> Budget {
        let bytes = self.bytes.map(|bytes| bytes.saturating_sub(taken));
        Budget { bytes, limit: self.limit.or(self.bytes), taken: self.taken.saturating_add(taken) }
    }

    /// Returns the budget for images, chunks and tables, where `self` is the budget of a process with `threads` threads.
    #[must_use]
    pub fn of_process(self, threads: usize) -> Budget {
        self.less(PROCESS_BYTES + THREAD_BYTES * threads.min(MAX_BUSY_THREADS) as u64)
    }

    /// Returns the minimum of the budget and `usual` bytes.
    pub fn at_most(self, usual: u64) -> u64 {
        self.bytes.map_or(usual, |bytes| bytes.min(usual))
    }

    /// Returns the number of parallel jobs that fit, 1 to `most`. Fails if one job does not fit.
    pub fn at_once(self, need: &Need<'_>, most: usize) -> Result<usize> {
        let Some(bytes) = self.bytes else { return Ok(most.max(1)) };
        let least = need.fixed.saturating_add(need.each);
        let whole = least.saturating_add(self.taken);
        if least > bytes {
            let instead = if need.instead.is_empty() { String::new() } else { format!(", or {}", need.instead) };
            return Err(Error::Usage(format!(
                "`memory` {self}: {} needs up to {} MB: increase it to that{instead}",
                need.what,
                whole.div_ceil(1_000_000)
            )));
        }
        let fit = (bytes - need.fixed) / need.each.max(1);
        Ok(usize::try_from(fit).unwrap_or(usize::MAX).clamp(1, most.max(1)))
    }
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.limit.or(self.bytes) {
            None => f.write_str("unlimited"),
            Some(bytes) if bytes >= 1_000_000 => write!(f, "{}M", bytes / 1_000_000),
            Some(bytes) => write!(f, "{bytes}"),
        }
    }
}

impl FromStr for Budget {
    type Err = Error;

    /// Parses a number of bytes with an optional unit: `k M G T`, optionally followed by `B`, are powers of 1000; `KiB MiB
    /// GiB TiB` are powers of 1024.
    fn from_str(text: &str) -> Result<Budget> {
        let wrong = || Error::Usage(format!("\"{text}\" is not a size such as 512M, 2G, 1.5GiB, or a number of bytes"));
        let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
        let number: f64 = text[..end].parse().map_err(|_| wrong())?;
        let unit = text[end..].trim().to_ascii_lowercase();
        let power = |letter: char| "kmgt".find(letter).map(|at| at as i32 + 1);
        let scale = match (unit.as_bytes(), unit.chars().next().and_then(power)) {
            ([] | b"b", _) => 1.0,
            ([_] | [_, b'b'], Some(power)) => 1000f64.powi(power),
            ([_, b'i', b'b'], Some(power)) => 1024f64.powi(power),
            _ => return Err(wrong()),
        };
        let bytes = number * scale;
        if bytes < 1.0 || bytes >= u64::MAX as f64 {
            return Err(wrong());
        }
        Ok(Budget::of(bytes as u64))
    }
}

/// Limits checked before memory is allocated for an image file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadLimits {
    /// Maximum bytes of decoded pixels of an image file, summed over all layers and channels.
    pub max_image_bytes: u64,
}

impl Default for ReadLimits {
    fn default() -> Self {
        ReadLimits { max_image_bytes: 4 << 30 }
    }
}

impl ReadLimits {
    /// Returns the peak memory in bytes of reading an image file of `file_len` bytes: its decoded pixels twice (as stored and as
    /// returned), or three times if integers are converted to floats, the display window, and the decoder's tables.
    pub fn memory_bound(&self, file_len: u64) -> u64 {
        self.believable(file_len, 64 << 20).saturating_mul(4).saturating_add(64 << 20)
    }

    /// Returns the maximum plausible bytes of pixels of a file of `file_len` bytes, within the limit. Files of any size are
    /// allowed `floor` bytes. Beyond that, no compression of real images exceeds 4096:1, so a header that claims more is damaged
    /// or hostile.
    pub fn believable(&self, file_len: u64, floor: u64) -> u64 {
        self.max_image_bytes.min(floor.max(file_len.saturating_mul(4096)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_and_without_units() {
        let bytes = |text: &str| text.parse::<Budget>().ok().and_then(|budget| budget.bytes);
        for (text, expected) in [
            ("1", 1),
            ("4096", 4096),
            ("7B", 7),
            ("512M", 512_000_000),
            ("512mb", 512_000_000),
            ("2 G", 2_000_000_000),
            ("1.5GiB", 3 << 29),
            ("3KiB", 3072),
            ("2k", 2000),
            ("0.5T", 500_000_000_000),
            ("1TiB", 1 << 40),
        ] {
            assert_eq!(bytes(text), Some(expected), "{text}");
        }
        for text in ["", "M", "-1", "1X", "1Gi", "1MBB", "1.2.3G", "0", "0.2", "inf", "nan", "99999999T", "1e9", "1é"]
        {
            assert_eq!(bytes(text), None, "{text}");
        }
    }

    #[test]
    fn as_many_jobs_run_as_fit() {
        let need = |fixed, each| Need { what: "the work", fixed, each, instead: "a smaller `depth_tile`" };
        let budget = Budget::of(100_000_000);
        assert_eq!(budget.at_once(&need(10_000_000, 30_000_000), 16).unwrap(), 3);
        assert_eq!(budget.at_once(&need(10_000_000, 30_000_000), 2).unwrap(), 2);
        assert_eq!(budget.at_once(&need(0, 0), 5).unwrap(), 5);
        assert_eq!(budget.at_once(&need(70_000_000, 30_000_000), 9).unwrap(), 1);
        let refused = budget.at_once(&need(70_000_000, 30_000_001), 9).unwrap_err().to_string();
        assert_eq!(
            refused,
            "`memory` 100M: the work needs up to 101 MB: increase it to that, or a smaller `depth_tile`"
        );
        assert!(budget.at_once(&need(u64::MAX, 9), 9).is_err());
        assert_eq!(Budget::UNLIMITED.at_once(&need(u64::MAX, 1), 7).unwrap(), 7);
        let less = budget.less(40_000_000);
        assert_eq!((less.bytes, less.to_string().as_str()), (Some(60_000_000), "100M"));
        assert_eq!(less.at_once(&need(10_000_000, 30_000_000), 16).unwrap(), 1);
        let refused = less.at_once(&need(40_000_000, 30_000_000), 9).unwrap_err().to_string();
        assert!(refused.starts_with("`memory` 100M: the work needs up to 110 MB"), "{refused}");
        let refused = Budget::of(1000).of_process(2).at_once(&need(0, 1), 9).unwrap_err().to_string();
        assert!(refused.starts_with("`memory` 1000: the work needs up to 36 MB"), "{refused}");
        assert_eq!([budget.at_most(5), budget.at_most(1 << 40), Budget::default().at_most(8)], [5, 100_000_000, 8]);
    }
}
