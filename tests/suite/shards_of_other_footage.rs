//! Shards can be joined only if all were encoded from footage with the same content, in whichever folder it is.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use codec::container::Reader;
use codec::image::{Face, Plane, StreamKind};
use codec::monitor::Silent;
use footage::dataset::source::{Source, SourceOptions};
use footage::encode::{self, EncodeSettings, Footage as Content, FrameSource, Part, ScanFile, Shard, ShardBy};
use footage::image_files::exr;
use footage::pack::{PackSettings, pack};
use half::f16;
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};
use crate::footage::{Footage, Random, drifting_color};

const FRAMES: u32 = 8;
const SIZE: [u32; 2] = [12, 8];

/// Writes a perspective probe of 12x8 pixels with eight frames of depth, colour and material; `seed` changes every pixel.
fn write(folder: &Path, seed: u32) {
    let depth = |_: Face, frame: u32| Plane::from_fn(SIZE[0], SIZE[1], |x, y| (seed + 1 + x + y * frame) as f32);
    let color = |_: Face, frame: u32| drifting_color(SIZE[0], SIZE[1], frame + seed);
    let material = |_: Face, frame: u32| {
        let reflection = ((frame + seed) % 5) as f32 / 8.0;
        Plane::filled(SIZE[0], SIZE[1], [reflection, 0.25, 1.5])
    };
    let footage = Footage {
        frames: [0, FRAMES - 1],
        depth: Some(&depth),
        color: Some(&color),
        material: Some(&material),
        ..Footage::new(SIZE[0], SIZE[1])
    };
    footage.write(folder);
}

fn settings() -> EncodeSettings {
    let mut settings = EncodeSettings::default();
    settings.temporal.keyframe_interval = 2;
    settings.color_chunk = 2;
    settings
}

fn open(folder: &Path) -> Source {
    Source::open(folder, &SourceOptions::default()).unwrap()
}

/// Encodes one shard of two, from the current footage or from a scan of it.
fn shard_of(source: &dyn FrameSource, number: u32, by: ShardBy, scan: Option<&ScanFile>) -> lightfold::Result<Vec<u8>> {
    let settings = settings();
    let part = Part::shard(source, &settings, Shard { number, count: 2 }, by)?;
    let part = match scan {
        Some(scan) => {
            let (scans, content) = scan.scans(source)?;
            part.with_footage(content).with_scans(scans)
        }
        None => part.with_footage(Content::read(source, &settings, &Silent)?).scan(&settings, &Silent)?,
    };
    Ok(encode::encode(&part, &settings, Vec::new(), &Silent)?.0)
}

fn scan(source: &Source) -> ScanFile {
    let mut scan = ScanFile::new(source);
    scan.scan(source, &settings(), None, &Silent, &mut |_| Ok(())).unwrap();
    scan
}

fn joined(files: &[Vec<u8>]) -> lightfold::Result<Vec<u8>> {
    let readers: Vec<Reader> = files.iter().map(|file| Reader::from_memory(file.clone()).unwrap()).collect();
    pack(&readers, &PackSettings::default(), Vec::new(), &Silent).map(|(file, _)| file)
}

fn file(folder: &Path, kind: &str, frame: u32) -> PathBuf {
    folder.join(format!("probe_00/face_view/{kind}.{frame:04}.exr"))
}

