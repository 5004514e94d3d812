//! Materials of OBJ files (MTL).
//!
//! Ks and Ns define an unnormalised Phong highlight with peak Ks; the weight computed here keeps the peak. Ns is the exponent
//! about the mirror direction. Pm and Pr (the PBR extension) select a metallic-roughness material, with Kd as its base colour.
//! Exporters write illumination models for materials that are neither mirrors nor glass, so models 3 and 5 are mirrors only where
//! Ks exceeds Kd, and 4, 6, 7 and 9 are glass only where the file states no opacity, or one below a half.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2};

use super::materials::shaded;
use crate::mesh::budget::Budget;
use crate::mesh::folder::Folder;
use crate::mesh::gltf::materials::{Paint, unit};
use crate::mesh::{ImageTexture, Material, Wrap};
use crate::mesh_scene::{MeshMaterial, Optics, Phong};
use codec::error::Result;
use footage::text::decode_lossy;

/// Alpha cutoff.
const CUTOFF: f64 = 0.5;

pub struct Library<'a> {
    pub folder: &'a mut Folder,
    pub budget: &'a mut Budget,
    pub notes: &'a mut Vec<String>,
    /// Textures by statement; `None` if a texture cannot be read.
    pub textures: BTreeMap<String, Option<Arc<ImageTexture>>>,
}

/// Scale and offset of texture coordinates, with v upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    scale: Vec2,
    offset: Vec2,
}

impl Default for Placement {
    fn default() -> Self {
        Placement { scale: Vec2::ONE, offset: Vec2::ZERO }
    }
}

impl Placement {
    /// Returns the coordinates in the texture.
    pub fn place(self, uv: Vec2) -> Vec2 {
        uv * self.scale + self.offset
    }
}

