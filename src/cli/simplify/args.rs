//! Arguments of `simplify`.

use std::path::{Path, PathBuf};

use crate::options::{Choices, EFFORTS, MemoryArgs, check_stdout, one_of, parse_positive, word_of};
use codec::effort::Effort;
use codec::error::{Error, Result};
use scene::placement::Region;
use simplify::cost::TextureCoordinates;
use simplify::export::{Ktx2Output, Outputs};
use simplify::quad_mesh::AtlasLight;
use simplify::samples::{Background, Inside};
use simplify::selection::Budgets;
use simplify::settings::{Settings, SurfaceAtlases, TilingKind};
use simplify::short_cuts::ShortCuts;
use simplify::texture_filter::TextureFilter;
use simplify::texture_sizes::Sizing;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    lightfold simplify footage/lightfield.json -o scene.glb\n  \
    lightfold simplify footage --triangles 20000 --atlas 2048 --effort fast -o scene.glb --json\n  \
    lightfold simplify footage -o scene.obj --uv projective\n  \
    lightfold simplify footage -o scene.glb --ktx2 scene.ktx2 --hdr\n  \
    lightfold simplify footage -o scene.glb --resume\n  \
    lightfold simplify footage --region=-0.5,1.2,-0.5,0.5,1.8,0.5 --frames 24 -o scene.glb\n\n\
    The scene is right for eyes in the viewing region only. Triangles are stored from back to front: a viewer draws them in that \
    order, blended, without depth test, culling or sorting (three.js: sortObjects = false, forceSinglePass = true).\n\n\
    A .glb file holds the texture as PNG; beside a .obj file lie a .mtl file and a .png file. --hdr writes the texture to a .exr file \
    of the scene's name as well, or in place of the .png file. All textures have straight alpha.\n\n\
    Triangles of glTF interpolate texture coordinates linearly, so that slanted quads are divided until that is within half a texel. \
    --uv projective divides none: a .glb file then has the attribute _TEXCOORD_STQ, and a .obj file vt s t q; the texture lies at s/q, \
    t/q, which few viewers know.\n\n\
    A run that stops after its quads were selected keeps them beside SCENE. The same command with --resume continues and writes the same \
    bytes.\n\n\
    All budgets are kept; one that cannot be is an error that names the least value that would do. Area: how often all quads \
    together would cover the sphere around the viewer. Peak overdraw: mean number of quads over a pixel in the worst of 126 views of \
    90 degrees. Cracks: pixels of the capture with less than half alpha.\n\n\
    --json has, beside PSNR, SSIM and PSNR-HVS-M (psnr_hvs_m_db) of all images: released_psnr_db, what the evaluator of the released \
    program would have printed, which left out translucent pixels and added 24.07 dB; random_poses, cracks seen from 64 places in the \
    region; selection, the energy of the quads (primal) and a lower bound of it (dual), within the budgets less the part that is \
    reserved for quads that are extended over gaps, a bound within the whole budgets (dual_of_budgets), and the budgets that keep it \
    from being less (limited_by), none where no smaller quads would fit better; in counters, the bytes of a .glb file's mesh \
    (geometry_bytes) and what they would be with EXT_meshopt_compression, which is not written.")]
