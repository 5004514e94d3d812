// The page: holds pose, film time and settings, and joins input, drawing, panels and the link.

import type { Vec3 } from "../format/types.ts";
import { NoWebGpuError } from "../gpu/device.ts";
import type { Film, Pose, Problem, RendererChoice, View } from "../player/types.ts";
import { clampEye, moveEye } from "./bounds.ts";
import { FilmClock } from "./clock.ts";
import { renderCommand } from "./command.ts";
import { Controls } from "./controls.ts";
import { byId, byteText, clause, copyText, messageOf, onPress, setText, numberText } from "./dom.ts";
import type { FilmFile } from "./film_file.ts";
import { Inspector } from "./inspector.ts";
import type { Reading } from "./inspector.ts";
import type { Action } from "./keys.ts";
import { headsetHelp, showPartsFor } from "./kinds.ts";
import { formatLink, hasPose, parseLink } from "./link.ts";
import type { Link } from "./link.ts";
import { DrawLoop } from "./loop.ts";
import { Messages, Notice } from "./notices.ts";
import type { OpenFilm } from "./opening.ts";
import { Orbit, orbitRadius } from "./orbit.ts";
import { stepOf, turned } from "./pose.ts";
import { Poster } from "./poster.ts";
import { savePicture, screenshotName } from "./screenshot.ts";
import { DEFAULTS, inRange } from "./settings.ts";
import type { OverlayName, Settings } from "./settings.ts";
import { SettingsPanel } from "./settings_panel.ts";
import { Panels } from "./panels.ts";
import { Timeline } from "./timeline.ts";

/** Milliseconds between changes of the address, and between those of the inspector and the fetched ranges. */
const LINK_MS = 400;
const PANEL_MS = 200;
/** Longest side of a picture in pixels. */
const MAX_SIDE = 8192;
/** Metres per second of held keys: this part of the longest side of the head box, within bounds. */
const MOVE_SPEED_SHARE = 0.4;
const MOVE_SPEEDS: [number, number] = [0.15, 3];
/** Milliseconds of pictures after which a lost film is loaded again by itself. */
const RELOAD_MS = 10_000;
/** Milliseconds for which a message stands of what may pass. */
const PASSING_MS = 15_000;
/** Tiles and cells are said to be missing once they are for so long. Milliseconds. */
const MISSING_MS = 400;
const SPEEDS = [0.25, 0.5, 1, 1.5, 2];

/** Opens the film for a new canvas. */
export type Opener = (file: FilmFile, canvas: HTMLCanvasElement, renderer: RendererChoice) => Promise<OpenFilm>;

/** The last picture. */
type Drawn = Pick<Reading, "stats" | "pictureMs" | "size">;

interface Shown extends OpenFilm {
  canvas: HTMLCanvasElement;
  loop: DrawLoop;
  clock: FilmClock;
}

export class Page {
  readonly #file: FilmFile;
  readonly #open: Opener;
  readonly #stage = byId("stage", HTMLElement);
  readonly #messages = new Messages();
  readonly #notice = new Notice(() => void this.load());
  readonly #panels = new Panels(() => (this.#panelsMs = -Infinity));
  readonly #settingsPanel = new SettingsPanel((change) => this.#set(change));
  readonly #inspector: Inspector;
  readonly #timeline: Timeline;
  readonly #controls: Controls;
  readonly #orbit = new Orbit();
  /** Until the film shows the same. */
  #poster: Poster | undefined;
  #settings: Settings = { ...DEFAULTS };
  #shown: Shown | undefined;
  /** None before the film is known. */
  #pose: Pose | undefined;
  #frame: number | undefined;
  #drawn: Drawn | undefined;
  #isLoading = false;
  /** The choice that the film was opened with last. */
  #renderer: RendererChoice | undefined;
  #mayReload = true;
  /** Why the processor is to draw, until it has. */
  #whyProcessor: string | undefined;
  #wantsPicture = false;
  #tickMs = 0;
  #linkMs = -Infinity;
  #panelsMs = -Infinity;
  /** When nothing was missing last. */
  #wholeMs = -Infinity;

