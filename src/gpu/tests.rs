//! The kernel table against the WGSL, by reflection.

use std::collections::BTreeSet;

use wgpu::naga;

use codec::depth::domain::DomainKind;
use codec::depth::runtime;
use kernels::layout::*;
use kernels::{Binding, BindingKind, DRAWINGS, KERNELS};

/// A row of the kernel table, with its parsed module.
struct Row {
    name: &'static str,
    bindings: &'static [Binding],
    renders: bool,
    module: naga::Module,
}

impl Row {
    fn new(name: &'static str, bindings: &'static [Binding], source: &str, renders: bool) -> Row {
        let module = naga::front::wgsl::parse_str(source);
        let module = module.unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
        Row { name, bindings, renders, module }
    }
}

fn rows() -> Vec<Row> {
    let kernels = KERNELS.iter().map(|kernel| {
        let is_light = |path: &str| path.starts_with("march/") || path == "epipolar/highlights.wgsl";
        let renders = kernel.files.iter().any(|file| is_light(file.path));
        Row::new(kernel.name, kernel.bindings, &kernel.source(), renders)
    });
    kernels
        .chain(DRAWINGS.iter().map(|drawing| Row::new(drawing.name, drawing.bindings, &drawing.source(), true)))
        .collect()
}

#[test]
fn structs_have_the_members_and_offsets_of_the_wgsl() {
    let mut seen = BTreeSet::new();
    for Row { name: row, module, .. } in rows() {
        for (_, found) in module.types.iter() {
            let (Some(name), naga::TypeInner::Struct { members, span }) = (&found.name, &found.inner) else {
                continue;
            };
            let Some((_, size, fields)) = STRUCTS.iter().find(|(known, ..)| known == name) else { continue };
            let wgsl: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
            assert_eq!((wgsl.as_slice(), *span as usize), (*fields, *size), "{name} of {row}");
            seen.insert(name.clone());
        }
    }
    assert_eq!(seen.len(), STRUCTS.len(), "no kernel declares some of the structs; declared are {seen:?}");
}

#[test]
fn constants_are_those_of_the_wgsl() {
    let mut seen = BTreeSet::new();
    for Row { name: row, module, .. } in rows() {
        for (_, found) in module.constants.iter() {
            let Some((name, value)) = CONSTANTS.iter().find(|(name, _)| found.name.as_deref() == Some(name)) else {
                continue;
            };
            let literal = &module.global_expressions[found.init];
            let is = matches!(literal, naga::Expression::Literal(naga::Literal::U32(found)) if found == value);
            assert!(is, "{name} is {value}, in {row} it is {literal:?}");
            seen.insert(*name);
        }
    }
    assert_eq!(seen.len(), CONSTANTS.len(), "no kernel declares some of the constants; declared are {seen:?}");
}

#[test]
fn scratch_words_are_those_of_the_struct() {
    let mut spans = Vec::new();
    for Row { module, .. } in rows() {
        let of_scratch = module.types.iter().filter(|(_, found)| found.name.as_deref() == Some("Scratch"));
        spans.extend(of_scratch.map(|(_, found)| match found.inner {
            naga::TypeInner::Struct { span, .. } => span,
            _ => 0,
        }));
    }
    assert_eq!(spans, [4 * SCRATCH_WORDS; 4]);
}

#[test]
fn constants_are_those_of_the_format() {
    assert_eq!([DOMAIN_LOG, DOMAIN_LINEAR, DOMAIN_INVERSE], DomainKind::ALL.map(|kind| kind as u32));
    assert_eq!(LEVELS as usize, runtime::LEVELS);
    assert_eq!(DEPTH_BITS_LEFT_OUT, simplify::raster::DEPTH_BITS_LEFT_OUT);
    {
        use epipolar::erosion;
        assert_eq!(EROSION_REACH as usize, erosion::REACH);
        assert_eq!((MOVE_BITS, EROSION_TOLERANCE as i32), (erosion::MOVE_BITS, erosion::TOLERANCE));
    }
    assert_eq!(NODE_HEADER_WORDS as usize * 4, runtime::HEADER_BYTES);
}

#[test]
fn modules_match_their_rows() {
    for Row { name, bindings, renders, module } in rows() {
        let flags = naga::valid::ValidationFlags::all();
        // Without any capability that browsers lack.
        let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|error| panic!("{name}: {error:?}"));
        let is_buffer = |b: &&Binding| matches!(b.kind, BindingKind::ReadOnlyStorage | BindingKind::Storage);
        assert!(bindings.iter().filter(is_buffer).count() <= 8, "{name}");
        let mut bound: Vec<_> = module
            .global_variables
            .iter()
            .filter_map(|(_, variable)| {
                let written = match variable.space {
                    naga::AddressSpace::Storage { access } => access.contains(naga::StorageAccess::STORE),
                    // Textures are in the handle address space.
                    naga::AddressSpace::Handle => false,
                    _ => return None,
                };
                Some((variable.binding?.binding, variable.name.clone().unwrap_or_default(), written))
            })
            .collect();
        bound.sort();
        let rows = bindings.iter().enumerate();
        let rows: Vec<_> = rows.map(|(at, b)| (at as u32, b.name.to_owned(), b.is_written())).collect();
        assert_eq!(bound, rows, "bindings of {name}");
        // Decoding must be bit-exact, so its kernels have no floats; neither do those of slices, except for highlights.
        for (_, found) in module.types.iter().filter(|_| !renders) {
            let scalar = found.inner.scalar_kind();
            assert!(scalar != Some(naga::ScalarKind::Float), "{name} has a float");
        }
    }
}

fn entry<'m>(module: &'m naga::Module, name: &str) -> &'m naga::EntryPoint {
    let entry = module.entry_points.iter().find(|entry| entry.name == name);
    entry.unwrap_or_else(|| panic!("there is no {name}"))
}

#[test]
fn entry_points_are_those_of_the_rows() {
    let rows = rows();
    for (kernel, Row { module, .. }) in KERNELS.iter().zip(&rows) {
        let entry = entry(module, kernel.entry);
        assert_eq!(entry.workgroup_size.iter().product::<u32>(), kernel.workgroup, "{}", kernel.name);
        assert!(kernel.workgroup <= 256, "{}", kernel.name);
    }
    for (drawing, Row { module, .. }) in DRAWINGS.iter().zip(&rows[KERNELS.len()..]) {
        let stages = [drawing.vertex, drawing.fragment].map(|name| entry(module, name).stage);
        assert_eq!(stages, [naga::ShaderStage::Vertex, naga::ShaderStage::Fragment], "{}", drawing.name);
        let result = entry(module, drawing.fragment).function.result.as_ref().expect("a fragment has a result");
        let locations = match &module.types[result.ty].inner {
            naga::TypeInner::Struct { members, .. } => {
                let is_target = |m: &&naga::StructMember| matches!(m.binding, Some(naga::Binding::Location { .. }));
                members.iter().filter(is_target).count()
            }
            _ => 1,
        };
        assert_eq!(locations, drawing.targets.len(), "{}", drawing.name);
    }
}
