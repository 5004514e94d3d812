//! Renders a drawing as SVG and PNG with the backends of `plotters`.
//!
//! Coordinates of `plotters` are integers, so a drawing is rendered on a finer grid: tenths of a pixel in an SVG file,
//! whose view box is scaled accordingly, and half pixels in a PNG file, which are then averaged.

use std::path::{Path, PathBuf};

use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, FontTransform, RGBAColor, ShapeStyle, TextStyle};

use super::drawing::{Anchor, Direction, Drawing, Ink, Shape, Spot, Stroke, Text};
use super::font::{self, Weight};
use codec::error::{Error, Result};
use codec::image::plane::Plane;
use footage::files::write_whole;
use footage::image_files::png;

/// PNG pixels per pixel of a chart's drawing, in each direction.
const CHART_DENSITY: u32 = 2;
/// Grid steps per pixel of the drawing in an SVG file.
const SVG_STEPS: u32 = 10;
/// Grid steps per pixel of a PNG file.
const PNG_STEPS: u32 = 2;
/// Bound on coordinates. It exceeds those of any drawing and keeps sums far from overflow.
const FARTHEST: f64 = 1e6;

/// Font size for `plotters` per em in an SVG file.
const SVG_SIZE_PER_EM: f64 = 1.24;
/// Distance in ems from the position of a text down to its baseline in an SVG file of `plotters`.
const SVG_BASELINE_EM: f64 = 0.76;

/// Writes a drawing as `name.svg` and `name.png` into a folder. The bytes depend only on the drawing.
pub fn save(drawing: &Drawing, folder: &Path, name: &str) -> Result<[PathBuf; 2]> {
    let paths = ["svg", "png"].map(|ending| folder.join(format!("{name}.{ending}")));
    let svg = to_svg(drawing)?;
    write_whole(&paths[0], svg.as_bytes())?;
    let pixels = to_pixels(drawing, CHART_DENSITY)?;
    let mut bytes = Vec::new();
    png::encode_color8(&mut bytes, &pixels).map_err(|error| error.in_file(&paths[1]))?;
    write_whole(&paths[1], &bytes)?;
    Ok(paths)
}

/// Returns the text of the SVG file.
pub fn to_svg(drawing: &Drawing) -> Result<String> {
    let (width, height) = (drawing.width, drawing.height);
    let steps = [width * SVG_STEPS, height * SVG_STEPS];
    let mut drawn = String::new();
    let backend = SVGBackend::with_string(&mut drawn, (steps[0], steps[1]));
    draw(drawing, backend, SVG_STEPS, Pen::named_text)?;
    // The width and height are in pixels of the drawing; the view box is in grid steps.
    let body = drawn.split_once('\n').map_or("", |(_, body)| body);
    Ok(format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" xmlns=\"http://www.w3.org/2000/svg\" \
         role=\"img\" stroke-linejoin=\"round\" stroke-linecap=\"butt\">\n<title>{}</title>\n{body}",
        steps[0],
        steps[1],
        escape(&drawing.title),
        body = whole_font_sizes(body)
    ))
}

/// Rounds font sizes to whole grid steps: `plotters` divides them, which leaves some with 17 digits.
fn whole_font_sizes(svg: &str) -> String {
    const ATTRIBUTE: &str = " font-size=\"";
    let mut parts = svg.split(ATTRIBUTE);
    let mut whole = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (size, rest) = part.split_once('"').unwrap_or((part, ""));
        let size = size.parse::<f64>().map_or_else(|_| size.to_owned(), |size| size.round().to_string());
        whole.push_str(&format!("{ATTRIBUTE}{size}\"{rest}"));
    }
    whole
}

/// Renders a drawing with `density` pixels per pixel of the drawing in each direction. Returns sRGB codes.
pub fn to_pixels(drawing: &Drawing, density: u32) -> Result<Plane<[u8; 3]>> {
    let steps = density * PNG_STEPS;
    let (width, height) = (drawing.width * steps, drawing.height * steps);
    let mut fine = vec![255; width as usize * height as usize * 3];
    draw(drawing, BitMapBackend::with_buffer(&mut fine, (width, height)), steps, Pen::outlined_text)?;
    let code = |x: u32, y: u32, component: usize| u32::from(fine[(y * width + x) as usize * 3 + component]);
    Ok(Plane::from_fn(drawing.width * density, drawing.height * density, |x, y| {
        std::array::from_fn(|component| {
            let square = (0..PNG_STEPS * PNG_STEPS)
                .map(|at| code(x * PNG_STEPS + at % PNG_STEPS, y * PNG_STEPS + at / PNG_STEPS, component));
            ((square.sum::<u32>() + PNG_STEPS * PNG_STEPS / 2) / (PNG_STEPS * PNG_STEPS)) as u8
        })
    }))
}

