//! Arguments of `simplify`.

use std::path::{Path, PathBuf};

use crate::options::{AccountArgs, Choices, EFFORTS, MemoryArgs, check_stdout, one_of, parse_positive, word_of};
use codec::effort::Effort;
use codec::error::{Error, Result};
use footage::image_files::ktx2::AstcBlock;
use scene::placement::Region;
use simplify::budgets::Budgets;
use simplify::cost::TextureCoordinates;
use simplify::energy::EnergyKind;
use simplify::export::{Ktx2Blocks, Ktx2Output, Outputs};
use simplify::quad_mesh::AtlasLight;
use simplify::samples::{Background, BakedLight, Inside};
use simplify::settings::{Settings, SurfaceAtlases, TilingKind};
use simplify::shading::ShortCuts;
use simplify::texture_filter::TextureFilter;
use simplify::texture_sizes::Sizing;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    lightfold simplify footage/lightfield.json -o scene.glb\n  \
    lightfold simplify footage --triangles 20000 --atlas 2048 --effort fast -o scene.glb --json\n  \
    lightfold simplify footage -o scene.obj --uv projective\n  \
    lightfold simplify footage -o scene.glb --ktx2 scene.ktx2 --hdr\n  \
    lightfold simplify footage -o scene.glb --ktx2 scene.ktx2 --ktx2-blocks astc-6x6\n  \
    lightfold simplify footage -o scene.glb --resume\n  \
    lightfold simplify footage --region=-0.5,1.2,-0.5,0.5,1.8,0.5 --frames 24 -o scene.glb\n\n\
    The scene is valid for eyes inside the viewing region only. Triangles are stored back to front: a viewer must \
    draw them in that order, blended, without depth test, culling or sorting (three.js: sortObjects = false, \
    forceSinglePass = true).\n\n\
    The sky is a cube around the centre of the region: 4 times as far as the farthest surface, at most 400 and at least \
    8 times the radius of the region. A .glb file has a camera of 60 degrees at that centre, which looks at the middle \
    of the scene, or along -Z if the scene is on all sides.\n\n\
    A .glb file contains the texture as PNG; a .obj file comes with a .mtl and a .png file. --hdr writes the texture \
    to a .exr file with the name of the scene, in addition to the PNG of a .glb file or instead of the .png file. All \
    textures have straight alpha.\n\n\
    Triangles of glTF interpolate texture coordinates linearly, so slanted quads are divided until the depths of each \
    part are within a ratio of 1.5. --uv projective does not divide quads: a .glb file then has the attribute \
    _TEXCOORD_STQ, and a .obj file vt s t q, with texture coordinates s/q, t/q. Few viewers support this.\n\n\
    A run that is interrupted after the selection of quads keeps them beside SCENE. The same command with --resume \
    continues it and writes the same bytes.\n\n\
    All budgets are met; if a budget cannot be met, the error states its minimum. Area: sum of the solid angles of \
    all quads, in full spheres. Peak overdraw: mean number of quads per pixel in the worst of 126 views of 90 \
    degrees, as measured from the corners, edges, sides and centre of the region. Cracks: pixels of the capture with \
    alpha below one half.\n\n\
    --json reports PSNR, SSIM and PSNR-HVS-M (psnr_hvs_m_db) of all images, and: released_psnr_db, the value that the \
    released evaluator of Seurat would print, which ignores translucent pixels and adds 24.07 dB; random_poses, \
    cracks seen from 64 positions in the region; unsupported_percent, the rays from the region that meet no \
    surface that a camera has seen; selection, the energy of the selected quads (primal) and its lower bound (dual) \
    under the budgets (or 90% of them, the rest of which extends quads over gaps), and the budgets that limit the \
    energy (limited_by), none if larger budgets would not reduce it; in counters, the size of the mesh in a .glb file \
    (geometry_bytes), and its size with EXT_meshopt_compression, which is not written.")]
