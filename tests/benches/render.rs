//! Rendering speed from arbitrary viewpoints on one thread: millions of pixels per second, and march and refinement steps per
//! ray.
//!
//! `cargo bench --bench render [-- IN.lfold..]` renders the six faces of a cube map from a point between the probes of each
//! container, by default of a procedural room. It varies the refinements, the steps (with and without pyramids), bisection, the
//! number of pixels and the number of views. Times are medians over `TURNS` runs; columns are separated by two spaces. `--plot
//! DIR` plots relative time over relative parameter values to `DIR/render-cost.svg` and `.png`.

#![allow(clippy::disallowed_methods)]

mod clock;

use std::hint::black_box;
use std::path::{Path, PathBuf};

use cli::report::plot::axis::Axis;
use cli::report::plot::chart::{Chart, Kind, Mark, Series};
use cli::report::plot::marker::Look;
use cli::report::plot::save;
use clock::Clock;
use codec::decode::{AllUnits, Decoder};
use codec::error::Result;
use codec::image::cube::Face;
use codec::image::transfer::ToneMap;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use glam::DVec3;
use render::march::active_views::ActiveViews;
use render::march::counters::Counters;
use render::march::ray::Steps;
use render::march::render::{render, render_plainly};
use render::march::settings::{Acceleration, Refinements, RenderSettings, SpecularMode};
use render::march::synthetic::{SyntheticProbe, room};
use render::rendered_image::{BackgroundFill, HoleFill};
use render::views::catalogue::ProbeChoice;
use render::views::light_field::{ColorCoding, LightField};
use render::views::player::Player;

/// Number of runs of each measurement.
const TURNS: usize = 3;
/// Values of the parameters that a measurement does not vary.
const SIZE: u32 = 256;
const STEPS: u32 = 64;
const REFINE: u32 = 8;

fn main() -> Result<()> {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().ok();
    let mut words = std::env::args().skip(1);
    let (mut files, mut plot) = (Vec::new(), None);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--plot" => plot = words.next().map(PathBuf::from),
            option if option.starts_with("--") => {}
            _ => files.push(word),
        }
    }
    if files.is_empty() {
        measure("room", &furnished(), plot.as_deref())?;
    }
    for file in files {
        let decoder = Decoder::open(&file)?;
        let first = decoder.streams().iter().map(|stream| stream.entry.first_frame).min().unwrap_or(0);
        let mut player = Player::new(&decoder, &ProbeChoice::default())?;
        let all: Vec<usize> = (0..player.field.views.len()).collect();
        player.show(first, &all, &AllUnits)?;
        measure(&file, &player.field, plot.as_deref())?;
    }
    Ok(())
}

fn measure(name: &str, field: &LightField, plot: Option<&Path>) -> Result<()> {
    let all = field.views.len();
    println!("{name}: {all} views");
    println!("{:<52}  {:>9}  {:>11}  {:>12}", "", "Mpixel/s", "steps a ray", "refine a ray");
    let base = Measurement {
        size: SIZE,
        steps: STEPS,
        refine: REFINE,
        views: all,
        refinements: Refinements::ALL,
        plain: false,
        pyramid: true,
    };
    let mut lines: Vec<Line> = ["steps, pyramid", "steps, every point", "pixels", "views"].map(Line::new).into();
    let none = Refinements::NONE;
    for refinements in [
        none,
        Refinements { angles: true, ..none },
        Refinements { edges: true, ..none },
        Refinements { thin: true, ..none },
    ] {
        base.with(|m| m.refinements = refinements).print(field);
    }
    for steps in [64, 256, 512, 2048] {
        for pyramid in [false, true] {
            let seconds = base.with(|m| (m.steps, m.pyramid) = (steps, pyramid)).print(field);
            lines[usize::from(!pyramid)].points.push([f64::from(steps), seconds]);
        }
    }
    base.with(|m| m.refine = 0).print(field);
    base.with(|m| m.plain = true).print(field);
    for size in [128, 256, 512, 1024] {
        let seconds = base.with(|m| m.size = size).print(field);
        lines[2].points.push([f64::from(size * size), seconds]);
    }
    for views in [1, 2, 4, 8].into_iter().filter(|views| *views < all).chain([all]) {
        let seconds = base.with(|m| m.views = views).print(field);
        lines[3].points.push([views as f64, seconds]);
    }
    println!();
    plot.map_or(Ok(()), |folder| draw(name, &lines, folder))
}

/// Plotted series: a parameter's values, and the seconds for each.
struct Line {
    name: &'static str,
    points: Vec<[f64; 2]>,
}

impl Line {
    fn new(name: &'static str) -> Line {
        Line { name, points: Vec::new() }
    }

    /// Returns the points relative to the first point, in both coordinates.
    fn marks(&self) -> Vec<Mark> {
        let Some(&[first, seconds]) = self.points.first() else { return Vec::new() };
        self.points.iter().map(|[x, y]| Mark { x: x / first, y: y / seconds, ..Mark::default() }).collect()
    }
}

