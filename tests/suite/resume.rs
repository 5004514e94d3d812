//! Resumed encodes give the bytes of uninterrupted ones: in process, stopped at every chunk and at random positions.

use std::collections::HashMap;
use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use codec::color::Target;
use codec::color::transform::Tables;
use codec::container::Compression;
use codec::container::journal::{self, Recovered};
use codec::image::{Plane, StreamKind};
use codec::monitor::{Monitor, Silent};
use footage::encode::{
    self, DepthCodec, EncodeSettings, EncodeSummary, ErrorBound, Kept, Plan, Resumable, Stopped, TileSize,
};
use footage::image_files::exr;
use lightfold::Error;

use crate::resume_footage::{Footage, all, color, dataset, depth, few_depths, transform};
use crate::samples::Random;

/// Byte buffer that outlives its writer.
#[derive(Clone, Default)]
pub struct Shared(Arc<Mutex<Vec<u8>>>);

impl Shared {
    fn new(bytes: &[u8]) -> Shared {
        Shared(Arc::new(Mutex::new(bytes.to_vec())))
    }

    fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap().clone()
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Files of a finished or interrupted encode.
#[derive(Clone, Default)]
struct State {
    container: Vec<u8>,
    journal: Vec<u8>,
}

impl State {
    fn recovered(&self) -> Option<Recovered> {
        journal::recover(&self.journal, &self.container[..]).unwrap()
    }

    fn chunks(&self) -> usize {
        self.recovered().map_or(0, |recovered| recovered.chunks.len())
    }

    /// Resumes from the valid part of the files, as the command line does.
    fn go_on(&self, footage: &Footage, monitor: &dyn Monitor) -> (State, Result<EncodeSummary, Stopped>) {
        let recovered = self.recovered();
        let of = |bytes: &[u8], sound: Option<u64>| Shared::new(&bytes[..sound.unwrap_or(0) as usize]);
        let container = of(&self.container, recovered.as_ref().map(|found| found.container_bytes));
        let journal = of(&self.journal, recovered.as_ref().map(|found| found.journal_bytes));
        let resumable = Resumable { out: container.clone(), journal: Some(Box::new(journal.clone())), recovered };
        let done = Plan::new(&footage.source(), &footage.settings).encode_resumable(resumable, monitor);
        let state = State { container: container.bytes(), journal: journal.bytes() };
        (state, done.map(|(_, summary)| summary))
    }