pub struct Args {
    /// Colour and depth: a dataset (lightfield.json or its folder), a container, or a Seurat manifest
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// File to write, binary glTF or Wavefront OBJ by its extension
    #[arg(long, short, value_name = "SCENE.glb|SCENE.obj")]
    pub output: PathBuf,
    /// Most triangles
    #[arg(long, value_name = "N", default_value_t = 72_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    pub triangles: u32,
    /// Most area of all quads around the viewer, in whole spheres
    #[arg(long, value_name = "SPHERES", default_value_t = 3.0, value_parser = parse_positive)]
    pub area: f64,
    /// Most quads over a pixel, as the mean of any view of 90 degrees
    #[arg(long, value_name = "LAYERS", default_value_t = 5.0, value_parser = parse_positive)]
    pub peak_overdraw: f64,
    /// Most texels of each side of the texture
    #[arg(long, value_name = "TEXELS", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(4..=16_384))]
    pub atlas: u32,
    /// Texels for each degree of view, before the atlas reduces them; less where quads of all the area would have more than two atlases
    /// hold [default: twice the pixels of the capture]
    #[arg(long, value_name = "P", value_parser = parse_positive)]
    pub pixels_per_degree: Option<f64>,
    /// Viewing region, without surfaces: x0,y0,z0,x1,y1,z1 (two corners in metres), sphere:x,y,z,r, or a file with a closed mesh;
    /// repeatable, for a union [default: the box around the cameras]
    #[arg(long, value_name = "BOX|SPHERE|MESH", allow_hyphen_values = true)]
    pub region: Vec<String>,
    /// What is infinitely far
    #[arg(long, value_parser = one_of(BACKGROUNDS), default_value = "sky")]
    pub background: Background,
    /// Samples in the viewing region
    #[arg(long, value_parser = one_of(INSIDE), default_value = "refuse")]
    pub inside: Inside,
    /// The frame to simplify [default: the first]
    #[arg(long, value_name = "N")]
    pub frames: Option<u32>,
    /// Search effort: tiles for each part of the scene and precision of their planes; fast traces a quarter of the rays
    #[arg(long, value_parser = one_of(EFFORTS), default_value = "normal")]
    pub effort: Effort,
    /// Parts of the sphere that get quads of their own
    #[arg(long, value_parser = one_of(TILINGS), default_value = "quadtree")]
    pub tiling: TilingKind,
    /// How textures shrink that do not fit into the atlas
    #[arg(long, value_parser = one_of(SIZINGS), default_value = "adaptive")]
    pub sizing: Sizing,
    /// How the light of samples is spread over texels
    #[arg(long, value_parser = one_of(FILTERS), default_value = "gaussian")]
    pub texture_filter: TextureFilter,
    /// Texture coordinates, which decide how many quads a slanted one is divided into
    #[arg(long, value_parser = one_of(COORDINATES), default_value = "affine")]
    pub uv: TextureCoordinates,
    /// Keep light above 1, as half floats: in a .exr file beside the scene, and in BC6H, which has no alpha, with
    /// --ktx2
    #[arg(long)]
    pub hdr: bool,
    /// Write the texture as KTX2, too, in BC7, which graphics cards read compressed
    #[arg(long, value_name = "FILE.ktx2")]
    pub ktx2: Option<PathBuf>,
    /// Compare pictures of the scene with the images of this dataset, too
    #[arg(long, value_name = "DATASET")]
    pub held_out: Option<PathBuf>,
    /// Draw charts and pictures into a folder: convergence of the selection, durations of the stages, the images that come out
    /// worst with their errors, and the overdraw of the view that has the most
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Compare pictures of the scene with the input, and print durations and counts of all stages
    #[arg(long)]
    pub stats: bool,
    /// Write normals and material of the texels, too, as .normal.exr and .material.exr of the scene's name
    #[arg(long)]
    pub gbuffer: bool,
    /// Resume a stopped run with the tiles that it had selected, with the same options; start over if there are none
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Report as JSON, with a comparison of pictures of the scene with the input
    #[arg(long)]
    pub json: bool,
}

const BACKGROUNDS: &Choices<Background> = &[
    ("sky", Background::Sky, "A cube around the viewing region, 400 times as large"),
    ("transparent", Background::Transparent, "Nothing; it stays transparent"),
];

const INSIDE: &Choices<Inside> =
    &[("refuse", Inside::Refuse, "Are an error"), ("drop", Inside::Drop, "Are left out, and counted")];

const TILINGS: &Choices<TilingKind> = &[
    ("quadtree", TilingKind::Quadtree, "Cells of any level of a quadtree"),
    ("uniform", TilingKind::Uniform, "Cells of the sixth level alone, for comparison (Seurat figure 13)"),
];

const COORDINATES: &Choices<TextureCoordinates> = &[
    ("affine", TextureCoordinates::Affine, "Interpolated linearly, which every viewer does"),
    ("projective", TextureCoordinates::Projective, "Homogeneous: no quad is divided"),
];

const SIZINGS: &Choices<Sizing> = &[
    ("adaptive", Sizing::Adaptive, "Those whose pictures lose least (Seurat 5.3)"),
    ("uniform", Sizing::Uniform, "All by one factor, for comparison (Seurat figure 14)"),
];

const FILTERS: &Choices<TextureFilter> = &[
    ("gaussian", TextureFilter::Gaussian, "Standard deviation of 0.3 texels, within 1.5"),
    ("box", TextureFilter::Box, "The mean of the samples in a texel; the most texels have none, and are filled"),
    ("b-spline", TextureFilter::BSpline, "Cubic, within 2 texels: smoothest"),
];

fn switch(is_on: bool) -> String {
    if is_on { "on" } else { "off" }.to_owned()
}

impl Args {
    pub(super) fn check(&self) -> Result<()> {
        check_stdout(&self.output, self.json)?;
        if self.stats && self.output == Path::new("-") {
            return Err(Error::Usage("--stats and -o - would both write to standard output; name a file".into()));
        }
        match (self.hdr || self.gbuffer) && self.output == Path::new("-") {
            true => Err(Error::Usage("--hdr and --gbuffer write files beside the scene: give -o a name, not -".into())),
            false => self.outputs().check(),
        }
    }

    /// True if pictures of the scene are compared with the capture.
    pub(super) fn is_evaluated(&self) -> bool {
        self.json || self.stats || self.plot.is_some()
    }

    pub(super) fn outputs(&self) -> Outputs {
        let ktx2 = |path: &PathBuf| Ktx2Output { path: path.clone(), effort: self.effort };
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