impl Library<'_> {
    /// Reads the materials of a file. On failure adds a note, and the scene has no materials.
    pub fn load(&mut self, name: &Path) -> tobj::MTLLoadResult {
        let name = name.to_string_lossy();
        let Some(text) = self.text_of(&name) else { return Err(tobj::LoadError::OpenFileFailed) };
        let loaded = tobj::load_mtl_buf(&mut BufReader::new(text.as_bytes()));
        if let Err(error) = &loaded {
            self.notes.push(format!("materials are ignored: {name} is damaged: {error}"));
        }
        loaded
    }

    /// Returns the text of one material file, whose name may have spaces, or else of all files of a list of names.
    fn text_of(&mut self, statement: &str) -> Option<String> {
        let whole = match self.folder.fetch(statement, self.budget) {
            Ok(bytes) => return Some(plain(&decode_lossy(&bytes))),
            Err(error) => error,
        };
        let names = statement.replace("\\ ", "\0");
        let names: Vec<String> = names.split_whitespace().map(|name| name.replace('\0', " ")).collect();
        if names.len() < 2 {
            self.notes.push(format!("materials are ignored: {whole}"));
            return None;
        }
        let mut text = String::new();
        for name in &names {
            match self.folder.fetch(name, self.budget) {
                Ok(bytes) => text.push_str(&plain(&decode_lossy(&bytes))),
                Err(error) => self.notes.push(format!("materials are ignored: {error}")),
            }
        }
        Some(text)
    }

    /// Returns the placement of the texture of a material; that of its first map, as all maps share their coordinates.
    pub fn placement(&mut self, material: &tobj::Material) -> Placement {
        let maps = [
            material.diffuse_texture.as_deref(),
            material.dissolve_texture.as_deref(),
            material.unknown_param.get("map_Ke").map(String::as_str),
        ];
        let placements: Vec<Placement> = maps.into_iter().flatten().map(|map| Map::parse(map).placement).collect();
        if placements.iter().any(|placement| *placement != placements[0]) {
            let name: String = material.name.chars().take(80).collect();
            self.notes.push(format!("the maps of “{name}” have several -o or -s: those of the first are used for all"));
        }
        placements.first().copied().unwrap_or_default()
    }

    pub fn convert(&mut self, material: &tobj::Material) -> MeshMaterial {
        let color = |value: Option<[f32; 3]>| value.map(|value| DVec3::from_array(value.map(unit)));
        let other = |name: &str| material.unknown_param.get(name).map(String::as_str);
        let diffuse_map = material.diffuse_texture.as_deref().and_then(|name| self.texture(name));
        let mask = material.dissolve_texture.as_deref().and_then(|name| self.texture(name));
        let emissive_texture = other("map_Ke").and_then(|name| self.texture(name));
        let masked = mask.is_some();
        let base_texture = match mask {
            Some(mask) => self.masked(diffuse_map, &mask),
            None => diffuse_map,
        };
        let transparency = other("Tr").and_then(|value| value.trim().parse::<f32>().ok());
        // MeshLab writes Tr 1 for opaque materials, and nobody a material that is invisible as a whole.
        let transparency = transparency.filter(|tr| *tr < 1.0).map(|tr| 1.0 - tr);
        let alpha = material.dissolve.or(transparency).map_or(1.0, unit);
        let specular = color(material.specular).unwrap_or(DVec3::ZERO);
        let ior = material.optical_density.map_or(1.0, f64::from);
        let number = |name: &str| other(name).and_then(|text| text.trim().parse::<f32>().ok()).map(unit);
        let metal_rough = [number("Pm"), number("Pr")];
        let is_metal_rough = metal_rough != [None; 2];
        let states_opacity = material.dissolve.or(transparency).is_some();
        let reflects = specular.max_element() >= color(material.diffuse).map_or(0.0, DVec3::max_element);
        let optics = match material.illumination_model {
            Some(3 | 5) if reflects && !is_metal_rough => {
                Optics::Mirror { tint: if specular == DVec3::ZERO { DVec3::ONE } else { specular } }
            }
            Some(4 | 6 | 7 | 9) if !states_opacity || alpha < CUTOFF => Optics::Glass {
                ior: if ior > 1.0 && ior < 100.0 { ior } else { 1.5 },
                tint: other("Tf").and_then(three).unwrap_or(DVec3::ONE),
            },
            _ => Optics::Opaque,
        };
        let exponent = material.shininess.map_or(1.0, f64::from).clamp(1.0, 1e4);
        let is_opaque = optics == Optics::Opaque;
        let weight = if material.illumination_model.is_some_and(|model| model < 2) || !is_opaque {
            DVec3::ZERO
        } else {
            specular * 2.0 / (exponent + 2.0)
        };
        let holes = is_opaque && (masked || alpha < 1.0);
        if is_opaque && alpha < 1.0 {
            let name: String = material.name.chars().take(80).collect();
            self.notes.push(format!(
                "“{name}” uses alpha blending with alpha {alpha:.3}, which is not supported: alpha \
                below {CUTOFF} is transparent, the rest opaque"
            ));
        }
        self.note_ignored_maps(material);
        // A map is multiplied by the file's factor, which defaults to 1.
        let default = if material.diffuse_texture.is_some() { DVec3::ONE } else { DVec3::splat(0.8) };
        let base_color = color(material.diffuse).unwrap_or(default);
        let given =
            material.emissive.map(|value| DVec3::from_array(value.map(f64::from))).filter(|value| value.is_finite());
        let default = if emissive_texture.is_some() { DVec3::ONE } else { DVec3::ZERO };
        let emission = given.map_or(default, |value| value.max(DVec3::ZERO));
        let plain = Material {
            name: material.name.clone(),
            base_color: if is_opaque { base_color } else { DVec3::ZERO },
            base_texture,
            alpha_cutoff: holes.then_some(CUTOFF),
            alpha,
            emission,
            emissive_texture,
            ..Material::default()
        };
        if is_metal_rough && is_opaque {
            let [metallic, roughness] = metal_rough;
            let mean_color = base_color * plain.base_texture.as_deref().map_or(DVec3::ONE, |map| map.means()[0]);
            let ior = if (1.0..100.0).contains(&ior) && material.optical_density.is_some() { ior } else { 1.5 };
            let (metallic, roughness) = (metallic.unwrap_or(0.0), roughness.unwrap_or(1.0));
            let material = Material { metallic, roughness, ior, ..plain };
            return shaded(Paint { material, mean_color, coordinates: None });
        }
        MeshMaterial { plain, phong: Phong { weight, exponent }, metal: DVec3::ZERO, optics }
    }

    /// Notes the maps of a material that are not read.
    fn note_ignored_maps(&mut self, material: &tobj::Material) {
        let known = [
            ("map_Ka", &material.ambient_texture),
            ("map_Ks", &material.specular_texture),
            ("map_Ns", &material.shininess_texture),
            ("map_Bump", &material.normal_texture),
        ];
        let of_known = known.into_iter().filter(|(_, map)| map.is_some()).map(|(name, _)| name);
        let is_map = |name: &&str| {
            let others = ["bump", "norm", "disp", "decal", "refl"];
            name.starts_with("map_") && *name != "map_Ke" || others.contains(name)
        };
        let others = material.unknown_param.keys().map(String::as_str).filter(is_map);
        let mut names: Vec<&str> = of_known.chain(others).collect();
        names.sort_unstable();
        if !names.is_empty() {
            let material: String = material.name.chars().take(80).collect();
            self.notes.push(format!("maps of “{material}” are ignored: {}", names.join(", ")));
        }
    }

    fn texture(&mut self, statement: &str) -> Option<Arc<ImageTexture>> {
        if let Some(known) = self.textures.get(statement) {
            return known.clone();
        }
        let Map { name, wrap, .. } = Map::parse(statement);
        let read = |library: &mut Self| -> Result<ImageTexture> {
            let bytes = library.folder.fetch(name, library.budget)?;
            ImageTexture::decode(&bytes, [wrap; 2], library.budget).map_err(|error| error.context(name))
        };
        let read = read(self).map_err(|error| self.notes.push(format!("a texture is ignored: {error}")));
        let read = read.ok().map(Arc::new);
        self.textures.insert(statement.to_string(), read.clone());
        read
    }

    fn masked(&mut self, map: Option<Arc<ImageTexture>>, mask: &ImageTexture) -> Option<Arc<ImageTexture>> {
        let size = map.as_ref().map_or(mask.pixels.len(), |map| map.pixels.len());
        let taken = self.budget.take(size as u64, 4, "a texture with holes");
        let taken = taken.map_err(|error| self.notes.push(format!("a texture is ignored: {error}")));
        taken.ok().map(|()| Arc::new(with_alpha(map.as_deref(), mask)))
    }
}

