// The kernels that the player runs: rows of shaders/kernels.json, whose WGSL is that of shaders/.

import table from "../../../shaders/kernels.json";
import blockBc1 from "../../../shaders/block/bc1.wgsl";
import blockBc4 from "../../../shaders/block/bc4.wgsl";
import blockBc5 from "../../../shaders/block/bc5.wgsl";
import blockBc6h from "../../../shaders/block/bc6h.wgsl";
import blockBc7 from "../../../shaders/block/bc7.wgsl";
import blockBptc from "../../../shaders/block/bptc.wgsl";
import colorBlend from "../../../shaders/color/blend.wgsl";
import colorCells from "../../../shaders/color/cells.wgsl";
import colorCellsOfBlocks from "../../../shaders/color/cells_of_blocks.wgsl";
import colorCellsOfSamples from "../../../shaders/color/cells_of_samples.wgsl";
import colorHalves from "../../../shaders/color/halves.wgsl";
import colorKeyframesBc1 from "../../../shaders/color/keyframes_bc1.wgsl";
import colorKeyframesBc6h from "../../../shaders/color/keyframes_bc6h.wgsl";
import colorKeyframesBc7 from "../../../shaders/color/keyframes_bc7.wgsl";
import colorSamples8 from "../../../shaders/color/samples_8.wgsl";
import colorSamplesHalf from "../../../shaders/color/samples_half.wgsl";
import colorTransformChunk from "../../../shaders/color/transform/chunk.wgsl";
import colorTransformCoder from "../../../shaders/color/transform/coder.wgsl";
import colorTransformContexts from "../../../shaders/color/transform/contexts.wgsl";
import colorTransformDomain from "../../../shaders/color/transform/domain.wgsl";
import colorTransformDomainBytes from "../../../shaders/color/transform/domain_bytes.wgsl";
import colorTransformDomainHalves from "../../../shaders/color/transform/domain_halves.wgsl";
import colorTransformLevels from "../../../shaders/color/transform/levels.wgsl";
import colorTransformMeans from "../../../shaders/color/transform/means.wgsl";
import colorTransformPalette from "../../../shaders/color/transform/palette.wgsl";
import colorTransformReconstruct from "../../../shaders/color/transform/reconstruct.wgsl";
import colorTransformRegion from "../../../shaders/color/transform/region.wgsl";
import depthBc4w from "../../../shaders/depth/bc4w.wgsl";
import depthBiquadratic from "../../../shaders/depth/biquadratic.wgsl";
import depthBlockTiles from "../../../shaders/depth/block_tiles.wgsl";
import depthBlockTilesBc1 from "../../../shaders/depth/block_tiles_bc1.wgsl";
import depthBlockTilesBc5 from "../../../shaders/depth/block_tiles_bc5.wgsl";
import depthBoxesOfValues from "../../../shaders/depth/boxes_of_values.wgsl";
import depthDomain from "../../../shaders/depth/domain.wgsl";
import depthPlatelet from "../../../shaders/depth/platelet.wgsl";
import depthRecordTable from "../../../shaders/depth/record_table.wgsl";
import depthRecords from "../../../shaders/depth/records.wgsl";
import depthRuntime from "../../../shaders/depth/runtime.wgsl";
import depthTexelCodes from "../../../shaders/depth/texel_codes.wgsl";
import depthTexelMaterial from "../../../shaders/depth/texel_material.wgsl";
import marchActiveViews from "../../../shaders/march/active_views.wgsl";
import marchCounters from "../../../shaders/march/counters.wgsl";
import marchDiffuse from "../../../shaders/march/diffuse.wgsl";
import marchInterpolate from "../../../shaders/march/interpolate.wgsl";
import marchIntersect from "../../../shaders/march/intersect.wgsl";
import marchLayers from "../../../shaders/march/layers.wgsl";
import marchLayout from "../../../shaders/march/layout.wgsl";
import marchLightField from "../../../shaders/march/light_field.wgsl";
import marchMarchedViews from "../../../shaders/march/marched_views.wgsl";
import marchMaterial from "../../../shaders/march/material.wgsl";
import marchNormal from "../../../shaders/march/normal.wgsl";
import marchPyramid from "../../../shaders/march/pyramid.wgsl";
import marchRay from "../../../shaders/march/ray.wgsl";
import marchRender from "../../../shaders/march/render.wgsl";
import marchSecondaryRays from "../../../shaders/march/secondary_rays.wgsl";
import marchSegments from "../../../shaders/march/segments.wgsl";
import marchShading from "../../../shaders/march/shading.wgsl";
import marchSolid from "../../../shaders/march/solid.wgsl";
import marchTexels from "../../../shaders/march/texels.wgsl";
import sharedBytes from "../../../shaders/shared/bytes.wgsl";
import sharedJobs from "../../../shaders/shared/jobs.wgsl";
import sharedLayout from "../../../shaders/shared/layout.wgsl";
import sharedPlan from "../../../shaders/shared/plan.wgsl";
import sharedProduct from "../../../shaders/shared/product.wgsl";
import sharedSums from "../../../shaders/shared/sums.wgsl";

