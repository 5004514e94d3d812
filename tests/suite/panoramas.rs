//! `render --projection`: panoramas and cube maps for one eye or two.

use std::path::Path;

use codec::image::{ChannelSelect, Plane, ReadLimits};
use footage::image_files::exr;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::exports::ffmpeg;

const EYE: &str = "--eye 0.05,1.5,0.1 --look-at -2,1.2,0.8";

fn film(folder: &Path) {
    let probes = "--position=-0.2,1.5,0 --position=0.2,1.5,0 --position=0,1.5,0.2 --position=0,1.5,-0.2";
    fine(&format!("capture courtyard {probes} --frames 0-1 --size 64 --samples 4 -o captured"), folder);
    fine("encode captured --clip -o a.lfold", folder);
}

fn open(folder: &Path, name: &str) -> image::RgbImage {
    image::open(folder.join(name)).unwrap().into_rgb8()
}

fn distances(folder: &Path, name: &str) -> Plane<f32> {
    exr::read_depth(&folder.join(name), &ChannelSelect::default(), &ReadLimits::default()).unwrap()
}

#[test]
fn panoramas_show_what_a_camera_sees_in_the_same_direction() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    fine(&format!("render a.lfold {EYE} --projection equirect --size 96 --aov depth,normal,holes -o all.exr"), at);
    fine(&format!("render a.lfold {EYE} --projection vr180 --size 96 --aov depth -o half.exr"), at);
    fine(&format!("render a.lfold {EYE} --fov 90 --size 96 --aov depth -o view.exr"), at);
    let [all, half, view] = ["all.exr", "half.exr", "view.exr"].map(|name| distances(at, name));
    let size = |plane: &Plane<f32>| (plane.width(), plane.height());
    assert_eq!([size(&all), size(&half), size(&view)], [(192, 96), (96, 96), (96, 96)]);
    // The VR180 picture is the middle of the whole panorama.
    let apart = |a: f32, b: f32| (a / b).ln().abs();
    assert!((0..96).all(|y| (0..96).all(|x| half.get(x, y) == all.get(x + 48, y))));
    let mut errors = Vec::new();
    for (x, y) in (0..96).flat_map(|y| (0..96).map(move |x| (x, y))) {
        let [u, v] = [x, y].map(|at| (2.0 * (f64::from(at) + 0.5)) / 96.0 - 1.0);
        let (lon, lat) = (u.atan(), -(v / (1.0 + u * u).sqrt()).atan());
        let column = (lon / std::f64::consts::PI + 1.0) / 2.0 * 192.0;
        let row = (0.5 - lat / std::f64::consts::PI) * 96.0;
        let (there, here) = (all.get(column as u32, row as u32), view.get(x, y));
        if there.is_finite() && here.is_finite() {
            errors.push(apart(there, here));
        }
    }
    errors.sort_by(f32::total_cmp);
    assert!(errors.len() > 4000, "{}", errors.len());
    assert!(errors[errors.len() / 2] < 0.02, "median {}", errors[errors.len() / 2]);
    assert!(errors[errors.len() * 9 / 10] < 0.1, "{}", errors[errors.len() * 9 / 10]);
}

