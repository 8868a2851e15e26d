// @ts-check
/** The plan of the scene from above: drawn, zoomed, moved, and pointed at by pointer or by keys. */

import { text } from "../../language.js";

const MARGIN = 0.6; // m round what is there
const STEP = 0.1, LONG_STEP = 1; // m that an arrow moves the cross
const ZOOM = 1.3, WHEEL = 0.0012;
const CLOSEST = 400, WIDEST = 2; // px for a metre
const OVERHEAD = 2; // m above the robot's base: what begins higher is a roof, and is not drawn
const FLAT = 0.06, LOW = 0.35; // m of height: to drive over, to climb
const DRAGGED = 8; // px
const SMALL = 5; // px; what can move is drawn as large as that at least
const TONES = { flat: "#2c3a47", low: "#4a5d6e", high: "#7d8f9f", movable: "#e3b341", picked: "#4fb3ff", robot: "#56c968" };
const ROBOT_LENGTH = 0.9; // m of the arrow that stands for a robot

/** @typedef {import("./scene_plan.js").ScenePlan} ScenePlan */
/** @typedef {import("./scene_plan.js").Point} Point */

export class PlanView {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {(from: Point, to: Point) => void} pointed  Where in the world (m) somebody pressed and let go.
   * @param {(at: Point) => void} crossed  Where the cross of the keys has moved to.
   */
  constructor(canvas, pointed, crossed) {
    this._canvas = canvas;
    this._pointed = pointed;
    this._crossed = crossed;
    /** @type {ScenePlan | null} */
    this._plan = null;
    /** Whether somebody has moved or zoomed it; it shows all there is until then. */
    this._isFree = false;
    this._middle = /** @type {Point} */ ([0, 0]);
    this._scale = 40; // px for a metre
    /** Where the keys point; null: they have not yet. @type {Point | null} */
    this._cross = null;
    /** @type {{id: number, from: Point, x: number, y: number, dragged: boolean} | null} */
    this._press = null;
    /** Whether a drag moves the plan. */
    this.pans = true;
    this.picked = "";
    this._listen();
  }

  /** @param {ScenePlan} plan  A change of what is there keeps where one looks; another scene does not. @param {boolean} isOther */
  show(plan, isOther) {
    this._plan = plan;
    if (isOther) this._isFree = false;
    this.draw();
  }

  /** Height (m) from which it is looked down. */
  get height() {
    const base = this._plan?.place(this._plan.robots[0]?.frame ?? -1);
    return OVERHEAD + (base?.z ?? 0);
  }

  /** Show all there is again. */
  fit() {
    this._isFree = false;
    this.draw();
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this._canvas;
    const plan = this._plan;
    if (plan === null || width === 0) return;
    if (!this._isFree) this._fit(plan, width, height);
    const ratio = window.devicePixelRatio || 1;
    if (this._canvas.width !== Math.round(width * ratio)) this._canvas.width = Math.round(width * ratio);
    if (this._canvas.height !== Math.round(height * ratio)) this._canvas.height = Math.round(height * ratio);
    const pen = /** @type {CanvasRenderingContext2D} */ (this._canvas.getContext("2d"));
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.fillStyle = "#0e1216";
    pen.fillRect(0, 0, width, height);
    this._drawGrid(pen, width, height);
    const roof = this.height;
    for (const thing of plan.things) if (thing.frame < 0 && thing.bottom < roof) this._fill(pen, thing.outlines, toneOf(thing.top));
    for (const thing of plan.things) {
      if (thing.frame >= 0) this._fill(pen, plan.outlines(thing), thing.name === this.picked ? TONES.picked : TONES.movable, true);
    }
    for (const robot of plan.robots) this._drawRobot(pen, robot.name, plan.place(robot.frame), plan.robots.length > 1);
    if (this._cross !== null && document.activeElement === this._canvas) this._drawCross(pen, this._cross);
  }

  /** @param {ScenePlan} plan  @param {number} width  @param {number} height */
  _fit(plan, width, height) {
    const { left, right, low, high } = plan.extent;
    this._middle = /** @type {Point} */ ([(left + right) / 2, (low + high) / 2]);
    this._scale = Math.min(width / (right - left + 2 * MARGIN), height / (high - low + 2 * MARGIN));
  }

  /** @param {Point} point @returns {Point} px */
  _pixel([x, y]) {
    const { clientWidth: width, clientHeight: height } = this._canvas;
    return [width / 2 + (x - this._middle[0]) * this._scale, height / 2 - (y - this._middle[1]) * this._scale];
  }

  /** @param {{clientX: number, clientY: number}} at @returns {Point} m */
  _world({ clientX, clientY }) {
    const box = this._canvas.getBoundingClientRect();
    return [
      this._middle[0] + (clientX - box.left - box.width / 2) / this._scale,
      this._middle[1] - (clientY - box.top - box.height / 2) / this._scale,
    ];
  }

