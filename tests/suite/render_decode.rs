//! Units that are decoded for rendering: all that pictures need, and few others (CALF 6.2).

use std::fs;
use std::path::Path;

use codec::decode::{AllUnits, Decoder, StreamInfo, UnitFilter};
use codec::image::{Plane, StreamKind};
use codec::math::{Camera, Lens};
use codec::memory::Budget;
use codec::monitor::Silent;
use evaluate::dataset_views::from_dataset;
use footage::dataset::{Source, SourceOptions};
use footage::image_files::exr;
use glam::DVec3;
use half::f16;
use lightfold::{Error, Result};
use render::frame_requests::FrameRequest;
use render::march::playback::frames::{CpuRenderer, DecodeScope, PictureOptions, Playback, PlaybackOptions, Shown};
use render::march::playback::selection::SelectionSettings;
use render::march::pyramid::{Pyramids, ViewPyramids};
use render::march::settings::{Acceleration, SpecularMode};
use render::views::backend::{FaceUpdate, NewFace, TexelBackend};
use render::views::catalogue::ProbeChoice;
use render::views::face_cache::{CachedUnit, FaceChanges};
use render::views::light_field::{ColorTexels, FaceTexels, LightField, UNKNOWN, View};
use render::views::player::{Change, Player, UnitRequest};
use render::views::visible_set::VisibleSets;
use tempfile::TempDir;

use crate::commands::fine;

/// Adds alpha files to a captured dataset: a transparent disc that moves in the left 20 columns; the others are opaque.
fn add_alpha(dataset: &Path) {
    let source = Source::open(dataset, &SourceOptions::default()).unwrap();
    let path = dataset.join("lightfield.json");
    let mut manifest: serde_json::Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    let files = manifest["files"]["color"].as_str().unwrap().replace("color.", "alpha.");
    manifest["files"]["alpha"] = files.into();
    fs::write(path, manifest.to_string()).unwrap();
    let of_color = source.groups().iter().filter(|group| group.kind == StreamKind::Color);
    for (group, frame) in of_color.flat_map(|group| (0..6).map(move |frame| (group, frame))) {
        let alpha = Plane::from_fn(32, 32, |x, y| {
            let square = (x as f32 - 10.0).powi(2) + (y as f32 - 6.0 - 3.0 * frame as f32).powi(2);
            f16::from_f32(if x < 20 { (square / 100.0).min(1.0) } else { 1.0 })
        });
        for face in &group.faces {
            let name = &source.probes()[group.probe].name;
            let place = format!("probe_{name}/face_{}/alpha.{frame:04}.exr", face.name());
            exr::write_alpha(&dataset.join(place), &alpha).unwrap();
        }
    }
}

/// Captures the courtyard, in which objects move, from three probes, and encodes it.
fn courtyard(folder: &Path, options: &str) -> Decoder {
    courtyard_of(folder, options, |_| {})
}

/// As [`courtyard`], with a change of the dataset before it is encoded.
fn courtyard_of(folder: &Path, options: &str, change: impl Fn(&Path)) -> Decoder {
    let cameras = r#"{ "lightfold_cameras": 1, "cameras": [ { "position": [0, 1.5, 0] }, { "position": [0.4, 1.4, 0.2] },
        { "position": [-0.3, 1.7, -0.5], "orientation": [0, 0.2588190451025207, 0, 0.9659258262890683] } ] }"#;
    fs::write(folder.join("cameras.json"), cameras).unwrap();
    fine("capture courtyard --cameras cameras.json --frames 0-5 --size 32 --samples 1 -q -o cap", folder);
    change(&folder.join("cap"));
    fine(format!("encode cap --clip --color-cell 8 --depth-tile 16 -o a.lfold {options}").trim_end(), folder);
    Decoder::open(folder.join("a.lfold")).unwrap()
}

fn camera(eye: [f64; 3], look_at: [f64; 3], fov_y_deg: f64) -> Camera {
    Camera::look_at(eye.into(), look_at.into(), DVec3::Y, Lens::new(fov_y_deg)).unwrap()
}

fn request(frame: u32, camera: Camera) -> FrameRequest {
    FrameRequest { frame, cameras: vec![camera] }
}

/// Returns a renderer of 4x4 pixels, for tests that do not compare pictures.
fn little(specular: SpecularMode) -> CpuRenderer {
    CpuRenderer::new(PictureOptions { size: [4, 4], steps: 8, specular, ..PictureOptions::default() })
}

/// Filter that wants about 4 of 7 units, by a hash of stream, unit and frame.
struct Some4Of7;

