//! Files of a simplified scene: binary glTF or OBJ, and separate textures (Seurat 6).
//!
//! All files store straight colour, not multiplied by alpha, and keep the order of triangles.

pub mod glb;
mod textures;

use std::ffi::OsStr;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use codec::error::{Error, Result};
use codec::image::Plane;
use footage::dataset::manifest::NORMAL_CHANNELS;
use footage::image_files::exr;

pub use glb::Scene;
pub use textures::{Ktx2Blocks, Ktx2Output};

/// Name of the material in an OBJ file and in its material library.
const MATERIAL: &str = "quads";

/// Output files.
#[derive(Debug)]
pub struct Outputs {
    /// Path of the scene: `.obj`, or binary glTF; `-` for standard output.
    pub scene: PathBuf,
    pub ktx2: Option<Ktx2Output>,
}

#[derive(Debug)]
pub struct OutputBytes {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SceneFormat {
    Glb,
    Obj,
}

impl Outputs {
    /// Fails if the names do not determine the formats, or if two files have the same name. Can be called before the scene
    /// exists.
    pub fn check(&self) -> Result<()> {
        self.format()?;
        let absolute = |path: &PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
        if let Some(Ktx2Output { path, .. }) = &self.ktx2
            && (path == Path::new("-") || self.of_scene().iter().any(|other| absolute(other) == absolute(path)))
        {
            return Err(Error::Usage(format!("{}: `ktx2` needs a different file name", path.display())));
        }
        Ok(())
    }

    /// Returns the files that a scene of this name may have.
    fn of_scene(&self) -> Vec<PathBuf> {
        let beside = ["exr", "mtl", "png", "normal.exr", "material.exr"].map(|extension| self.beside(extension));
        [self.scene.clone()].into_iter().chain(beside).collect()
    }

    /// Returns all files that may be written.
    pub fn all(&self) -> Vec<PathBuf> {
        self.of_scene().into_iter().chain(self.ktx2.as_ref().map(|ktx2| ktx2.path.clone())).collect()
    }

    fn format(&self) -> Result<SceneFormat> {
        let extension = self.scene.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("obj") => Ok(SceneFormat::Obj),
            Some("glb") | None => Ok(SceneFormat::Glb),
            Some(other) => Err(Error::Usage(format!(
                "{}: a name that ends in .glb or .obj was expected, not .{other}",
                self.scene.display()
            ))),
        }
    }

    /// Returns the path of the scene with another extension.
    fn beside(&self, extension: &str) -> PathBuf {
        self.scene.with_extension(extension)
    }
}

/// Returns the bytes of all files, the scene first. If the scene has half floats, they are written to an EXR file of the scene's
/// name, and to the KTX2 file in place of codes.
pub fn files(scene: &Scene, outputs: &Outputs) -> Result<Vec<OutputBytes>> {
    outputs.check()?;
    let mut beside = Vec::new();
    if outputs.scene == Path::new("-") && (scene.quads.light.is_some() || scene.surfaces.is_some()) {
        return Err(Error::Usage("the scene has additional files: specify a file name instead of -".into()));
    }
    if let Some(light) = &scene.quads.light {
        beside.push(OutputBytes { path: outputs.beside("exr"), bytes: textures::exr(&scene.quads.texture, light)? });
    }
    if let Some(output) = &outputs.ktx2 {
        beside.push(OutputBytes { path: output.path.clone(), bytes: textures::ktx2(scene.quads, output)? });
    }
    for SurfaceFile { values, extension, channels } in surfaces(scene) {
        beside.push(OutputBytes { path: outputs.beside(extension), bytes: exr::triple_bytes(values, channels)? });
    }
    let mut files = match outputs.format()? {
        SceneFormat::Glb => {
            let names = beside.iter().map(|file| file_name(&file.path)).collect::<Result<Vec<&str>>>()?;
            vec![OutputBytes { path: outputs.scene.clone(), bytes: glb::bytes(scene, &names)? }]
        }
        SceneFormat::Obj => {
            let [materials, png] = ["mtl", "png"].map(|extension| outputs.beside(extension));
            let texture = if scene.quads.light.is_some() { outputs.beside("exr") } else { png.clone() };
            let names = [file_name(&materials)?, file_name(&texture)?];
            let mut files = vec![
                OutputBytes { path: outputs.scene.clone(), bytes: obj_bytes(scene, names[0]) },
                OutputBytes { bytes: obj_material(names[1]), path: materials },
            ];
            if scene.quads.light.is_none() {
                files.push(OutputBytes { path: png, bytes: scene.quads.texture.png()? });
            }
            files
        }
    };
    files.extend(beside);
    Ok(files)
}