/// Rewrites an image with one pixel changed.
fn render_again(folder: &Path, kind: &str, frame: u32, random: &mut Random) {
    let path = file(folder, kind, frame);
    let [x, y] = SIZE.map(|side| random.below(side));
    let step = 1 + random.below(9);
    let source = open(folder);
    let group = source.groups().iter().find(|group| group.kind.name() == kind).unwrap().clone();
    let is_there = |at: (u32, u32)| at == (x, y);
    match kind {
        "depth" => {
            let plane = source.read_depth(&group, frame).unwrap().remove(0);
            let changed = Plane::from_fn(SIZE[0], SIZE[1], |x, y| {
                plane.get(x, y) + if is_there((x, y)) { step as f32 / 64.0 } else { 0.0 }
            });
            exr::write_depth(&path, &changed).unwrap();
        }
        "color" => {
            let plane = source.read_color(&group, frame).unwrap().remove(0);
            let changed = Plane::from_fn(SIZE[0], SIZE[1], |x, y| {
                let light = plane.get(x, y);
                if is_there((x, y)) { light.map(|value| f16::from_bits(value.to_bits() ^ step as u16)) } else { light }
            });
            exr::write_color(&path, &changed).unwrap();
        }
        _ => {
            let plane = source.read_material(&group, frame).unwrap().remove(0);
            let changed = Plane::from_fn(SIZE[0], SIZE[1], |x, y| {
                let [reflection, refraction, ior] = plane.get(x, y);
                [reflection, refraction, if is_there((x, y)) { 1.5 + step as f32 / 32.0 } else { ior }]
            });
            exr::write_material(&path, &changed, ["reflect", "refract", "ior"]).unwrap();
        }
    }
}

#[test]
fn footage_that_changed_between_shards_is_refused_a_hundred_times_of_a_hundred() {
    let mut random = Random(48);
    let (mut own, mut of_others) = (0, 0);
    let folder = TempDir::new().unwrap();
    for by in [ShardBy::Time, ShardBy::Stream, ShardBy::Segment] {
        write(folder.path(), 0);
        let whole = encode::encode(&open(folder.path()), &settings(), Vec::new(), &Silent).unwrap().0;
        let of = |number| shard_of(&open(folder.path()), number, by, None).unwrap();
        assert!(joined(&[of(2), of(1)]).unwrap() == whole, "{by:?}");
    }
    for trial in 0..100 {
        write(folder.path(), 0);
        let by = [ShardBy::Time, ShardBy::Stream, ShardBy::Segment][trial % 3];
        let first = 1 + random.below(2);
        let before = shard_of(&open(folder.path()), first, by, None).unwrap();
        let kind = ["depth", "color", "material"][random.below(3) as usize];
        let frame = random.below(FRAMES);
        let path = file(folder.path(), kind, frame);
        let time = fs::metadata(&path).unwrap().modified().unwrap();
        render_again(folder.path(), kind, frame, &mut random);
        // The change is not detectable by file size or time.
        fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        let after = shard_of(&open(folder.path()), 3 - first, by, None).unwrap();
        let has = |file: &[u8]| {
            let reader = Reader::from_memory(file.to_vec()).unwrap();
            let streams = &reader.index().streams;
            streams.iter().any(|stream| {
                stream.kind == StreamKind::from_name(kind).unwrap() as u8
                    && (stream.first_frame..stream.end_frame()).contains(&frame)
            })
        };
        if has(&after) {
            own += 1
        } else {
            of_others += 1
        }
        for files in [[before.clone(), after.clone()], [after, before]] {
            let message = joined(&files).expect_err("changed footage joins").to_string();
            assert!(message.contains("a shard of another encode"), "{message}");
            assert!(message.contains(&format!("other footage, whose {kind} of probe 00, face view has")), "{message}");
        }
    }
    assert!(own > 20 && of_others > 20, "{own} and {of_others}");
}

#[test]
fn a_changed_pose_or_another_data_set_is_refused() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), 0);
    let by = ShardBy::Stream;
    let first = shard_of(&open(folder.path()), 1, by, None).unwrap();
    let manifest = folder.path().join("lightfield.json");
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, text.replace("[0, 1, 2]", "[0, 1, 2.5]")).unwrap();
    let moved = shard_of(&open(folder.path()), 2, by, None).unwrap();
    let message = joined(&[first.clone(), moved]).unwrap_err().to_string();
    assert!(message.contains("a shard of another encode") && message.contains("other settings"), "{message}");
    // The same manifest, with all pixels changed.
    write(folder.path(), 7);
    let other = shard_of(&open(folder.path()), 2, by, None).unwrap();
    for files in [[first.clone(), other.clone()], [other, first]] {
        let message = joined(&files).unwrap_err().to_string();
        assert!(message.contains("2 further streams have different content"), "{message}");
    }
}

