// @ts-check
/** One or two large views, and a small one for each of the other cameras; their pictures are drawn by the video worker. */

import { decimal, term, text, translated } from "./language.js";
import { setText } from "./panels.js";

export const STALLED_AFTER = 1000; // ms without a new picture, or by which a scene is older than the line makes it, after which a view counts as stalled

const THUMBNAIL_WIDTH = 208; // CSS px; they are hardly ever shown larger
const SCENE_WITHIN = 10_000; // ms after which the first picture of another scene is not waited for any longer

/** @typedef {import("./video.js").ViewReport} ViewReport */
/** @typedef {import("./video_source.js").VideoConfig} VideoConfig */

/** What the page knows of a view, from the worker's last report. */
export class ViewState {
  /** @param {import("./line.js").Line} line  Its pictures come over it. */
  constructor(line) {
    this._line = line;
    /** @type {ViewReport | null} */
    this._report = null;
    /** @type {string} */
    this.camera = "";
  }

  /** @param {ViewReport} report */
  set(report) {
    // A report that was under way when the view changed is about the previous camera.
    if (report.camera === this.camera) this._report = report;
  }

  /**
   * Turn to another camera.
   * @param {string} camera
   * @param {ViewReport | null} report  The last of the view that showed it before.
   */
  turn(camera, report) {
    this.camera = camera;
    this._report = report && { ...report, width: null };
  }

  get report() {
    return this._report;
  }

  /** Age (ms) of the scene that is shown, as well as it is known; Infinity if there is none. */
  get age() {
    if (this._report === null || this._report.drawn === null) return Infinity;
    return Date.now() - Math.min(this._report.drawn, this._report.captured ?? Infinity);
  }

  /** Whether pictures come, of a scene that is no older than the line makes it. */
  get live() {
    const since = Date.now() - (this._report?.drawn ?? -Infinity);
    return since < STALLED_AFTER && this.age < STALLED_AFTER + this._line.delay;
  }

  /** How old the scene was (ms) when it was drawn; null where only its picture's arrival is known. */
  get latency() {
    return this._report?.latency ?? null;
  }

  /** Width (px) of the pictures that come; null while none has. */
  get width() {
    return this._report?.width ?? null;
  }

  /** Pictures per second. */
  get rate() {
    return this._report?.rate ?? 0;
  }

  /** Why there is no picture. */
  get trouble() {
    return translated(this._report?.trouble ?? term("waiting for the camera"));
  }
}

/** A view of a camera that changes places with the first one by a click. */
class Thumbnail {
  /**
   * @param {import("./line.js").Line} line
   * @param {(camera: string) => void} choose
   */
  constructor(line, choose) {
    this.state = new ViewState(line);
    this.element = document.createElement("button");
    this.element.type = "button";
    this.element.className = "thumbnail";
    this.canvas = document.createElement("canvas");
    this.canvas.width = 208;
    this.canvas.height = 156;
    this._name = document.createElement("b");
    this._note = document.createElement("span");
    this._note.className = "num";
    const over = document.createElement("span");
    over.className = "over";
    over.append(this._name, this._note);
    this.element.append(this.canvas, over);
    // Like every button here it leaves the focus where it is: Space must never click it.
    this.element.addEventListener("pointerdown", (event) => event.preventDefault());
    this.element.addEventListener("mousedown", (event) => event.preventDefault());
    this.element.addEventListener("click", () => choose(this.state.camera));
  }

  /**
   * @param {string} camera
   * @param {ViewReport | null} report  The last of the view that showed it before.
   */
  show(camera, report) {
    this.state.turn(camera, report);
    setText(this._name, translated(camera));
    this.element.dataset.camera = camera;
    this.element.title = text("show {camera} in the first view", { camera: translated(camera) });
  }

  /** Whether anybody can see it: the page's layout may have no place for it. */
  get isShown() {
    return this.element.offsetParent !== null;
  }

  /** Show whether the picture is live. */
  refresh() {
    const { live, age } = this.state;
    const state = live ? "live" : "stalled";
    if (this.element.dataset.state !== state) this.element.dataset.state = state;
    const since = age < 100_000 ? ` ${decimal(age / 1000, 1)} s` : "";
    setText(this._note, live ? "" : text("NO PICTURE") + since);
  }
}

/** Age (ms) from which a picture counts as none. */
const LONGEST_AGE = 3_600_000;

export class Cameras {
  /**
   * @param {VideoConfig} config
   * @param {import("./line.js").Line} line
   * @param {HTMLCanvasElement} canvas  Of the first view.
   * @param {HTMLElement[]} places  Where the others go, one after the other; the last place has all that are left, small.
   * @param {(cameras: string[]) => void} arranged  Called with the cameras of all views, the first one's first.
   * @param {URLSearchParams} [given]  Has the token and the role that the video server may ask for.
   */
  constructor(config, line, canvas, places, arranged, given = new URLSearchParams(location.search)) {
    this._config = config;
    this._line = line;
    this._access = Object.fromEntries([...given].filter(([name]) => ["token", "role", "robot"].includes(name)));
    this._places = places;
    this._arranged = arranged;
    this._worker = new Worker(new URL("video_worker.js", import.meta.url), { type: "module" });
    this._worker.onmessage = ({ data }) => this._receive(data);
    this.main = new ViewState(line);
    /** @type {Thumbnail[]} */
    this._thumbnails = [];
    /** Called when somebody has chosen what he sees. */
    this.chosen = () => {};
    /** Called when there are further cameras. */
    this.grown = () => {};
    /** When another scene was loaded whose first picture is awaited (Date.now()). */
    this._sceneLoaded = -Infinity;
    // A view that the layout has no place for, or has one for again.
    this._sizes = new ResizeObserver(() => this._tell());
    this._canvas = canvas;
    this._giveCanvas(canvas);
    const camera = config.cameras.find(({ name }) => name === config.main_camera) ?? config.cameras[0];
    /** What is in the first view unless something else is asked for. */
    this.preferred = this.main.camera = camera?.name ?? config.main_camera;
    this._addViews(config.cameras);
    this._arranged(this.order);
  }

