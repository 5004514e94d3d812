/** WGSL is imported as text: `loader` of build.mjs. */
declare module "*.wgsl" {
  const text: string;
  export default text;
}
