// Draws a scene by three.js as `lightfold render --method painter` does: all triangles in the order of the file, from both sides,
// blended in linear light without depth test (Compositing::Painter of src/simplify/raster.rs).

import {
  AddEquation,
  BufferAttribute,
  BufferGeometry,
  Camera,
  CustomBlending,
  DataUtils,
  DoubleSide,
  HalfFloatType,
  LinearFilter,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  NormalBlending,
  OneFactor,
  PerspectiveCamera,
  Scene,
  ShaderMaterial,
  WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import type { Object3D, Texture } from "three";
import { FormatError, UnsupportedError } from "../format/types.ts";
import type { View } from "../player/types.ts";
import { STEREO_NUMBERS, TONE_MAP_NUMBERS } from "../views/presentation.ts";
import { rightOf } from "../ui/pose.ts";
import { OVERDRAW_FRAGMENT, QUAD_FRAGMENT, QUAD_VERTEX, SCREEN_FRAGMENT, SCREEN_VERTEX } from "./shaders.ts";

/** Clip planes in metres: nothing is hidden by depth, so that the range may be wide. */
const NEAR_M = 0.001;
const FAR_M = 1e7;

const PAINTER = { transparent: true, depthTest: false, depthWrite: false, side: DoubleSide, forceSinglePass: true };

function quadMaterial(atlas: Texture, geometry: BufferGeometry): ShaderMaterial {
  const isProjective = geometry.hasAttribute("_texcoord_stq");
  return new ShaderMaterial({
    ...PAINTER,
    uniforms: { atlas: { value: atlas } },
    defines: isProjective ? { PROJECTIVE: "" } : {},
    vertexShader: QUAD_VERTEX,
    fragmentShader: QUAD_FRAGMENT,
    blending: NormalBlending,
  });
}

function overdrawMaterial(): ShaderMaterial {
  return new ShaderMaterial({
    ...PAINTER,
    vertexShader: QUAD_VERTEX,
    fragmentShader: OVERDRAW_FRAGMENT,
    blending: CustomBlending,
    blendEquation: AddEquation,
    blendSrc: OneFactor,
    blendDst: OneFactor,
  });
}

/** Gives the quads of a loaded file the material of the painter. */
function prepare(root: Object3D, maxTextureSize: number): void {
  root.traverse((object) => {
    object.frustumCulled = false;
    if (!(object instanceof Mesh)) {
      return;
    }
    const mesh = object as Mesh<BufferGeometry>;
    const material: unknown = mesh.material;
    if (!(material instanceof MeshBasicMaterial) || material.map === null) {
      throw new FormatError("A mesh of the scene has no texture that shows under any light.");
    }
    const atlas = material.map;
    const { width, height } = atlas.image as { width: number; height: number };
    if (Math.max(width, height) > maxTextureSize) {
      const size = `${width}x${height}`;
      throw new UnsupportedError(`The texture has ${size} texels; the graphics device takes ${maxTextureSize} a side.`);
    }
    // As the program samples: bilinearly, of the full texture.
    [atlas.generateMipmaps, atlas.minFilter, atlas.magFilter] = [false, LinearFilter, LinearFilter];
    atlas.needsUpdate = true;
    mesh.material = quadMaterial(atlas, mesh.geometry);
    material.dispose();
  });
}

function target(): WebGLRenderTarget {
  const filters = { minFilter: NearestFilter, magFilter: NearestFilter };
  return new WebGLRenderTarget(1, 1, { type: HalfFloatType, depthBuffer: false, ...filters });
}

/** Ends what a headset shows, unless it has ended. */
export function endSession(session: XRSession | null): void {
  session?.end().catch(() => undefined);
}

/** Mean and greatest number of triangles over a pixel. */
export interface Overdraw {
  mean: number;
  peak: number;
}

export class Drawing {
  readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly #root: Object3D;
  readonly #camera = new PerspectiveCamera(60, 1, NEAR_M, FAR_M);
  readonly #eyes = [target(), target()];
  readonly #screen = new Scene();
  readonly #show: ShaderMaterial;
  readonly #overdraw = overdrawMaterial();
  #isClosed = false;

  constructor(canvas: HTMLCanvasElement, root: Object3D) {
    try {
      this.renderer = new WebGLRenderer({ canvas, antialias: false, depth: false });
    } catch {
      throw new UnsupportedError("This browser has no WebGL 2, which scenes need.");
    }
    this.renderer.sortObjects = false;
    this.renderer.autoClear = false;
    this.#root = root;
    this.scene.add(root);
    try {
      prepare(root, this.renderer.capabilities.maxTextureSize);
    } catch (error) {
      this.#release();
      throw error;
    }
    this.#show = new ShaderMaterial({
      depthTest: false,
      depthWrite: false,
      vertexShader: SCREEN_VERTEX,
      fragmentShader: SCREEN_FRAGMENT,
      uniforms: {
        leftEye: { value: this.#eyes[0].texture },
        rightEye: { value: this.#eyes[1].texture },
        stereo: { value: 0 },
        gain: { value: 1 },
        toneMap: { value: 0 },
        isOverdraw: { value: false },
      },
    });
    const cover = new BufferGeometry();
    cover.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const mesh = new Mesh(cover, this.#show);
    mesh.frustumCulled = false;
    this.#screen.add(mesh);
  }

  /** Draws a view into the canvas, and calls `onShown` as long as it can be copied from there; resolves when the device has drawn. */
  async draw(view: View, isOverdraw: boolean, onShown: () => void): Promise<void> {
    const [width, height] = view.size;
    const half = view.stereo === "mono" ? 0 : view.eyeDistance / 2;
    const eyeWidth = view.stereo === "side-by-side" ? Math.floor(width / 2) : width;
    this.#eyes.forEach((eye) => eye.setSize(eyeWidth, height));
    this.scene.overrideMaterial = isOverdraw ? this.#overdraw : null;
    this.#drawEye(view, this.#eyes[0], -half);
    if (half > 0) {
      this.#drawEye(view, this.#eyes[1], half);
    }
    this.scene.overrideMaterial = null;
    const { uniforms } = this.#show;
    uniforms.rightEye.value = this.#eyes[half > 0 ? 1 : 0].texture;
    uniforms.stereo.value = STEREO_NUMBERS[view.stereo];
    uniforms.gain.value = 2 ** view.exposureEv;
    uniforms.toneMap.value = TONE_MAP_NUMBERS[view.toneMap];
    uniforms.isOverdraw.value = isOverdraw;
    this.renderer.setSize(width, height, false);
    this.renderer.setRenderTarget(null);
    this.renderer.render(this.#screen, new Camera());
    onShown();
    await this.#done();
  }

  /** Counts of the left or only eye, of a picture that was drawn with overdraw. */
  overdraw(): Overdraw {
    const counts = this.#read((half) => DataUtils.fromHalfFloat(half)).filter((_, at) => at % 4 === 0);
    const sum = counts.reduce((total, count) => total + count, 0);
    return { mean: sum / counts.length, peak: counts.reduce((most, count) => Math.max(most, count), 0) };
  }

  /** Light of the left or only eye, row by row from the top. */
  pixels(): { size: [number, number]; rgba: Float32Array } {
    const { width, height } = this.#eyes[0];
    const upwards = this.#read((half) => DataUtils.fromHalfFloat(half));
    const rgba = new Float32Array(upwards.length);
    for (let row = 0; row < height; row += 1) {
      const from = 4 * width * (height - 1 - row);
      rgba.set(upwards.subarray(from, from + 4 * width), 4 * width * row);
    }
    return { size: [width, height], rgba };
  }

  /** Whether {@link Drawing.close} was called. */
  get isClosed(): boolean {
    return this.#isClosed;
  }

  /** Ends what a headset shows, and gives the graphics device all back. */
  close(): void {
    this.#isClosed = true;
    endSession(this.renderer.xr.getSession());
    this.#root.traverse((object) => {
      if (object instanceof Mesh) {
        const { geometry, material } = object as Mesh<BufferGeometry, ShaderMaterial>;
        (material.uniforms.atlas.value as Texture).dispose();
        geometry.dispose();
        material.dispose();
      }
    });
    this.#eyes.forEach((eye) => eye.dispose());
    this.#release();
  }

  /** Browsers keep a context of WebGL until its canvas is collected, and allow few at a time. */
  #release(): void {
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  #drawEye({ pose, fovDeg }: View, into: WebGLRenderTarget, offset: number): void {
    const camera = this.#camera;
    const right = rightOf(pose);
    camera.fov = fovDeg;
    camera.aspect = into.width / into.height;
    camera.updateProjectionMatrix();
    camera.position.set(...pose.eye).addScaledVector(camera.up.clone().set(...right), offset);
    camera.rotation.set(pose.pitch, pose.yaw, 0, "YXZ");
    this.renderer.setRenderTarget(into);
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.clear();
    this.renderer.render(this.scene, camera);
  }

  #read(convert: (half: number) => number): Float32Array {
    const { width, height } = this.#eyes[0];
    const halves = new Uint16Array(4 * width * height);
    this.renderer.readRenderTargetPixels(this.#eyes[0], 0, 0, width, height, halves);
    return Float32Array.from(halves, convert);
  }

  async #done(): Promise<void> {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    while (fence !== null && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) {
      await new Promise((resolve) => setTimeout(resolve, 1));
    }
    gl.deleteSync(fence);
  }
}