/// Escapes the characters that have a meaning in XML and HTML. Control characters are replaced by spaces.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            control if control.is_control() => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}

/// Function by which a pen writes a text.
type Write<B> = fn(&mut Pen<B>, Spot, &Text) -> Result<()>;

fn draw<B: DrawingBackend>(drawing: &Drawing, backend: B, steps: u32, write: Write<B>) -> Result<()> {
    let mut pen = Pen { backend, steps: f64::from(steps), write };
    pen.rectangle([0.0, 0.0], [f64::from(drawing.width), f64::from(drawing.height)], Ink::WHITE)?;
    drawing.shapes.iter().try_for_each(|shape| pen.shape(shape))?;
    pen.backend.present().map_err(failed)
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::unsupported(format!("a chart cannot be drawn: {error}"))
}

struct Pen<B> {
    backend: B,
    steps: f64,
    write: Write<B>,
}

impl<B: DrawingBackend> Pen<B> {
    fn spot(&self, [x, y]: Spot) -> (i32, i32) {
        let step = |value: f64| (value.clamp(-FARTHEST, FARTHEST) * self.steps).round() as i32;
        (step(x), step(y))
    }

    fn shape(&mut self, shape: &Shape) -> Result<()> {
        match shape {
            Shape::Line { through, stroke } => self.line(through, stroke),
            Shape::Rectangle { from, to, ink } => self.rectangle(*from, *to, *ink),
            Shape::Polygon { corners, ink } => {
                let corners: Vec<_> = corners.iter().map(|corner| self.spot(*corner)).collect();
                self.backend.fill_polygon(corners, &color(*ink)).map_err(failed)
            }
            Shape::Disc { at, radius, ink } => {
                let radius = (radius * self.steps).round().max(1.0) as u32;
                self.backend.draw_circle(self.spot(*at), radius, &color(*ink), true).map_err(failed)
            }
            Shape::Text { at, text } => (self.write)(self, *at, text),
        }
    }

    fn rectangle(&mut self, from: Spot, to: Spot, ink: Ink) -> Result<()> {
        let (from, to) = (self.spot(from), self.spot(to));
        self.backend.draw_rect(from, to, &color(ink), true).map_err(failed)
    }

    fn line(&mut self, through: &[Spot], stroke: &Stroke) -> Result<()> {
        let mut places: Vec<_> = through.iter().map(|place| self.spot(*place)).collect();
        places.dedup();
        let stroke_width = (stroke.width * self.steps).round().max(1.0) as u32;
        let style = ShapeStyle { color: color(stroke.ink), filled: false, stroke_width };
        if places.len() < 2 { Ok(()) } else { self.backend.draw_path(places, &style).map_err(failed) }
    }

    /// Writes a text element that refers to the font by name.
    fn named_text(&mut self, [x, y]: Spot, text: &Text) -> Result<()> {
        let rise = text.em * SVG_BASELINE_EM;
        let (upper, transform) = match text.direction {
            Direction::Across => ([x, y - rise], FontTransform::None),
            Direction::Up => ([x - rise, y], FontTransform::Rotate270),
        };
        let h_pos = match text.anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let weight = if text.weight == Weight::Bold { FontStyle::Bold } else { FontStyle::Normal };
        let size = text.em * self.steps * SVG_SIZE_PER_EM;
        let font = FontDesc::new(FontFamily::Name(font::FAMILY), size, weight).transform(transform);
        let ink = color(text.ink);
        let style = TextStyle::from(font).color(&ink).pos(Pos::new(h_pos, VPos::Top));
        self.backend.draw_text(&text.text, &style, self.spot(upper)).map_err(failed)
    }

    /// Draws the glyphs of the embedded font.
    fn outlined_text(&mut self, at: Spot, text: &Text) -> Result<()> {
        let before = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => text.width() / 2.0,
            Anchor::End => text.width(),
        };
        let (x0, y0) = match text.direction {
            Direction::Across => self.spot([at[0] - before, at[1]]),
            Direction::Up => self.spot([at[0], at[1] + before]),
        };
        let (width, height) = self.backend.get_size();
        let backend = &mut self.backend;
        font::rasterise(&text.text, text.em * self.steps, text.weight, |[x, y], share| {
            let (x, y) = match text.direction {
                Direction::Across => (x0 + x, y0 + y),
                Direction::Up => (x0 + y, y0 - x),
            };
            let inside = x >= 0 && y >= 0 && x < width as i32 && y < height as i32;
            let ink = color(text.ink.with_alpha(text.ink.alpha * share)).to_backend_color();
            if inside { backend.draw_pixel((x, y), ink).map_err(failed) } else { Ok(()) }
        })
    }
}