#[test]
fn frames_in_memory_have_a_digest_of_their_pixels() {
    let folders = [0, 0, 3].map(|seed| {
        let folder = TempDir::new().unwrap();
        write(folder.path(), seed);
        (open(folder.path()), folder)
    });
    let [same, copy, other] = folders.each_ref().map(|(source, _)| WithoutFiles(source));
    let of = |source: &dyn FrameSource, number| shard_of(source, number, ShardBy::Time, None).unwrap();
    let whole = encode::encode(&same, &settings(), Vec::new(), &Silent).unwrap().0;
    assert!(joined(&[of(&same, 1), of(&copy, 2)]).unwrap() == whole);
    assert!(joined(&[of(&same, 1), of(&other, 2)]).is_err());
}

/// A source whose frames are not files.
struct WithoutFiles<'a>(&'a Source);

impl FrameSource for WithoutFiles<'_> {
    fn name(&self) -> &str {
        self.0.name()
    }
    fn fps(&self) -> f64 {
        self.0.fps()
    }
    fn projection(&self) -> lightfold::Projection {
        self.0.projection()
    }
    fn probes(&self) -> &[lightfold::ProbeInfo] {
        self.0.probes()
    }
    fn groups(&self) -> &[lightfold::SourceGroup] {
        self.0.groups()
    }
    fn read_depth(&self, group: &lightfold::SourceGroup, frame: u32) -> lightfold::Result<Vec<Plane<f32>>> {
        self.0.read_depth(group, frame)
    }
    fn read_color(&self, group: &lightfold::SourceGroup, frame: u32) -> lightfold::Result<Vec<Plane<[f16; 3]>>> {
        self.0.read_color(group, frame)
    }
    fn read_material(&self, group: &lightfold::SourceGroup, frame: u32) -> lightfold::Result<Vec<Plane<[f32; 3]>>> {
        self.0.read_material(group, frame)
    }
    fn read_alpha(&self, group: &lightfold::SourceGroup, frame: u32) -> lightfold::Result<Vec<Plane<f32>>> {
        self.0.read_alpha(group, frame)
    }
}

#[test]
fn a_shard_refuses_files_that_changed_since_the_scan() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), 0);
    let source = open(folder.path());
    let (old, mut random) = (scan(&source), Random(3));
    let by = ShardBy::Time;
    let shards = |scan| [1, 2].map(|number| shard_of(&source, number, by, Some(scan)));
    let before = shards(&old).map(Result::unwrap);
    render_again(folder.path(), "color", 7, &mut random);
    // Only one of the shards reads the changed file.
    let after = shards(&old);
    let reader = after.iter().position(Result::is_err).expect("a shard that reads the file");
    let (first, number) = (before[1 - reader].clone(), reader as u32 + 1);
    assert!(after[1 - reader].as_ref().is_ok_and(|shard| *shard == first));
    let message = after[reader].as_ref().unwrap_err().to_string();
    assert!(message.contains("color.0007.exr") && message.contains("changed since the scan"), "{message}");
    let second = shard_of(&source, number, by, Some(&scan(&source))).unwrap();
    let message = joined(&[second.clone(), first]).unwrap_err().to_string();
    assert!(message.contains("whose color of probe 00"), "{message}");
    // The digests of a scan equal those of reading the files.
    assert!(joined(&[second, shard_of(&source, 2 - reader as u32, by, None).unwrap()]).is_ok());
}

