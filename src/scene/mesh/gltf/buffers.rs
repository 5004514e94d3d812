//! Buffers, views and accessors (glTF 2.0, section 3.6). Every range is checked before it is read.

use std::ops::Range;
use std::sync::Arc;

use gltf::json::Root;
use gltf::json::accessor::{Accessor, ComponentType};
use gltf::json::validation::Checked;

use crate::mesh::budget::Budget;
use crate::mesh::folder::{Folder, percent_decoded};
use codec::error::{Error, Result};

#[derive(Debug)]
pub struct Buffers<'a> {
    pub root: &'a Root,
    blob: Option<Vec<u8>>,
    loaded: Vec<Option<Arc<Vec<u8>>>>,
    pub folder: Folder,
    pub budget: Budget,
}

/// Elements of an accessor, tightly packed.
struct Elements {
    component: ComponentType,
    normalized: bool,
    bytes: Vec<u8>,
}

impl<'a> Buffers<'a> {
    pub fn new(root: &'a Root, blob: Option<Vec<u8>>, folder: Folder, budget: Budget) -> Buffers<'a> {
        Buffers { root, blob, loaded: vec![None; root.buffers.len()], folder, budget }
    }

    /// Returns the bytes of a data URI, or of a file in the document's folder.
    pub fn fetch(&mut self, uri: &str) -> Result<Arc<Vec<u8>>> {
        if uri.starts_with("data:") {
            self.budget.take(uri.len() as u64, 1, "data in a URI")?;
            let data = gltf::buffer::Data::from_source(gltf::buffer::Source::Uri(uri), None);
            return data.map(|data| Arc::new(data.0)).map_err(|_| Error::invalid("the data in a URI is not base64"));
        }
        self.folder.fetch(&percent_decoded(uri), &mut self.budget)
    }

    fn buffer(&mut self, number: usize) -> Result<Arc<Vec<u8>>> {
        if let Some(Some(bytes)) = self.loaded.get(number) {
            return Ok(bytes.clone());
        }
        let root = self.root;
        let buffer = root.buffers.get(number).ok_or_else(|| Error::invalid(format!("there is no buffer {number}")))?;
        let bytes = match (&buffer.uri, number) {
            (Some(uri), _) => self.fetch(uri).map_err(|error| error.context(format!("buffer {number}")))?,
            (None, 0) if self.blob.is_some() => Arc::new(self.blob.take().unwrap_or_default()),
            _ => return Err(Error::invalid(format!("buffer {number} has no data"))),
        };
        let (has, expected) = (bytes.len() as u64, buffer.byte_length.0);
        if has < expected {
            return Err(Error::invalid(format!("buffer {number} has {has} bytes, where {expected} were expected")));
        }
        self.loaded[number] = Some(bytes.clone());
        Ok(bytes)
    }

    /// Returns a buffer, and the range of a view in it.
    pub fn view(&mut self, number: usize) -> Result<(Arc<Vec<u8>>, Range<usize>)> {
        let root = self.root;
        let missing = || Error::invalid(format!("there is no buffer view {number}"));
        let view = root.buffer_views.get(number).ok_or_else(missing)?;
        let bytes = self.buffer(view.buffer.value())?;
        let (start, length) = (view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0);
        let end = start.checked_add(length).filter(|&end| end <= bytes.len() as u64).ok_or_else(|| {
            let shows = format!("buffer view {number} shows {length} bytes from {start} on");
            Error::invalid(format!("{shows}, but its buffer has {}", bytes.len()))
        })?;
        Ok((bytes, start as usize..end as usize))
    }

    /// Copies `count` elements of `size` bytes out of a view.
    fn copy(&mut self, view: usize, offset: u64, count: usize, size: usize) -> Result<Vec<u8>> {
        let (bytes, range) = self.view(view)?;
        let bytes = &bytes[range];
        let stride = self.root.buffer_views[view].byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            let lie = format!("elements of {size} bytes lie {stride} bytes apart in buffer view {view}");
            return Err(Error::invalid(lie));
        }
        let needed = (count as u64).saturating_sub(1).saturating_mul(stride as u64).saturating_add(size as u64);
        let end = offset.saturating_add(needed);
        if count > 0 && end > bytes.len() as u64 {
            let reach = format!("{count} elements reach to byte {end} of buffer view {view}");
            return Err(Error::invalid(format!("{reach}, which has {}", bytes.len())));
        }
        let starts = (0..count).map(|number| offset as usize + number * stride);
        let mut out = Vec::with_capacity(count * size);
        starts.for_each(|at| out.extend_from_slice(&bytes[at..at + size]));
        Ok(out)
    }