fn draw(name: &str, lines: &[Line], folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|error| lightfold::Error::io(folder, error))?;
    let marks: Vec<Vec<Mark>> = lines.iter().map(Line::marks).collect();
    let most = marks.iter().flatten().map(|mark| mark.x.max(mark.y)).fold(1.0, f64::max);
    let axis = |label: &str| Axis::logarithmic(label, [1.0, most]);
    let name = Path::new(name).file_name().unwrap_or_default().to_string_lossy();
    let mut chart = Chart::new(format!("What pictures of {name} cost"), axis("times as many"), axis("times as long"));
    let ends = [1.0, most].map(|at| Mark { x: at, y: at, ..Mark::default() });
    let straight = Look::of(lines.len()).dashed([4.0, 3.0]);
    chart.series.push(Series { name: "in proportion".into(), kind: Kind::Curve, look: straight, marks: ends.into() });
    for (at, (line, marks)) in lines.iter().zip(marks).enumerate() {
        chart.series.push(Series { name: line.name.into(), kind: Kind::Line, look: Look::of(at), marks });
    }
    for path in save::save(&chart.draw(760, 460), folder, "render-cost")? {
        println!("{}", path.display());
    }
    Ok(())
}

/// Parameters of a measurement.
#[derive(Clone, Copy)]
struct Measurement {
    size: u32,
    steps: u32,
    refine: u32,
    views: usize,
    refinements: Refinements,
    plain: bool,
    pyramid: bool,
}

impl Measurement {
    fn with(self, change: impl FnOnce(&mut Measurement)) -> Measurement {
        let mut other = self;
        change(&mut other);
        other
    }

    fn refinements(&self) -> String {
        let Refinements { angles, edges, thin } = self.refinements;
        let named = [(angles, "angles"), (edges, "edges"), (thin, "thin")];
        let names: Vec<&str> = named.into_iter().filter_map(|(is_on, name)| is_on.then_some(name)).collect();
        match names.len() {
            0 => "no refinements".into(),
            3 => "all refinements".into(),
            _ => names.join("+"),
        }
    }

    /// Prints a line and returns the median seconds of a run.
    fn print(&self, field: &LightField) -> f64 {
        let positions = field.views.iter().map(|view| view.position);
        let eye = positions.sum::<DVec3>() / field.views.len() as f64 + DVec3::new(0.13, 0.07, -0.05);
        let indices: Vec<usize> = (0..self.views).collect();
        let views = ActiveViews::new(field, &indices, eye);
        let settings = RenderSettings {
            size: [self.size; 2],
            steps: Steps::new(self.steps, views.near_m() / 10.0, views.far_m(), self.refine),
            samples: 1,
            holes: HoleFill::Blank,
            background: BackgroundFill::Opaque,
            specular: SpecularMode::None,
            max_bounces: 0,
            acceleration: if self.pyramid { Acceleration::Pyramid } else { Acceleration::None },
            refinements: self.refinements,
        };
        let mut counters = Counters::default();
        let mut seconds = Vec::new();
        for turn in 0..TURNS {
            let start = Clock::start();
            for face in Face::CUBE {
                let [forward, _, down] = face.axes();
                let Ok(camera) = Camera::look_at(eye, eye + forward, -down, Lens::new(90.0)) else { continue };
                let picture = if self.plain { render_plainly } else { render }(&views, &camera, &settings, &Silent);
                if let (0, Ok(picture)) = (turn, black_box(picture)) {
                    counters = counters + picture.counters;
                }
            }
            seconds.push(start.seconds());
        }
        seconds.sort_by(f64::total_cmp);
        let rays = counters.primary_rays as f64;
        println!(
            "{:<52}  {:>9.3}  {:>11.2}  {:>12.2}",
            format!(
                "{}²; {}; {} steps + {}; {} views; {}{}",
                self.size,
                self.refinements(),
                self.steps,
                self.refine,
                self.views,
                if self.pyramid { "pyramid" } else { "every point" },
                if self.plain { "; plain" } else { "" }
            ),
            rays / seconds[TURNS / 2] / 1e6,
            counters.march_steps as f64 / rays,
            counters.refine_steps as f64 / rays,
        );
        seconds[TURNS / 2]
    }
}

/// Returns a light field of nine probes in a room with a post in the middle.
fn furnished() -> LightField {
    let coding = ColorCoding::Codes(ToneMap::default());
    let view = |at: u32| {
        let position = DVec3::new(f64::from(at % 3) - 1.0, 0.3 * f64::from(at % 2), f64::from(at / 3) - 2.5);
        let sight = |direction| room(position, direction, DVec3::new(4.0, 1.5, 3.0), 0.1);
        SyntheticProbe::new(position, SIZE).cube(coding, &sight)
    };
    LightField { views: (0..9).map(view).collect(), coding }
}