/** Kernels of the player. */
export const KERNEL_NAMES = [
  "nodes",
  "boxes-codes",
  "boxes-material",
  "cells-8bit",
  "cells-half",
  "boxes-bc5",
  "boxes-bc1",
  "cells-bc1",
  "cells-bc7",
  "cells-bc6h",
  "transform-read-8bit",
  "transform-8bit",
  "transform-read-half",
  "transform-half",
  "plan-records",
  "plan-cells",
  "texels",
  "squares",
  "render",
  "render-pyramid",
  "render-effects",
] as const;

export type KernelName = (typeof KERNEL_NAMES)[number];

/** The files of these kernels, by their path below shaders/. */
const TEXTS: Readonly<Record<string, string>> = {
  "block/bc1.wgsl": blockBc1,
  "block/bc4.wgsl": blockBc4,
  "block/bc5.wgsl": blockBc5,
  "block/bc6h.wgsl": blockBc6h,
  "block/bc7.wgsl": blockBc7,
  "block/bptc.wgsl": blockBptc,
  "color/blend.wgsl": colorBlend,
  "color/cells.wgsl": colorCells,
  "color/cells_of_blocks.wgsl": colorCellsOfBlocks,
  "color/cells_of_samples.wgsl": colorCellsOfSamples,
  "color/halves.wgsl": colorHalves,
  "color/keyframes_bc1.wgsl": colorKeyframesBc1,
  "color/keyframes_bc6h.wgsl": colorKeyframesBc6h,
  "color/keyframes_bc7.wgsl": colorKeyframesBc7,
  "color/samples_8.wgsl": colorSamples8,
  "color/samples_half.wgsl": colorSamplesHalf,
  "color/transform/chunk.wgsl": colorTransformChunk,
  "color/transform/coder.wgsl": colorTransformCoder,
  "color/transform/contexts.wgsl": colorTransformContexts,
  "color/transform/domain.wgsl": colorTransformDomain,
  "color/transform/domain_bytes.wgsl": colorTransformDomainBytes,
  "color/transform/domain_halves.wgsl": colorTransformDomainHalves,
  "color/transform/levels.wgsl": colorTransformLevels,
  "color/transform/means.wgsl": colorTransformMeans,
  "color/transform/palette.wgsl": colorTransformPalette,
  "color/transform/reconstruct.wgsl": colorTransformReconstruct,
  "color/transform/region.wgsl": colorTransformRegion,
  "depth/bc4w.wgsl": depthBc4w,
  "depth/biquadratic.wgsl": depthBiquadratic,
  "depth/block_tiles.wgsl": depthBlockTiles,
  "depth/block_tiles_bc1.wgsl": depthBlockTilesBc1,
  "depth/block_tiles_bc5.wgsl": depthBlockTilesBc5,
  "depth/boxes_of_values.wgsl": depthBoxesOfValues,
  "depth/domain.wgsl": depthDomain,
  "depth/platelet.wgsl": depthPlatelet,
  "depth/record_table.wgsl": depthRecordTable,
  "depth/records.wgsl": depthRecords,
  "depth/runtime.wgsl": depthRuntime,
  "depth/texel_codes.wgsl": depthTexelCodes,
  "depth/texel_material.wgsl": depthTexelMaterial,
  "march/active_views.wgsl": marchActiveViews,
  "march/counters.wgsl": marchCounters,
  "march/diffuse.wgsl": marchDiffuse,
  "march/interpolate.wgsl": marchInterpolate,
  "march/intersect.wgsl": marchIntersect,
  "march/layers.wgsl": marchLayers,
  "march/layout.wgsl": marchLayout,
  "march/light_field.wgsl": marchLightField,
  "march/marched_views.wgsl": marchMarchedViews,
  "march/material.wgsl": marchMaterial,
  "march/normal.wgsl": marchNormal,
  "march/pyramid.wgsl": marchPyramid,
  "march/ray.wgsl": marchRay,
  "march/render.wgsl": marchRender,
  "march/secondary_rays.wgsl": marchSecondaryRays,
  "march/segments.wgsl": marchSegments,
  "march/shading.wgsl": marchShading,
  "march/solid.wgsl": marchSolid,
  "march/texels.wgsl": marchTexels,
  "shared/bytes.wgsl": sharedBytes,
  "shared/jobs.wgsl": sharedJobs,
  "shared/layout.wgsl": sharedLayout,
  "shared/plan.wgsl": sharedPlan,
  "shared/product.wgsl": sharedProduct,
  "shared/sums.wgsl": sharedSums,
};

