//! Small datasets for tests, written as files that the library reads.

use std::path::Path;

use codec::image::{AlphaPlane, ColorPlane, DepthPlane, Face, MaterialPlane, Plane};
use footage::dataset::source::{Source, SourceOptions};
use footage::image_files::exr;
use half::f16;

/// A dataset to be written. Each closure returns the image of a face and a frame.
pub struct Footage<'a> {
    /// Width and height of a face in pixels.
    pub size: [u32; 2],
    /// First and last frame, inclusive.
    pub frames: [u32; 2],
    /// Faces of the cube map; ignored for perspective images.
    pub faces: &'a [Face],
    /// Extra keys of the manifest's `depth`, such as `, "near": 1`.
    pub depth_keys: &'a str,
    /// Depth in metres; `None` for a dataset without depth.
    pub depth: Option<&'a dyn Fn(Face, u32) -> DepthPlane>,
    /// Linear RGB; `None` for a dataset without colour.
    pub color: Option<&'a dyn Fn(Face, u32) -> ColorPlane>,
    /// Reflection weight, refraction weight and index of refraction; `None` for a dataset without material.
    pub material: Option<&'a dyn Fn(Face, u32) -> MaterialPlane>,
    /// Alpha, 0 to 1; `None` for a dataset without alpha.
    pub alpha: Option<&'a dyn Fn(Face, u32) -> AlphaPlane>,
}

impl Footage<'_> {
    /// Creates a dataset of face px and frames 0 to 5, without streams.
    pub fn new(width: u32, height: u32) -> Footage<'static> {
        Footage {
            size: [width, height],
            frames: [0, 5],
            faces: &[Face::Px],
            depth_keys: "",
            depth: None,
            color: None,
            material: None,
            alpha: None,
        }
    }

    /// Writes the images and the manifest of a single probe "00". Square images are cube map faces, others are perspective.
    pub fn write(&self, folder: &Path) {
        let cube = self.size[0] == self.size[1];
        let faces = if cube { self.faces } else { &[Face::View] };
        for &face in faces {
            let of = |kind: &str, frame: u32| {
                let folder = folder.join(format!("probe_00/face_{}", face.name()));
                std::fs::create_dir_all(&folder).unwrap();
                folder.join(format!("{kind}.{frame:04}.exr"))
            };
            for frame in self.frames[0]..=self.frames[1] {
                if let Some(depth) = self.depth {
                    exr::write_depth(&of("depth", frame), &depth(face, frame)).unwrap();
                }
                if let Some(color) = self.color {
                    exr::write_color(&of("color", frame), &color(face, frame)).unwrap();
                }
                if let Some(material) = self.material {
                    let names = ["reflect", "refract", "ior"];
                    exr::write_material(&of("material", frame), &material(face, frame), names).unwrap();
                }
                if let Some(alpha) = self.alpha {
                    let halves = alpha(face, frame).map(|&alpha| f16::from_f32(alpha));
                    exr::write_alpha(&of("alpha", frame), &halves).unwrap();
                }
            }
        }
        let file = |kind: &str, there: bool| {
            let face = if cube { "{face}" } else { "view" };
            there.then(|| format!(r#""{kind}": "probe_{{probe}}/face_{face}/{kind}.%04d.exr""#))
        };
        let files: Vec<String> = [
            file("depth", self.depth.is_some()),
            file("color", self.color.is_some()),
            file("material", self.material.is_some()),
            file("alpha", self.alpha.is_some()),
        ]
        .into_iter()
        .flatten()
        .collect();
        let names: Vec<String> = self.faces.iter().map(|face| format!("{:?}", face.name())).collect();
        let (projection, present, lens) = if cube {
            ("cubemap", format!(r#""faces_present": [{}],"#, names.join(", ")), "")
        } else {
            ("perspective", String::new(), r#", "fov_y_deg": 60"#)
        };
        let manifest = format!(
            r#"{{ "lightfield": 1, "name": "test", "fps": 24, "frames": [{}, {}], "projection": "{projection}",
                "size": [{}, {}], {present}
                "depth": {{ "kind": "distance", "unit": "m", "background": "inf"{} }},
                "files": {{ {} }}, "probes": [{{ "name": "00", "position": [0, 1, 2]{lens} }}] }}"#,
            self.frames[0],
            self.frames[1],
            self.size[0],
            self.size[1],
            self.depth_keys,
            files.join(", "),
        );
        std::fs::write(folder.join("lightfield.json"), manifest).unwrap();
    }

    /// Writes the dataset and opens it.
    pub fn open(&self, folder: &Path) -> Source {
        self.write(folder);
        Source::open(folder, &SourceOptions::default()).unwrap()
    }
}

/// A pseudo-random sequence that depends only on its seed.
pub struct Random(pub u64);

impl Random {
    /// Returns the next 31 bits.
    pub fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }

    /// Returns a number below `limit`.
    pub fn below(&mut self, limit: u32) -> u32 {
        self.next() % limit
    }
}

/// Returns linear RGB that drifts in the right half, flickers in the top left corner, and is constant elsewhere.
pub fn drifting_color(width: u32, height: u32, frame: u32) -> ColorPlane {
    Plane::from_fn(width, height, |x, y| {
        let base = (x * 7 + y * 3) as f32 / 400.0;
        let drift = if x > width / 2 { frame as f32 * 0.01 } else { 0.0 };
        let flicker = if x < 3 && y < 3 && frame % 3 == 1 { 5.0 } else { 0.0 };
        [base + drift, base * 0.5 + drift * 0.5, flicker + 0.1].map(f16::from_f32)
    })
}
