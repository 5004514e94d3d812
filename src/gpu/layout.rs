//! What Rust and WGSL both know: structs of 32-bit words and constants. `shaders/shared/layout.wgsl` says the same
//! again, and a test compares the two by reflection.

/// Something that is a row of a buffer.
pub trait Words {
    /// Words that it takes.
    const WORDS: usize;

    /// Appends its words.
    fn put(&self, out: &mut Vec<u32>);
}

/// The words of some rows.
pub fn words_of<T: Words>(rows: &[T]) -> Vec<u32> {
    let mut out = Vec::with_capacity(rows.len() * T::WORDS);
    rows.iter().for_each(|row| row.put(&mut out));
    out
}

macro_rules! structs {
    ($($(#[$about:meta])* $name:ident { $($(#[$what:meta])* $field:ident),+ $(,)? })+) => {
        $(
            $(#[$about])*
            #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
            pub struct $name { $($(#[$what])* pub $field: u32),+ }

            impl Words for $name {
                const WORDS: usize = [$(stringify!($field)),+].len();

                fn put(&self, out: &mut Vec<u32>) {
                    out.extend_from_slice(&[$(self.$field),+]);
                }
            }
        )+
        /// Names of all structs with those of their members, each a word, in order.
        pub const STRUCTS: &[(&str, &[&str])] = &[$((stringify!($name), &[$(stringify!($field)),+])),+];
    };
}

macro_rules! constants {
    ($($(#[$about:meta])* $name:ident = $value:expr;)+) => {
        $($(#[$about])* pub const $name: u32 = $value;)+
        /// Names and values of all constants.
        pub const CONSTANTS: &[(&str, u32)] = &[$((stringify!($name), $name)),+];
    };
}

structs! {
    /// A tile or a cell.
    Unit {
        /// First word of its picture.
        picture,
        /// Columns of pixels.
        width,
        /// Rows of pixels.
        height,
        /// Words from row to row: of codes, two in a word, `width.div_ceil(2)`; of bytes `width`, of halves twice that.
        stride,
        /// W of its stream; 0 where each frame is whole, so that any can follow any.
        window,
        /// `DomainKind` of its functions, with the two numbers of the domain.
        domain,
        /// Logarithm at near.
        base,
        /// Codes for each unit of the logarithm.
        scale,
    }

    /// A chunk that is on the device.
    Chunk {
        /// Its first row in the table of records.
        first_record,
        /// Its rows.
        record_count,
        /// Colour: the byte of the stream at which its weights start.
        weights_at,
        /// Colour: weights.
        weight_count,
    }

    /// What a frame changes: a record of depth or material, or a keyframe of colour.
    Record {
        /// The frame, counted from the chunk's first.
        frame,
        /// Nodes: the word of the stream at which its header starts. Keyframes: the byte of the first sample or block.
        at,
        /// Boxes: the first in the table of boxes.
        first,
        /// Boxes: their number.
        count,
        /// Invocations that it takes; of a keyframe, as many as the blend that it begins.
        work,
        /// Keyframes: how they are coded.
        coding,
    }

    /// A rectangle of values of one record.
    BoxRow {
        /// Left column in the unit.
        x,
        /// Top row.
        y,
        /// Columns.
        width,
        /// Rows.
        height,
        /// The byte of the stream at which its values start.
        at,
        /// How it is coded.
        coding,
        /// Invocations that the record's boxes take, up to this one and with it.
        end,
    }

    /// A unit that is to be decoded.
    Item {
        /// Its number.
        unit,
        /// Where its chunk is in the table of chunks.
        chunk,
        /// Colour: where the cell's next chunk is, where it is needed.
        next,
        /// The frame that is wanted, counted from the chunk's first.
        frame,
        /// What tells the chunk from all others, never 0.
        key,
    }

    /// What a unit's picture shows.
    State {
        /// The key of the chunk; 0 for nothing.
        key,
        /// The frame; of colour, the keyframe.
        frame,
        /// Colour: the weight.
        weight,
    }

    /// Work on one unit.
    Job {
        /// The unit.
        unit,
        /// Invocations of all jobs up to this one and with it.
        end,
        /// The record; of colour, the first keyframe's record.
        record,
        /// Colour: the second keyframe's record.
        next,
        /// Colour: the weight.
        weight,
    }

    /// The size of the dispatch that follows, in workgroups.
    Dispatch {
        /// Along x.
        x,
        /// Along y.
        y,
        /// Along z.
        z,
    }

    /// Texels whose inverse depths are written.
    DepthJob {
        /// First word of the picture of the tile that they lie in; [`NONE`]: they become all alike.
        picture,
        /// Its words from row to row.
        stride,
        /// The first column of the tile.
        left,
        /// The first row of the tile.
        top,
        /// Columns.
        width,
        /// Where the inverse depths of codes start among the tables; without a picture, what the texels become.
        table,
        /// Where there is what the first texel is multiplied by; [`NONE`]: nothing is.
        stretch,
        /// Words from row to row of that.
        stretch_pitch,
        /// Word of the planes that the first texel lies in.
        place,
        /// Words from row to row of these.
        pitch,
        /// Invocations of all jobs up to this one and with it.
        end,
    }

    /// Squares of a level of a pyramid that are written.
    SquareJob {
        /// First word of the level below, or of the texels.
        below,
        /// Its words from row to row.
        below_pitch,
        /// Its columns.
        below_width,
        /// Its rows.
        below_height,
        /// The first column.
        left,
        /// The first row.
        top,
        /// Columns.
        width,
        /// First word of the level.
        place,
        /// Its words from row to row.
        pitch,
        /// The greatest that is written, as bits.
        most,
        /// Invocations of all jobs up to this one and with it.
        end,
    }
}

/// Words before the rows of a list: of `Items` and of all sorts of jobs.
pub const LIST_HEAD_WORDS: usize = 2;

constants! {
    /// No row.
    NONE = u32::MAX;
    /// Invocations of a workgroup of a decoding kernel.
    WORKGROUP = 64;
    /// Invocations of the one workgroup of a planning kernel.
    PLAN_WORKGROUP = 256;
    /// Most workgroups along one direction.
    MAX_GROUPS = 65_535;
    /// Words of the header of a frame of nodes.
    NODE_HEADER_WORDS = 12;
    /// Levels of nodes.
    LEVELS = 9;
    /// A box of values.
    BOX_VALUES = 0;
    /// A box of one value.
    BOX_CONSTANT = 1;
    /// A box of blocks.
    BOX_BLOCKS = 2;
    /// A keyframe of samples.
    KEYFRAME_SAMPLES = 0;
    /// A keyframe of blocks.
    KEYFRAME_BLOCKS = 1;
    /// Functions in log codes.
    DOMAIN_LOG = 0;
    /// Functions in depth.
    DOMAIN_LINEAR = 1;
    /// Functions in inverse depth.
    DOMAIN_INVERSE = 2;
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use wgpu::naga;

    use super::*;
    use crate::depth::domain::DomainKind;
    use crate::depth::runtime;
    use crate::gpu::kernels::{KERNELS, Kernel};

    fn module(kernel: &Kernel) -> naga::Module {
        naga::front::wgsl::parse_str(&kernel.source())
            .unwrap_or_else(|error| panic!("{}: {}", kernel.name, error.emit_to_string(&kernel.source())))
    }

    #[test]
    fn structs_have_the_members_and_offsets_that_wgsl_says() {
        let mut seen = BTreeMap::new();
        for kernel in KERNELS {
            let module = module(kernel);
            for (_, found) in module.types.iter() {
                let (Some(name), naga::TypeInner::Struct { members, span }) = (&found.name, &found.inner) else {
                    continue;
                };
                let Some((_, fields)) = STRUCTS.iter().find(|(known, _)| known == name) else { continue };
                let wgsl: Vec<_> = members.iter().map(|m| (m.name.clone().unwrap(), m.offset)).collect();
                let rust: Vec<_> = fields.iter().enumerate().map(|(at, f)| ((*f).to_owned(), 4 * at as u32)).collect();
                assert_eq!(wgsl, rust, "{name} of {}", kernel.name);
                assert_eq!(*span as usize, 4 * fields.len(), "{name}");
                let word =
                    |m: &naga::StructMember| module.types[m.ty].inner == naga::TypeInner::Scalar(naga::Scalar::U32);
                assert!(members.iter().all(word), "{name} has members that are no u32");
                seen.insert(name.clone(), ());
            }
        }
        assert_eq!(seen.len(), STRUCTS.len(), "structs that no kernel knows; known: {seen:?}");
    }

    #[test]
    fn constants_are_those_of_wgsl() {
        let mut seen = BTreeMap::new();
        for kernel in KERNELS {
            let module = module(kernel);
            for (_, found) in module.constants.iter() {
                let Some((name, value)) = CONSTANTS.iter().find(|(name, _)| found.name.as_deref() == Some(name)) else {
                    continue;
                };
                let literal = &module.global_expressions[found.init];
                let is = matches!(literal, naga::Expression::Literal(naga::Literal::U32(found)) if found == value);
                assert!(is, "{name} is {value}, in {} it is {literal:?}", kernel.name);
                seen.insert(*name, ());
            }
        }
        assert_eq!(seen.len(), CONSTANTS.len(), "constants that no kernel knows; known: {seen:?}");
    }

    #[test]
    fn constants_are_those_of_the_format() {
        assert_eq!([DOMAIN_LOG, DOMAIN_LINEAR, DOMAIN_INVERSE], DomainKind::ALL.map(|kind| kind as u32));
        assert_eq!(LEVELS as usize, runtime::LEVELS);
        assert_eq!(NODE_HEADER_WORDS as usize * 4, runtime::HEADER_BYTES);
    }

    #[test]
    fn kernels_are_what_their_rows_say() {
        for kernel in KERNELS {
            let module = module(kernel);
            let flags = naga::valid::ValidationFlags::all();
            // Nothing that a browser does not have.
            let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|error| panic!("{}: {error:?}", kernel.name));
            let entry = module.entry_points.iter().find(|entry| entry.name == kernel.entry);
            let entry = entry.unwrap_or_else(|| panic!("{} has no {}", kernel.name, kernel.entry));
            assert_eq!(entry.workgroup_size.iter().product::<u32>(), kernel.workgroup, "{}", kernel.name);
            let buffers = kernel.bindings.iter().filter(|binding| !binding.is_texture()).count();
            assert!(kernel.workgroup <= 256 && buffers <= 8, "{}", kernel.name);
            let mut bound: Vec<_> = module
                .global_variables
                .iter()
                .filter_map(|(_, variable)| {
                    let written = match variable.space {
                        naga::AddressSpace::Storage { access } => access.contains(naga::StorageAccess::STORE),
                        // A texture.
                        naga::AddressSpace::Handle => false,
                        _ => return None,
                    };
                    Some((variable.binding?.binding, variable.name.clone().unwrap_or_default(), written))
                })
                .collect();
            bound.sort();
            let rows = kernel.bindings.iter().enumerate();
            let rows: Vec<_> = rows.map(|(at, b)| (at as u32, b.name().to_owned(), b.is_written())).collect();
            assert_eq!(bound, rows, "bindings of {}", kernel.name);
            // What is rendered is measured in decibels; what is decoded is right to the bit.
            let renders = kernel.files.iter().any(|file| file.path.starts_with("march/"));
            for (_, found) in module.types.iter().filter(|_| !renders) {
                let scalar = found.inner.scalar_kind();
                assert!(scalar != Some(naga::ScalarKind::Float), "{} has a float", kernel.name);
            }
        }
    }
}
