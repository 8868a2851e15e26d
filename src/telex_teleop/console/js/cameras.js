// @ts-check
/** One large view and a small one for each of the other cameras; their pictures are drawn by the video worker. */

import { setText } from "./panels.js";

export const STALLED_AFTER = 1000; // ms without a new picture after which a view counts as stalled

const THUMBNAIL_WIDTH = 208; // CSS px; they are hardly ever shown larger
const SCENE_WITHIN = 10_000; // ms after which nobody waits for the first picture of another scene

/** @typedef {import("./video.js").ViewReport} ViewReport */
/** @typedef {import("./video_source.js").VideoConfig} VideoConfig */

/** What the page knows of a view, from the worker's last report. */
export class ViewState {
  constructor() {
    /** @type {ViewReport | null} */
    this._report = null;
    /** @type {string} */
    this.camera = "";
  }

  /** @param {ViewReport} report */
  set(report) {
    // One that was on its way while the view turned to another camera is about the camera before.
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

  get live() {
    return this.age < STALLED_AFTER;
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
    return this._report?.trouble ?? "waiting for the camera";
  }
}

/** A small view of a camera that becomes the large one by a click. */
class Thumbnail {
  /** @param {(camera: string) => void} choose */
  constructor(choose) {
    this.state = new ViewState();
    this.element = document.createElement("button");
    this.element.type = "button";
    this.element.className = "thumbnail";
    this.element.tabIndex = -1;
    this.canvas = document.createElement("canvas");
    this.canvas.width = 208;
    this.canvas.height = 156;
    this._name = document.createElement("span");
    this._name.className = "hud thumbnail-name";
    this._note = document.createElement("span");
    this._note.className = "thumbnail-note num";
    this.element.append(this.canvas, this._name, this._note);
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
    setText(this._name, camera);
    this.element.dataset.camera = camera;
    this.element.title = `show ${camera} large`;
  }

  /** Show whether the picture is live. */
  refresh() {
    const { live, age } = this.state;
    const state = live ? "live" : "stalled";
    if (this.element.dataset.state !== state) this.element.dataset.state = state;
    const since = age < 100_000 ? ` ${(age / 1000).toFixed(1)} s` : "";
    setText(this._note, live ? "" : `NO PICTURE${since}`);
  }
}

/** Age (ms) from which a picture counts as none. */
const LONGEST_AGE = 3_600_000;

export class Cameras {
  /**
   * @param {VideoConfig} config
   * @param {HTMLCanvasElement} canvas  Of the large view.
   * @param {HTMLElement} column  Where the small ones go.
   * @param {(name: string) => void} named  Called with the camera that is shown large.
   * @param {URLSearchParams} [given]  Has the token and the role that the video server may ask for.
   */
  constructor(config, canvas, column, named, given = new URLSearchParams(location.search)) {
    this._config = config;
    this._access = Object.fromEntries([...given].filter(([name]) => ["token", "role", "robot"].includes(name)));
    this._column = column;
    this._named = named;
    this._worker = new Worker(new URL("video_worker.js", import.meta.url), { type: "module" });
    this._worker.onmessage = ({ data }) => this._receive(data);
    this.main = new ViewState();
    /** @type {Thumbnail[]} */
    this._thumbnails = [];
    /** The camera that was large before the one that is for a while. @type {string | null} */
    this._lent = null;
    /** When another scene was loaded whose first picture is awaited (Date.now()). */
    this._sceneLoaded = -Infinity;
    this._giveCanvas(canvas);
    const camera = config.cameras.find(({ name }) => name === config.main_camera) ?? config.cameras[0];
    this.main.camera = camera?.name ?? config.main_camera;
    this._named(this.main.camera);
    this._addViews(config.cameras);
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

  /** Whether the large view still has to show the scene that was loaded. */
  get awaitsScene() {
    return Date.now() - this._sceneLoaded < SCENE_WITHIN && !((this.main.report?.captured ?? -Infinity) > this._sceneLoaded);
  }

  /** What is seen in the large view: its camera, and how old (s) its picture is by the wall's clock; null: there is none. */
  get seen() {
    const { age, camera } = this.main;
    return { view: camera, picture_age: age < LONGEST_AGE ? age / 1000 : null };
  }

  /** Show the next camera large. */
  next() {
    if (this._thumbnails.length > 0) this.choose(this._thumbnails[0].state.camera, true);
  }

  /**
   * Show another camera large; the one that was takes its place, or the end of the column.
   * @param {string} camera
   * @param {boolean} [last]
   */
  choose(camera, last = false) {
    const thumbnail = this._thumbnails.find(({ state }) => state.camera === camera);
    if (thumbnail === undefined) return;
    this._lent = null;
    const names = this._thumbnails.map(({ state }) => state.camera);
    const before = this.main.camera;
    const reports = new Map(this._states().map((state) => [state.camera, state.report]));
    if (last) names.push(...names.splice(names.indexOf(camera), 1, before).slice(1), names.shift() ?? "");
    else names[names.indexOf(camera)] = before;
    this.main.turn(camera, reports.get(camera) ?? null);
    this._thumbnails.forEach((each, index) => each.show(names[index], reports.get(names[index]) ?? null));
    this.refresh();
    this._named(camera);
    this._tell();
  }

  /**
   * Show a camera large for a while.
   * @param {string | null} camera  Null: the one that was large before, unless another one has been chosen meanwhile.
   */
  borrow(camera) {
    if (camera !== null) {
      if (camera === this.main.camera) return;
      const before = this.main.camera;
      this.choose(camera);
      if (this.main.camera === camera) this._lent = before;
    } else if (this._lent !== null) {
      this.choose(this._lent);
    }
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
    const shown = new Set(this._states().map(({ camera }) => camera));
    for (const { name } of cameras) {
      if (shown.has(name)) continue;
      const thumbnail = new Thumbnail((camera) => this.choose(camera));
      thumbnail.show(name, null);
      this._thumbnails.push(thumbnail);
      this._column.append(thumbnail.element);
      this._giveCanvas(thumbnail.canvas);
    }
    this._column.style.setProperty("--thumbnails", String(Math.max(5, this._thumbnails.length)));
    this.refresh();
    this._tell();
  }

  _states() {
    return [this.main, ...this._thumbnails.map(({ state }) => state)];
  }

  /** @param {HTMLCanvasElement} canvas */
  _giveCanvas(canvas) {
    const offscreen = canvas.transferControlToOffscreen();
    const maxWidth = this._thumbnails.length === 0 ? Infinity : THUMBNAIL_WIDTH * window.devicePixelRatio;
    this._worker.postMessage({ view: this._thumbnails.length, canvas: offscreen, maxWidth }, [offscreen]);
  }

  _tell() {
    this._worker.postMessage({ show: this._states().map(({ camera }) => camera), hidden: document.hidden });
  }
}