impl UnitFilter for Some4Of7 {
    fn wants(&self, stream: &StreamInfo, unit: u32, frame: u32) -> bool {
        let hash = (stream.index * 31 + unit * 17 + frame * 5 + 1).wrapping_mul(2_654_435_761);
        (hash >> 16) % 7 < 4
    }
}

fn faces(field: &LightField) -> impl Iterator<Item = &FaceTexels> {
    field.views.iter().flat_map(|view| view.faces.iter().flatten())
}

/// Checks that known texels equal those of a complete decode. Returns the number of known texels and of all texels.
fn compare(field: &LightField, all: &LightField) -> [usize; 2] {
    let mut known = [0, 0];
    for (some, all) in faces(field).zip(faces(all)) {
        for at in 0..all.inverse_depth.len() {
            known[1] += 1;
            if some.inverse_depth[at] != UNKNOWN {
                known[0] += 1;
                assert_eq!(some.inverse_depth[at], all.inverse_depth[at]);
                assert_eq!((some.color.get(at), some.alpha(at)), (all.color.get(at), all.alpha(at)));
                assert_eq!(some.material.as_ref().map(|m| m[at]), all.material.as_ref().map(|m| m[at]));
            }
        }
    }
    assert_eq!(faces(field).count(), faces(all).count());
    known
}

/// Copies the texels that changed, as a device would.
fn copy(changes: &[Change], from: &LightField, to: &mut LightField) {
    for change in changes {
        let source = from.views[change.view].faces[change.face].as_ref().unwrap();
        let target = to.views[change.view].faces[change.face].get_or_insert_with(|| {
            let texels = FaceTexels::unknown(source.size, source.map, from.coding);
            let texels = FaceTexels { has_alpha: source.has_alpha, ..texels };
            if source.material.is_some() { texels.with_material() } else { texels }
        });
        let [left, top, width, height] = change.rect;
        for at in (top..top + height).flat_map(|y| (left..left + width).map(move |x| (y * source.size[0] + x) as usize))
        {
            match change.kind {
                StreamKind::Depth => target.inverse_depth[at] = source.inverse_depth[at],
                StreamKind::Color => match (&mut target.color, &source.color) {
                    (ColorTexels::Codes(target), ColorTexels::Codes(source)) => target[at] = source[at],
                    (ColorTexels::Light(target), ColorTexels::Light(source)) => target[at] = source[at],
                    _ => panic!("colours are coded alike"),
                },
                StreamKind::Alpha => panic!("alpha is a part of colour"),
                StreamKind::Material => {
                    target.material.as_mut().unwrap()[at] = source.material.as_ref().unwrap()[at];
                }
            }
        }
    }
}

#[test]
fn texels_that_are_known_are_those_of_decoding_everything_and_changes_tell_all() {
    for (options, has_alpha) in [
        ("--keyframe-interval 3", false),
        ("--hdr --max-error 0", false),
        ("--depth-codec aabb --keyframe-interval 4", false),
        ("--keyframe-interval 3", true),
        ("--hdr --keyframe-interval 4", true),
    ] {
        let folder = TempDir::new().unwrap();
        let decoder = courtyard_of(folder.path(), options, |dataset| {
            if has_alpha {
                add_alpha(dataset);
            }
        });
        let views = [0, 1, 2];
        let mut player = Player::new(&decoder, &ProbeChoice::default()).unwrap();
        let (mut mirror, mut pyramids) = (player.field.clone(), Pyramids::default());
        let (mut visible_sets, mut ever_known) = (VisibleSets::new(&decoder), 0);
        let looks = [[2.0, 1.5, 0.0], [2.0, 1.0, 1.0], [-3.0, 1.5, 1.0]];
        for (at, frame) in [0, 1, 1, 2, 4, 5, 5, 3, 0, 1, 2].into_iter().enumerate() {
            let counts = if at % 3 == 1 {
                player.show(frame, &views, &Some4Of7).unwrap()
            } else {
                let camera = camera([0.1, 1.5, 0.1], looks[at % 3], 60.0);
                let streams = player.streams_of(frame, &views);
                player.show(frame, &views, visible_sets.find(&streams, &[camera])).unwrap()
            };
            let changes = player.take_changes();
            assert!(faces(&player.field).all(|face| face.has_alpha == has_alpha));
            copy(&changes, &player.field, &mut mirror);
            for (copied, shown) in faces(&mirror).zip(faces(&player.field)) {
                assert!(copied.inverse_depth == shown.inverse_depth, "frame {frame}");
                assert!(copied.color == shown.color && copied.material == shown.material, "frame {frame}");
            }
            pyramids.update(&player.field, &changes);
            for (at, view) in player.field.views.iter().enumerate() {
                assert!(*pyramids.view(at) == ViewPyramids::of(view), "frame {frame}");
            }
            let mut whole = Player::new(&decoder, &ProbeChoice::default()).unwrap();
            let all = whole.show(frame, &views, &AllUnits).unwrap();
            let known = compare(&player.field, &whole.field);
            assert_eq!(compare(&whole.field, &whole.field), [known[1]; 2]);
            assert!(known[0] < known[1] && known[0] > 0, "{known:?}");
            ever_known += known[0];
            assert_eq!((all.cells_unchanged, all.cells_unseen), (0, 0));
            let cells = counts.cells_decoded + counts.cells_skipped();
            assert_eq!(cells, all.cells_decoded);
            assert!(counts.cells_unseen > 0);
        }
        assert!(ever_known > 50_000, "{ever_known}");
    }
}

