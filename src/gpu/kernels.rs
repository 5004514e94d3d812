//! The table of kernels: a row says which files of `shaders/` a kernel is put together from, and what it is given.

/// A file of `shaders/`.
#[derive(Debug, Clone, Copy)]
pub struct ShaderFile {
    /// Path below `shaders/`.
    pub path: &'static str,
    /// What is in it.
    pub text: &'static str,
}

/// A buffer or a texture that a kernel is given, at the place in group 0 that its place in the row says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Binding {
    /// A buffer that is only read; its name in WGSL.
    Read(&'static str),
    /// A buffer that is read and written; its name in WGSL.
    Write(&'static str),
    /// Layers of texels that are words; its name in WGSL.
    WordTexels(&'static str),
    /// Layers of texels that become floats and are never filtered; its name in WGSL.
    FloatTexels(&'static str),
}

impl Binding {
    /// Its name in WGSL.
    pub fn name(self) -> &'static str {
        match self {
            Binding::Read(name) | Binding::Write(name) => name,
            Binding::WordTexels(name) | Binding::FloatTexels(name) => name,
        }
    }

    /// Whether it is a texture.
    pub fn is_texture(self) -> bool {
        matches!(self, Binding::WordTexels(_) | Binding::FloatTexels(_))
    }

    /// Whether the kernel writes it.
    pub fn is_written(self) -> bool {
        matches!(self, Binding::Write(_))
    }
}

/// A kernel.
#[derive(Debug)]
pub struct Kernel {
    /// Its name, in reports too.
    pub name: &'static str,
    /// Its function in WGSL.
    pub entry: &'static str,
    /// Its files; the order does not matter to WGSL, it is that of reading.
    pub files: &'static [ShaderFile],
    /// Its buffers.
    pub bindings: &'static [Binding],
    /// Invocations of a workgroup, at most 256.
    pub workgroup: u32,
}

impl Kernel {
    /// The whole of its WGSL.
    pub fn source(&self) -> String {
        self.files.iter().map(|file| file.text).collect::<Vec<_>>().join("\n")
    }
}

macro_rules! file {
    ($path:literal) => {
        ShaderFile { path: $path, text: include_str!(concat!("../../shaders/", $path)) }
    };
}

use Binding::{FloatTexels, Read, WordTexels, Write};

const LAYOUT: ShaderFile = file!("shared/layout.wgsl");
const JOBS: ShaderFile = file!("shared/jobs.wgsl");

/// Nodes of the quadtree, in the runtime form: `DQPN`, `DQTR` and `DB4W`.
pub static NODES: Kernel = Kernel {
    name: "nodes",
    entry: "decode_nodes",
    files: &[
        LAYOUT,
        JOBS,
        file!("depth/domain.wgsl"),
        file!("depth/biquadratic.wgsl"),
        file!("depth/platelet.wgsl"),
        file!("depth/bc4w.wgsl"),
        file!("depth/runtime.wgsl"),
    ],
    bindings: &[Read("units"), Read("records"), Read("jobs"), Read("stream"), Read("log2_table"), Write("pictures")],
    workgroup: 64,
};

const BYTES: ShaderFile = file!("shared/bytes.wgsl");
const PLAN: ShaderFile = file!("shared/plan.wgsl");
const BLEND: ShaderFile = file!("color/blend.wgsl");

const SAMPLES_8: ShaderFile = file!("color/samples_8.wgsl");
const SAMPLES_HALF: ShaderFile = file!("color/samples_half.wgsl");
const CELLS_OF_SAMPLES: ShaderFile = file!("color/cells_of_samples.wgsl");
const CELLS_OF_BLOCKS: ShaderFile = file!("color/cells_of_blocks.wgsl");
const RECORDS: ShaderFile = file!("depth/records.wgsl");
const CODES: ShaderFile = file!("depth/texel_codes.wgsl");
const MATERIAL: ShaderFile = file!("depth/texel_material.wgsl");
const PIECES: ShaderFile = file!("depth/pieces.wgsl");
const BC1_BLOCKS: ShaderFile = file!("block/bc1.wgsl");
const BC4_BLOCKS: ShaderFile = file!("block/bc4.wgsl");
const BC5_BLOCKS: ShaderFile = file!("block/bc5.wgsl");
const BC6H_BLOCKS: ShaderFile = file!("block/bc6h.wgsl");
const BC7_BLOCKS: ShaderFile = file!("block/bc7.wgsl");
const BPTC: ShaderFile = file!("block/bptc.wgsl");

const BOX_BINDINGS: &[Binding] =
    &[Read("units"), Read("records"), Read("jobs"), Read("boxes"), Read("stream"), Write("pictures")];
const CELL_BINDINGS: &[Binding] = &[Read("units"), Read("records"), Read("jobs"), Read("stream"), Write("pictures")];

/// Boxes of depth codes: `DAAB`.
pub static BOXES_CODES: Kernel = Kernel {
    name: "boxes-codes",
    entry: "decode_codes",
    files: &[LAYOUT, JOBS, BYTES, RECORDS, file!("depth/boxes_of_values.wgsl"), CODES],
    bindings: BOX_BINDINGS,
    workgroup: 64,
};

/// Boxes of material: `MAAB`.
pub static BOXES_MATERIAL: Kernel = Kernel {
    name: "boxes-material",
    entry: "decode_material",
    files: &[LAYOUT, JOBS, BYTES, RECORDS, file!("depth/boxes_of_values.wgsl"), MATERIAL],
    bindings: BOX_BINDINGS,
    workgroup: 64,
};

/// Cells of 8-bit colour: `CCL8`.
pub static CELLS_8: Kernel = Kernel {
    name: "cells-8bit",
    entry: "decode_cells",
    files: &[LAYOUT, JOBS, BYTES, BLEND, SAMPLES_8, CELLS_OF_SAMPLES],
    bindings: CELL_BINDINGS,
    workgroup: 64,
};

/// Cells of half floats: `CCLH`.
pub static CELLS_HALF: Kernel = Kernel {
    name: "cells-half",
    entry: "decode_cells",
    files: &[LAYOUT, JOBS, BYTES, BLEND, SAMPLES_HALF, CELLS_OF_SAMPLES],
    bindings: CELL_BINDINGS,
    workgroup: 64,
};

/// Boxes of depth codes, pieces of them in BC5: `DAB5`.
pub static BOXES_BC5: Kernel = Kernel {
    name: "boxes-bc5",
    entry: "decode_codes",
    files: &[LAYOUT, JOBS, BYTES, RECORDS, PIECES, BC4_BLOCKS, BC5_BLOCKS, file!("depth/pieces_bc5.wgsl"), CODES],
    bindings: BOX_BINDINGS,
    workgroup: 64,
};

/// Boxes of material, pieces of them in BC1: `MAB1`.
pub static BOXES_BC1: Kernel = Kernel {
    name: "boxes-bc1",
    entry: "decode_material",
    files: &[LAYOUT, JOBS, BYTES, RECORDS, PIECES, BC1_BLOCKS, file!("depth/pieces_bc1.wgsl"), MATERIAL],
    bindings: BOX_BINDINGS,
    workgroup: 64,
};

/// Cells of 8-bit colour with keyframes in BC1: `CCB1`.
pub static CELLS_BC1: Kernel = Kernel {
    name: "cells-bc1",
    entry: "decode_blocks",
    files: &[LAYOUT, JOBS, BYTES, BLEND, BC1_BLOCKS, SAMPLES_8, file!("color/keyframes_bc1.wgsl"), CELLS_OF_BLOCKS],
    bindings: CELL_BINDINGS,
    workgroup: 64,
};

/// Cells of 8-bit colour with keyframes in BC7: `CCB7`.
pub static CELLS_BC7: Kernel = Kernel {
    name: "cells-bc7",
    entry: "decode_blocks",
    files: &[
        LAYOUT,
        JOBS,
        BYTES,
        BLEND,
        BPTC,
        BC7_BLOCKS,
        SAMPLES_8,
        file!("color/keyframes_bc7.wgsl"),
        CELLS_OF_BLOCKS,
    ],
    bindings: CELL_BINDINGS,
    workgroup: 64,
};

/// Cells of half floats with keyframes in BC6H: `CCB6`.
pub static CELLS_BC6H: Kernel = Kernel {
    name: "cells-bc6h",
    entry: "decode_blocks",
    files: &[
        LAYOUT,
        JOBS,
        BYTES,
        BLEND,
        BPTC,
        BC6H_BLOCKS,
        SAMPLES_HALF,
        file!("color/keyframes_bc6h.wgsl"),
        CELLS_OF_BLOCKS,
    ],
    bindings: CELL_BINDINGS,
    workgroup: 64,
};

/// Plans what units of depth and material apply next.
pub static PLAN_RECORDS: Kernel = Kernel {
    name: "plan-records",
    entry: "plan_records",
    files: &[LAYOUT, PLAN, file!("depth/record_table.wgsl")],
    bindings: &[
        Read("units"),
        Read("chunks"),
        Read("records"),
        Read("items"),
        Write("states"),
        Write("jobs"),
        Write("dispatch"),
    ],
    workgroup: 256,
};

/// Plans what cells are blended of.
pub static PLAN_CELLS: Kernel = Kernel {
    name: "plan-cells",
    entry: "plan_cells",
    files: &[LAYOUT, PLAN, BYTES, file!("color/cells.wgsl")],
    bindings: &[
        Read("chunks"),
        Read("records"),
        Read("items"),
        Read("stream"),
        Write("states"),
        Write("jobs"),
        Write("dispatch"),
    ],
    workgroup: 256,
};

const BLOCK_BINDINGS: &[Binding] = &[Read("blocks"), Write("texels")];

/// Blocks of BC1, all their pixels.
pub static BC1: Kernel = Kernel {
    name: "bc1",
    entry: "decode_bc1",
    files: &[LAYOUT, BC1_BLOCKS, file!("block/decode_bc1.wgsl")],
    bindings: BLOCK_BINDINGS,
    workgroup: 64,
};

/// Blocks of BC4, all their pixels.
pub static BC4: Kernel = Kernel {
    name: "bc4",
    entry: "decode_bc4",
    files: &[LAYOUT, BC4_BLOCKS, file!("block/decode_bc4.wgsl")],
    bindings: BLOCK_BINDINGS,
    workgroup: 64,
};

/// Blocks of BC5, all their pixels.
pub static BC5: Kernel = Kernel {
    name: "bc5",
    entry: "decode_bc5",
    files: &[LAYOUT, BC4_BLOCKS, BC5_BLOCKS, file!("block/decode_bc5.wgsl")],
    bindings: BLOCK_BINDINGS,
    workgroup: 64,
};

/// Blocks of BC6H, all their pixels.
pub static BC6H: Kernel = Kernel {
    name: "bc6h",
    entry: "decode_bc6h",
    files: &[LAYOUT, BPTC, BC6H_BLOCKS, file!("block/decode_bc6h.wgsl")],
    bindings: BLOCK_BINDINGS,
    workgroup: 64,
};

/// Blocks of BC7, all their pixels.
pub static BC7: Kernel = Kernel {
    name: "bc7",
    entry: "decode_bc7",
    files: &[LAYOUT, BPTC, BC7_BLOCKS, file!("block/decode_bc7.wgsl")],
    bindings: BLOCK_BINDINGS,
    workgroup: 64,
};

/// Inverse depths of texels.
pub static TEXELS: Kernel = Kernel {
    name: "texels",
    entry: "write_depths",
    files: &[LAYOUT, JOBS, file!("march/texels.wgsl")],
    bindings: &[Read("pictures"), Read("tables"), Read("jobs"), Write("planes")],
    workgroup: 64,
};

/// A level of the pyramids above them.
pub static SQUARES: Kernel = Kernel {
    name: "squares",
    entry: "write_squares",
    files: &[LAYOUT, JOBS, file!("march/squares.wgsl")],
    bindings: &[Read("jobs"), Write("planes")],
    workgroup: 64,
};

const VIEWS: ShaderFile = file!("march/layout.wgsl");
const LIGHT_FIELD: ShaderFile = file!("march/light_field.wgsl");
const ASKED_ALL: ShaderFile = file!("march/asked_all.wgsl");
const ACTIVE_VIEWS: ShaderFile = file!("march/active_views.wgsl");
const COUNTERS: ShaderFile = file!("march/counters.wgsl");
const RAY: ShaderFile = file!("march/ray.wgsl");
const PYRAMID: ShaderFile = file!("march/pyramid.wgsl");
const INTERPOLATE: ShaderFile = file!("march/interpolate.wgsl");
const LIGHT: ShaderFile = file!("march/light.wgsl");
const DIFFUSE: ShaderFile = file!("march/diffuse.wgsl");
const PICTURE: ShaderFile = file!("march/render.wgsl");

/// Pictures from any eye: every point of a ray is looked at, and neither mirrors nor glass send rays on.
pub static RENDER: Kernel = Kernel {
    name: "render",
    entry: "render",
    files: &[
        VIEWS,
        LIGHT_FIELD,
        ASKED_ALL,
        ACTIVE_VIEWS,
        COUNTERS,
        RAY,
        file!("march/march.wgsl"),
        INTERPOLATE,
        LIGHT,
        DIFFUSE,
        PICTURE,
    ],
    bindings: &[
        Read("scene"),
        Read("views"),
        Read("faces"),
        Read("distances_m"),
        WordTexels("inverse_depths"),
        FloatTexels("colors"),
        Write("pixels"),
        Write("counts"),
    ],
    workgroup: 64,
};

/// The same, where segments that a view proves to be empty are passed over.
pub static RENDER_PYRAMID: Kernel = Kernel {
    name: "render-pyramid",
    entry: "render",
    files: &[VIEWS, LIGHT_FIELD, ASKED_ALL, ACTIVE_VIEWS, COUNTERS, RAY, PYRAMID, INTERPOLATE, LIGHT, DIFFUSE, PICTURE],
    bindings: &[
        Read("scene"),
        Read("views"),
        Read("faces"),
        Read("distances_m"),
        WordTexels("inverse_depths"),
        FloatTexels("colors"),
        Write("pixels"),
        Write("counts"),
        WordTexels("pyramids"),
    ],
    workgroup: 64,
};

/// The same, where mirrors and glass send rays on.
pub static RENDER_EFFECTS: Kernel = Kernel {
    name: "render-effects",
    entry: "render",
    files: &[
        VIEWS,
        LIGHT_FIELD,
        file!("march/asked_alone.wgsl"),
        ACTIVE_VIEWS,
        COUNTERS,
        RAY,
        PYRAMID,
        INTERPOLATE,
        LIGHT,
        file!("march/material.wgsl"),
        file!("march/normal.wgsl"),
        file!("march/solid.wgsl"),
        file!("march/effects.wgsl"),
        PICTURE,
    ],
    bindings: &[
        Read("scene"),
        Read("views"),
        Read("faces"),
        Read("distances_m"),
        WordTexels("inverse_depths"),
        FloatTexels("colors"),
        Write("pixels"),
        Write("counts"),
        WordTexels("pyramids"),
        FloatTexels("materials"),
    ],
    workgroup: 64,
};

/// All kernels.
pub static KERNELS: [&Kernel; 22] = [
    &NODES,
    &BOXES_CODES,
    &BOXES_MATERIAL,
    &CELLS_8,
    &CELLS_HALF,
    &BOXES_BC5,
    &BOXES_BC1,
    &CELLS_BC1,
    &CELLS_BC7,
    &CELLS_BC6H,
    &PLAN_RECORDS,
    &PLAN_CELLS,
    &BC1,
    &BC4,
    &BC5,
    &BC6H,
    &BC7,
    &TEXELS,
    &SQUARES,
    &RENDER,
    &RENDER_PYRAMID,
    &RENDER_EFFECTS,
];
