//! Luminance outside the range of PU21: above 10000 cd/m², below 0.005 cd/m², and negative. Its error has a bound of its own
//! (color.md 5) and is 0 if exact coding is requested; `diff` reports every difference.

use std::path::Path;

use codec::decode::Picture;
use codec::image::{ColorPlane, Face, Plane};
use half::f16;
use lightfold::Decoder;
use tempfile::TempDir;

use crate::commands::{fine, lightfold};
use crate::footage::{Footage, Random};

const SIDE: u32 = 32;
const FRAMES: u32 = 8;
const WHITE_CD_M2: f64 = 100.0;

type Light = fn(u32) -> ColorPlane;

fn plane(pixel: impl Fn(u32, u32) -> [f32; 3]) -> ColorPlane {
    Plane::from_fn(SIDE, SIDE, |x, y| pixel(x, y).map(f16::from_f32))
}

fn shade(x: u32, y: u32) -> f32 {
    0.2 + (x + 2 * y) as f32 / 200.0
}

/// Name of a scene, and its linear RGB by frame.
const SCENES: [(&str, Light); 8] = [
    ("lamp that moves", |frame| {
        plane(|x, y| if (x / 2, y / 2) == (2 * frame, 5) { [200.0, 60_000.0, 121.0] } else { [shade(x, y); 3] })
    }),
    ("lamp of one pixel that brightens", |frame| {
        plane(|x, y| match (x, y) {
            (13, 20) => [200.0 * 2f32.powi(frame as i32); 3],
            _ => [shade(x, y), 0.3, 0.1],
        })
    }),
    ("darkness in motion", |frame| {
        let mut random = Random(1 + u64::from(frame));
        let values: Vec<f32> = (0..3 * SIDE * SIDE).map(|_| 5e-5 * random.below(1000) as f32 / 1000.0).collect();
        plane(|x, y| [0, 1, 2].map(|channel| values[(3 * (x + SIDE * y) + channel) as usize]))
    }),
    ("subnormal halves", |frame| {
        Plane::from_fn(SIDE, SIDE, |x, y| [x + frame, y, x * y + frame].map(|bits| f16::from_bits(bits as u16)))
    }),
    ("negative light just below black", |frame| {
        plane(|x, y| if (x + frame) % 7 == 0 { [-0.0011, 0.0, -1e-6] } else { [shade(x, y), -0.0, 2e-5] })
    }),
    ("negative light of all sizes", |frame| {
        plane(|x, y| match (x, y) {
            (3, 9) => [-6e-8 * 1000f32.powi(frame as i32 % 5), 0.4, -65_504.0],
            _ => [shade(x, y); 3],
        })
    }),
    ("greatest half beside black", |frame| {
        plane(|x, y| if x == 4 * frame && y > 8 { [65_504.0; 3] } else { [0.0; 3] })
    }),
    ("any finite bits", |frame| {
        let mut random = Random(77 + u64::from(frame));
        let bits: Vec<u16> =
            (0..3 * SIDE * SIDE).map(|_| (random.below(0x7c00) | random.below(2) << 15) as u16).collect();
        Plane::from_fn(SIDE, SIDE, |x, y| {
            [0, 1, 2].map(|channel| f16::from_bits(bits[(3 * (x + SIDE * y) + channel) as usize]))
        })
    }),
];

fn write(folder: &Path, light: Light) {
    std::fs::create_dir_all(folder).unwrap();
    let color = |_: Face, frame: u32| light(frame);
    Footage { frames: [0, FRAMES - 1], color: Some(&color), ..Footage::new(SIDE, SIDE) }.write(folder);
}

fn diff(line: &str, at: &Path) -> (i32, serde_json::Value) {
    let out = lightfold(&format!("diff {line} --json").split(' ').collect::<Vec<_>>(), at);
    (out.status.code().unwrap(), serde_json::from_slice(&out.stdout).unwrap())
}

/// Computes the encoding E of color.md 5.1, independently of the library.
fn encoding(value: f16) -> f64 {
    let pu = |y: f64| {
        let power = y.powf(0.906_256_262_7);
        let ratio = (0.353_487_901 + 0.373_465_862_9 * power) / (1.0 + 8.277_049_286e-5 * power);
        596.314_814_2 * (ratio.powf(0.091_503_031_66) - 0.909_951_720_4)
    };
    let positive = |y: f64| match y {
        y if y > 10_000.0 => pu(10_000.0) + 69.93 * (y / 10_000.0).ln(),
        y if y < 0.005 => pu(0.005) - 77.44 * (0.005 - y),
        y => pu(y),
    };
    let y = value.to_f64() * WHITE_CD_M2;
    if y < 0.0 { 2.0 * positive(0.0) - positive(-y) } else { positive(y) }
}

fn is_outside(value: f16) -> bool {
    !(0.005..=10_000.0).contains(&(value.to_f64() * WHITE_CD_M2))
}