    /// Returns the offsets at which the records of the journal end; the first record is the head.
    fn record_ends(&self) -> Vec<usize> {
        let mut ends = vec![journal::MAGIC.len()];
        while let Some(length) = self.journal.get(ends[ends.len() - 1]..).and_then(|rest| rest.get(..4)) {
            ends.push(ends[ends.len() - 1] + 9 + u32::from_le_bytes(length.try_into().unwrap()) as usize);
        }
        ends.split_off(1)
    }
}

impl Footage {
    /// Encodes without interruption. Returns the files, and the summary without times.
    fn whole(&self) -> (State, EncodeSummary) {
        let (state, summary) = State::default().go_on(self, &Silent);
        let summary = summary.unwrap();
        let (plain, _) = encode::encode(&self.source(), &self.settings, Vec::new(), &Silent).unwrap();
        assert!(plain == state.container, "a journal changes the container");
        (state, timeless(summary))
    }
}

fn timeless(summary: EncodeSummary) -> EncodeSummary {
    let (reading, scanning, coding) = (Duration::ZERO, Duration::ZERO, Duration::ZERO);
    EncodeSummary { reading, scanning, coding, resumed_chunks: 0, ..summary }
}

/// Checks that the resumed encode has the container and the summary of an uninterrupted one.
#[track_caller]
fn comes_to(left: &State, footage: &Footage, whole: &(State, EncodeSummary), what: &str) {
    let (state, summary) = left.go_on(footage, &Silent);
    let summary = summary.unwrap_or_else(|stopped| panic!("{what}: {}", stopped.error));
    assert!(state.container == whole.0.container, "{what}: other bytes");
    assert_eq!(summary.resumed_chunks, left.chunks() as u64, "{what}");
    assert_eq!(timeless(summary), whole.1, "{what}");
    let chunks = |state: &State| state.recovered().unwrap().chunks;
    assert_eq!(chunks(&state), chunks(&whole.0), "{what}");
}

#[test]
fn every_codec_goes_on_at_every_chunk() {
    for (name, footage) in all() {
        let whole = footage.whole();
        let recovered = whole.0.recovered().unwrap();
        assert!(recovered.chunks.len() >= 4, "{name} has {} chunks", recovered.chunks.len());
        let units = recovered.chunks.iter().map(|chunk| (chunk.entry.key.stream, chunk.entry.key.unit));
        let mut counts: HashMap<_, usize> = HashMap::new();
        units.for_each(|unit| *counts.entry(unit).or_default() += 1);
        assert!(counts.values().any(|&chunks| chunks > 1), "{name}: no unit has two chunks");
        for end in whole.0.record_ends() {
            let left = State { container: whole.0.container.clone(), journal: whole.0.journal[..end].to_vec() };
            comes_to(&left, &footage, &whole, name);
        }
    }
}

#[test]
fn whatever_is_left_goes_on() {
    let mut random = Random(1);
    let (mut tried, mut counts) = (0, 0);
    for (name, footage) in
        [("quadtree", depth(DepthCodec::Quadtree)), ("color", color(false, None)), ("dataset", dataset())]
    {
        let whole = footage.whole();
        let chunks = whole.0.recovered().unwrap().chunks;
        let mut known = HashMap::new();
        for round in 0..3000 {
            let mut left = whole.0.clone();
            // Truncates either file or both at any byte, zeroes up to 4096 bytes of the container, or flips a bit.
            let mut at = |bytes: &[u8]| random.below(bytes.len() as u32 + 1) as usize;
            let (container, journal) = (at(&left.container), at(&left.journal));
            let mut first_lost = u64::MAX;
            match round % 5 {
                0 => left.container.truncate(container),
                1 => left.journal.truncate(journal),
                2 => {
                    left.container.truncate(container);
                    left.journal.truncate(journal);
                }
                3 => {
                    let end = left.container.len().min(container + 4096);
                    if let Some(lost) = left.container[container..end].iter().position(|&byte| byte != 0) {
                        first_lost = (container + lost) as u64;
                    }
                    left.container[container..end].fill(0);
                }
                _ => {
                    let (bytes, at) =
                        if round % 2 == 0 { (&mut left.journal, journal) } else { (&mut left.container, container) };
                    if let Some(byte) = bytes.get_mut(at) {
                        *byte ^= 1 << (round % 8);
                    }
                }
            }
            let recovered = left.recovered();
            let found = recovered.as_ref().map_or(&[][..], |found| &found.chunks);
            assert_eq!(found, &chunks[..found.len()], "{name}, round {round}");
            for chunk in found {
                let end = chunk.entry.offset + u64::from(chunk.entry.stored_bytes);
                assert!(end <= left.container.len() as u64 && end <= first_lost, "{name}, round {round}");
            }
            // The resumed encode depends only on the valid part of the journal, so one state of each length is resumed.
            let sound = recovered.as_ref().map_or(0, |found| found.journal_bytes);
            tried += 1;
            if known.insert(sound, found.len()).is_none() {
                comes_to(&left, &footage, &whole, &format!("{name}, round {round}"));
            }
        }
        counts += known.len();
    }
    println!("{tried} states of {counts} kinds");
    assert!(tried == 9000 && counts > 150, "{counts}");
}

/// Requests a stop after so many calls of `interrupted`.
struct StopsAfter(AtomicU32);

impl Monitor for StopsAfter {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_err()
    }
}

#[test]
fn an_encode_that_is_asked_to_stop_over_and_over_ends_in_the_same_bytes_on_any_threads() {
    let mut random = Random(3);
    for (name, footage) in [
        ("quadtree", depth(DepthCodec::Quadtree)),
        ("half", color(true, None)),
        ("transform", transform(false)),
        ("dataset", dataset()),
    ] {
        let whole = footage.whole();
        for _ in 0..6 {
            let mut state = State::default();
            let mut patience = 3 + random.below(12);
            let mut stops = 0;
            loop {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1 + random.below(4) as usize).build().unwrap();
                let monitor = StopsAfter(AtomicU32::new(patience));
                let before = state.chunks();
                let (left, done) = pool.install(|| state.go_on(&footage, &monitor));
                assert!(left.chunks() >= before, "{name}: chunks are lost");
                state = left;
                let Err(stopped) = done else { break };
                assert!(matches!(stopped.error, Error::Interrupted), "{}", stopped.error);
                let safe = matches!(stopped.kept, Kept::Chunks(_));
                assert_eq!(safe, state.chunks() > 0, "{name}: {:?}", stopped.kept);
                stops += 1;
                patience += random.below(60);
            }
            assert!(stops > 0 && state.container == whole.0.container, "{name}: {stops} stops");
        }
    }
}

