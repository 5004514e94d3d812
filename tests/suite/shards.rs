//! Joined shards have the bytes of a single encode: every codec, in process.

use codec::color::Target;
use codec::container::Reader;
use codec::image::{FrameRange, StreamKind};
use codec::monitor::Silent;
use footage::encode::{self, Footage as Content, Part, ScanFile, Shard, ShardBy, ShardChoice};
use footage::pack::{PackSettings, pack};
use lightfold::Error;

use crate::resume_footage::{Footage, all, dataset};
use crate::samples::Random;

/// Encodes a shard.
fn encoded(footage: &Footage, part: Part<'_>) -> Vec<u8> {
    let (source, settings) = (footage.source(), &footage.settings);
    let part = part.with_footage(Content::read(&source, settings, &Silent).unwrap());
    let part = part.scan(settings, &Silent).unwrap();
    encode::encode(&part, settings, Vec::new(), &Silent).unwrap().0
}

/// Encodes all shards; `None` if the footage cannot be divided in this way.
fn shards(footage: &Footage, count: u32, by: ShardBy) -> Option<Vec<Vec<u8>>> {
    let (source, settings) = (footage.source(), &footage.settings);
    let mut shards = Vec::new();
    for number in 1..=count {
        let part = match Part::shard(&source, settings, Shard { number, count }, by) {
            Ok(part) => part,
            Err(Error::Usage(_)) if number == 1 => return None,
            Err(error) => panic!("{error}"),
        };
        shards.push(encoded(footage, part));
    }
    Some(shards)
}

fn open(files: &[Vec<u8>]) -> Vec<Reader> {
    files.iter().map(|file| Reader::from_memory(file.clone()).unwrap()).collect()
}

fn joined(files: &[Vec<u8>]) -> lightfold::Result<Vec<u8>> {
    pack(&open(files), &PackSettings::default(), Vec::new(), &Silent).map(|(file, _)| file)
}

fn refused(files: &[Vec<u8>]) -> String {
    joined(files).unwrap_err().to_string()
}

#[test]
fn shards_of_every_codec_join_in_any_order_to_one_encode() {
    let mut random = Random(3);
    let mut cut_in_time = Vec::new();
    for (name, footage) in all() {
        let whole = encode::encode(&footage.source(), &footage.settings, Vec::new(), &Silent).unwrap().0;
        for (count, by) in [(1, ShardBy::Segment), (2, ShardBy::Segment), (3, ShardBy::Time), (2, ShardBy::Probe)] {
            let Some(mut files) = shards(&footage, count, by) else { continue };
            if by == ShardBy::Time {
                cut_in_time.push(name);
            }
            for at in (1..files.len()).rev() {
                files.swap(at, random.below(at as u32 + 1) as usize);
            }
            // A shard that was encoded twice may be joined twice.
            files.push(files[0].clone());
            assert!(joined(&files).unwrap() == whole, "{name}: {count} shards by {by:?} join to other bytes");
        }
    }
    for codec in ["quadtree", "tree", "boxes", "boxes in blocks", "blocks", "predictive", "material", "dataset"] {
        assert!(cut_in_time.contains(&codec), "{codec} is not cut in time");
    }
}

#[test]
fn the_transform_codec_is_cut_in_time_every_fourth_chunk() {
    let (_, mut footage) = all().into_iter().find(|(name, _)| *name == "transform").unwrap();
    footage.settings.color_chunk = 2;
    let whole = encode::encode(&footage.source(), &footage.settings, Vec::new(), &Silent).unwrap().0;
    let files = shards(&footage, 3, ShardBy::Time).unwrap();
    let frames = open(&files).iter().map(|reader| reader.index().streams[0].first_frame).collect::<Vec<_>>();
    assert_eq!(frames, [0, 8, 16]);
    assert!(joined(&files).unwrap() == whole);
}

