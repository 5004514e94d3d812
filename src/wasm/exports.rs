//! The functions that JavaScript calls. viewer/src/decoder/decoder.ts and viewer/src/cpu/field.ts are the other side.
//!
//! The page writes the input of a call into the memory that [`input`] returns, calls a function, and reads its output at
//! [`output_pointer`], which is valid until the next call. A negative result is an error, whose sentence is the output. A panic
//! stops the instance, and the page starts another.

// SAFETY: `no_mangle` is all that is unsafe here. No other function of the module has one of these names, and no function
// reads or writes through a pointer.
#![allow(unsafe_code)]

use std::cell::RefCell;

use crate::chunk_decoder::{Frames, Shown};
use crate::coding_map::CodingMaps;
use crate::numbers::Numbers;
use crate::picture::{FaceArea, PictureColors, PictureField, PictureSettings};
use crate::present::{Presentation, present};
use crate::requests::{StraightTables, units_in_sight};
use crate::slots::Slots;
use crate::stream::{ChunkArea, Storage, Stream};
use crate::{chunk_decoder, device};
use codec::container::{ChunkPlace, Payload};
use codec::depth::DepthRange;
use codec::depth::domain::LOG2_TABLE;
use codec::error::{Error, Result};
use codec::image::{DepthKind, ToneCurve, ToneMap, Transfer};
use render::march::{Rendered, Steps};
use render::rendered_image::HoleFill;
use render::views::{ColorCoding, InverseDepth, UnitGrid};

/// Results of functions that fail.
const INVALID: i32 = -1;
const UNSUPPORTED: i32 = -2;
const FAILED: i32 = -3;

enum Output {
    Bytes(Vec<u8>),
    Words(Vec<u32>),
    /// Address and bytes of the picture of a chunk's decoder.
    Picture(*const u8, usize),
}

struct State {
    input: Vec<u8>,
    output: Output,
    streams: Slots<Stream>,
    chunks: Slots<OpenChunk>,
    /// None before [`open_field`].
    field: Option<PictureField>,
    straight: StraightTables,
}

struct OpenChunk {
    frame_count: u32,
    frames: Box<dyn Frames>,
}

thread_local! {
    static STATE: RefCell<State> = const {
        RefCell::new(State {
            input: Vec::new(),
            output: Output::Bytes(Vec::new()),
            streams: Slots::new(),
            chunks: Slots::new(),
            field: None,
            straight: StraightTables::new(),
        })
    };
}

fn with_state<T>(run: impl FnOnce(&mut State) -> T) -> T {
    STATE.with(|state| run(&mut state.borrow_mut()))
}

/// Runs a fallible function; turns an error into its code and its sentence.
fn call(run: impl FnOnce(&mut State) -> Result<i32>) -> i32 {
    with_state(|state| match run(state) {
        Ok(result) => result,
        Err(error) => {
            state.output = Output::Bytes(error.to_string().into_bytes());
            match error {
                Error::Invalid { .. } => INVALID,
                Error::Unsupported { .. } => UNSUPPORTED,
                _ => FAILED,
            }
        }
    })
}

impl State {
    fn take_input(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.input)
    }

    /// Returns the payload of the stored bytes in the input.
    fn payload(&mut self, storage: Storage) -> Result<Payload> {
        storage.payload(self.take_input())
    }

    fn field(&mut self) -> Result<&mut PictureField> {
        self.field.as_mut().ok_or_else(|| Error::Usage("there is no light field".into()))
    }

    fn open_chunk(&mut self, area: ChunkArea, frames: Box<dyn Frames>) -> i32 {
        self.chunks.insert(OpenChunk { frame_count: area.frames, frames })
    }
}

fn area_of(unit: u32, frames: u32, is_last: u32) -> ChunkArea {
    let place = if is_last == 0 { ChunkPlace::Inner } else { ChunkPlace::Last };
    ChunkArea { unit, frames, place }
}