/// Writes `room` bytes, then fails with an OS error, as a full or broken disk does.
struct Failing {
    out: Shared,
    room: usize,
    code: i32,
}

impl Write for Failing {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let taken = bytes.len().min(self.room);
        if taken == 0 && !bytes.is_empty() {
            return Err(std::io::Error::from_raw_os_error(self.code));
        }
        self.room -= taken;
        self.out.write(&bytes[..taken])
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn write_errors_leave_what_is_safe() {
    const ENOSPC: i32 = 28;
    const EIO: i32 = 5;
    let mut random = Random(17);
    for (name, footage) in [("boxes", depth(DepthCodec::Boxes)), ("color", color(false, None)), ("dataset", dataset())]
    {
        let whole = footage.whole();
        let mut kept = 0;
        for round in 0..40 {
            let (container, journal) = (Shared::default(), Shared::default());
            let code = if round % 2 == 0 { ENOSPC } else { EIO };
            let room = |bytes: &[u8], here: bool, random: &mut Random| {
                if here { random.below(bytes.len() as u32) as usize } else { usize::MAX }
            };
            let in_container = round % 4 < 3;
            let out =
                Failing { out: container.clone(), room: room(&whole.0.container, in_container, &mut random), code };
            let log = Failing { out: journal.clone(), room: room(&whole.0.journal, !in_container, &mut random), code };
            let resumable = Resumable { out: BufWriter::new(out), journal: Some(Box::new(log)), recovered: None };
            let stopped = Plan::new(&footage.source(), &footage.settings).encode_resumable(resumable, &Silent);
            // Dropping the buffered writer may or may not write the bytes that it holds.
            let Err(Stopped { error, kept: left }) = stopped.map(|_| ()) else { panic!("{name}: nothing failed") };
            let Error::Io { source, .. } = &error else { panic!("{name}: {error}") };
            assert_eq!(source.raw_os_error(), Some(code), "{error}");
            let state = State { container: container.bytes(), journal: journal.bytes() };
            let safe = match &left {
                Kept::Chunks(words) => words.split(' ').next().unwrap().parse().unwrap(),
                Kept::Nothing => 0,
                Kept::Unchanged => panic!("{name}: nothing was there"),
            };
            assert!(state.chunks() >= safe, "{name}: {left:?}, but {} chunks are there", state.chunks());
            kept += usize::from(safe > 0);
            comes_to(&state, &footage, &whole, name);
        }
        assert!(kept > 5, "{name}: {kept} of 40 kept anything");
    }
}

/// Returns the state with the journal cut after a fraction `share` (0 to 1) of its records.
fn stopped_after(whole: &State, share: f64) -> State {
    let ends = whole.record_ends();
    let end = ends[((ends.len() - 1) as f64 * share) as usize];
    State { container: whole.container.clone(), journal: whole.journal[..end].to_vec() }
}

#[track_caller]
fn refused(left: &State, footage: &Footage) -> String {
    let (after, done) = left.go_on(footage, &Silent);
    let Err(Stopped { error, kept: kind }) = done else { panic!("it went on") };
    assert_eq!(kind, Kept::Unchanged, "{error}");
    assert!(matches!(error, Error::Usage(_)), "{error}");
    assert_eq!(after.container.len() as u64, left.recovered().unwrap().container_bytes, "something was written");
    error.to_string()
}

#[test]
fn other_options_are_refused_by_name() {
    let mut footage = depth(DepthCodec::Quadtree);
    let left = stopped_after(&footage.whole().0, 0.6);
    type Change = fn(&mut EncodeSettings);
    let changes: [(&str, Change); 15] = [
        ("`depth_codec` was quadtree and is aabb now", |s| s.depth.codec = DepthCodec::Boxes),
        ("`max_error` was 40 codes and is 41 codes now", |s| s.depth.error = ErrorBound::Codes(41)),
        ("`depth_tile` was the default and is 1 per side now", |s| s.tiles = TileSize::PerSide(1)),
        ("the compression of chunks was Zstandard 9 and is LZMA2 6 now", |s| s.compression = Compression::Lzma2(6)),
        ("`near`", |s| s.near_m = Some(0.5)),
        ("`far`", |s| s.far_m = Some(1e6)),
        ("`depth_window`", |s| s.temporal.window = 4),
        ("`update_threshold`", |s| s.temporal.epsilon = 1),
        ("`keyframe_interval`", |s| s.temporal.keyframe_interval = 6),
        ("`min_children`", |s| s.depth.min_children = 1),
        ("`effort`", |s| s.depth.effort = codec::effort::Effort::Fast),
        ("`color_cell`", |s| s.cell = 32),
        ("`color_tables` was none and is given now", |s| s.color_tables = Some(Tables::default().sets()[1].clone())),
        ("`psnr`", |s| s.search.target = Target::Psnr(49.0)),
        ("`stream`", |s| s.kinds = vec![StreamKind::Depth]),
    ];
    let settings = footage.settings.clone();
    for (words, change) in changes {
        change(&mut footage.settings);
        let said = refused(&left, &footage);
        assert!(said.contains(words), "{said}");
        assert!(said.contains("`resume`"), "{said}");
        footage.settings = settings.clone();
    }
    fs::remove_file(footage.path(22)).unwrap();
    assert!(refused(&left, &footage).contains("the range of `frames` was"), "a frame is gone");
}

fn age(path: &Path) {
    let file = fs::File::options().write(true).open(path).unwrap();
    file.set_modified(std::time::SystemTime::now() - Duration::from_secs(1000)).unwrap();
}

/// Returns the last frame that a complete chunk depends on.
fn last_frame(left: &State) -> u32 {
    left.recovered().unwrap().chunks.iter().map(|chunk| chunk.last_frame).max().unwrap()
}

#[test]
fn a_frame_of_complete_chunks_may_not_change_and_a_later_one_may() {
    for (name, mut footage) in [("half", color(true, None)), ("boxes", depth(DepthCodec::Boxes))] {
        (footage.settings.near_m, footage.settings.far_m) = (Some(1.0), Some(70_000.0));
        let whole = footage.whole();
        let left = stopped_after(&whole.0, 0.6);
        let last = last_frame(&left);
        let count = footage.source().groups()[0].frames.count() as u32;
        assert!(0 < last && last + 1 < count, "{name}: {last} of {count}");
        for frame in [0, last] {
            let before = fs::File::open(footage.path(frame)).unwrap().metadata().unwrap().modified().unwrap();
            age(&footage.path(frame));
            let said = refused(&left, &footage);
            assert!(said.contains(footage.path(frame).to_str().unwrap()) && said.contains("has changed"), "{said}");
            let file = fs::File::options().write(true).open(footage.path(frame)).unwrap();
            file.set_modified(before).unwrap();
        }
        // A later frame is replaced. The resumed encode then equals an encode of the new files.
        fs::copy(footage.path(1), footage.path(last + 1)).unwrap();
        age(&footage.path(last + 1));
        let changed = footage.whole();
        assert!(changed.0.container != whole.0.container, "{name}: the change does not show");
        comes_to(&left, &footage, &changed, name);
    }
}

/// Changes a file at the first call of `interrupted`, which is before any frame is read.
struct Changes(Mutex<Option<PathBuf>>);

impl Monitor for Changes {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        // The lock makes other threads wait until the file is changed.
        let mut file = self.0.lock().unwrap();
        if let Some(path) = file.take() {
            age(&path);
        }
        false
    }
}

