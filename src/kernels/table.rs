//! The kernel table: kernels and drawings of `shaders/kernels.json`, which `build.rs` turns into the statics below.

#[derive(Debug, Clone, Copy)]
pub struct ShaderFile {
    /// Path below `shaders/`.
    pub path: &'static str,
    pub text: &'static str,
}

/// Type of a binding; the names are those of WebGPU's bind group layouts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BindingKind {
    ReadOnlyStorage,
    Storage,
    Uint,
    UnfilterableFloat,
}

/// A buffer or texture of group 0; its binding number is its position in the row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    pub name: &'static str,
    pub kind: BindingKind,
}

impl Binding {
    pub fn is_written(self) -> bool {
        self.kind == BindingKind::Storage
    }
}

#[derive(Debug)]
pub struct Kernel {
    pub name: &'static str,
    pub entry: &'static str,
    pub files: &'static [ShaderFile],
    pub bindings: &'static [Binding],
    /// Invocations per workgroup, at most 256.
    pub workgroup: u32,
    /// Kernel that runs before this one, in one or more passes, with one invocation per workgroup of this one; passes its
    /// results in `scratch`.
    pub reader: Option<&'static Kernel>,
}

/// Kernels are identified by name.
impl PartialEq for Kernel {
    fn eq(&self, other: &Kernel) -> bool {
        self.name == other.name
    }
}

impl Kernel {
    pub fn source(&self) -> String {
        source(self.files)
    }
}

/// Effect of a fragment on a render target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blending {
    /// Premultiplied alpha blending.
    Over,
    /// Additive blending.
    Add,
    /// Replacement behind a depth test.
    Nearest,
    /// Replacement behind a depth test, for two unsigned integers.
    Index,
}

impl Blending {
    /// True if the drawing uses a depth test.
    pub fn has_depth(self) -> bool {
        matches!(self, Blending::Nearest | Blending::Index)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Target {
    pub name: &'static str,
    pub blending: Blending,
}

/// A drawing of triangles by the device's rasteriser.
#[derive(Debug)]
pub struct Drawing {
    pub name: &'static str,
    /// Names of the shader entry points.
    pub vertex: &'static str,
    pub fragment: &'static str,
    pub files: &'static [ShaderFile],
    pub bindings: &'static [Binding],
    /// Render targets; the location of each is its position in the row.
    pub targets: &'static [Target],
}

impl Drawing {
    pub fn source(&self) -> String {
        source(self.files)
    }
}

fn source(files: &[ShaderFile]) -> String {
    files.iter().map(|file| file.text).collect::<Vec<_>>().join("\n")
}

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