  constructor(file: FilmFile, open: Opener) {
    this.#file = file;
    this.#open = open;
    this.#inspector = new Inspector(file.kind, (mark, isOn) => this.#mark(mark, isOn));
    // Isolated: the name may hold marks of direction.
    document.title = `\u2068${file.name}\u2069 · lightfold`;
    const name = byId("film-name", HTMLElement);
    name.title = file.name;
    setText(name, file.name);
    const parts = {
      slider: byId("timeline", HTMLInputElement),
      canvas: byId("fetched", HTMLCanvasElement),
      label: byId("frame-label", HTMLElement),
      time: byId("time-code", HTMLElement),
    };
    this.#timeline = new Timeline(parts, (frame) => this.#seek(frame));
    this.#controls = new Controls(this.#stage, {
      act: (action) => this.#act(action),
      turn: (left, up) => this.#turn(left, up),
      move: (step) => this.#move(step),
      zoom: (factor) => this.#set({ fovDeg: inRange("fovDeg", this.#settings.fovDeg * factor) }),
      hover: (part) => this.#hover(part),
      fovDeg: () => this.#settings.fovDeg,
      moveSpeed: () => this.#moveSpeed(),
      reach: () => this.#moveSpeed() * 2,
    });
    this.#buttons();
    const link = parseLink(location.hash);
    this.#settings = this.#linked(link);
    if (!hasPose(link) && link.frame === undefined && file.poster !== undefined) {
      this.#poster = new Poster(file.poster, file.kind);
    }
    if (hasPose(link) || matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.#orbit.stop();
    }
    this.#settingsPanel.show(this.#settings);
    this.#inspector.showMarks(this.#settings.marks);
    window.addEventListener("hashchange", () => this.#follow());
    new ResizeObserver(() => this.#shown?.loop.change()).observe(this.#stage);
    requestAnimationFrame((now) => this.#tick(now));
  }

  /** Loads the film, or loads it again with the same pose, frame and settings; for the processor where there is a reason to. */
  async load(whyProcessor?: string): Promise<void> {
    if (this.#isLoading) {
      return;
    }
    this.#isLoading = true;
    const { renderer } = this.#settings;
    this.#renderer = renderer;
    this.#whyProcessor = whyProcessor;
    this.#leave();
    this.#notice.opening(this.#file.name);
    try {
      await this.#openWith(whyProcessor === undefined ? renderer : "cpu");
      this.#notice.hide();
      this.#panels.restore();
    } catch (error) {
      this.#leave();
      this.#poster?.remove();
      this.#stage.replaceChildren();
      setText(byId("film-facts", HTMLElement), "");
      this.#notice.failed(error);
      if (this.#pose !== undefined) {
        this.#writeLink(this.#frame ?? 0);
      }
    } finally {
      this.#isLoading = false;
    }
    if (this.#file.kind === "lfold" && renderer !== this.#settings.renderer) {
      await this.load();
    }
  }

  /** Opens the film in a new canvas: for the processor where no device can be had. */
  async #openWith(renderer: RendererChoice): Promise<void> {
    const canvas = document.createElement("canvas");
    this.#stage.replaceChildren(canvas);
    try {
      this.#enter(await this.#open(this.#file, canvas, renderer), canvas);
    } catch (error) {
      if (!(error instanceof NoWebGpuError)) {
        throw error;
      }
      this.#whyProcessor = error.message;
      await this.#openWith("cpu");
    }
  }

  #enter(opened: OpenFilm, canvas: HTMLCanvasElement): void {
    const { player } = opened;
    const { film } = player;
    const clock = new FilmClock(film);
    // What comes of a film that was left is of no interest.
    const lost = (problem: Problem): void => {
      if (this.#shown?.player === player) {
        this.#lost(problem);
      }
    };
    const openedMs = performance.now();
    let isWhole = false;
    const loop = new DrawLoop({
      draw: (factor) => {
        isWhole = factor === 1;
        return player.draw(this.#view(factor));
      },
      onDrawn: (stats, pictureMs) => {
        if (this.#shown?.player === player) {
          this.#drawn = { stats, pictureMs, size: [canvas.width, canvas.height] };
          this.#sayProcessor();
          // A film that was shown for a while may be loaded again by itself.
          this.#mayReload ||= performance.now() - openedMs > RELOAD_MS;
        }
      },
      onFailed: (error) => lost({ fatal: true, isOfDevice: player.renderer === "gpu", message: messageOf(error) }),
      now: () => performance.now(),
    });
    this.#shown = { ...opened, canvas, loop, clock };
    player.onProblem = lost;
    player.onShown = () => {
      if (this.#wantsPicture && (isWhole || clock.isPlaying)) {
        this.#wantsPicture = false;
        this.#savePicture(canvas);
      }
    };
    const link = parseLink(location.hash);
    this.#pose ??= this.#posed(this.#start(film), link);
    this.#pose = { ...this.#pose, eye: clampEye(this.#pose.eye, film.headBox) };
    clock.isLooped = this.#settings.isLooped;
    clock.setSpeed(this.#settings.speed, performance.now());
    clock.seek(this.#frame ?? link.frame ?? startFrameOf(film), performance.now());
    this.#describe(opened);
    opened.showOverdraw?.(this.#settings.marks.has("overdraw"));
  }

  /** Words and controls for this film. */
  #describe({ player: { film, renderer }, marks, isFixed, enterHeadset }: OpenFilm): void {
    const isStill = film.frameCount < 2;
    const isQuilt = this.#file.kind === "quilt";
    showPartsFor(this.#file.kind);
    this.#stage.classList.toggle("fits", isFixed);
    if (isQuilt) {
      this.#stage.ariaDescription = "The pointer chooses the view, Space plays, H opens help.";
    }
    ["transport", "help-playing"].forEach((id) => (byId(id, HTMLElement).hidden = isStill));
    byId("headset", HTMLButtonElement).hidden = enterHeadset === undefined;
    byId("orbit", HTMLInputElement).disabled = orbitRadius(film) === 0;
    this.#timeline.setFilm(film, isQuilt ? "View" : "Frame");
    this.#inspector.setFilm(film, marks);
    // The processor takes few.
    byId("steps", HTMLSelectElement).disabled = renderer === "cpu";
    const rate = Number(film.framesPerSecond.toFixed(3));
    const moving = isQuilt ? `${film.frameCount} views` : `${film.frameCount} frames at ${rate}/s`;
    const frames = isStill ? "still" : moving;
    const { length } = film.probes;
    const probes = length === 0 ? [] : [`${numberText(length)} ${length === 1 ? "probe" : "probes"}`];
    const facts = byId("film-facts", HTMLElement);
    const small = renderer === "cpu" ? ["small pictures, drawn on the processor"] : [];
    facts.title = [...probes, frames, byteText(film.fileBytes), ...small].join(" · ");
    setText(facts, facts.title);
    setText(byId("headset-help", HTMLElement), headsetHelp(this.#file.kind, enterHeadset !== undefined));
  }

  #leave(): void {
    const shown = this.#shown;
    if (shown !== undefined) {
      this.#frame = shown.clock.frame(performance.now());
      this.#shown = undefined;
      this.#drawn = undefined;
      shown.player.close();
    }
  }

  /** Says why the processor draws, once it has. */
  #sayProcessor(): void {
    if (this.#whyProcessor !== undefined) {
      this.#messages.say(`${clause(this.#whyProcessor)}; the processor draws small pictures`, PASSING_MS);
      this.#whyProcessor = undefined;
    }
  }

  /** Shows a problem. A fatal one loads the film again, once; after a second one, the viewer has a button. If a device fails before its
   *  first picture, or a second time, the processor takes over. */
  #lost({ fatal, passes, isOfDevice = false, message }: Problem): void {
    if (!fatal) {
      this.#messages.say(message, passes === true ? PASSING_MS : Infinity);
      return;
    }
    const stats = this.#drawn?.stats;
    const hasShown = stats !== undefined && (stats.unitsMissing === 0 || stats.marchMs > 0);
    const mayReload = this.#mayReload && (hasShown || !isOfDevice);
    this.#mayReload = false;
    this.#leave();
    if (mayReload) {
      this.#messages.say(`${clause(message)}; the film is loaded again`);
      void this.load();
    } else if (isOfDevice) {
      void this.load(message);
    } else {
      this.#stage.replaceChildren();
      this.#notice.failed(message);
    }
  }

  #tick(now: number): void {
    requestAnimationFrame((next) => this.#tick(next));
    const seconds = (now - this.#tickMs) / 1000;
    this.#tickMs = now;
    const shown = this.#shown;
    if (shown === undefined) {
      return;
    }
    this.#controls.advance(seconds);
    this.#circle(shown, seconds);
    const time = performance.now();
    const frame = shown.clock.frame(time);
    if (frame !== this.#frame) {
      this.#frame = frame;
      shown.loop.move();
    }
    if (this.#settings.marks.has("fetched") && (this.#drawn?.stats.fetchRate ?? 0) > 0) {
      // What was fetched is marked for a second.
      shown.loop.change();
    }
    shown.loop.tick();
    if (shown.loop.isSettled || !this.#isAtStart(shown)) {
      this.#poster?.remove();
      this.#poster = undefined;
    }
    this.#stage.ariaBusy = String(!shown.loop.isSettled);
    this.#timeline.showFrame(frame, this.#drawn?.stats.shownFrame ?? frame);
    byId("play", HTMLButtonElement).classList.toggle("playing", shown.clock.isPlaying);
    byId("play", HTMLButtonElement).ariaLabel = shown.clock.isPlaying ? "Pause" : "Play";
    if (time - this.#panelsMs >= PANEL_MS) {
      this.#panelsMs = time;
      this.#showPanels(shown);
    }
    if (time - this.#linkMs >= LINK_MS && shown.loop.isStill && !shown.clock.isPlaying) {
      this.#linkMs = time;
      this.#writeLink(frame);
    }
  }

  /** Moves the eye by the orbit, which begins once the start is shown in full, where pictures are fast enough. */
  #circle({ player: { film }, loop }: Shown, seconds: number): void {
    if (this.#pose === undefined || this.#file.kind === "quilt") {
      return;
    }
    const moved = this.#orbit.advance(this.#pose, { film, seconds, isShown: loop.isSettled, isFluent: loop.isFluent });
    if (moved !== undefined) {
      this.#pose = { ...this.#pose, eye: clampEye(moved, film.headBox) };
      loop.move();
    }
    byId("orbit", HTMLInputElement).checked = this.#orbit.isOn;
  }

  /** True if the view is that of the poster. */
  #isAtStart({ player: { film }, clock }: Shown): boolean {
    const { eye, yaw, pitch } = this.#start(film);
    const pose = this.#pose ?? ORIGIN;
    const isSame = pose.yaw === yaw && pose.pitch === pitch && pose.eye.join() === clampEye(eye, film.headBox).join();
    return isSame && !clock.isPlaying && this.#frame === startFrameOf(film);
  }

  #savePicture(canvas: HTMLCanvasElement): void {
    const saved = savePicture(canvas, screenshotName(this.#file.name, this.#frame ?? 0));
    saved.catch((error: unknown) => this.#messages.say(messageOf(error)));
  }

  #showPanels(shown: Shown): void {
    this.#timeline.showFetched(shown.player.fetched());
    const missing = this.#drawn?.stats.unitsMissing ?? 0;
    const state = byId("state", HTMLElement);
    const now = performance.now();
    this.#wholeMs = missing === 0 ? now : this.#wholeMs;
    state.hidden = this.#drawn !== undefined && now - this.#wholeMs < MISSING_MS;
    setText(state, this.#drawn ? `${numberText(missing)} tiles and cells not loaded yet` : "Loading the first picture");
    if (this.#drawn !== undefined && this.#pose !== undefined && this.#panels.open === "inspector") {
      const [width, height] = this.#size(1);
      const half = Math.tan((this.#settings.fovDeg * Math.PI) / 360) * (width / height);
      const fovDeg = (2 * Math.atan(half) * 180) / Math.PI;
      this.#inspector.show({ ...this.#drawn, pose: this.#pose, fovDeg, command: this.#command(this.#pose) });
    }
  }

  #view(factor: number): View {
    const { marks, fovDeg, stereo, eyeDistance, exposureEv, toneMap, steps } = this.#settings;
    const overlays = new Set(
      (this.#shown?.marks ?? []).flatMap((mark) => (mark !== "overdraw" && marks.has(mark) ? [mark] : [])),
    );
    const [pose, frame, size] = [
      this.#pose ?? ORIGIN,
      this.#frame ?? 0,
      this.#size(factor, this.#shown?.player.mostPixels),
    ];
    const playing = this.#shown?.clock.isPlaying ?? false;
    return { pose, frame, playing, size, fovDeg, stereo, eyeDistance, exposureEv, toneMap, overlays, steps };
  }

  /** Width, which is even, and height of a picture at a part of the resolution, in device pixels, of which it has `most` in full. */
  #size(factor: number, most = Infinity): [number, number] {
    const [width, height] = [this.#stage.clientWidth, this.#stage.clientHeight];
    const wanted = window.devicePixelRatio * this.#settings.scale;
    const scale = factor * Math.min(wanted, MAX_SIDE / Math.max(width, height, 1), Math.sqrt(most / (width * height)));
    return [Math.max(2, 2 * Math.round((width * scale) / 2)), Math.max(1, Math.round(height * scale))];
  }

  /** The view as a command line. */
  #command(pose: Pose): string | undefined {
    const { kind, name } = this.#file;
    if (kind === "quilt") {
      return undefined;
    }
    const { fovDeg, stereo, eyeDistance } = this.#settings;
    const shot = { pose, fovDeg, stereo, eyeDistance, size: this.#size(1 / this.#settings.scale) };
    return renderCommand(name, kind === "glb" ? shot : { ...shot, frame: this.#frame ?? 0 });
  }

  #moveSpeed(): number {
    const box = this.#shown?.player.film.headBox;
    const sides = box === undefined ? [0] : box.least.map((value, axis) => box.greatest[axis] - value);
    return Math.min(Math.max(MOVE_SPEED_SHARE * Math.max(...sides), MOVE_SPEEDS[0]), MOVE_SPEEDS[1]);
  }

  #turn(left: number, up: number): void {
    if (this.#pose === undefined || this.#shown === undefined || this.#file.kind === "quilt") {
      return;
    }
    this.#orbit.stop();
    this.#pose = turned(this.#pose, left, up);
    this.#shown.loop.move();
  }

  #move(step: Vec3): void {
    if (this.#pose === undefined || this.#shown === undefined || this.#file.kind === "quilt") {
      return;
    }
    this.#orbit.stop();
    const eye = moveEye(this.#pose.eye, stepOf(this.#pose, step), this.#shown.player.film.headBox);
    this.#pose = { ...this.#pose, eye };
    this.#shown.loop.move();
  }

  /** A quilt shows the view under the pointer. */
  #hover(part: number): void {
    const shown = this.#shown;
    if (this.#file.kind === "quilt" && shown !== undefined && !shown.clock.isPlaying) {
      const { firstFrame, frameCount } = shown.player.film;
      shown.clock.seek(firstFrame + part * (frameCount - 1), performance.now());
    }
  }

  #seek(frame: number): void {
    this.#shown?.clock.pause(performance.now());
    this.#shown?.clock.seek(frame, performance.now());
  }

  #set(change: Partial<Settings>): void {
    const settings = { ...this.#settings, ...change };
    this.#settings = settings;
    this.#settingsPanel.show(settings);
    this.#inspector.showMarks(settings.marks);
    this.#panelsMs = -Infinity;
    const shown = this.#shown;
    if (shown !== undefined) {
      shown.clock.isLooped = settings.isLooped;
      shown.clock.setSpeed(settings.speed, performance.now());
      shown.showOverdraw?.(settings.marks.has("overdraw"));
      shown.loop.move();
    }
    if (this.#file.kind === "lfold" && settings.renderer !== this.#renderer) {
      void this.load();
    }
  }

  #mark(mark: OverlayName, isOn: boolean): void {
    const others = [...this.#settings.marks].filter((other) => other !== mark);
    this.#set({ marks: new Set(isOn ? [...others, mark] : others) });
  }

  /** Where the film begins. */
  #start(film: Film): Pose {
    return this.#file.start?.pose ?? film.start;
  }

  /** Settings of a link. The field of view of the start goes with its pose. */
  #linked(link: Link): Settings {
    const { start } = this.#file;
    const fovDeg = start === undefined || hasPose(link) ? DEFAULTS.fovDeg : start.fovDeg;
    return { ...DEFAULTS, fovDeg, ...link.settings };
  }

  /** A pose of the film with what a link says. */
  #posed(pose: Pose, { eye, look }: Link): Pose {
    const box = this.#shown?.player.film.headBox;
    const placed = eye !== undefined && box !== undefined ? clampEye(eye, box) : pose.eye;
    return { eye: placed, yaw: look?.[0] ?? pose.yaw, pitch: look?.[1] ?? pose.pitch };
  }

  /** Goes where the address says, as it was changed. */
  #follow(): void {
    const link = parseLink(location.hash);
    const shown = this.#shown;
    this.#orbit.stop();
    this.#pose = shown && this.#posed(this.#start(shown.player.film), link);
    this.#frame = undefined;
    if (shown !== undefined) {
      this.#seek(link.frame ?? startFrameOf(shown.player.film));
    }
    // Another renderer opens the film anew.
    this.#set(this.#linked(link));
    this.#shown?.loop.move();
  }

  #writeLink(frame: number): void {
    const hash = formatLink(this.#pose ?? ORIGIN, frame, this.#settings);
    if (hash !== location.hash) {
      history.replaceState(null, "", hash);
    }
  }

  #act(action: Action): void {
    const [shown, now] = [this.#shown, performance.now()];
    if (shown === undefined) {
      return;
    }
    if (action === "settings" || action === "inspector" || action === "help") {
      this.#panels.toggle(action);
    } else if (action === "full-screen") {
      void toggleFullScreen().catch(() => this.#messages.say("The browser allows no full screen here."));
    } else {
      this.#actOn(shown, action, now);
    }
  }

  #actOn({ clock, player, loop }: Shown, action: Action, now: number): void {
    const { film } = player;
    switch (action) {
      case "play":
        loop.change();
        return clock.isPlaying ? clock.pause(now) : clock.play(now);
      case "step-back":
        return clock.step(-1, now);
      case "step-forward":
        return clock.step(1, now);
      case "first":
        return this.#seek(film.firstFrame);
      case "last":
        return this.#seek(clock.lastFrame);
      case "loop":
        return this.#set({ isLooped: !this.#settings.isLooped });
      case "slower":
        return this.#set({ speed: SPEEDS.findLast((speed) => speed < this.#settings.speed) ?? SPEEDS[0] });
      case "faster":
        return this.#set({ speed: SPEEDS.find((speed) => speed > this.#settings.speed) ?? SPEEDS[SPEEDS.length - 1] });
      case "reset":
        this.#pose = this.#start(film);
        return loop.move();
      case "lock-pointer":
        return this.#controls.toggleLock();
      case "screenshot":
        this.#wantsPicture = true;
        return loop.change();
    }
  }

  #buttons(): void {
    const actions: Action[] = [
      "play",
      "step-back",
      "step-forward",
      "first",
      "last",
      "loop",
      "screenshot",
      "full-screen",
    ];
    actions.forEach((action) => onPress(action, () => this.#act(action)));
    for (const panel of ["settings", "inspector", "help"] as const) {
      onPress(`open-${panel}`, () => this.#act(panel));
    }
    const copy = onPress("copy-link", () => {
      if (this.#shown !== undefined) {
        this.#writeLink(this.#frame ?? 0);
      }
      void copyText(location.href, copy);
    });
    const orbit = byId("orbit", HTMLInputElement);
    orbit.addEventListener("change", () => (orbit.checked ? this.#orbit.ask() : this.#orbit.stop()));
    onPress("headset", () => {
      const asked = this.#shown?.enterHeadset?.(this.#pose ?? ORIGIN);
      asked?.catch((error: unknown) => this.#messages.say(`The headset does not open: ${messageOf(error)}`));
    });
  }
}

function startFrameOf({ startFrame, firstFrame }: Film): number {
  return startFrame ?? firstFrame;
}

const ORIGIN: Pose = { eye: [0, 0, 0], yaw: 0, pitch: 0 };

async function toggleFullScreen(): Promise<void> {
  await (document.fullscreenElement === null
    ? document.documentElement.requestFullscreen()
    : document.exitFullscreen());
}