#[test]
fn a_frame_that_changes_while_it_is_gone_on_with_is_refused_as_one_that_had_changed() {
    for (name, mut footage) in [("half", color(true, None)), ("boxes", depth(DepthCodec::Boxes))] {
        (footage.settings.near_m, footage.settings.far_m) = (Some(1.0), Some(70_000.0));
        let whole = footage.whole();
        // In one of these states the last frame is read again, because units end at different frames or an encoder used its
        // lookahead.
        let left =
            [0.6, 0.55, 0.5, 0.45].map(|share| stopped_after(&whole.0, share)).into_iter().find(reads_last_again);
        let left = left.unwrap_or_else(|| panic!("{name}: no frame is read again"));
        let changes = Changes(Mutex::new(Some(footage.path(last_frame(&left)))));
        let (after, done) = left.go_on(&footage, &changes);
        let Err(Stopped { error, kept: kind }) = done else { panic!("{name}: it went on") };
        assert!(error.to_string().contains("has changed since"), "{name}: {error}");
        assert_eq!(kind, Kept::Unchanged, "{name}: {error}");
        // The resulting state is refused as well, because it still has the old modification time.
        assert!(after.chunks() >= left.chunks(), "{name}");
        assert!(refused(&after, &footage).contains("has changed since"), "{name}");
    }
}