/** How a kernel accesses a binding, by the names of WebGPU's bind group layouts. */
export type BindingKind = "read-only-storage" | "storage" | "uint" | "unfilterable-float";

/** A buffer or texture of group 0; its number is its position in the row. */
export interface Binding {
  name: string;
  kind: BindingKind;
}

export interface Kernel {
  name: KernelName;
  entry: string;
  bindings: readonly Binding[];
  /** Invocations per workgroup. */
  workgroup: number;
  /** Kernel that runs before this one, in passes, with an invocation for each of its workgroups; `scratch` carries the result. */
  reader: KernelName | undefined;
}

const KINDS: readonly string[] = ["read-only-storage", "storage", "uint", "unfilterable-float"] satisfies BindingKind[];

function isKind(kind: string): kind is BindingKind {
  return KINDS.includes(kind);
}

function row(name: KernelName): (typeof table.kernels)[number] {
  const found = table.kernels.find((kernel) => kernel.name === name);
  if (found === undefined) {
    throw new Error(`shaders/kernels.json has no kernel ${name}`);
  }
  return found;
}

/** The row of a kernel. */
export function kernel(name: KernelName): Kernel {
  const { entry, workgroup, bindings, reader } = row(name);
  const parsed = bindings.map((binding) => {
    const [label = "", kind = ""] = binding.split(": ");
    if (!isKind(kind)) {
      throw new Error(`shaders/kernels.json: ${kind} is no kind of binding`);
    }
    return { name: label, kind };
  });
  const found = KERNEL_NAMES.find((other) => other === reader);
  if (found !== reader) {
    throw new Error(`shaders/kernels.json: ${reader} is no kernel of the player`);
  }
  return { name, entry, workgroup, bindings: parsed, reader: found };
}

/** The WGSL of a kernel: its files one behind the other. */
export function kernelSource(name: KernelName): string {
  const texts = row(name).files.map((file) => {
    const text = TEXTS[file];
    if (text === undefined) {
      throw new Error(`${file} of kernel ${name} is not part of the player`);
    }
    return text;
  });
  return texts.join("\n");
}