/// Rewrites every colour to have three numbers, or none where they are not RGB, and opacity to be one number: otherwise the parser
/// returns an error or panics.
fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().take(4).collect();
        match words[..] {
            [color @ ("Ka" | "Kd" | "Ks" | "Ke"), ..] => {
                let is_rgb = words[1..].iter().all(|word| word.parse::<f32>().is_ok());
                let [r, g, b] = match words[1..] {
                    [r, g, b] if is_rgb => [r, g, b],
                    [gray] if is_rgb => [gray; 3],
                    _ => ["none"; 3],
                };
                plain.push_str(&format!("{color} {r} {g} {b}"));
            }
            ["d", "-halo", alpha, ..] => plain.push_str(&format!("d {alpha}")),
            _ => plain.push_str(line),
        }
        plain.push('\n');
    }
    plain
}

/// A map statement: options, then the name of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Map<'a> {
    name: &'a str,
    wrap: Wrap,
    placement: Placement,
}

impl<'a> Map<'a> {
    fn parse(statement: &'a str) -> Map<'a> {
        let mut rest = statement.trim();
        let (mut wrap, mut placement) = (Wrap::Repeat, Placement::default());
        while rest.starts_with('-') {
            let cut = |text: &mut &'a str| -> &'a str {
                let end = text.find(char::is_whitespace).unwrap_or(text.len());
                let word = &text[..end];
                *text = text[end..].trim_start();
                word
            };
            let option = cut(&mut rest);
            match option {
                "-o" | "-s" | "-t" => {
                    let mut numbers = Vec::new();
                    while let Some(Ok(number)) = rest.split_whitespace().next().map(str::parse::<f32>)
                        && numbers.len() < 3
                    {
                        numbers.push(number);
                        cut(&mut rest);
                    }
                    let is_finite = numbers.iter().all(|number| number.is_finite());
                    let given =
                        |usual: f32| Vec2::from_array([0, 1].map(|at| numbers.get(at).copied().unwrap_or(usual)));
                    match option {
                        "-o" if is_finite => placement.offset = given(0.0),
                        "-s" if is_finite => placement.scale = given(1.0),
                        _ => {}
                    }
                }
                "-mm" => {
                    cut(&mut rest);
                    cut(&mut rest);
                }
                "-clamp" => wrap = if cut(&mut rest) == "on" { Wrap::Clamp } else { wrap },
                "-blendu" | "-blendv" | "-cc" | "-colorspace" | "-bm" | "-boost" | "-texres" | "-imfchan" | "-type" => {
                    cut(&mut rest);
                }
                _ => {}
            }
        }
        Map { name: rest, wrap, placement }
    }
}

/// Parses three numbers, or one for all, and clamps them to at least 0.
fn three(text: &str) -> Option<DVec3> {
    let numbers: Vec<f32> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let value = match numbers[..] {
        [r, g, b, ..] => [r, g, b],
        [gray] => [gray; 3],
        _ => return None,
    };
    let value = DVec3::from_array(value.map(f64::from));
    value.is_finite().then(|| value.max(DVec3::ZERO))
}

/// Combines the colours of one image with the alpha of a mask: its alpha channel, or its brightness if it has none.
fn with_alpha(map: Option<&ImageTexture>, mask: &ImageTexture) -> ImageTexture {
    let own = mask.pixels.iter().any(|pixel| pixel[3] != 255);
    let alpha = |pixel: [u8; 4]| if own { pixel[3] } else { pixel[1] };
    let mut map = map.cloned().unwrap_or_else(|| {
        let mut white = mask.clone();
        white.pixels.fill([255; 4]);
        white
    });
    for y in 0..map.height {
        for x in 0..map.width {
            let at =
                DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / DVec2::new(map.width.into(), map.height.into());
            let place = (at * DVec2::new(mask.width.into(), mask.height.into())).floor().as_uvec2();
            let pixel = mask.pixels[(place.y * mask.width + place.x) as usize];
            map.pixels[(y * map.width + x) as usize][3] = alpha(pixel);
        }
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_three_numbers() {
        assert_eq!(
            plain("Kd 1 2 3 4\n Ks 0.5\nKe\nKa 1 2\nNs 3\nKd xyz 1 2 3\nKs spectral a.rfl\nd -halo 0.5"),
            "Kd 1 2 3\nKs 0.5 0.5 0.5\nKe none none none\nKa none none none\nNs 3\nKd none none none\nKs none none none\nd 0.5\n"
        );
    }

    #[test]
    fn names_of_maps_stand_behind_their_options() {
        let name_and_wrap = |statement: &'static str| {
            let map = Map::parse(statement);
            (map.name, map.wrap)
        };
        assert_eq!(name_and_wrap(" a b.png "), ("a b.png", Wrap::Repeat));
        assert_eq!(name_and_wrap("-s 1 2 -clamp on -o 0.5 a.png"), ("a.png", Wrap::Clamp));
        assert_eq!(name_and_wrap("-mm 0 1 -bm 2 -clamp off x y.png"), ("x y.png", Wrap::Repeat));
        assert_eq!(name_and_wrap("-s"), ("", Wrap::Repeat));
        assert_eq!(name_and_wrap("-"), ("", Wrap::Repeat));
    }

    #[test]
    fn options_of_maps_place_the_texture() {
        let placed = |statement: &str| Map::parse(statement).placement.place(Vec2::new(1.0, 0.5)).to_array();
        assert_eq!(placed("-o 0.5 0.25 -s 0.5 2 a.png"), [1.0, 1.25]);
        assert_eq!(placed("-s 3 a.png"), [3.0, 0.5]);
        assert_eq!(placed("-s 2 2 1 -o 0.25 0 0 a.png"), [2.25, 1.0]);
        assert_eq!(placed("-t 1 1 1 -s nan 1 a.png"), [1.0, 0.5]);
    }
}