#[test]
fn two_eyes_are_over_or_beside_each_other_or_in_files_of_their_own() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    let line = format!("render a.lfold {EYE} --projection equirect --size 32 --eye-distance 0.2 --steps 256");
    fine(&format!("{line} --stereo over-under -o over.png"), at);
    fine(&format!("{line} --stereo side-by-side -o beside.png"), at);
    fine(&format!("{line} --stereo side-by-side -o %V.png --threads 1"), at);
    let [over, beside, left, right] = ["over.png", "beside.png", "left.png", "right.png"].map(|name| open(at, name));
    assert_eq!([&over, &beside, &left].map(|picture| picture.dimensions()), [(64, 64), (128, 32), (64, 32)]);
    assert!(left != right);
    for (x, y, pixel) in left.enumerate_pixels() {
        assert!(over.get_pixel(x, y) == pixel && beside.get_pixel(x, y) == pixel);
    }
    for (x, y, pixel) in right.enumerate_pixels() {
        assert!(over.get_pixel(x, y + 32) == pixel && beside.get_pixel(x + 64, y) == pixel);
    }
    // Straight ahead, the left eye of the panorama has the position of a camera moved to the left; behind, of one moved to the
    // right.
    fine(&format!("{line} --stereo side-by-side --aov depth -o %V.exr"), at);
    let [left, right] = ["left.exr", "right.exr"].map(|name| distances(at, name));
    let ahead = |to: &str, eye: &str, name: &str| {
        fine(
            &format!("render a.lfold --eye {eye} --look-at {to} --fov 1 --size 1 --steps 256 --aov depth -o {name}"),
            at,
        );
        distances(at, name).get(0, 0)
    };
    let level = "--eye 0,1.5,0 --look-at -1,1.5,0 --projection equirect --size 33x33 --eye-distance 0.2";
    fine(&format!("render a.lfold {level} --stereo side-by-side --steps 256 --aov depth -o level.%V.exr"), at);
    let near = |a: f32, b: f32| (a / b).ln().abs() < 0.03;
    // Looking along −X, the left eye is at +Z. The middle of 33 columns and rows is straight ahead.
    let [left_level, right_level] = ["level.left.exr", "level.right.exr"].map(|name| distances(at, name).get(16, 16));
    assert!(near(left_level, ahead("-9,1.5,0.1", "0,1.5,0.1", "l.exr")), "{left_level}");
    assert!(near(right_level, ahead("-9,1.5,-0.1", "0,1.5,-0.1", "r.exr")), "{right_level}");
    assert_eq!((left.width(), right.width()), (64, 64));
}

#[test]
fn cube_maps_have_six_faces_in_two_rows() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    fine(&format!("render a.lfold {EYE} --projection cubemap --size 24 --stereo over-under -o cube.png"), at);
    assert_eq!(open(at, "cube.png").dimensions(), (72, 96));
    fine(&format!("render a.lfold {EYE} --projection cubemap --size 24 --aov depth -o cube.exr"), at);
    fine(&format!("render a.lfold {EYE} --fov 90 --size 24 --aov depth -o front.exr"), at);
    let [cube, front] = ["cube.exr", "front.exr"].map(|name| distances(at, name));
    assert_eq!((cube.width(), cube.height()), (72, 48));
    assert!((0..24).all(|y| (0..24).all(|x| cube.get(24 + x, 24 + y) == front.get(x, y))));
}

/// ffmpeg's filter v360 converts the cube map to the panorama.
#[test]
#[cfg_attr(not(ffmpeg_at_hand), ignore = "no ffmpeg at hand")]
fn cube_maps_are_laid_out_as_ffmpeg_reads_them() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    let printed = fine(&format!("render a.lfold {EYE} --projection cubemap --size 128 -o -"), at).stdout;
    let turned = ffmpeg("-i - -vf v360=c3x2:e:w=128:h=64 -f rawvideo -pix_fmt rgb24 -", printed);
    fine(&format!("render a.lfold {EYE} --projection equirect --size 64 --samples 2 -o all.png"), at);
    let all = open(at, "all.png").into_raw();
    assert_eq!(all.len(), turned.len());
    let squares: f64 = all.iter().zip(&turned).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    let psnr_db = 10.0 * (255.0 * 255.0 / (squares / all.len() as f64)).log10();
    assert!(psnr_db > 25.0, "{psnr_db:.2} dB");
}

#[test]
fn projections_that_make_no_sense_are_refused() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    let clipped = r#"{"cameras": [{"eye": [0, 1.5, 0], "look_at": [1, 1.5, 0], "fov_y_deg": 60, "near_m": 0.5}]}"#;
    std::fs::write(at.join("clipped.json"), clipped).unwrap();
    for (options, words) in [
        (format!("{EYE} --projection equirect --device gpu --null"), "--device"),
        (format!("{EYE} --projection vr180 --method splat --null"), "perspective"),
        (format!("{EYE} --projection cubemap --size 32x24 --null"), "of a face"),
        ("--projection equirect --camera clipped.json --null".to_owned(), "near_m"),
        ("--projection equirect --reference captured --null".to_owned(), "--reference"),
        (format!("{EYE} --eye-distance 0.1 --null"), "--stereo"),
    ] {
        let said = refused(&format!("render a.lfold {options}"), at);
        assert!(said.contains(words), "{options}: {said}");
    }
}
