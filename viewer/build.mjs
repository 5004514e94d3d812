// Bundles the player to dist/, which travels inside the program, or to --output DIR; with --tests the tests to target/tests/, for
// `node --test`.
import { build } from "esbuild";
import { copyFile, mkdir, readdir, rm } from "node:fs/promises";

const shared = {
  bundle: true,
  format: "esm",
  target: "es2022",
  loader: { ".wgsl": "text" },
  logLevel: "warning",
  charset: "utf8",
};

if (process.argv.includes("--tests")) {
  await rm("target/tests", { recursive: true, force: true });
  const tests = (await readdir("tests")).filter((name) => name.endsWith(".test.ts")).map((name) => `tests/${name}`);
  const external = ["playwright-core", "axe-core", "esbuild"];
  await build({
    ...shared,
    entryPoints: tests,
    outdir: "target/tests",
    platform: "node",
    external,
    sourcemap: "inline",
  });
} else {
  const at = process.argv.indexOf("--output");
  const outdir = at < 0 ? "dist" : process.argv[at + 1];
  await rm(outdir, { recursive: true, force: true });
  await mkdir(outdir, { recursive: true });
  const entryPoints = {
    viewer: "src/main.ts",
    worker: "src/worker.ts",
    glb: "src/glb/main.ts",
    cpu_worker: "src/cpu/worker.ts",
  };
  await build({ ...shared, entryPoints, outdir, minify: true, legalComments: "none" });
  for (const name of ["index.html", "style.css", "narrow.css"]) {
    await copyFile(`src/ui/${name}`, `${outdir}/${name}`);
  }
  // Built by scripts/build-wasm.
  await copyFile("src/decoder/lightfold.wasm", `${outdir}/lightfold.wasm`);
}