pub struct Args {
    /// Input with colour and depth: a dataset (lightfield.json or its folder), a container, or a Seurat manifest
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// Output scene: binary glTF (.glb) or Wavefront OBJ (.obj)
    #[arg(long, short, value_name = "SCENE.glb|SCENE.obj")]
    pub output: PathBuf,
    /// Maximum number of triangles
    #[arg(long, value_name = "N", default_value_t = 72_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    pub triangles: u32,
    /// Maximum area of all quads as seen by the viewer, in full spheres
    #[arg(long, value_name = "SPHERES", default_value_t = 3.0, value_parser = parse_positive)]
    pub area: f64,
    /// Maximum overdraw: mean number of quads per pixel in any 90-degree view
    #[arg(long, value_name = "LAYERS", default_value_t = 5.0, value_parser = parse_positive)]
    pub peak_overdraw: f64,
    /// Maximum side of the texture atlas in texels
    #[arg(long, value_name = "TEXELS", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(4..=16_384))]
    pub atlas: u32,
    /// Texels per degree of view before textures are fitted to the atlas; reduced if quads of the full area would need
    /// more than two atlases [default: 1.5 to 3 times those of the capture, by its number of cameras]
    #[arg(long, value_name = "P", value_parser = parse_positive)]
    pub pixels_per_degree: Option<f64>,
    /// Viewing region, which must not contain surfaces: x0,y0,z0,x1,y1,z1 (two corners in metres), sphere:x,y,z,r, or a
    /// file with a closed mesh; repeatable, for a union [default: the bounding box of the cameras]
    #[arg(long, value_name = "BOX|SPHERE|MESH", allow_hyphen_values = true)]
    pub region: Vec<String>,
    /// Representation of background
    #[arg(long, value_parser = one_of(BACKGROUNDS), default_value = "sky")]
    pub background: Background,
    /// Handling of samples inside the viewing region
    #[arg(long, value_parser = one_of(INSIDE), default_value = "refuse")]
    pub inside: Inside,
    /// Frame to simplify [default: the first]
    #[arg(long, value_name = "N")]
    pub frames: Option<u32>,
    /// Search effort: number of candidate tiles for each part of the scene and precision of their planes
    #[arg(long, value_parser = one_of(EFFORTS), default_value = "normal")]
    pub effort: Effort,
    /// Partition of the sphere into cells with separate quads
    #[arg(long, value_parser = one_of(TILINGS), default_value = "quadtree")]
    pub tiling: TilingKind,
    /// Error of the quads that is minimised
    #[arg(long, value_parser = one_of(ENERGIES), default_value = "picture")]
    pub energy: EnergyKind,
    /// Reduction of textures that do not fit into the atlas
    #[arg(long, value_parser = one_of(SIZINGS), default_value = "adaptive")]
    pub sizing: Sizing,
    /// Light of surfaces that look different to each camera
    #[arg(long, value_parser = one_of(LIGHTS), default_value = "mean")]
    pub light: BakedLight,
    /// Filter from samples to texels
    #[arg(long, value_parser = one_of(FILTERS), default_value = "gaussian")]
    pub texture_filter: TextureFilter,
    /// Interpolation of texture coordinates; affine divides slanted quads
    #[arg(long, value_parser = one_of(COORDINATES), default_value = "affine")]
    pub uv: TextureCoordinates,
    /// Keep values above 1: write the texture as half floats to a .exr file beside the scene; --ktx2 then uses BC6H,
    /// which has no alpha, or ASTC of 8 bits
    #[arg(long)]
    pub hdr: bool,
    /// Also write the texture as KTX2, which graphics cards read compressed
    #[arg(long, value_name = "FILE.ktx2")]
    pub ktx2: Option<PathBuf>,
    /// Blocks of the KTX2 file
    #[arg(long, value_name = "BLOCKS", value_parser = one_of(BLOCKS), default_value = "bc", requires = "ktx2")]
    pub ktx2_blocks: Ktx2Blocks,
    /// Also compare pictures of the scene with the images of this dataset
    #[arg(long, value_name = "DATASET")]
    pub held_out: Option<PathBuf>,
    /// Write charts and pictures into this folder: convergence of the selection, durations of stages, the worst images
    /// with their errors, and the view with the most overdraw
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Compare pictures of the scene with the input, and print durations and counters of all stages
    #[arg(long)]
    pub stats: bool,
    /// Also write normals and material of texels to .normal.exr and .material.exr files beside the scene
    #[arg(long)]
    pub gbuffer: bool,
    /// Resume an interrupted run from its selected tiles with the same options; start over if there are none
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Report as JSON, with a comparison of pictures of the scene with the input
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub account: AccountArgs,
}

const BACKGROUNDS: &Choices<Background> = &[
    ("sky", Background::Sky, "Cube around the viewing region, 4 times as far as the farthest surface"),
    ("transparent", Background::Transparent, "No geometry; background stays transparent"),
];

const INSIDE: &Choices<Inside> =
    &[("refuse", Inside::Refuse, "Fail"), ("drop", Inside::Drop, "Exclude and count them")];

const ENERGIES: &Choices<EnergyKind> = &[
    ("picture", EnergyKind::Picture, "Displacement in pictures from the region, weighted by contrast"),
    ("paper", EnergyKind::Paper, "Relative distance (Seurat equation 2)"),
];

const LIGHTS: &Choices<BakedLight> = &[
    ("mean", BakedLight::Mean, "Mean of all cameras"),
    (
        "center",
        BakedLight::Center,
        "As from the center of the viewing region: reflections are sharp, and stay in place",
    ),
];

const BLOCKS: &Choices<Ktx2Blocks> = &[
    ("bc", Ktx2Blocks::Bc, "BC7, 8 bits per texel; BC6H with --hdr: desktops"),
    ("astc-4x4", Ktx2Blocks::Astc(AstcBlock::Pixels4x4), "ASTC, 8 bits per texel: phones and headsets"),
    ("astc-6x6", Ktx2Blocks::Astc(AstcBlock::Pixels6x6), "ASTC, 3.56 bits per texel"),
    ("astc-8x8", Ktx2Blocks::Astc(AstcBlock::Pixels8x8), "ASTC, 2 bits per texel"),
];