/// Checks that pictures are the same with visible units and with all units decoded. Returns the bytes read in both cases.
fn both(decoder: &Decoder, requests: &[FrameRequest], acceleration: Acceleration) -> [u64; 2] {
    let options = PictureOptions { size: [21, 16], steps: 48, refine: 4, acceleration, ..PictureOptions::default() };
    let show = |decode| -> (Vec<Shown>, u64) {
        let mut playback = Playback::new(decoder, PlaybackOptions { decode, ..PlaybackOptions::default() }).unwrap();
        let mut renderer = CpuRenderer::new(options.clone());
        let shown = requests.iter().map(|request| playback.show(request, &mut renderer, &Silent).unwrap()).collect();
        (shown, playback.summary().counts.bytes_read)
    };
    let ((seen, seen_bytes), (all, all_bytes)) = (show(DecodeScope::Seen), show(DecodeScope::All));
    let pairs = seen.iter().zip(&all).flat_map(|(seen, all)| seen.pictures.iter().zip(&all.pictures));
    let mut with_something = 0;
    for (seen, all) in pairs {
        assert_eq!(seen.image, all.image);
        with_something += usize::from(all.image.alpha.data().iter().any(|alpha| *alpha > 0.0));
        if acceleration == Acceleration::None {
            assert_eq!(seen.counters, all.counters);
        }
    }
    assert!(2 * with_something >= requests.len(), "{with_something} of {}", requests.len());
    [seen_bytes, all_bytes]
}

#[test]
fn pictures_do_not_depend_on_what_is_decoded_beyond_what_is_seen() {
    let folder = TempDir::new().unwrap();
    let decoder = courtyard(folder.path(), "");
    let mut requests = Vec::new();
    // Eyes between the probes, at a probe, below the ground, outside and far away; narrow and wide fields of view; along face
    // axes and oblique.
    let eyes = [[0.1, 1.5, 0.1], [0.0, 1.5, 0.0], [0.3, -0.5, 0.3], [4.0, 2.0, -3.0], [-30.0, 9.0, 40.0]];
    let ways = [[1.0, 0.0, 0.0], [0.7, -0.7, 0.1], [-0.3, 0.1, -1.0], [0.01, -1.0, 0.0]];
    for (at, eye) in eyes.into_iter().enumerate() {
        for (turn, way) in ways.into_iter().enumerate() {
            let fov_y_deg = [20.0, 90.0, 140.0][(at + turn) % 3];
            let camera = camera(eye, (DVec3::from(eye) + DVec3::from(way)).to_array(), fov_y_deg);
            requests.push(request(((at + turn) % 3) as u32, camera));
        }
    }
    both(&decoder, &requests, Acceleration::None);
    both(&decoder, &requests, Acceleration::Pyramid);
    // A narrow field of view reads few bytes.
    let narrow = request(0, camera([0.1, 1.5, 0.1], [2.0, 1.5, 0.3], 30.0));
    let [seen, all] = both(&decoder, &[narrow], Acceleration::None);
    assert!(2 * seen < all, "{seen} of {all} bytes");
    // Two cameras, as for stereo.
    let eyes = [-0.03, 0.03].map(|x| camera([x, 1.5, 0.1], [x + 0.5, 1.5, 2.0], 50.0)).to_vec();
    both(&decoder, &[FrameRequest { frame: 0, cameras: eyes }], Acceleration::None);
}

