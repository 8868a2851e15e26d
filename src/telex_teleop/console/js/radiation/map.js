// @ts-check
/** The map: a panel that can be opened, with the way by the robot's own odometry and what was measured along it. */

import { onClick } from "../buttons.js";
import { headingOfYaw, yawOf } from "../hud.js";
import { text } from "../language.js";
import { byId, setText } from "../panels.js";
import { RadiationTrack, bearingOf } from "./track.js";
import { rateText } from "./units.js";

/** @typedef {import("./track.js").Place} Place */

const WIDTH = 280, HEIGHT = 150; // CSS pixels
const MARGIN = 18; // pixels
const LEAST_SPAN = 4; // m that the map shows at least
const ROSE = 36; // pixels, its radius
const DOT = 4; // pixels

/** From cold to hot; told by the legend's figures as well. */
const COLOURS = ["#3b6fb5", "#3fa7a0", "#7bbf4a", "#e3b341", "#f0803c", "#ff5d52"];

/**
 * @param {number} rate
 * @param {{least: number, most: number}} range
 */
export function colourOf(rate, { least, most }) {
  const share = most > least ? Math.log(Math.max(rate, least) / least) / Math.log(most / least) : 1;
  return COLOURS[Math.min(COLOURS.length - 1, Math.floor(share * COLOURS.length))];
}

export class RadiationMap {
  constructor() {
    this._track = new RadiationTrack();
    this._canvas = /** @type {HTMLCanvasElement} */ (byId("radiation-map-canvas"));
    /** Whether it is open for what was measured, and for the robot's way. */
    this._isOpen = this._isPlan = false;
    /** Called when it is closed while it is open for the robot's way. */
    this.closed = () => {};
    /** What was drawn last. */
    this._drawn = "";
    onClick(byId("radiation-map-open"), () => this._open(byId("radiation-map").hidden));
    onClick(byId("radiation-map-close"), () => this._open(false));
    onClick(byId("radiation-map-clear"), () => this._track.clear());
    /** Of the simulation, as it says. @type {number | null} */
    this._resets = null;
  }

  /** @param {boolean} isOpen */
  _open(isOpen) {
    this._isOpen = isOpen;
    if (!isOpen && this._isPlan) this.closed();
    this._show();
  }

  /** Whether it shall be open for the robot's way. @param {boolean} isPlan */
  showPlan(isPlan) {
    this._isPlan = isPlan;
    this._show();
  }

  _show() {
    byId("radiation-map").hidden = !this._isOpen && !this._isPlan;
  }

  /** After a reset the odometry begins anew. @param {{resets: number}} status  telex_msgs/SimStatus */
  hearStatus({ resets }) {
    if (this._resets !== null && this._resets !== resets) this._track.clear();
    this._resets = resets;
  }

  /** @param {any} odometry  nav_msgs/Odometry */
  move({ pose }) {
    const { position, orientation } = pose.pose;
    const yaw = yawOf(orientation);
    if ([position.x, position.y, yaw].every(Number.isFinite)) this._track.move({ x: position.x, y: position.y, yaw });
  }

  /**
   * @param {import("./dosimeter.js").Reading} reading
   * @param {number | null} direction  Of a shielded detector's axis, from the robot's (rad); null: there is none.
   */
  measure({ hull_rate: rate, tool_rate: seen }, direction) {
    byId("radiation-map-open").hidden = false;
    this._track.measure(rate, direction === null ? null : seen, direction);
  }

  /** Forget all: another scene. */
  forget() {
    this._track.clear();
    byId("radiation-map-open").hidden = true;
    this._isOpen = false;
    this._show();
  }

  /** Draw it, where it is open. */
  draw() {
    const { points, trail, place, range, hottest, rose } = this._track;
    const seen = JSON.stringify([this._track.changes, place && [place.x.toFixed(2), place.y.toFixed(2), place.yaw.toFixed(2)]]);
    if (byId("radiation-map").hidden || seen === this._drawn) return;
    this._drawn = seen;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(WIDTH * ratio), Math.round(HEIGHT * ratio)];
    if (this._canvas.width !== width) Object.assign(this._canvas, { width, height });
    const context = this._canvas.getContext("2d");
    if (context === null) return;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, WIDTH, HEIGHT);
    const fit = fitOf([...points, ...trail, ...(place === null ? [] : [place])]);
    drawGrid(context, fit);
    drawTrail(context, fit, place === null ? trail : [...trail, place]);
    for (const point of points) if (range !== null) dot(context, fit.project(point), colourOf(point.rate, range));
    if (place !== null) drawRobot(context, fit, place);
    const bearing = bearingOf(rose);
    if (place !== null && rose.length > 0) drawRose(context, fit.project(place), rose, bearing);
    const most = hottest === null || range === null ? text("way by odometry") : text("{least} to {most}", { least: rateText(range.least), most: rateText(range.most) });
    setText(byId("radiation-map-range"), most);
    setText(byId("radiation-map-bearing"), bearing === null ? "" : text("most seen at {heading}", { heading: headingOfYaw(bearing) }));
    setText(byId("radiation-map-scale"), text("squares of {length} m", { length: fit.square }));
  }
}