  start() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const url = `${scheme}//${location.host}/video`;
    this._worker.postMessage({ start: { url, access: this._access, config: this._config } });
    this._tell();
    // Like the bridge's: a browser may keep a page that was left.
    let isLeft = false;
    const leave = (/** @type {boolean} */ left) => {
      if (left !== isLeft) this._worker.postMessage({ left });
      isLeft = left;
    };
    window.addEventListener("pagehide", () => leave(true));
    window.addEventListener("pageshow", () => leave(false));
    // What nobody sees need not be drawn, neither here nor by the robot's cameras.
    document.addEventListener("visibilitychange", () => this._tell());
  }

  /** Show which views are live. */
  refresh() {
    for (const thumbnail of this._thumbnails) thumbnail.refresh();
  }

  /** Another scene is loaded: pictures that were taken before are not of it. */
  newScene() {
    this._sceneLoaded = Date.now();
  }

  /** Whether the first view still has to show the scene that was loaded. */
  get awaitsScene() {
    return Date.now() - this._sceneLoaded < SCENE_WITHIN && !((this.main.report?.captured ?? -Infinity) > this._sceneLoaded);
  }

  /** What is seen in the first view: its camera, and how old (s) its picture is by the wall's clock; null: there is none. */
  get seen() {
    const { age, camera } = this.main;
    return { view: camera, picture_age: age < LONGEST_AGE ? age / 1000 : null };
  }

  /** Cameras of all views, the first one's first. */
  get order() {
    return this._states().map(({ camera }) => camera);
  }

  /** The views that are large, as far as they are shown: what each shows, where, and what stands over it. */
  get large() {
    const main = /** @type {HTMLElement} */ (this._canvas.parentElement);
    const others = this._thumbnails.slice(0, this._places.length - 1).filter(({ isShown }) => isShown);
    return [{ state: this.main, element: main }, ...others].map(({ state: { camera, live }, element }) =>
      ({ camera, live, element, isFirst: element === main, over: /** @type {HTMLElement | null} */ (element.querySelector(".over")) }));
  }

  /**
   * Show the next one of the cameras that are small.
   * @param {number} [place]  Of the large view in which.
   */
  next(place = 0) {
    const { order } = this;
    const [camera] = order.splice(this._places.length, 1);
    if (camera === undefined) return this.choose(order[1]);
    order.push(...order.splice(place, 1, camera));
    this.arrange(order);
    this.chosen();
  }

  /** Let a camera change places with that of the first view. @param {string} camera */
  choose(camera) {
    const { order } = this;
    if (!order.includes(camera)) return;
    order[order.indexOf(camera)] = order[0];
    order[0] = camera;
    this.arrange(order);
    this.chosen();
  }

  /** Show cameras in this order; those that are not named follow as they stand. @param {string[]} cameras */
  arrange(cameras) {
    const { order: before } = this;
    const order = [...new Set([...cameras.filter((camera) => before.includes(camera)), ...before])];
    if (order.join() === before.join()) return;
    const reports = new Map(this._states().map((state) => [state.camera, state.report]));
    this.main.turn(order[0], reports.get(order[0]) ?? null);
    this._thumbnails.forEach((each, index) => each.show(order[index + 1], reports.get(order[index + 1]) ?? null));
    this.refresh();
    this._arranged(order);
    this._tell();
  }

  /** @param {any} message  From the worker. */
  _receive(message) {
    if (message.cameras !== undefined) this._addViews(message.cameras);
    if (message.views === undefined) return;
    const states = this._states();
    message.views.forEach((/** @type {any} */ report, /** @type {number} */ index) => states[index]?.set(report));
  }

  /** @param {{name: string}[]} cameras  All that are published. */
  _addViews(cameras) {
    const shown = new Set(this.order);
    for (const { name } of cameras) {
      if (shown.has(name)) continue;
      const thumbnail = new Thumbnail(this._line, (camera) => this.choose(camera));
      thumbnail.show(name, null);
      this._thumbnails.push(thumbnail);
      this._giveCanvas(thumbnail.canvas);
      this._places[Math.min(this._thumbnails.length, this._places.length) - 1].append(thumbnail.element);
      this._sizes.observe(thumbnail.element);
    }
    this.refresh();
    this._tell();
    this.grown();
  }

  _states() {
    return [this.main, ...this._thumbnails.map(({ state }) => state)];
  }

  /** @param {HTMLCanvasElement} canvas */
  _giveCanvas(canvas) {
    const offscreen = canvas.transferControlToOffscreen();
    const view = this._thumbnails.length;
    const maxWidth = view < this._places.length ? Infinity : THUMBNAIL_WIDTH * window.devicePixelRatio;
    this._worker.postMessage({ view, canvas: offscreen, maxWidth }, [offscreen]);
  }

  _tell() {
    const shown = [this.main.camera, ...this._thumbnails.filter(({ isShown }) => isShown).map(({ state }) => state.camera)];
    this._worker.postMessage({ show: this.order, shown: document.hidden ? [] : shown });
  }
}
