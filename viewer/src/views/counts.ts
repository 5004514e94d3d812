/** Counts of a picture in the order of shaders/march/counters.wgsl, by the names of `lightfold render --stats`. */
export const COUNTS = [
  "primary_rays",
  "march_steps",
  "refine_steps",
  "secondary_rays",
  "normal_evals",
  "material_samples",
  "hole_rays",
  "background_rays",
] as const;
export type Counts = Record<(typeof COUNTS)[number], number>;