#[test]
fn a_view_of_90_degrees_reads_at_most_half_of_the_bytes() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let cameras = r#"{ "lightfold_cameras": 1, "cameras": [ { "position": [0, 1.5, 0] }, { "position": [0.4, 1.4, 0.2] },
        { "position": [-0.3, 1.7, -0.3] }, { "position": [0.2, 1.6, -0.4] } ] }"#;
    fs::write(at.join("cameras.json"), cameras).unwrap();
    fine("capture courtyard --cameras cameras.json --frames 0 --size 64 --samples 1 -q -o cap", at);
    fine("encode cap --clip --color-cell 8 -o a.lfold", at);
    let decoder = Decoder::open(at.join("a.lfold")).unwrap();
    for look_at in [[2.0, 1.5, 0.3], [-1.0, 1.4, 2.0], [0.1, 1.2, -2.0], [1.0, 0.5, 1.0]] {
        let wide = request(0, camera([0.1, 1.5, 0.1], look_at, 90.0));
        let [seen, all] = both(&decoder, &[wide], Acceleration::Pyramid);
        assert!(0 < seen && 2 * seen <= all, "{seen} of {all} bytes towards {look_at:?}");
    }
}

#[test]
fn what_did_not_change_is_not_done_again() {
    let folder = TempDir::new().unwrap();
    let decoder = courtyard(folder.path(), "");
    let mut playback = Playback::new(&decoder, PlaybackOptions::default()).unwrap();
    let mut renderer = little(SpecularMode::Auto);
    let looking = camera([0.1, 1.5, 0.1], [2.0, 1.0, -3.0], 100.0);
    let first = playback.show(&request(0, looking), &mut renderer, &Silent).unwrap().counts;
    assert!(first.cells_decoded > 0 && first.texels_updated > 0 && first.bytes_read > 0);
    assert!(first.cells_unseen > first.cells_decoded && first.cells_unchanged == 0);
    assert!(first.bytes_all > first.bytes_read, "{first:?}");
    let again = playback.show(&request(0, looking), &mut renderer, &Silent).unwrap().counts;
    assert_eq!((again.cells_decoded, again.texels_updated, again.bytes_read, again.bytes_all), (0, 0, 0, 0));
    assert_eq!((again.cells_unchanged, again.cells_unseen), (first.cells_decoded, first.cells_unseen));
    // Few objects move in the next frame.
    let next = playback.show(&request(1, looking), &mut renderer, &Silent).unwrap().counts;
    assert!(next.cells_decoded > 0 && next.cells_unchanged > next.cells_decoded, "{next:?}");
    assert_eq!(next.cells_decoded + next.cells_unchanged, first.cells_decoded);
    // Looking in another direction in the same frame keeps the decoded cells of the first direction.
    let behind = camera([0.1, 1.5, 0.1], [-2.0, 1.5, 0.3], 60.0);
    playback.show(&request(1, behind), &mut renderer, &Silent).unwrap();
    let back = playback.show(&request(1, looking), &mut renderer, &Silent).unwrap().counts;
    assert_eq!((back.cells_decoded, back.texels_updated, back.bytes_read), (0, 0, 0), "{back:?}");
    let sum = playback.summary();
    assert_eq!(sum.shots, 5);
    assert!(sum.counts.cells_decoded > first.cells_decoded + next.cells_decoded);
    assert!(sum.counts.bytes_all >= sum.counts.bytes_read && sum.pacing.frame.max_ms >= sum.pacing.frame.mean_ms);
}

/// Captures a scene with mirrors and glass from one probe, and encodes it.
fn mirrors(folder: &Path) -> Decoder {
    let capture = "capture mirrors --position 0,1.5,0 --frames 0 --size 64 --samples 1 --aov depth,material -q -o cap";
    fine(capture, folder);
    fine("encode cap --clip --color-cell 8 --depth-tile 16 -o a.lfold", folder);
    Decoder::open(folder.join("a.lfold")).unwrap()
}

/// Shows what a camera sees of one frame, rendered with 24x24 pixels.
fn shown(decoder: &Decoder, options: &PlaybackOptions, specular: SpecularMode, camera: &Camera) -> Shown {
    let mut playback = Playback::new(decoder, options.clone()).unwrap();
    let options = PictureOptions { size: [24, 24], steps: 256, specular, ..PictureOptions::default() };
    playback.show(&request(0, *camera), &mut CpuRenderer::new(options), &Silent).unwrap()
}