/// True if the last frame that complete chunks depend on is at or after the first frame to encode.
fn reads_last_again(left: &State) -> bool {
    let mut ends: HashMap<_, u32> = HashMap::new();
    for chunk in left.recovered().unwrap().chunks {
        let key = chunk.entry.key;
        ends.insert((key.stream, key.unit), key.first_frame + key.frame_count);
    }
    ends.values().min().is_some_and(|&first| first <= last_frame(left))
}

#[test]
fn an_encode_of_other_sources_is_refused() {
    let footage = depth(DepthCodec::Boxes);
    let left = stopped_after(&footage.whole().0, 0.6);
    let head = left.recovered().unwrap().head;
    let name = b"the sources of lightfold";
    let at = head.windows(name.len()).position(|part| part == name).expect("the head names the sources") + name.len();
    let hash = head[at..].iter().position(|&byte| byte == b'#').unwrap() + at;
    // The first record is the head: length, CRC-32 of kind and body, kind, body.
    let with_head = |at: usize, byte: u8| {
        let (mut head, mut changed, start) = (head.clone(), left.clone(), journal::MAGIC.len() + 9);
        head[at] = byte;
        changed.journal[start..start + head.len()].copy_from_slice(&head);
        let crc32 = crc32fast::hash(&[&[0], &head[..]].concat());
        changed.journal[start - 5..start - 1].copy_from_slice(&crc32.to_le_bytes());
        changed
    };
    let said = refused(&with_head(hash + 1, if head[hash + 1] == b'0' { b'1' } else { b'0' }), &footage);
    assert!(said.contains("started by another version of lightfold"), "{said}");
    // A head that is not JSON, as in journals of earlier versions.
    let said = refused(&with_head(0, 0), &footage);
    assert!(said.contains("started by another version of lightfold"), "{said}");
}

#[test]
fn a_later_frame_that_moves_near_or_far_is_refused() {
    let footage = depth(DepthCodec::Boxes);
    let left = stopped_after(&footage.whole().0, 0.5);
    let frame = last_frame(&left) + 1;
    exr::write_depth(&footage.path(frame), &Plane::filled(40, 24, 1e9)).unwrap();
    let said = refused(&left, &footage);
    assert!(said.contains("the farthest surface"), "{said}");
    // If no complete chunk depends on them, near and far are determined again.
    let only_notes = State { container: left.container[..16].to_vec(), journal: left.journal.clone() };
    assert_eq!(only_notes.chunks(), 0);
    comes_to(&only_notes, &footage, &footage.whole(), "notes alone");
}

#[test]
fn a_later_frame_with_another_distance_is_refused_only_where_there_are_levels() {
    for (codec, is_refused) in [(DepthCodec::Predictive, true), (DepthCodec::Boxes, false)] {
        let footage = few_depths(codec);
        let left = stopped_after(&footage.whole().0, 0.5);
        exr::write_depth(&footage.path(last_frame(&left) + 1), &Plane::filled(40, 24, 2.5)).unwrap();
        if is_refused {
            let said = refused(&left, &footage);
            assert!(said.contains("the few distances of probe"), "{said}");
        } else {
            comes_to(&left, &footage, &footage.whole(), "boxes");
        }
    }
}

#[test]
fn frames_of_complete_groups_are_not_read_again() {
    let footage = dataset();
    let whole = footage.whole();
    let left = stopped_after(&whole.0, 0.9);
    let stamp = |path: &Path| fs::metadata(path).unwrap().modified().unwrap();
    // Invalid bytes with the same size and modification time would cause an error if they were read.
    let path = footage.folder.path().join("a/px/c.0010.exr");
    let (time, size) = (stamp(&path), fs::metadata(&path).unwrap().len());
    fs::write(&path, vec![0; size as usize]).unwrap();
    fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
    comes_to(&left, &footage, &whole, "dataset");
    let (_, done) = State::default().go_on(&footage, &Silent);
    assert!(done.is_err(), "the rubbish was not noticed");
}

#[test]
fn what_is_safe_is_told_in_words() {
    let footage = dataset();
    let whole = footage.whole();
    let recovered = whole.0.recovered().unwrap();
    let words = Plan::new(&footage.source(), &footage.settings).describe(recovered.safe()).unwrap();
    let count = recovered.chunks.len();
    assert_eq!(words, format!("{count} chunks, the last of frames 19-19 of probe b, material ny"));
}
