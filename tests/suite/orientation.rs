//! Letters on the six walls of a room read left to right after `init`, `encode` and `render`, in every convention of images.
//!
//! Images are written from the conventions of formats/manifest.md 1, in code of their own.

use std::path::Path;

use codec::image::Plane;
use footage::image_files::{exr as ours, png};
use tempfile::TempDir;

use crate::commands::fine;

type Vector = [f64; 3];

/// Side of an image of a face in pixels: 8 cells of 8 pixels.
const SIDE: u32 = 64;

/// A wall with its letter, seen by a camera: forward, right and down.
struct Wall {
    letter: [&'static str; 8],
    axes: [Vector; 3],
}

const X: Vector = [1.0, 0.0, 0.0];
const Y: Vector = [0.0, 1.0, 0.0];
const Z: Vector = [0.0, 0.0, 1.0];
const LEFT: Vector = [-1.0, 0.0, 0.0];
const DOWN: Vector = [0.0, -1.0, 0.0];
const AHEAD: Vector = [0.0, 0.0, -1.0];

/// Letters that no mirroring or turning maps to themselves or each other.
const WALLS: [Wall; 6] = [
    Wall {
        letter: ["........", ".#####..", ".#......", ".####...", ".#......", ".#......", ".#......", "........"],
        axes: [AHEAD, X, DOWN],
    },
    Wall {
        letter: ["........", ".####...", ".#..#...", ".####...", ".#.#....", ".#..#...", ".#...#..", "........"],
        axes: [X, Z, DOWN],
    },
    Wall {
        letter: ["........", ".#......", ".#......", ".#......", ".#......", ".#......", ".#####..", "........"],
        axes: [Z, LEFT, DOWN],
    },
    Wall {
        letter: ["........", ".#####..", "....#...", "....#...", "....#...", ".#..#...", "..##....", "........"],
        axes: [LEFT, AHEAD, DOWN],
    },
    Wall {
        letter: ["........", ".####...", ".#...#..", ".####...", ".#......", ".#......", ".#......", "........"],
        axes: [Y, X, AHEAD],
    },
    Wall {
        letter: ["........", "..####..", ".#......", ".#......", ".#..##..", ".#...#..", "..####..", "........"],
        axes: [DOWN, X, Z],
    },
];

fn dot(one: Vector, other: Vector) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

/// Returns the code of the wall that a direction meets.
fn seen(direction: Vector) -> [u8; 3] {
    let wall = WALLS.iter().max_by(|one, other| dot(one.axes[0], direction).total_cmp(&dot(other.axes[0], direction)));
    let Wall { letter, axes: [forward, right, down] } = wall.unwrap();
    let cell = |axis: &Vector| {
        let at = dot(*axis, direction) / dot(*forward, direction);
        (((at + 1.0) * 4.0).floor().clamp(0.0, 7.0)) as usize
    };
    if letter[cell(down)].as_bytes()[cell(right)] == b'#' { [230; 3] } else { [40; 3] }
}

/// Returns the direction of a place in an image, −1 to 1 to the right and down.
fn along([forward, right, down]: [Vector; 3], u: f64, v: f64) -> Vector {
    [0, 1, 2].map(|at| forward[at] + u * right[at] + v * down[at])
}

/// Returns the picture of a camera or face with these axes.
fn picture(axes: [Vector; 3]) -> Plane<[u8; 3]> {
    let place = |at: u32| 2.0 * (f64::from(at) + 0.5) / f64::from(SIDE) - 1.0;
    Plane::from_fn(SIDE, SIDE, |x, y| seen(along(axes, place(x), place(y))))
}

/// Axes of the faces px, nx, py, ny, pz and nz of OpenGL.
const GL_FACES: [[Vector; 3]; 6] =
    [[X, AHEAD, DOWN], [LEFT, Z, DOWN], [Y, X, Z], [DOWN, X, AHEAD], [Z, X, DOWN], [AHEAD, LEFT, DOWN]];

/// Writes colour, and depth of the same size: everything is 2 m away.
fn write(folder: &Path, name: &str, picture: &Plane<[u8; 3]>) {
    let path = |kind: &str, ending: &str| folder.join(name.replace("{kind}", kind)).with_extension(ending);
    std::fs::create_dir_all(path("color", "png").parent().unwrap()).unwrap();
    png::write_color8(&path("color", "png"), picture).unwrap();
    ours::write_depth(&path("depth", "exr"), &picture.map(|_| 2.0)).unwrap();
}

/// Tiles six faces; each place has a column, a row, and whether the face is turned by 180 degrees.
fn tiled([columns, rows]: [u32; 2], places: [(u32, u32, bool); 6]) -> Plane<[u8; 3]> {
    let faces = GL_FACES.map(picture);
    Plane::from_fn(columns * SIDE, rows * SIDE, |x, y| {
        let at = places.iter().position(|(column, row, _)| (x / SIDE, y / SIDE) == (*column, *row));
        let (x, y) = (x % SIDE, y % SIDE);
        at.map_or([0; 3], |at| match places[at].2 {
            true => faces[at].get(SIDE - 1 - x, SIDE - 1 - y),
            false => faces[at].get(x, y),
        })
    })
}

fn panorama() -> Plane<[u8; 3]> {
    let (width, height) = (8 * SIDE, 4 * SIDE);
    Plane::from_fn(width, height, |x, y| {
        let longitude = (2.0 * (f64::from(x) + 0.5) / f64::from(width) - 1.0) * std::f64::consts::PI;
        let latitude = (0.5 - (f64::from(y) + 0.5) / f64::from(height)) * std::f64::consts::PI;
        seen([longitude.sin() * latitude.cos(), latitude.sin(), -longitude.cos() * latitude.cos()])
    })
}

/// Encodes the footage in a folder, renders each of the first walls, and compares the middle of each cell with its letter.
fn assert_reads(folder: &TempDir, init: &str, walls: usize) {
    fine(&format!("init in {init}"), folder.path());
    let manifest = std::fs::read_to_string(folder.path().join("in/lightfield.json")).unwrap();
    fine("encode in -o film.lfold --quiet", folder.path());
    for (at, Wall { letter, axes: [forward, _, down] }) in WALLS.iter().enumerate().take(walls) {
        let words = |vector: Vector| vector.map(|value| value.to_string()).join(",");
        let up = down.map(|value| -value);
        let line = format!(
            "render film.lfold --eye 0,0,0 --look-at={} --up={} --fov 90 --size {SIDE} -o view.png",
            words(*forward),
            words(up)
        );
        fine(&line, folder.path());
        let view = image::open(folder.path().join("view.png")).unwrap().into_rgb8();
        let found = [0, 1, 2, 3, 4, 5, 6, 7].map(|row| {
            let code = |column: u32| view.get_pixel(8 * column + 4, 8 * row + 4).0[0];
            (0..8).map(|column| if code(column) > 135 { '#' } else { '.' }).collect::<String>()
        });
        assert_eq!(found, letter.map(str::to_owned), "wall {at} of {init} {manifest}");
    }
}

#[test]
fn letters_read_in_six_files_of_opengl_and_of_cameras() {
    let folder = TempDir::new().unwrap();
    for (name, axes) in ["px", "nx", "py", "ny", "pz", "nz"].iter().zip(GL_FACES) {
        write(folder.path(), &format!("in/{{kind}}_{name}.0001.x"), &picture(axes));
    }
    assert_reads(&folder, "", 6);
    let folder = TempDir::new().unwrap();
    for (name, wall) in ["front", "right", "back", "left", "top", "bottom"].iter().zip(&WALLS) {
        write(folder.path(), &format!("in/{name}/{{kind}}.0001.x"), &picture(wall.axes));
    }
    assert_reads(&folder, "", 6);
}

#[test]
fn letters_read_in_crosses_and_strips() {
    let row = [0, 1, 2, 3, 4, 5].map(|at| (at, 0, false));
    let column = [0, 1, 2, 3, 4, 5].map(|at| (0, at, false));
    let lying = [(2, 1, false), (0, 1, false), (1, 0, false), (1, 2, false), (1, 1, false), (3, 1, false)];
    let standing = [(2, 1, false), (0, 1, false), (1, 0, false), (1, 2, false), (1, 1, false), (1, 3, true)];
    for (size, places) in [([6, 1], row), ([1, 6], column), ([4, 3], lying), ([3, 4], standing)] {
        let folder = TempDir::new().unwrap();
        write(folder.path(), "in/{kind}.0001.x", &tiled(size, places));
        assert_reads(&folder, "", 6);
    }
}

#[test]
fn letters_read_in_panoramas_and_views() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), "in/{kind}.0001.x", &panorama());
    assert_reads(&folder, "", 6);
    // Both eyes are at one place here.
    let folder = TempDir::new().unwrap();
    let one = panorama();
    let both = Plane::from_fn(one.width(), 2 * one.height(), |x, y| one.get(x, y % one.height()));
    write(folder.path(), "in/{kind}.0001.x", &both);
    assert_reads(&folder, "", 6);
    let folder = TempDir::new().unwrap();
    write(folder.path(), "in/{kind}.0001.x", &picture(WALLS[0].axes));
    let cameras = "{\"camera_angle_x\": 1.5707963267948966, \"frames\": [{\"file_path\": \"color.0001.png\", \
                   \"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}";
    std::fs::write(folder.path().join("in/transforms.json"), cameras).unwrap();
    assert_reads(&folder, "", 1);
}

/// In a world whose Z is up, the front camera looks along +Y.
#[test]
fn letters_read_in_worlds_whose_z_is_up() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), "in/{kind}.0001.x", &picture(WALLS[0].axes));
    // Columns of the camera's axes in the world: right +X, up +Z, back −Y.
    let cameras = "{\"camera_angle_x\": 1.5707963267948966, \"frames\": [{\"file_path\": \"color.0001.png\", \
                   \"transform_matrix\": [[1,0,0,0],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]}]}";
    std::fs::write(folder.path().join("in/transforms.json"), cameras).unwrap();
    assert_reads(&folder, "--up z", 1);
}