#[test]
fn all_units_are_decoded_only_if_a_specular_one_is_in_sight() {
    let folder = TempDir::new().unwrap();
    let decoder = mirrors(folder.path());
    let seen = PlaybackOptions::default();
    let all = PlaybackOptions { decode: DecodeScope::All, ..PlaybackOptions::default() };
    let of_camera = |look_at: [f64; 3]| {
        let camera = camera([0.1, 1.5, 0.0], look_at, 40.0);
        let [seen, all] = [&seen, &all].map(|options| shown(&decoder, options, SpecularMode::Auto, &camera));
        assert_eq!(seen.pictures[0].image, all.pictures[0].image, "{look_at:?}");
        [seen.counts.cells_unseen, seen.pictures[0].counters.secondary_rays]
    };
    // A ball of glass.
    let [unseen, rays] = of_camera([0.1, 0.5, -0.5]);
    assert!(unseen == 0 && rays > 0, "{unseen} {rays}");
    // The ceiling is dull.
    let [unseen, rays] = of_camera([0.1, 3.0, -0.01]);
    assert!(unseen > 0 && rays == 0, "{unseen} {rays}");
}

#[test]
fn without_effects_no_material_is_read() {
    let folder = TempDir::new().unwrap();
    let decoder = mirrors(folder.path());
    let camera = camera([0.1, 1.5, 0.0], [0.1, 1.5, -3.0], 40.0);
    let of = |no_materials| {
        let probes = ProbeChoice { no_materials, ..ProbeChoice::default() };
        let options = PlaybackOptions { probes, ..PlaybackOptions::default() };
        let player = Player::new(&decoder, &options.probes).unwrap();
        let min_bytes = player.min_bytes(&[0]);
        (shown(&decoder, &options, SpecularMode::None, &camera), min_bytes)
    };
    let ((with, bytes_with), (without, bytes_without)) = (of(false), of(true));
    assert_eq!(with.pictures[0].image, without.pictures[0].image);
    assert!(bytes_without < bytes_with, "{bytes_without} of {bytes_with} bytes of memory");
    let read = |shown: &Shown| shown.counts.bytes_read;
    assert!(0 < read(&without) && read(&without) < read(&with), "{} {}", read(&without), read(&with));
}

/// A scene with material images but without mirrors and glass.
#[test]
fn materials_that_call_for_nothing_do_not_decode_everything() {
    let folder = TempDir::new().unwrap();
    let capture =
        "capture courtyard --position 0,1.5,0 --frames 0-1 --size 32 --samples 1 --aov depth,material -q -o cap";
    fine(capture, folder.path());
    fine("encode cap --clip --color-cell 8 --depth-tile 16 -o a.lfold", folder.path());
    let decoder = Decoder::open(folder.path().join("a.lfold")).unwrap();
    let looking = camera([0.1, 1.5, 0.0], [2.0, 1.5, 0.0], 40.0);
    let shown = |decode, specular| {
        let options = PlaybackOptions { decode, ..PlaybackOptions::default() };
        let mut playback = Playback::new(&decoder, options).unwrap();
        let mut renderer = little(specular);
        playback.show(&request(0, looking), &mut renderer, &Silent).unwrap();
        playback.show(&request(1, looking), &mut renderer, &Silent).unwrap()
    };
    let none = shown(DecodeScope::Seen, SpecularMode::None);
    let all = shown(DecodeScope::All, SpecularMode::Auto);
    for specular in [SpecularMode::Auto, SpecularMode::Force] {
        let seen = shown(DecodeScope::Seen, specular);
        assert!(seen.counts.cells_unseen > 0, "{:?}", seen.counts);
        assert_eq!(seen.counts.cells_unseen, none.counts.cells_unseen);
        assert_eq!(seen.pictures[0].image, all.pictures[0].image);
        assert_eq!(seen.pictures[0].counters.secondary_rays, 0);
    }
}