fn color(ink: Ink) -> RGBAColor {
    let [red, green, blue] = ink.rgb;
    RGBAColor(red, green, blue, ink.alpha)
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::ReadLimits;

    fn specimen() -> Drawing {
        let mut drawing = Drawing::new(320, 160, "a <specimen> & more");
        let red = Stroke::solid(Ink::opaque([200, 30, 30]), 1.0);
        for (row, anchor) in [Anchor::Start, Anchor::Middle, Anchor::End].into_iter().enumerate() {
            let y = 30.0 + 40.0 * row as f64;
            drawing.line(&[[100.0, y], [300.0, y]], red);
            drawing.line(&[[200.0, y - 20.0], [200.0, y + 10.0]], red);
            drawing.text([200.0, y], Text::new("Egx 0.5 MB", 20.0).anchor(anchor));
        }
        drawing.line(&[[40.0, 10.0], [40.0, 150.0]], red);
        drawing.text([40.0, 80.0], Text::new("Egx <&> up", 16.0).bold().up().anchor(Anchor::Middle));
        drawing.line(&[[60.0, 10.0], [80.0, 60.0], [60.0, 110.0]], Stroke::dashed(Ink::BLACK, 1.5));
        drawing.disc([70.0, 130.0], 8.0, Ink::opaque([0, 114, 178]));
        drawing.polygon([[80.0, 130.0], [96.0, 138.0], [96.0, 122.0]].as_ref(), Ink::BLACK.with_alpha(0.5));
        drawing
    }

    #[test]
    fn both_files_are_written_and_are_the_same_on_every_run() {
        let folder = tempfile::tempdir().unwrap();
        let first = save(&specimen(), folder.path(), "specimen").unwrap();
        let bytes = first.clone().map(|path| std::fs::read(path).unwrap());
        save(&specimen(), folder.path(), "specimen").unwrap();
        assert_eq!(bytes, first.clone().map(|path| std::fs::read(path).unwrap()));
        assert_eq!(png::read_size(&first[1], &ReadLimits::default()).unwrap(), (640, 320));

        let svg = String::from_utf8(bytes[0].clone()).unwrap();
        assert!(svg.starts_with("<svg width=\"320\" height=\"160\" viewBox=\"0 0 3200 1600\""), "{svg}");
        assert!(svg.contains("<title>a &lt;specimen&gt; &amp; more</title>"), "{svg}");
        assert!(svg.contains("Egx &lt;&amp;&gt; up") && svg.trim_end().ends_with("</svg>"), "{svg}");
    }

    /// Returns the bounding box (left, top, right, bottom) of the nearly black pixels of a region.
    fn dark(pixels: &Plane<[u8; 3]>, [x0, y0]: [u32; 2], [x1, y1]: [u32; 2]) -> Option<[u32; 4]> {
        let found = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
        found.filter(|&(x, y)| pixels.get(x, y).iter().all(|&code| code < 100)).fold(None, |bounds, (x, y)| {
            let [left, top, right, bottom] = bounds.unwrap_or([x, y, x, y]);
            Some([left.min(x), top.min(y), right.max(x), bottom.max(y)])
        })
    }

    #[test]
    fn text_stands_on_its_baseline_and_has_the_width_that_was_asked_for() {
        let mut drawing = Drawing::new(300, 60, "");
        drawing.text([150.0, 40.0], Text::new("HEHEHEHEH", 20.0).anchor(Anchor::Middle));
        let pixels = to_pixels(&drawing, 2).unwrap();
        let [left, top, right, bottom] = dark(&pixels, [0, 0], [600, 120]).unwrap();
        let width = Text::new("HEHEHEHEH", 20.0).width() * 2.0;
        assert!((f64::from(right - left) - width).abs() < 10.0, "{left} {right} {width}");
        assert!((f64::from(left + right) / 2.0 - 300.0).abs() < 2.0, "{left} {right}");
        assert!(bottom.abs_diff(80) <= 2, "{bottom}");
        assert!((f64::from(bottom - top) - 40.0 * font::CAP_PER_EM).abs() < 3.0, "{top} {bottom}");
    }

    #[test]
    fn text_that_runs_up_stands_on_a_vertical_line() {
        let mut drawing = Drawing::new(60, 300, "");
        drawing.text([40.0, 150.0], Text::new("HEHEHEHEH", 20.0).up().anchor(Anchor::Middle));
        let [_, top, right, bottom] = dark(&to_pixels(&drawing, 2).unwrap(), [0, 0], [120, 600]).unwrap();
        assert!(right.abs_diff(80) <= 2, "{right}");
        assert!((f64::from(top + bottom) / 2.0 - 300.0).abs() < 4.0, "{top} {bottom}");
    }

    #[test]
    #[ignore = "writes a specimen to look at"]
    fn write_specimen() {
        save(&specimen(), &std::env::temp_dir(), "specimen").unwrap();
    }
}