const TILINGS: &Choices<TilingKind> = &[
    ("quadtree", TilingKind::Quadtree, "Cells of any quadtree level"),
    ("uniform", TilingKind::Uniform, "Cells of the sixth level only, for comparison (Seurat figure 13)"),
];

const COORDINATES: &Choices<TextureCoordinates> = &[
    ("affine", TextureCoordinates::Affine, "Linear: supported by every viewer"),
    ("projective", TextureCoordinates::Projective, "Homogeneous: quads are not divided"),
];

const SIZINGS: &Choices<Sizing> = &[
    ("adaptive", Sizing::Adaptive, "Reduce those that lose least (Seurat 5.3)"),
    ("uniform", Sizing::Uniform, "Reduce all by one factor, for comparison (Seurat figure 14)"),
];

const FILTERS: &Choices<TextureFilter> = &[
    ("gaussian", TextureFilter::Gaussian, "Gaussian with a standard deviation of 0.4 texels and a radius of 1.5"),
    ("box", TextureFilter::Box, "Mean of the samples in a texel; most texels have none, and are filled"),
    ("b-spline", TextureFilter::BSpline, "Cubic with a radius of 2 texels: smoothest"),
];

fn switch(is_on: bool) -> String {
    if is_on { "on" } else { "off" }.to_owned()
}

impl Args {
    pub(super) fn check(&self) -> Result<()> {
        check_stdout(&self.output, self.json)?;
        if self.stats && self.output == Path::new("-") {
            return Err(Error::Usage(
                "--stats and -o - would both write to standard output: specify an output file".into(),
            ));
        }
        match (self.hdr || self.gbuffer) && self.output == Path::new("-") {
            true => Err(Error::Usage(
                "--hdr and --gbuffer write files beside the scene: specify an output file instead of -".into(),
            )),
            false => self.outputs().check(),
        }
    }

    /// True if pictures of the scene are compared with the capture.
    pub(super) fn is_evaluated(&self) -> bool {
        self.json || self.stats || self.plot.is_some()
    }

    pub(super) fn outputs(&self) -> Outputs {
        let ktx2 = |path: &PathBuf| Ktx2Output { path: path.clone(), blocks: self.ktx2_blocks, effort: self.effort };
        Outputs { scene: self.output.clone(), ktx2: self.ktx2.as_ref().map(ktx2) }
    }

    /// Returns names and values of the options that tiles depend on.
    pub(super) fn options(&self) -> Vec<(&'static str, String)> {
        let Budgets { triangles, area, peak_overdraw } = self.budgets();
        let density = self.pixels_per_degree.map_or("default".to_owned(), |density| density.to_string());
        let region = if self.region.is_empty() { "default".to_owned() } else { self.region.join(" ") };
        vec![
            ("`triangles`", triangles.to_string()),
            ("`area`", area.to_string()),
            ("`peak_overdraw`", peak_overdraw.to_string()),
            ("`atlas`", self.atlas.to_string()),
            ("`pixels_per_degree`", density),
            ("`region`", region),
            ("`background`", word_of(BACKGROUNDS, &self.background).to_owned()),
            ("`inside`", word_of(INSIDE, &self.inside).to_owned()),
            ("`effort`", word_of(EFFORTS, &self.effort).to_owned()),
            ("`energy`", word_of(ENERGIES, &self.energy).to_owned()),
            ("`light`", word_of(LIGHTS, &self.light).to_owned()),
            ("`tiling`", word_of(TILINGS, &self.tiling).to_owned()),
            ("`sizing`", word_of(SIZINGS, &self.sizing).to_owned()),
            ("`texture_filter`", word_of(FILTERS, &self.texture_filter).to_owned()),
            ("`uv`", word_of(COORDINATES, &self.uv).to_owned()),
            ("`hdr`", switch(self.hdr)),
            ("`gbuffer`", switch(self.gbuffer)),
        ]
    }

    pub(super) fn budgets(&self) -> Budgets {
        Budgets { triangles: f64::from(self.triangles), area: self.area, peak_overdraw: self.peak_overdraw }
    }

    pub(super) fn settings(&self) -> Result<Settings> {
        let region = if self.region.is_empty() { None } else { Some(Region::parse(&self.region)?) };
        Ok(Settings {
            budgets: self.budgets(),
            atlas: self.atlas,
            pixels_per_degree: self.pixels_per_degree,
            region,
            background: self.background,
            inside: self.inside,
            effort: self.effort,
            energy: self.energy,
            baked: self.light,
            tiling: self.tiling,
            sizing: self.sizing,
            texture_filter: self.texture_filter,
            texture_coordinates: self.uv,
            surfaces: if self.gbuffer { SurfaceAtlases::GBuffer } else { SurfaceAtlases::None },
            light: if self.hdr { AtlasLight::HalfFloats } else { AtlasLight::Codes },
            short_cuts: ShortCuts::Taken,
            memory: self.memory.get(),
        })
    }
}