/// Returns memory for the input of the next call.
#[unsafe(no_mangle)]
pub extern "C" fn input(bytes: usize) -> *mut u8 {
    with_state(|state| {
        state.input = vec![0; bytes];
        state.input.as_mut_ptr()
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn output_pointer() -> *const u8 {
    with_state(|state| match &state.output {
        Output::Bytes(bytes) => bytes.as_ptr(),
        Output::Words(words) => words.as_ptr().cast(),
        Output::Picture(pointer, _) => *pointer,
    })
}

/// Returns the number of bytes of the output.
#[unsafe(no_mangle)]
pub extern "C" fn output_bytes() -> usize {
    with_state(|state| match &state.output {
        Output::Bytes(bytes) => bytes.len(),
        Output::Words(words) => size_of_val(words.as_slice()),
        Output::Picture(_, bytes) => *bytes,
    })
}

/// Returns the CRC-32 of the input, which stays.
#[unsafe(no_mangle)]
pub extern "C" fn crc32() -> u32 {
    with_state(|state| crc32fast::hash(&state.input))
}

/// Decompresses the input.
#[unsafe(no_mangle)]
pub extern "C" fn decompress(method: u32, raw_bytes: u32) -> i32 {
    call(|state| {
        state.output = Output::Bytes(state.payload(Storage { method, raw_bytes })?.into_vec());
        Ok(0)
    })
}

/// Reads the codec of four characters and the codec header in the input. Returns the number of the stream; the output is the
/// header as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn open_stream(kind: u32, face: u32, width: u32, height: u32, unit_width: u32, unit_height: u32) -> i32 {
    call(|state| {
        let bytes = state.take_input();
        let stream = Stream::read(&bytes, [kind, face], [width, height, unit_width, unit_height])?;
        state.output = Output::Bytes(stream.json().into_bytes());
        Ok(state.streams.insert(stream))
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn close_stream(stream: u32) {
    with_state(|state| state.streams.remove(stream));
}

/// Parses the chunk whose stored bytes are the input. Returns its number.
#[unsafe(no_mangle)]
pub extern "C" fn open_chunk(stream: u32, unit: u32, frames: u32, is_last: u32, method: u32, raw_bytes: u32) -> i32 {
    call(|state| {
        let payload = state.payload(Storage { method, raw_bytes })?;
        let area = area_of(unit, frames, is_last);
        let decoder = chunk_decoder::open(state.streams.get(stream)?, payload, area)?;
        Ok(state.open_chunk(area, decoder))
    })
}

/// As [`open_chunk`]; the frames are maps of how pixels are coded.
#[unsafe(no_mangle)]
pub extern "C" fn open_codings(stream: u32, unit: u32, frames: u32, is_last: u32, method: u32, raw_bytes: u32) -> i32 {
    call(|state| {
        let payload = state.payload(Storage { method, raw_bytes })?;
        let area = area_of(unit, frames, is_last);
        let maps = CodingMaps::open(state.streams.get(stream)?, payload, area)?;
        Ok(state.open_chunk(area, Box::new(maps)))
    })
}

/// Parses the unit's next chunk, whose stored bytes are the input, for frames that blend into it.
#[unsafe(no_mangle)]
pub extern "C" fn set_next(chunk: u32, frames: u32, is_last: u32, method: u32, raw_bytes: u32) -> i32 {
    call(|state| {
        let payload = state.payload(Storage { method, raw_bytes })?;
        state.chunks.get_mut(chunk)?.frames.set_next(payload, area_of(0, frames, is_last))?;
        Ok(0)
    })
}

/// Decodes a frame, counted from the chunk's first, into the output. Returns 1 if it needs [`set_next`] first.
#[unsafe(no_mangle)]
pub extern "C" fn show_frame(chunk: u32, frame: u32) -> i32 {
    call(|state| {
        let OpenChunk { frame_count, frames } = state.chunks.get_mut(chunk)?;
        if frame >= *frame_count {
            return Err(Error::Usage(format!("frame {frame} of a chunk of {frame_count}")));
        }
        if frames.show(frame)? == Shown::NeedsNext {
            return Ok(1);
        }
        let (pointer, bytes) = frames.picture();
        state.output = Output::Picture(pointer, bytes);
        Ok(0)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn close_chunk(chunk: u32) {
    with_state(|state| {
        state.output = Output::Bytes(Vec::new());
        state.chunks.remove(chunk);
    });
}

/// Checks the chunk whose stored bytes are the input; the output is its form for graphics devices ([`device::prepared`]).
#[unsafe(no_mangle)]
pub extern "C" fn prepare(stream: u32, unit: u32, frames: u32, is_last: u32, method: u32, raw_bytes: u32) -> i32 {
    call(|state| {
        let payload = state.payload(Storage { method, raw_bytes })?;
        let words = device::prepared(state.streams.get(stream)?, payload, area_of(unit, frames, is_last))?;
        state.output = Output::Words(words);
        Ok(0)
    })
}

/// Outputs the tables of the streams of the transform codec whose numbers are the input, four bytes each.
#[unsafe(no_mangle)]
pub extern "C" fn transform_tables() -> i32 {
    call(|state| {
        let numbers = state.take_input();
        let streams = numbers.as_chunks().0.iter().map(|number| state.streams.get(u32::from_le_bytes(*number)));
        let streams = streams.collect::<Result<Vec<&Stream>>>()?;
        state.output = Output::Words(device::transform_tables(&streams));
        Ok(0)
    })
}

/// Outputs the table of logarithms (arithmetic.md 7).
#[unsafe(no_mangle)]
pub extern "C" fn log2_table() {
    with_state(|state| state.output = Output::Words(LOG2_TABLE.to_vec()));
}

/// Outputs the inverse depth of each code of a range, in 1/m, as floats.
#[unsafe(no_mangle)]
pub extern "C" fn inverse_depths(near_m: f32, far_m: f32) -> i32 {
    call(|state| {
        let table = InverseDepth::new(DepthRange::new(near_m, far_m)?, DepthKind::Planar);
        state.output = Output::Words(table.of_code.into_iter().map(f32::to_bits).collect());
        Ok(0)
    })
}

/// Outputs the steps of rays: the logarithm of the ratio of adjacent distances, the uncertainty of hits, and the distances in
/// metres, as floats.
#[unsafe(no_mangle)]
pub extern "C" fn ray_steps(count: u32, near_m: f32, far_m: f32, refine: u32) {
    with_state(|state| {
        let steps = Steps::new(count, near_m, far_m, refine);
        let numbers = [steps.log_step(), steps.uncertainty()].into_iter().chain(steps.distances_m.iter().copied());
        state.output = Output::Words(numbers.map(f32::to_bits).collect());
    });
}

/// Outputs the codes of pictures; [`present`] describes input and output. `tone` is 0 for none, 1 for Reinhard's, 2 for a
/// filmic one.
#[unsafe(no_mangle)]
pub extern "C" fn present_pictures(tone: u32, marks_holes: u32, is_anaglyph: u32) -> i32 {
    call(|state| {
        let tone = match tone {
            0 => ToneCurve::None,
            1 => ToneCurve::Reinhard,
            2 => ToneCurve::Filmic,
            other => return Err(Error::Usage(format!("there is no tone curve {other}"))),
        };
        let how = Presentation { tone, marks_holes: marks_holes != 0, is_anaglyph: is_anaglyph != 0 };
        let input = state.take_input();
        state.output = Output::Bytes(present(&input, how)?);
        Ok(0)
    })
}

/// Outputs which units of a face cameras see; [`units_in_sight`] describes input and output.
#[unsafe(no_mangle)]
pub extern "C" fn visible_units(face: u32, width: u32, height: u32, unit_width: u32, unit_height: u32) -> i32 {
    call(|state| {
        let input = state.take_input();
        let grid = UnitGrid { size: [width, height], unit: [unit_width, unit_height] };
        state.output = Output::Bytes(units_in_sight(Numbers::new(&input), face, grid)?);
        Ok(0)
    })
}

/// Outputs straight colours and alpha; [`StraightTables::texels`] describes input and output.
#[unsafe(no_mangle)]
pub extern "C" fn straight_texels() -> i32 {
    call(|state| {
        let input = state.take_input();
        state.output = Output::Bytes(state.straight.texels(&input)?);
        Ok(0)
    })
}

/// Starts a light field without views. `coding` is that of its colours: 0 for halves of light, 1 for linear codes, 2 for sRGB
/// codes.
#[unsafe(no_mangle)]
pub extern "C" fn open_field(coding: u32, exposure_ev: f32) -> i32 {
    call(|state| {
        let coding = match coding {
            0 => ColorCoding::Light,
            1 => ColorCoding::Codes(ToneMap { transfer: Transfer::Linear, exposure_ev }),
            2 => ColorCoding::Codes(ToneMap { transfer: Transfer::Srgb, exposure_ev }),
            other => return Err(Error::Usage(format!("there is no coding of colors {other}"))),
        };
        state.field = Some(PictureField::new(coding));
        Ok(0)
    })
}

/// Runs a function with the light field and the input.
fn with_field(run: impl FnOnce(&mut PictureField, &[u8]) -> Result<()>) -> i32 {
    call(|state| {
        let input = state.take_input();
        run(state.field()?, &input)?;
        Ok(0)
    })
}

/// Loads a view; [`PictureField::load`] describes the numbers in the input.
#[unsafe(no_mangle)]
pub extern "C" fn load_view(view: u32) -> i32 {
    with_field(|field, input| field.load(view, Numbers::new(input)))
}

#[unsafe(no_mangle)]
pub extern "C" fn unload_view(view: u32) -> i32 {
    with_field(|field, _| field.unload(view))
}

/// Writes the depth codes in the input; without an input the depths become unknown.
#[unsafe(no_mangle)]
pub extern "C" fn write_depth(view: u32, face: u32, left: u32, top: u32, width: u32, height: u32) -> i32 {
    let area = FaceArea { view, face, rect: [left, top, width, height] };
    with_field(|field, input| field.write_depth(area, input))
}

/// Writes the texels of colour in the input.
#[unsafe(no_mangle)]
pub extern "C" fn write_color(view: u32, face: u32, left: u32, top: u32, width: u32, height: u32) -> i32 {
    let area = FaceArea { view, face, rect: [left, top, width, height] };
    with_field(|field, input| field.write_color(area, input))
}

/// Writes the texels of material in the input.
#[unsafe(no_mangle)]
pub extern "C" fn write_material(view: u32, face: u32, left: u32, top: u32, width: u32, height: u32) -> i32 {
    let area = FaceArea { view, face, rect: [left, top, width, height] };
    with_field(|field, input| field.write_material(area, input))
}

/// Writes the texels of an overlay in the input.
#[unsafe(no_mangle)]
pub extern "C" fn write_overlay(view: u32, face: u32, left: u32, top: u32, width: u32, height: u32) -> i32 {
    let area = FaceArea { view, face, rect: [left, top, width, height] };
    with_field(|field, input| field.write_overlay(area, input))
}

/// Renders a picture; [`PictureField::render`] describes the numbers in the input. The output is linear RGB and alpha of each
/// pixel as floats, and the counters as integers.
#[unsafe(no_mangle)]
pub extern "C" fn render_picture(width: u32, height: u32, steps: u32, marks_holes: u32, shows_overlay: u32) -> i32 {
    call(|state| {
        let input = state.take_input();
        let field = state.field()?;
        let holes = if marks_holes == 0 { HoleFill::Behind } else { HoleFill::Nearest };
        let colors = if shows_overlay == 0 { PictureColors::Texels } else { PictureColors::Overlay };
        let settings = PictureSettings { size: [width, height], steps, holes, colors };
        state.output = Output::Words(words_of(&field.render(Numbers::new(&input), settings)?));
        Ok(0)
    })
}

fn words_of(Rendered { image, counters }: &Rendered) -> Vec<u32> {
    let pixels = image.color.data().iter().zip(image.alpha.data());
    let mut words: Vec<u32> =
        pixels.flat_map(|([r, g, b], alpha)| [r, g, b, alpha].map(|part| part.to_bits())).collect();
    let counts = [
        counters.primary_rays,
        counters.march_steps,
        counters.refine_steps,
        counters.secondary_rays,
        counters.normal_evals,
        counters.material_samples,
        counters.hole_rays,
        counters.background_rays,
    ];
    words.extend(counts.map(|count| u32::try_from(count).unwrap_or(u32::MAX)));
    words
}