#[test]
fn copies_of_footage_join_and_changed_footage_names_both_files() {
    let folder = TempDir::new().unwrap();
    let [here, there] = ["here", "elsewhere/copy"].map(|name| folder.path().join(name));
    for place in [&here, &there] {
        fs::create_dir_all(place).unwrap();
        write(place, 0);
    }
    let old = SystemTime::now() - Duration::from_secs(86_400);
    for kind in ["depth", "color", "material"] {
        for frame in 0..FRAMES {
            fs::File::options().write(true).open(file(&there, kind, frame)).unwrap().set_modified(old).unwrap();
        }
    }
    let options = "--clip --keyframe-interval 2 --shard-by stream";
    fine("encode here --clip --keyframe-interval 2 -o one.lfold", folder.path());
    fine(&format!("encode here {options} --shard 1/2 -o 1.lfold"), folder.path());
    fine("scan elsewhere/copy -o scan.json", folder.path());
    fine(&format!("encode elsewhere/copy {options} --shard 2/2 --scan scan.json -o 2.lfold"), folder.path());
    fine("pack 2.lfold 1.lfold -o joined.lfold", folder.path());
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("joined.lfold") == read("one.lfold"), "other bytes");
    assert!(
        Reader::open(folder.path().join("joined.lfold")).unwrap().index().attributes.get("shard.footage").is_none()
    );
    // Depth and colour are from different datasets.
    write(&there, 5);
    fs::remove_file(folder.path().join("scan.json")).unwrap();
    fine(&format!("encode elsewhere/copy {options} --shard 2/2 -o 2.lfold"), folder.path());
    for names in ["1.lfold 2.lfold", "2.lfold 1.lfold"] {
        let message = refused(&format!("pack {names} -o no.lfold"), folder.path());
        assert!(message.contains("1.lfold") && message.contains("2.lfold"), "{message}");
        assert!(!folder.path().join("no.lfold").exists());
    }
    // A complete shard is encoded again if files of other shards have changed.
    let again = format!("encode here {options} --shard 1/2 --resume -o 1.lfold");
    let words = |line: &str| String::from_utf8(fine(line, folder.path()).stderr).unwrap();
    assert!(words(&again).contains("this shard is complete"));
    render_again(&here, "material", 7, &mut Random(1));
    assert!(!words(&again).contains("this shard is complete"));
}

#[test]
fn a_shard_that_changed_footage_stopped_is_resumed_after_another_scan() {
    let folder = TempDir::new().unwrap();
    let (at, mut random) = (folder.path(), Random(8));
    let options = "--clip --keyframe-interval 2 --color-chunk 2 --shard-by time --scan scan.json";
    let shard = |number: usize, more: &str| format!("encode . {options} --shard {number}/2 {more}");
    let scan = || {
        let _ = fs::remove_file(at.join("scan.json"));
        fine("scan . -o scan.json", at);
    };
    // There are many frames so that chunks are complete before the last frame is read.
    let last = 199;
    let color = |_: Face, frame: u32| drifting_color(SIZE[0], SIZE[1], frame);
    Footage { frames: [0, last], depth: None, color: Some(&color), ..Footage::new(SIZE[0], SIZE[1]) }.write(at);
    scan();
    render_again(at, "color", last, &mut random);
    let stopped = [1, 2].map(|number| lightfold(&shard(number, "-o a.lfold").split(' ').collect::<Vec<_>>(), at));
    let number = 1 + stopped.iter().position(|out| !out.status.success()).expect("a shard that reads the file");
    assert_eq!(stopped[number - 1].status.code(), Some(2));
    let said = String::from_utf8(stopped[number - 1].stderr.clone()).unwrap();
    assert!(said.contains("color.0199.exr") && said.contains("scan again"), "{said}");
    assert!(!said.contains("the same command"), "{said}");
    let resumed = |words: &str| {
        let said = String::from_utf8(fine(&shard(number, "--resume -o a.lfold"), at).stderr).unwrap();
        assert!(said.contains(words), "{said}");
        fine(&shard(number, "-o b.lfold"), at);
        assert!(fs::read(at.join("a.lfold")).unwrap() == fs::read(at.join("b.lfold")).unwrap(), "other bytes");
    };
    assert!(said.contains("safe in") && said.contains("after a new scan, --resume starts this shard again"), "{said}");
    scan();
    resumed("input files have changed since the unfinished encode; starting over");
    // Other options prevent resuming, as for any encode.
    fs::remove_file(at.join("a.lfold")).unwrap();
    let before = fs::read(file(at, "color", last)).unwrap();
    render_again(at, "color", last, &mut random);
    refused(&shard(number, "-o a.lfold"), at);
    let said = refused(&shard(number, "--resume --psnr 30 -o a.lfold"), at);
    assert!(said.contains("cannot resume") && said.contains("psnr"), "{said}");
    // With the file as it was scanned, the shard is resumed.
    fs::write(file(at, "color", last), before).unwrap();
    resumed("resuming after");
}