    fn elements(&mut self, number: usize, components: usize) -> Result<Elements> {
        let root = self.root;
        let missing = || Error::invalid("there is no such accessor");
        let accessor = root.accessors.get(number).ok_or_else(missing)?;
        let (Checked::Valid(component), Checked::Valid(shape)) = (accessor.component_type, accessor.type_) else {
            return Err(Error::invalid("its type is not known"));
        };
        let numbers = shape.multiplicity();
        if numbers != components {
            return Err(Error::invalid(format!("elements of {numbers} numbers, where {components} were expected")));
        }
        let size = component.0.size() * components;
        // Memory of the bytes, and of the floats or integers converted from them.
        self.budget.take(accessor.count.0, size as u64 + 4 * components as u64, "an accessor")?;
        let count = accessor.count.0 as usize;
        let mut bytes = match accessor.buffer_view {
            Some(view) => self.copy(view.value(), accessor.byte_offset.map_or(0, |offset| offset.0), count, size)?,
            None => vec![0; count * size],
        };
        self.displace(accessor, &mut bytes, size)?;
        Ok(Elements { component: component.0, normalized: accessor.normalized, bytes })
    }

    /// Replaces elements of sparse accessors (glTF 2.0, section 3.6.2.3).
    fn displace(&mut self, accessor: &Accessor, bytes: &mut [u8], size: usize) -> Result<()> {
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        if sparse.count.0 > accessor.count.0 {
            return Err(Error::invalid("more sparse elements than there are"));
        }
        let count = sparse.count.0 as usize;
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return Err(Error::invalid("the type of sparse indices is not known"));
        };
        self.budget.take(sparse.count.0, size as u64 + 8, "a sparse accessor")?;
        let indices =
            self.copy(sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0, count, kind.0.size())?;
        let values = self.copy(sparse.values.buffer_view.value(), sparse.values.byte_offset.0, count, size)?;
        for (index, value) in unsigned(kind.0, &indices).zip(values.chunks_exact(size)) {
            let at = index as usize * size;
            let place = bytes.get_mut(at..at + size);
            let beyond = || Error::invalid(format!("sparse index {index} of {} elements", accessor.count.0));
            place.ok_or_else(beyond)?.copy_from_slice(value);
        }
        Ok(())
    }

    /// Returns elements of `N` floats. Normalised integers are converted to −1..=1 or 0..=1.
    pub fn floats<const N: usize>(&mut self, number: usize) -> Result<Vec<[f32; N]>> {
        let elements = self.elements(number, N).map_err(|error| error.context(format!("accessor {number}")))?;
        let scale = |most: f32| if elements.normalized { 1.0 / most } else { 1.0 };
        let signed = |value: f32, most: f32| if elements.normalized { (value / most).max(-1.0) } else { value };
        let numbers: Vec<f32> = match elements.component {
            ComponentType::I8 => elements.bytes.iter().map(|&b| signed(f32::from(b as i8), 127.0)).collect(),
            ComponentType::U8 => elements.bytes.iter().map(|&b| f32::from(b) * scale(255.0)).collect(),
            ComponentType::I16 => {
                words::<2>(&elements.bytes).map(|w| signed(f32::from(i16::from_le_bytes(w)), 32767.0)).collect()
            }
            ComponentType::U16 => {
                words::<2>(&elements.bytes).map(|w| f32::from(u16::from_le_bytes(w)) * scale(65535.0)).collect()
            }
            ComponentType::U32 => words::<4>(&elements.bytes).map(|w| u32::from_le_bytes(w) as f32).collect(),
            ComponentType::F32 => words::<4>(&elements.bytes).map(f32::from_le_bytes).collect(),
        };
        Ok(numbers.as_chunks::<N>().0.to_vec())
    }

    /// Returns elements of `N` unsigned integers. Fails for signed integers and floats.
    pub fn integers<const N: usize>(&mut self, number: usize) -> Result<Vec<[u32; N]>> {
        let elements = self.elements(number, N).map_err(|error| error.context(format!("accessor {number}")))?;
        if !matches!(elements.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(Error::invalid(format!("accessor {number} should hold unsigned integers")));
        }
        let numbers: Vec<u32> = unsigned(elements.component, &elements.bytes).collect();
        Ok(numbers.as_chunks::<N>().0.to_vec())
    }
}

fn words<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [u8; N]> {
    bytes.as_chunks::<N>().0.iter().copied()
}

/// Decodes little-endian unsigned integers of 1, 2 or 4 bytes.
fn unsigned(component: ComponentType, bytes: &[u8]) -> impl Iterator<Item = u32> {
    let size = component.size();
    bytes.chunks_exact(size).map(move |word| word.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte)))
}