/**
 * How the map lies in the panel: x ahead of where the robot started is up.
 * @param {{x: number, y: number}[]} places
 */
function fitOf(places) {
  const xs = places.map(({ x }) => x), ys = places.map(({ y }) => y);
  const bounds = (/** @type {number[]} */ all) => (all.length === 0 ? [0, 0] : [Math.min(...all), Math.max(...all)]);
  const [[left, right], [low, high]] = [bounds(ys), bounds(xs)];
  const scale = Math.min(
    (WIDTH - 2 * MARGIN) / Math.max(right - left, LEAST_SPAN), (HEIGHT - 2 * MARGIN) / Math.max(high - low, LEAST_SPAN),
  );
  const middle = { x: (low + high) / 2, y: (left + right) / 2 };
  const project = (/** @type {{x: number, y: number}} */ { x, y }) =>
    /** @type {[number, number]} */ ([WIDTH / 2 - (y - middle.y) * scale, HEIGHT / 2 - (x - middle.x) * scale]);
  return { project, scale, middle, square: scale > 24 ? 1 : scale > 5 ? 5 : 20 };
}

/** @typedef {ReturnType<typeof fitOf>} Fit */

/** @param {CanvasRenderingContext2D} context  @param {Fit} fit */
function drawGrid(context, { project, scale, middle, square }) {
  context.strokeStyle = "#27303a";
  context.lineWidth = 1;
  context.beginPath();
  const half = { x: HEIGHT / scale / 2, y: WIDTH / scale / 2 };
  for (let x = Math.ceil((middle.x - half.x) / square) * square; x <= middle.x + half.x; x += square) {
    const [, v] = project({ x, y: 0 });
    context.moveTo(0, v);
    context.lineTo(WIDTH, v);
  }
  for (let y = Math.ceil((middle.y - half.y) / square) * square; y <= middle.y + half.y; y += square) {
    const [u] = project({ x: 0, y });
    context.moveTo(u, 0);
    context.lineTo(u, HEIGHT);
  }
  context.stroke();
}

/** @param {CanvasRenderingContext2D} context  @param {Fit} fit  @param {{x: number, y: number}[]} trail */
function drawTrail(context, { project }, trail) {
  context.strokeStyle = "#e6edf3";
  context.lineWidth = 2;
  context.beginPath();
  for (const each of trail) context.lineTo(...project(each));
  context.stroke();
}

/** @param {CanvasRenderingContext2D} context  @param {[number, number]} at  @param {string} colour */
function dot(context, [u, v], colour) {
  context.fillStyle = colour;
  context.beginPath();
  context.arc(u, v, DOT, 0, 2 * Math.PI);
  context.fill();
}

/** @param {CanvasRenderingContext2D} context  @param {Fit} fit  @param {Place} place */
function drawRobot(context, { project }, place) {
  const [u, v] = project(place);
  context.save();
  context.translate(u, v);
  context.rotate(-place.yaw);
  context.fillStyle = "#e6edf3";
  context.strokeStyle = "#0e1216";
  context.beginPath();
  context.moveTo(0, -9);
  context.lineTo(6, 7);
  context.lineTo(-6, 7);
  context.closePath();
  context.fill();
  context.stroke();
  context.restore();
}

/**
 * What the detector saw around, as a line about the robot.
 * @param {CanvasRenderingContext2D} context
 * @param {[number, number]} at
 * @param {{bearing: number, seen: number}[]} rose
 * @param {number | null} best
 */
function drawRose(context, [u, v], rose, best) {
  const most = Math.max(...rose.map(({ seen }) => seen));
  if (!(most > 0)) return;
  const end = (/** @type {number} */ bearing, /** @type {number} */ length) =>
    /** @type {[number, number]} */ ([u - length * Math.sin(bearing), v - length * Math.cos(bearing)]);
  context.strokeStyle = "#4fb3ff";
  context.lineWidth = 2;
  context.beginPath();
  for (const { bearing, seen } of rose) {
    context.moveTo(u, v);
    context.lineTo(...end(bearing, (ROSE * seen) / most));
  }
  context.stroke();
  if (best === null) return;
  context.strokeStyle = "#ff5d52";
  context.setLineDash([5, 4]);
  context.beginPath();
  context.moveTo(u, v);
  context.lineTo(...end(best, 2 * WIDTH));
  context.stroke();
  context.setLineDash([]);
}