#[test]
fn probes_take_part_in_the_frames_that_they_have() {
    let folder = TempDir::new().unwrap();
    let cameras = r#"{ "lightfold_cameras": 1, "cameras": [ { "name": "a", "position": [0, 1.5, 0], "frames": [0, 1] },
        { "name": "b", "position": [0.4, 1.4, 0.2], "frames": [1, 2] }, { "name": "c", "position": [0, 1.4, 0.2], "frames": [5, 5] } ] }"#;
    fs::write(folder.path().join("cameras.json"), cameras).unwrap();
    fine("capture courtyard --cameras cameras.json --frames 0-5 --size 8 --samples 1 -q -o cap", folder.path());
    fine("encode cap --clip --color-cell 8 -o a.lfold", folder.path());
    let decoder = Decoder::open(folder.path().join("a.lfold")).unwrap();
    let options = PlaybackOptions { decode: DecodeScope::All, ..PlaybackOptions::default() };
    let mut playback = Playback::new(&decoder, options).unwrap();
    assert_eq!((playback.player.frames().first, playback.player.frames().last), (0, 5));
    let mut renderer = little(SpecularMode::Auto);
    let looking = camera([0.1, 1.5, 0.1], [2.0, 1.5, 0.3], 60.0);
    for (frame, probes) in [(0, "a"), (1, "ab"), (2, "b"), (5, "c"), (1, "ab")] {
        let shown = playback.show(&request(frame, looking), &mut renderer, &Silent).unwrap();
        let mut active: Vec<&str> = shown.trace.active.iter().map(|active| active.probe.as_str()).collect();
        active.sort_unstable();
        assert_eq!(active.concat(), probes, "frame {frame}");
        for view in &playback.player.field.views {
            let texels = || view.faces.iter().flatten().flat_map(|face| &face.inverse_depth);
            let known = texels().filter(|texel| **texel != UNKNOWN).count();
            assert_eq!(known, if probes.contains(&view.name) { 384 } else { 0 }, "frame {frame}, probe {}", view.name);
        }
    }
    for frame in [3, 9] {
        let said = playback.show(&request(frame, looking), &mut renderer, &Silent).unwrap_err().to_string();
        assert!(said.contains(&format!("frame {frame}")) && said.contains("0-5"), "{said}");
    }
}

#[test]
fn a_damaged_chunk_is_an_error_and_leaves_nothing_that_could_be_taken_for_the_frame() {
    let folder = TempDir::new().unwrap();
    let whole = courtyard(folder.path(), "--depth-codec aabb --keyframe-interval 2");
    let index = whole.reader().index();
    // Chunks with equal bytes are stored once, so the test takes one that is not shared.
    let chunks = index.chunks.iter().filter(|chunk| chunk.key.first_frame > 0);
    let chunk = *chunks.max_by_key(|chunk| chunk.stored_bytes).unwrap();
    assert_eq!(index.chunks.iter().filter(|other| other.offset == chunk.offset).count(), 1);
    let mut bytes = fs::read(folder.path().join("a.lfold")).unwrap();
    bytes[chunk.offset as usize + chunk.stored_bytes as usize / 2] ^= 0x55;
    fs::write(folder.path().join("b.lfold"), bytes).unwrap();
    let damaged = Decoder::open(folder.path().join("b.lfold")).unwrap();
    let mut player = Player::new(&damaged, &ProbeChoice::default()).unwrap();
    let (good, bad) = (0, chunk.key.first_frame);
    player.show(good, &[0, 1, 2], &AllUnits).unwrap();
    player.take_changes();
    let said = player.show(bad, &[0, 1, 2], &AllUnits).unwrap_err().to_string();
    assert!(said.contains("b.lfold"), "{said}");
    assert!(faces(&player.field).next().is_none() && player.take_changes().is_empty());
    player.show(good, &[0, 1, 2], &AllUnits).unwrap();
    let mut fresh = Player::new(&whole, &ProbeChoice::default()).unwrap();
    fresh.show(good, &[0, 1, 2], &AllUnits).unwrap();
    assert_eq!(&player.field, &fresh.field);
}

#[test]
fn views_that_do_not_fit_are_given_up_and_too_many_at_once_refused() {
    let folder = TempDir::new().unwrap();
    let decoder = courtyard(folder.path(), "");
    let one = {
        let mut player = Player::new(&decoder, &ProbeChoice::default()).unwrap();
        player.show(0, &[1], &AllUnits).unwrap();
        player.bytes()
    };
    assert!(one > 6 * 32 * 32 * 8);
    let limited_beside = |bytes, beside| {
        let mut player = Player::new(&decoder, &ProbeChoice::default()).unwrap();
        player.limit_memory(Budget::of(bytes), beside);
        player
    };
    let limited = |bytes| limited_beside(bytes, 0);
    let mut player = limited(one * 5 / 2);
    let shown = |player: &Player<'_>| -> Vec<bool> {
        player.field.views.iter().map(|view| view.faces.iter().any(Option::is_some)).collect()
    };
    player.show(0, &[0], &AllUnits).unwrap();
    player.show(0, &[1], &AllUnits).unwrap();
    assert_eq!(shown(&player), [true, true, false]);
    let counts = player.show(0, &[2], &AllUnits).unwrap();
    assert!(counts.bytes_read > 0);
    // The least recently used view is unloaded.
    assert_eq!(shown(&player), [false, true, true]);
    assert_eq!(player.show(0, &[1], &AllUnits).unwrap().bytes_read, 0);
    let again = player.show(0, &[0], &AllUnits).unwrap();
    assert!(again.bytes_read > 0);
    assert!(player.take_changes().iter().any(|change| change.view == 0));
    // Decoder state can be dropped, texels cannot: three views do not fit into the bytes of one view's texels.
    let little = 6 * 32 * 32 * 8;
    let said = limited(little).show(0, &[0, 1, 2], &AllUnits).unwrap_err().to_string();
    assert!(said.contains("`memory`") && said.contains("`views`"), "{said}");
    // Memory that others use is not available for views.
    assert!(limited_beside(2 * one, one / 2).show(0, &[0], &AllUnits).is_ok());
    assert!(limited_beside(2 * one, 2 * one - little).show(0, &[0], &AllUnits).is_err());
}