#[test]
fn exact_keeps_every_bit() {
    for (name, light) in SCENES {
        let folder = TempDir::new().unwrap();
        let at = folder.path();
        write(at, light);
        for options in [
            "--preset exact",
            "--preset exact --color-codec cells",
            "--preset exact --color-codec cells --effort exhaustive",
            "--hdr --psnr 200 --color-chunk 3",
            "--hdr --color-block bc6h --psnr 200 --psnr-final 200",
        ] {
            fine(&format!("encode . -o a.lfold {options}"), at);
            let (code, report) = diff(". a.lfold --exact --min-cell-psnr inf", at);
            assert_eq!((code, &report["exact"]["differing_pixels"]), (0, &0.into()), "{name} with {options}: {report}");
            assert_eq!(report["color"]["psnr_db_is"], "inf");
        }
    }
}

#[test]
fn every_codec_keeps_the_bound_outside_the_metric() {
    for (name, light) in SCENES {
        let folder = TempDir::new().unwrap();
        let at = folder.path();
        write(at, light);
        for (options, db) in [
            ("--hdr --psnr 40", 40.0),
            ("--hdr --psnr 55 --effort fast", 55.0),
            ("--hdr --color-codec cells", 50.0),
            ("--hdr --color-codec cells --psnr 30", 30.0),
            ("--hdr --color-block bc6h", 40.0),
        ] {
            fine(&format!("encode . -o a.lfold {options}"), at);
            let decoder = Decoder::open(at.join("a.lfold")).unwrap();
            let mut face = decoder.face(&decoder.streams()[0]);
            // The second bound of color.md 5.1, plus the rounding to 64ths on both sides.
            let most = 4.0 * 256.0 * 10f64.powf(-db / 20.0) + 1.0 / 64.0;
            for frame in 0..FRAMES {
                let Picture::ColorHalf(shown) = face.decode(frame).unwrap() else {
                    panic!("half floats were expected")
                };
                let (shown, source) = (shown.data().as_flattened().to_vec(), light(frame));
                for (shown, source) in shown.iter().zip(source.data().as_flattened()) {
                    let error = (encoding(*shown) - encoding(*source)).abs();
                    let is_bounded = is_outside(*shown) || is_outside(*source);
                    assert!(
                        !is_bounded || error <= most,
                        "{name} with {options}, frame {frame}: {source} became {shown}"
                    );
                }
            }
            let (code, report) = diff(&format!(". a.lfold --min-cell-psnr {db}"), at);
            assert_eq!(code, 0, "{name} with {options}: {report}");
        }
    }
}

#[test]
fn diff_sees_every_difference_of_halves() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let changes: [(f32, f32); 8] = [
        (200.0, 60_000.0),
        (121.0, 63_072.0),
        (65_472.0, 65_504.0),
        (-0.0011, -1.24),
        (-1.0, 0.0),
        (-0.0, 0.0),
        (6e-8, 1.2e-7),
        (1e-5, 4e-5),
    ];
    for (from, to) in changes {
        let of = |value: f32, name: &str| {
            let color = |_: Face, _: u32| plane(|x, y| if (x, y) == (3, 4) { [value; 3] } else { [0.5; 3] });
            let folder = at.join(name);
            std::fs::create_dir_all(&folder).unwrap();
            Footage { frames: [0, 1], color: Some(&color), ..Footage::new(SIDE, SIDE) }.write(&folder);
            fine(&format!("encode {name} -o {name}.lfold --preset exact"), at);
        };
        of(from, "a");
        of(to, "b");
        for sides in ["a b --hdr", "a b.lfold", "a.lfold b", "a.lfold b.lfold"] {
            let (code, report) = diff(sides, at);
            let color = &report["color"];
            assert_eq!((code, &report["equal"], &color["differing_pixels"]), (0, &false.into(), &2.into()), "{sides}");
            for key in ["psnr_db", "min_psnr_db", "min_cell_psnr_db"] {
                assert!(color[key].is_f64(), "{from} and {to}, {sides}: {color}");
            }
            assert!(
                report["streams"][0]["psnr_db"].is_f64() && report["streams"][0]["max_error_pu21"].as_f64() > Some(0.0)
            );
            for bound in ["--exact", "--min-psnr 180", "--min-cell-psnr inf"] {
                assert_eq!(diff(&format!("{sides} {bound}"), at).0, 1, "{from} and {to}, {sides} {bound}");
            }
            let text = String::from_utf8(lightfold(&format!("diff {sides}").split(' ').collect::<Vec<_>>(), at).stdout)
                .unwrap();
            assert!(!text.contains("inf dB") && text.contains("different; no bound was given"), "{text}");
        }
        // A lamp of the wrong brightness also breaks an ordinary PSNR bound.
        if (to - from).abs() > 1000.0 {
            assert_eq!(diff("a b.lfold --min-cell-psnr 50", at).0, 1, "{from} and {to}");
        }
        assert_eq!(diff("a a.lfold --exact --min-cell-psnr inf", at).0, 0);
    }
}
