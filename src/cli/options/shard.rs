//! Options for work that is split between machines.

use std::path::PathBuf;

use clap::Args;

use super::parse_kind;
use super::value::{Choices, one_of};
use codec::error::Result;
use codec::image::{FrameRange, StreamKind};
use footage::encode::{EncodeSettings, FrameSource, Part, Shard, ShardBy, ShardChoice};

const SHARD_BYS: &Choices<ShardBy> = &[
    ("auto", ShardBy::Segment, "By stream and time segment: the most even shards"),
    ("probe", ShardBy::Probe, "By probe"),
    ("stream", ShardBy::Stream, "By stream, with all frames"),
    ("time", ShardBy::Time, "By time, with all streams"),
];

/// Parses a shard such as `3/8`.
pub fn parse_shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(number, count)| Some((number.parse().ok()?, count.parse().ok()?)));
    match numbers {
        Some((number, count)) if (1..=count).contains(&number) => Ok(Shard { number, count }),
        _ => Err(format!("'{text}': a shard I/N with I from 1 to N was expected, such as 3/8")),
    }
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Shards")]
pub struct ShardArgs {
    /// Encode one shard, such as 3/8; pack joins all shards to the same bytes as a single encode
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// Division of the footage into shards
    #[arg(long, value_name = "WHAT", value_parser = one_of(SHARD_BYS), default_value = "auto", requires = "shard")]
    pub shard_by: ShardBy,
    /// Encode these probes in this shard, instead of an even share
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "shard", conflicts_with = "shard_by")]
    pub shard_probe: Vec<String>,
    /// Encode streams of these kinds in this shard: color, depth, material, alpha
    #[arg(long, value_name = "KINDS", value_delimiter = ',', value_parser = parse_kind, requires = "shard",
        conflicts_with = "shard_by")]
    pub shard_stream: Vec<StreamKind>,
    /// Encode these frames in this shard; they must begin and end where all its streams can be cut
    #[arg(long, value_name = "A-B", requires = "shard", conflicts_with = "shard_by")]
    pub shard_frames: Option<FrameRange>,
    /// Scan file with depth ranges and digests of all images; without it, each shard reads all images
    #[arg(long, value_name = "FILE")]
    pub scan: Option<PathBuf>,
}

impl ShardArgs {
    /// Returns the requested shard, without scans.
    pub fn part<'a>(&self, source: &'a dyn FrameSource, settings: &EncodeSettings) -> Result<Option<Part<'a>>> {
        let Some(shard) = self.shard else { return Ok(None) };
        let choice = ShardChoice {
            probes: self.shard_probe.clone(),
            kinds: self.shard_stream.clone(),
            frames: self.shard_frames,
        };
        match choice == ShardChoice::default() {
            true => Part::shard(source, settings, shard, self.shard_by),
            false => Part::chosen(source, settings, shard, &choice),
        }
        .map(Some)
    }
}