#[test]
fn views_whose_decoders_do_not_fit_show_the_same() {
    let folder = TempDir::new().unwrap();
    let decoder = courtyard(folder.path(), "");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let mut roomy = Player::new(&decoder, &ProbeChoice::default()).unwrap();
        roomy.show(0, &[0, 1, 2], &AllUnits).unwrap();
        let mut tight = Player::new(&decoder, &ProbeChoice::default()).unwrap();
        tight.limit_memory(Budget::of(roomy.bytes() - 1), 0);
        let last = roomy.frames().last;
        for frame in [0, last, 0] {
            roomy.show(frame, &[0, 1, 2], &AllUnits).unwrap();
            tight.show(frame, &[0, 1, 2], &AllUnits).unwrap();
            assert_eq!(tight.field, roomy.field);
        }
        // No decoder state is left from the frame before.
        assert!(tight.show(0, &[0, 1, 2], &AllUnits).unwrap().bytes_read > 0);
        assert_eq!(roomy.show(0, &[0, 1, 2], &AllUnits).unwrap().bytes_read, 0);
    });
}

/// Backend that holds at most `most` probes of `each_bytes` bytes each, and decodes nothing.
struct SmallBackend {
    most: usize,
    each_bytes: u64,
    loaded: Vec<usize>,
}

impl TexelBackend for SmallBackend {
    fn keeps_texels(&self) -> bool {
        true
    }

