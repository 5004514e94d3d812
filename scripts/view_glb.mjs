// Validates and draws a scene.glb; scripts/view-glb calls it and says what the columns and exit codes are.
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname, join } from "node:path";

const [modules, scenePath, out, sizeText, reference] = process.argv.slice(2);
const size = Number(sizeText);
const FOV_DEG = 90, WANTED_DB = 30;
const require = createRequire(join(modules, "index.js"));
const glb = readFileSync(scenePath);
let failed = false, notRun = false;

function missing(words) {
    console.log(`NOT RUN: ${words}`);
    notRun = true;
}

async function validate() {
    let validator;
    try {
        validator = require("gltf-validator");
    } catch {
        return missing("the validator; the npm package gltf-validator is missing");
    }
    const { issues } = await validator.validateBytes(new Uint8Array(glb), { maxIssues: 1000 });
    console.log(`validator ${validator.version()}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos`);
    for (const { severity, code, pointer, message } of issues.messages.slice(0, 20))
        console.log(`  ${["error", "warning", "info", "hint"][severity]} ${code} ${pointer}: ${message}`);
    failed ||= issues.numErrors + issues.numWarnings > 0;
}

// Three poses in the viewing region that the file names.
function posesOf(document) {
    const region = document.extras?.lightfold?.viewing_region_m;
    if (!region) throw new Error(`${scenePath}: not a scene of \`lightfold simplify\`: its extras name no viewing region`);
    const place = (part, along) => {
        const eye = [0, 1, 2].map(axis => 0.5 * (region[0][axis] + region[1][axis]) + 0.25 * part[axis] * (region[1][axis] - region[0][axis]));
        return { eye, target: eye.map((at, axis) => at + along[axis]) };
    };
    return [place([0, 0, 0], [0, 0, -1]), place([1, 1, 1], [1, -0.1, 0.3]), place([-1, -0.5, 1], [-0.5, 0.3, 0.8])];
}

function readDocument() {
    if (glb.length < 20 || glb.toString("latin1", 0, 4) !== "glTF") throw new Error(`${scenePath}: not binary glTF`);
    return JSON.parse(glb.toString("utf8", 20, 20 + glb.readUInt32LE(12)));
}

// Our own pictures of the poses, as PNG, or none.
function ownPictures(poses) {
    return poses.map(({ eye, target }, at) => {
        const path = join(reference || out, reference ? `pose-${at}.png` : `pose-${at}-lightfold.png`);
        if (!reference) {
            const options = ["render", scenePath, `--eye=${eye}`, `--look-at=${target}`, "--fov", String(FOV_DEG), "--size", `${size}`, "-o", path];
            try {
                execFileSync(process.env.LIGHTFOLD, options, { stdio: ["ignore", "ignore", "pipe"] });
            } catch (error) {
                missing(`${process.env.LIGHTFOLD} render of pose ${at}: ${String(error.stderr ?? error.message).trim().split("\n")[0]}`);
                return null;
            }
        }
        if (!existsSync(path)) return missing(`comparison of pose ${at}; ${path} is missing`), null;
        return readFileSync(path);
    });
}

// Files that the page asks for: itself, the scene, modules, pictures.
function serve(pictures) {
    const page = `<!doctype html><script type="importmap">{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}</script>`;
    const kinds = { ".js": "text/javascript", ".glb": "model/gltf-binary", ".png": "image/png", ".html": "text/html" };
    const server = createServer((request, response) => {
        const path = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
        const picture = path.match(/^\/own-(\d)\.png$/);
        let body;
        if (path === "/page.html") body = page;
        else if (path === "/scene.glb") body = glb;
        else if (picture) body = pictures[Number(picture[1])];
        else if (path.startsWith("/three/") && !path.includes("..") && existsSync(join(modules, path))) body = readFileSync(join(modules, path));
        response.writeHead(body ? 200 : 404, { "content-type": kinds[extname(path)] ?? "application/octet-stream" });
        response.end(body ?? "");
    });
    return new Promise(resolve => server.listen(0, "127.0.0.1", () => resolve(server)));
}