#[test]
fn shards_of_chosen_probes_kinds_and_frames_join_to_one_encode() {
    let footage = dataset();
    let (source, settings) = (footage.source(), &footage.settings);
    let whole = encode::encode(&source, settings, Vec::new(), &Silent).unwrap().0;
    let shard = |number, probes: &[&str], kinds: &[StreamKind], frames: Option<[u32; 2]>| {
        let choice = ShardChoice {
            probes: probes.iter().map(|&name| name.to_owned()).collect(),
            kinds: kinds.to_vec(),
            frames: frames.map(|[first, last]| FrameRange { first, last }),
        };
        Part::chosen(&source, settings, Shard { number, count: 4 }, &choice).map(|part| encoded(&footage, part))
    };
    let others = [StreamKind::Depth, StreamKind::Material];
    let files = [
        shard(1, &[], &[StreamKind::Color], None),
        shard(2, &["a"], &others, Some([10, 15])),
        shard(3, &["a"], &others, Some([16, 20])),
        shard(4, &["b"], &others, None),
    ]
    .map(Result::unwrap);
    assert!(joined(&[3, 1, 0, 2, 1].map(|at: usize| files[at].clone())).unwrap() == whole);
    let message = refused(&files[..3]);
    assert!(message.contains("shard 4 of 4 is missing: no shard has frame 13 of depth of probe b"), "{message}");
    // All four shard numbers are present, but not all frames.
    let less = shard(3, &["a"], &others, Some([19, 20])).unwrap();
    let message = refused(&[files[0].clone(), files[1].clone(), less, files[3].clone()]);
    assert!(message.contains("in one of them: no shard has frame 16 of depth of probe a"), "{message}");
    for more in [[10, 12], [13, 18]] {
        let message = refused(&[&files[..], &[shard(3, &["a"], &others, Some(more)).unwrap()]].concat());
        assert!(message.contains("shards must not overlap"), "{message}");
    }
    for (probes, kinds, frames, words) in [
        (
            &["a"][..],
            &others[..],
            Some([10, 16]),
            "`shard_frames` 10-16: depth of probe a can end at frame 15 or 18, not at 16",
        ),
        (&[], &others, Some([12, 20]), "depth of probe a can begin at frame 10 or 13, not at 12"),
        (&[], &[], Some([10, 15]), "color of probe a can end at frame 20, not at 15"),
        (&["c"], &[], None, "`shard_probe` c: the probes are a, b"),
        (&["b"], &[], Some([10, 12]), "no stream has the probes, kinds and frames"),
    ] {
        let message = shard(1, probes, kinds, frames).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn what_is_missing_or_does_not_belong_is_named() {
    let mut footage = dataset();
    let files = shards(&footage, 4, ShardBy::Segment).unwrap();
    let message = refused(&[files[0].clone(), files[3].clone()]);
    assert!(message.contains("shards 2, 3 of 4 are missing") && message.contains("frame "), "{message}");
    let message = refused(&files[1..]);
    assert!(message.contains("shard 1 of 4 is missing") && message.contains("probe a"), "{message}");
    let whole = joined(&files).unwrap();
    let message = refused(&[files[0].clone(), whole]);
    assert!(message.contains("a complete container among shards"), "{message}");
    let other_cut = shards(&footage, 4, ShardBy::Probe);
    assert!(other_cut.is_none(), "two probes cannot make four shards");
    let message = refused(&[&shards(&footage, 2, ShardBy::Time).unwrap()[..1], &files[..1]].concat());
    assert!(message.contains("different divisions") || message.contains("overlap"), "{message}");
    footage.settings.search.target = Target::Quality(70.0);
    let others = shards(&footage, 4, ShardBy::Segment).unwrap();
    let message = refused(&[&files[..3], &others[3..]].concat());
    assert!(message.contains("a shard of another encode"), "{message}");
}

#[test]
fn scans_of_shards_merge_to_the_scan_of_all_and_serve_encodes() {
    let footage = dataset();
    let (source, settings) = (footage.source(), &footage.settings);
    let whole = encode::encode(&source, settings, Vec::new(), &Silent).unwrap().0;
    let scan = |shard: Option<Shard>| {
        let mut scan = ScanFile::new(&source);
        scan.scan(&source, settings, shard, &Silent, &mut |_| Ok(())).unwrap();
        scan
    };
    // With more shards than images, some shards are empty.
    for count in [1, 3, 7, 40] {
        let mut parts = (1..=count).rev().map(|number| scan(Some(Shard { number, count })));
        let mut merged = parts.next().unwrap();
        parts.for_each(|part| merged.merge(part).unwrap());
        assert_eq!(merged, scan(None), "{count}");
    }
    let first = scan(Some(Shard { number: 1, count: 3 }));
    let message = first.scans(&source).unwrap_err().to_string();
    assert!(message.contains("the scan lacks frames 1"), "{message}");
    let (scans, content) = scan(None).scans(&source).unwrap();
    let part = Part::whole(&source, content).with_scans(scans);
    assert!(encode::encode(&part, settings, Vec::new(), &Silent).unwrap().0 == whole, "a scan changes the container");
}