/// Returns the scene as Wavefront OBJ, in the form of the released Seurat: homogeneous texture coordinates are `vt s t q`, affine
/// ones `vt u v`. Both have their origin in the bottom left corner of the image.
fn obj_bytes(scene: &Scene, materials: &str) -> Vec<u8> {
    let quads = scene.quads;
    let mut text =
        String::from("# Triangles are in drawing order, from back to front: blend them, without depth test.\n");
    let [min, max] = [scene.region.middle - scene.region.half, scene.region.middle + scene.region.half];
    // Writing to a string cannot fail.
    let _ =
        writeln!(text, "# Viewing region in metres: {} {} {} to {} {} {}", min.x, min.y, min.z, max.x, max.y, max.z);
    let _ = writeln!(text, "mtllib {materials}");
    for position in &quads.mesh.positions {
        let at = position.as_vec3();
        let _ = writeln!(text, "v {} {} {}", at.x, at.y, at.z);
    }
    for stq in &quads.stq {
        let _ = writeln!(text, "vt {} {} {}", stq.x, stq.z - stq.y, stq.z);
    }
    if quads.stq.is_empty() {
        for uv in &quads.mesh.uvs {
            let _ = writeln!(text, "vt {} {}", uv.x, 1.0 - uv.y);
        }
    }
    let _ = writeln!(text, "usemtl {MATERIAL}");
    for corners in &quads.mesh.triangles {
        let [a, b, c] = corners.map(|corner| corner + 1);
        let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}");
    }
    text.into_bytes()
}

/// Returns the material library: the unlit colour of the texture. Viewers take alpha from the same image.
fn obj_material(texture: &str) -> Vec<u8> {
    format!("newmtl {MATERIAL}\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 0\nmap_Kd {texture}\n").into_bytes()
}

/// An atlas other than that of colour.
struct SurfaceFile<'a> {
    values: &'a Plane<[f32; 3]>,
    extension: &'static str,
    channels: [&'static str; 3],
}

fn surfaces<'a>(scene: &'a Scene) -> impl Iterator<Item = SurfaceFile<'a>> {
    let of = |values, extension, channels| Some(SurfaceFile { values: values?, extension, channels });
    let atlas = scene.surfaces;
    let normal = atlas.and_then(|atlas| atlas.normal.as_ref());
    let material = atlas.and_then(|atlas| atlas.material.as_ref());
    let files =
        [of(normal, "normal.exr", NORMAL_CHANNELS), of(material, "material.exr", ["reflect", "refract", "ior"])];
    files.into_iter().flatten()
}

/// Returns the name by which other files refer to a file. Fails if it is not UTF-8 or contains control characters.
fn file_name(path: &Path) -> Result<&str> {
    let name = path.file_name().and_then(OsStr::to_str).filter(|name| !name.chars().any(char::is_control));
    name.ok_or_else(|| Error::Usage(format!("{}: a file name in UTF-8 was expected", path.display())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::effort::Effort;

    #[test]
    fn names_tell_the_format() {
        let of = |scene: &str, ktx2: Option<&str>| {
            let ktx2 = ktx2.map(|path| Ktx2Output { path: path.into(), blocks: Ktx2Blocks::Bc, effort: Effort::Fast });
            Outputs { scene: scene.into(), ktx2 }
        };
        for (name, format) in [("a.glb", SceneFormat::Glb), ("a.OBJ", SceneFormat::Obj), ("-", SceneFormat::Glb)] {
            assert_eq!(of(name, None).format().unwrap(), format);
        }
        assert!(of("a.glb", Some("a.ktx2")).check().is_ok());
        for (outputs, words) in [
            (of("a.ply", None), "a.ply: a name that ends in .glb or .obj"),
            (of("a.glb", Some("a.glb")), "a.glb: `ktx2` needs a different file name"),
            (of("a.obj", Some("-")), "-: `ktx2` needs a different file name"),
        ] {
            let said = outputs.check().unwrap_err().to_string();
            assert!(said.contains(words), "{said}");
        }
    }
}