// Runs in the page: draws all poses in a mode, and returns the PSNR to our own picture and the picture itself.
async function drawInPage({ poses, size, fovDeg, mode, own }) {
    const THREE = await import("three");
    const { GLTFLoader } = await import("three/addons/loaders/GLTFLoader.js");
    const loaded = await new GLTFLoader().loadAsync("/scene.glb");
    const canvas = document.createElement("canvas");
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: false, alpha: false });
    renderer.setSize(size, size, false);
    if (mode !== "stock") {
        renderer.sortObjects = false;
        loaded.scene.traverse(object => {
            if (!object.isMesh) return;
            object.material.forceSinglePass = true;
            if (!object.geometry.attributes._texcoord_stq) return;
            object.material.onBeforeCompile = shader => {
                shader.vertexShader = "attribute vec3 _texcoord_stq; varying vec3 vStq;\n"
                    + shader.vertexShader.replace("#include <uv_vertex>", "#include <uv_vertex>\nvStq = _texcoord_stq;");
                shader.fragmentShader = "varying vec3 vStq;\n"
                    + shader.fragmentShader.replace("#include <map_fragment>", "diffuseColor *= texture2D(map, vStq.xy / vStq.z);");
            };
        });
    }
    const scene = new THREE.Scene();
    scene.add(loaded.scene);
    const encode = light => 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055);
    const results = [];
    for (const [at, { eye, target }] of poses.entries()) {
        const distance = Math.max(1e-9, ...target.map((part, axis) => Math.abs(part - eye[axis])));
        const camera = new THREE.PerspectiveCamera(fovDeg, 1, 1e-3 * distance, 1e6 * distance);
        camera.position.set(...eye);
        camera.lookAt(...target);
        const codes = new Uint8ClampedArray(4 * size * size);
        let bottomUp = new Uint8Array(codes.length);
        if (mode === "linear") {
            const halves = new Uint16Array(codes.length);
            const buffer = new THREE.WebGLRenderTarget(size, size, { type: THREE.HalfFloatType });
            renderer.setRenderTarget(buffer);
            renderer.render(scene, camera);
            renderer.readRenderTargetPixels(buffer, 0, 0, size, size, halves);
            renderer.setRenderTarget(null);
            bottomUp = Uint8ClampedArray.from(halves, (half, i) => i % 4 === 3 ? 255 : encode(THREE.DataUtils.fromHalfFloat(half)));
        } else {
            renderer.render(scene, camera);
            const gl = renderer.getContext();
            gl.readPixels(0, 0, size, size, gl.RGBA, gl.UNSIGNED_BYTE, bottomUp);
        }
        for (let row = 0; row < size; row++)
            codes.set(bottomUp.subarray(4 * size * (size - 1 - row), 4 * size * (size - row)), 4 * size * row);
        const flat = document.createElement("canvas");
        [flat.width, flat.height] = [size, size];
        const context = flat.getContext("2d");
        let psnrDb = null;
        if (own[at]) {
            const bitmap = await createImageBitmap(await (await fetch(`/own-${at}.png`)).blob(), { colorSpaceConversion: "none" });
            if (bitmap.width !== size || bitmap.height !== size) throw new Error(`our picture of pose ${at} has ${bitmap.width}x${bitmap.height} pixels, not ${size}x${size}`);
            context.fillRect(0, 0, size, size);
            context.drawImage(bitmap, 0, 0);
            const wanted = context.getImageData(0, 0, size, size).data;
            let squared = 0;
            for (let i = 0; i < codes.length; i++) if (i % 4 !== 3) squared += (codes[i] - wanted[i]) ** 2;
            psnrDb = squared === 0 ? 999 : 10 * Math.log10(255 ** 2 * 3 * size * size / squared);
        }
        for (let i = 3; i < codes.length; i += 4) codes[i] = 255;
        context.putImageData(new ImageData(codes, size, size), 0, 0);
        results.push({ psnrDb, png: flat.toDataURL("image/png") });
    }
    renderer.dispose();
    return { results, revision: THREE.REVISION };
}

async function draw(poses) {
    let puppeteer;
    try {
        puppeteer = require("puppeteer-core");
        require.resolve("three");
    } catch {
        return missing("pictures; the npm packages three and puppeteer-core are missing");
    }
    if (!process.env.CHROMIUM) return missing("pictures; chromium is missing");
    const pictures = ownPictures(poses);
    const server = await serve(pictures);
    const browser = await puppeteer.launch({
        executablePath: process.env.CHROMIUM,
        args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
        protocolTimeout: 600_000,
    });
    try {
        for (const mode of ["recommended", "stock", "linear"]) {
            const page = await browser.newPage();
            page.on("pageerror", error => console.log(`  page: ${error.message}`));
            await page.goto(`http://127.0.0.1:${server.address().port}/page.html`);
            const own = pictures.map(picture => picture !== null);
            const { results, revision } = await page.evaluate(drawInPage, { poses, size, fovDeg: FOV_DEG, mode, own });
            const found = results.map(({ psnrDb }) => psnrDb === null ? "not compared" : `${psnrDb.toFixed(2)} dB`);
            console.log(`three.js ${revision}, ${mode}: ${found.join(", ")}`);
            if (mode === "recommended") failed ||= results.some(({ psnrDb }) => psnrDb !== null && psnrDb < WANTED_DB);
            results.forEach(({ png }, at) => writeFileSync(join(out, `pose-${at}-${mode}.png`), Buffer.from(png.split(",")[1], "base64")));
            await page.close();
        }
        console.log(`pictures: ${out}`);
    } finally {
        await browser.close();
        server.close();
    }
}

try {
    const poses = posesOf(readDocument());
    await validate();
    await draw(poses);
} catch (error) {
    console.error(error.message);
    process.exit(2);
}
process.exit(failed ? 1 : notRun ? 3 : 0);