  /** @param {CanvasRenderingContext2D} pen  @param {number} width  @param {number} height */
  _drawGrid(pen, width, height) {
    const spacing = [1, 2, 5, 10, 20, 50].find((each) => each * this._scale > 24) ?? 100;
    pen.strokeStyle = "#1d262e";
    pen.lineWidth = 1;
    pen.beginPath();
    const [left, right] = [width / 2 / this._scale, -width / 2 / this._scale].map((half) => this._middle[0] - half);
    const [low, high] = [height / 2 / this._scale, -height / 2 / this._scale].map((half) => this._middle[1] - half);
    for (let x = Math.ceil(left / spacing) * spacing; x <= right; x += spacing) {
      const [at] = this._pixel([x, 0]);
      pen.moveTo(at, 0);
      pen.lineTo(at, height);
    }
    for (let y = Math.ceil(low / spacing) * spacing; y <= high; y += spacing) {
      const [, at] = this._pixel([0, y]);
      pen.moveTo(0, at);
      pen.lineTo(width, at);
    }
    pen.stroke();
    pen.fillStyle = "#a7b4c0";
    pen.font = "13px system-ui, sans-serif";
    pen.fillText(text("one square is {n} m", { n: spacing }), 6, height - 7);
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {Point[][]} outlines
   * @param {string} tone
   * @param {boolean} [marked]  Small things are seen, too.
   */
  _fill(pen, outlines, tone, marked = false) {
    pen.fillStyle = tone;
    for (const outline of outlines) {
      pen.beginPath();
      for (const point of outline) pen.lineTo(...this._pixel(point));
      pen.closePath();
      pen.fill();
    }
    const points = marked ? outlines.flat().map((point) => this._pixel(point)) : [];
    if (points.length === 0) return;
    const xs = points.map(([x]) => x), ys = points.map(([, y]) => y);
    const [left, low] = [Math.min(...xs), Math.min(...ys)], [right, high] = [Math.max(...xs), Math.max(...ys)];
    if (Math.max(right - left, high - low) < SMALL) pen.fillRect((left + right - SMALL) / 2, (low + high - SMALL) / 2, SMALL, SMALL);
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {string} name
   * @param {import("./scene_plan.js").Place | null} place
   * @param {boolean} isNamed
   */
  _drawRobot(pen, name, place, isNamed) {
    if (place === null) return;
    const [x, y] = this._pixel([place.x, place.y]);
    const long = Math.max(14, ROBOT_LENGTH * this._scale);
    pen.save();
    pen.translate(x, y);
    pen.rotate(-place.heading);
    pen.beginPath();
    pen.moveTo(long / 2, 0);
    pen.lineTo(-long / 2, -long * 0.32);
    pen.lineTo(-long * 0.3, 0);
    pen.lineTo(-long / 2, long * 0.32);
    pen.closePath();
    pen.fillStyle = TONES.robot;
    pen.strokeStyle = "#0e1216";
    pen.lineWidth = 1.5;
    pen.fill();
    pen.stroke();
    pen.restore();
    if (!isNamed) return;
    pen.fillStyle = "#e6edf3";
    pen.font = "13px system-ui, sans-serif";
    pen.fillText(name, x + long / 2 + 2, y - 4);
  }

  /** @param {CanvasRenderingContext2D} pen  @param {Point} at */
  _drawCross(pen, at) {
    const [x, y] = this._pixel(at);
    for (const [tone, width] of /** @type {[string, number][]} */ ([["#000000", 4], ["#ffffff", 1.5]])) {
      pen.strokeStyle = tone;
      pen.lineWidth = width;
      pen.beginPath();
      pen.moveTo(x - 12, y);
      pen.lineTo(x + 12, y);
      pen.moveTo(x, y - 12);
      pen.lineTo(x, y + 12);
      pen.stroke();
    }
  }

  _listen() {
    const canvas = this._canvas;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      canvas.setPointerCapture(event.pointerId);
      this._press = { id: event.pointerId, from: this._world(event), x: event.clientX, y: event.clientY, dragged: false };
    });
    canvas.addEventListener("pointermove", (event) => {
      const press = this._press;
      if (press === null || press.id !== event.pointerId) return;
      press.dragged ||= Math.hypot(event.clientX - press.x, event.clientY - press.y) > DRAGGED;
      if (!press.dragged || !this.pans) return;
      const [x, y] = this._world(event);
      this._look([this._middle[0] + press.from[0] - x, this._middle[1] + press.from[1] - y], this._scale);
    });
    canvas.addEventListener("pointerup", (event) => {
      const press = this._press;
      this._press = null;
      if (press === null || (this.pans && press.dragged)) return;
      const to = this._world(event);
      this._pointed(press.dragged ? press.from : to, to);
    });
    canvas.addEventListener("pointercancel", () => { this._press = null; });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this._zoom(Math.exp(-WHEEL * event.deltaY), this._world(event));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this._type(event));
    for (const turn of ["focus", "blur"]) canvas.addEventListener(turn, () => this.draw());
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** @param {KeyboardEvent} event */
  _type(event) {
    const ways = /** @type {Record<string, Point>} */ ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] });
    const way = ways[event.key];
    if (way !== undefined) {
      const step = event.shiftKey ? LONG_STEP : STEP;
      const [x, y] = this._cross ?? this._middle;
      this._cross = [x + step * way[0], y + step * way[1]];
      this._crossed(this._cross);
      this.draw();
    } else if (event.key === "Enter" || event.key === " ") {
      if (!event.repeat && this._cross !== null) this._pointed(this._cross, this._cross);
    } else if (event.key === "+" || event.key === "-") {
      this._zoom(event.key === "+" ? ZOOM : 1 / ZOOM, this._cross ?? this._middle);
    } else if (event.key === "0") {
      this.fit();
    } else {
      return;
    }
    event.preventDefault();
  }

  /** @param {number} factor  @param {Point} about  What stays where it is. */
  _zoom(factor, [x, y]) {
    const scale = Math.min(CLOSEST, Math.max(WIDEST, this._scale * factor));
    const share = this._scale / scale;
    this._look([x + (this._middle[0] - x) * share, y + (this._middle[1] - y) * share], scale);
  }

  /** @param {Point} middle  @param {number} scale */
  _look(middle, scale) {
    this._isFree = true;
    this._middle = middle;
    this._scale = scale;
    this.draw();
  }
}

/** @param {number} top  m */
const toneOf = (top) => (top < FLAT ? TONES.flat : top < LOW ? TONES.low : TONES.high);