    fn load(&mut self, probe: usize, _faces: &[NewFace<'_>]) -> Result<()> {
        if self.loaded.len() == self.most {
            return Err(Error::unsupported("the device is full"));
        }
        self.loaded.push(probe);
        Ok(())
    }

    fn bytes(&self, probe: usize) -> u64 {
        if self.loaded.contains(&probe) { self.each_bytes } else { 0 }
    }

    fn unload(&mut self, probe: usize) {
        self.loaded.retain(|loaded| *loaded != probe);
    }

    fn decode(&mut self, _frame: u32, units: Vec<&mut CachedUnit<'_>>) -> Result<()> {
        units.into_iter().for_each(|unit| unit.set_decoded(1));
        Ok(())
    }

    fn shows(&self, _unit: &CachedUnit<'_>, _frame: u32) -> bool {
        false
    }

    fn update(&mut self, faces: Vec<FaceUpdate<'_, '_>>) -> Result<Vec<FaceChanges>> {
        Ok(faces.iter().map(|_| FaceChanges::default()).collect())
    }

    fn bytes_read(&self) -> u64 {
        0
    }
}

#[test]
fn idle_views_make_room_on_a_device() {
    let folder = TempDir::new().unwrap();
    let decoder = courtyard(folder.path(), "");
    let request = UnitRequest { visible: &AllUnits, secondary_rays: false };
    let mut player = Player::new(&decoder, &ProbeChoice::default()).unwrap();
    let mut device = SmallBackend { most: 2, each_bytes: 1, loaded: Vec::new() };
    let mut show = |device: &mut SmallBackend, views: &[usize]| player.show_on(0, views, request, device);
    show(&mut device, &[0]).unwrap();
    show(&mut device, &[1]).unwrap();
    assert_eq!(device.loaded, [0, 1]);
    show(&mut device, &[2]).unwrap();
    assert_eq!(device.loaded, [2]);
    assert!(show(&mut device, &[0, 1, 2]).unwrap_err().to_string().contains("full"));
    assert!(device.loaded.is_empty());
    // The bytes that the device reports for a probe count if they are more than the CPU would need.
    device.each_bytes = 3 << 30;
    show(&mut device, &[0]).unwrap();
    show(&mut device, &[1]).unwrap();
    assert_eq!(device.loaded, [1]);
}

#[test]
fn only_chosen_probes_take_part_and_unknown_names_are_refused() {
    let folder = TempDir::new().unwrap();
    let decoder = courtyard(folder.path(), "");
    let choice = |only: &[&str], without: &[&str]| {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        ProbeChoice { only: names(only), without: names(without), ..ProbeChoice::default() }
    };
    let names = |choice: &ProbeChoice| -> Vec<String> {
        let player = Player::new(&decoder, choice).unwrap();
        player.field.views.iter().map(|view| view.name.clone()).collect()
    };
    assert_eq!(names(&choice(&[], &[])), ["00", "01", "02"]);
    assert_eq!(names(&choice(&["02", "00"], &[])), ["00", "02"]);
    assert_eq!(names(&choice(&[], &["01"])), ["00", "02"]);
    assert!(Player::new(&decoder, &choice(&["00"], &["00"])).is_err());
    let said = Player::new(&decoder, &choice(&[], &["7"])).unwrap_err().to_string();
    assert!(said.contains("'7'") && said.contains("00, 01, 02"), "{said}");
    // A limit on views is respected and reported.
    let selection = SelectionSettings { most: Some(2), ..SelectionSettings::default() };
    let mut playback = Playback::new(&decoder, PlaybackOptions { selection, ..PlaybackOptions::default() }).unwrap();
    let mut renderer = little(SpecularMode::Auto);
    let shown =
        playback.show(&request(0, camera([0.3, 1.4, 0.2], [2.0, 1.5, 0.3], 60.0)), &mut renderer, &Silent).unwrap();
    let (active, culled) = (&shown.trace.active, &shown.trace.culled);
    assert_eq!((active.len(), active[0].probe.as_str(), active[0].slot), (2, "01", 0));
    assert_eq!((culled.len(), culled[0].probe.as_str(), culled[0].why), (1, "02", "limit"));
}

#[test]
fn views_of_a_container_are_those_of_the_dataset_that_it_decodes_to() {
    for options in ["--keyframe-interval 3", "--hdr"] {
        let folder = TempDir::new().unwrap();
        let decoder = courtyard(folder.path(), options);
        fine("decode a.lfold -o decoded -q", folder.path());
        let source = Source::open(&folder.path().join("decoded"), &SourceOptions::default()).unwrap();
        let mut player = Player::new(&decoder, &ProbeChoice::default()).unwrap();
        for frame in [0, 4] {
            player.show(frame, &[0, 1, 2], &AllUnits).unwrap();
            let field = &player.field;
            let loaded = from_dataset(&source, frame, field.coding).unwrap();
            assert_eq!(loaded.views.len(), 3);
            for (view, expected) in loaded.views.iter().zip(&field.views) {
                let pose = |view: &View| (view.name.clone(), view.position, view.probe_from_world);
                assert_eq!(pose(view), pose(expected));
                assert!(view.faces == expected.faces, "{options}: frame {frame} of {}", view.name);
            }
        }
    }
}

#[test]
fn alpha_of_a_container_is_that_of_its_dataset() {
    for options in ["--psnr 60", "--hdr --psnr 60"] {
        let folder = TempDir::new().unwrap();
        let decoder = courtyard_of(folder.path(), options, add_alpha);
        let source = Source::open(&folder.path().join("cap"), &SourceOptions::default()).unwrap();
        let mut player = Player::new(&decoder, &ProbeChoice::default()).unwrap();
        // Frames go forwards and backwards, so that alpha changes where colour does not.
        for frame in [0, 1, 5, 2] {
            player.show(frame, &[0, 1, 2], &AllUnits).unwrap();
            let loaded = from_dataset(&source, frame, player.field.coding).unwrap();
            let [mut opaque, mut thin] = [0, 0];
            for (shown, expected) in faces(&player.field).zip(faces(&loaded)) {
                for at in 0..shown.inverse_depth.len() {
                    let alpha = expected.alpha(at);
                    assert!((shown.alpha(at) - alpha).abs() < 0.0025, "{} and {alpha}", shown.alpha(at));
                    opaque += usize::from(alpha == 1.0);
                    thin += usize::from(alpha < 0.5);
                    let [a, b] = [shown, expected].map(|face| face.color.get(at));
                    let most = 0.03 + 0.03 * b.max_element();
                    assert!(alpha < 0.5 || (a - b).abs().max_element() < most, "{options}: {a} and {b} at {alpha}");
                }
            }
            assert!(opaque > 1000 && thin > 1000, "{opaque} texels are opaque, and {thin} thin");
        }
    }
}
