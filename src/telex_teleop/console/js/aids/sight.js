// @ts-check
/** What a large view shows of the robot's surroundings: from points about the robot to places on the page. */

import { project } from "./lens.js";
import { column, dot, plus } from "./lines.js";

/** @typedef {import("../urdf.js").Vector} Vector */
/** @typedef {import("../urdf.js").Pose} Pose */
/** @typedef {import("./lens.js").Lens} Lens */
/** @typedef {[number, number]} Place  CSS pixels from the view's left upper corner. */
/** @typedef {{left: number, top: number, width: number, height: number}} Box  Of the picture in its view (CSS px). */

const NEAREST = 0.02; // m before the camera from which on lines are drawn
const PIECES = 12; // of a line between two points: the lens bends it
const BESIDE = 0.5; // of the picture, by which lines go on beside it

/**
 * Where a picture is that is shown whole in its view.
 * @param {number} width   Of the view (CSS px).
 * @param {number} height
 * @param {Lens} lens
 * @param {"top" | "middle"} at  Where it stands in a view that is higher.
 * @returns {Box}
 */
export function boxOf(width, height, lens, at) {
  const scale = Math.min(width / lens.width, height / lens.height);
  const shown = { width: scale * lens.width, height: scale * lens.height };
  return { left: (width - shown.width) / 2, top: at === "top" ? 0 : (height - shown.height) / 2, ...shown };
}

/** Of one camera, where it is now. */
export class Sight {
  /**
   * @param {Lens} lens
   * @param {Pose} pose  Of its optical frame, in the robot's root link.
   * @param {Box} box
   */
  constructor(lens, pose, box) {
    this._lens = lens;
    this.pose = pose;
    this.box = box;
    this._axes = [column(pose.rotation, 0), column(pose.rotation, 1), column(pose.rotation, 2)];
  }

  /** A direction as the camera's frame has it. @param {Vector} direction @returns {Vector} */
  _turned(direction) {
    const [x, y, z] = this._axes.map((axis) => dot(axis, direction));
    return [x, y, z];
  }

  /** Place of a point of the camera's frame. @param {Vector} point @returns {Place | null} */
  _shown(point) {
    const pixel = project(this._lens, point);
    if (pixel === null) return null;
    const { left, top, width, height } = this.box;
    // A pixel's centre is half a pixel from its edge.
    return [rounded(left + ((pixel[0] + 0.5) / this._lens.width) * width), rounded(top + ((pixel[1] + 0.5) / this._lens.height) * height)];
  }

  /** @param {Place} place @param {number} margin  Of the picture's size. */
  _isNear([x, y], margin) {
    const { left, top, width, height } = this.box;
    return x >= left - margin * width && x <= left + (1 + margin) * width && y >= top - margin * height && y <= top + (1 + margin) * height;
  }

  /** Where a point is seen; null: it is not in the picture. @param {Vector} point @returns {Place | null} */
  place(point) {
    const before = this._turned(plus(point, this.pose.translation, -1));
    const place = before[2] > NEAREST ? this._shown(before) : null;
    return place !== null && this._isNear(place, 0) ? place : null;
  }

  /** Whether any of the lines is in the picture. @param {Place[][]} lines */
  sees(lines) {
    return lines.some((line) => line.some((place) => this._isNear(place, 0)));
  }

  /** How a line between points looks, in as many pieces as it is seen in. @param {Vector[]} points @returns {Place[][]} */
  line(points) {
    return this._traced(points.map((point) => this._turned(plus(point, this.pose.translation, -1))), PIECES);
  }

  /** The same for directions, which lead to what is far away. @param {Vector[]} directions @returns {Place[][]} */
  farLine(directions) {
    return this._traced(directions.map((direction) => this._turned(direction)), 1);
  }

  /** @param {Vector[]} points  Of the camera's frame. @param {number} pieces @returns {Place[][]} */
  _traced(points, pieces) {
    /** @type {Place[][]} */
    const lines = [];
    /** @type {Place[]} */
    let line = [];
    const end = () => {
      if (line.length > 1) lines.push(line);
      line = [];
    };
    points.slice(1).forEach((to, index) => {
      const from = points[index];
      for (let piece = index === 0 ? 0 : 1; piece <= pieces; piece += 1) {
        const point = plus(from, plus(to, from, -1), piece / pieces);
        const place = point[2] > NEAREST ? this._shown(point) : null;
        if (place !== null && this._isNear(place, BESIDE)) line.push(place);
        else end();
      }
    });
    end();
    return lines;
  }
}

/** @param {number} value  To halves of a pixel: by less, nothing is drawn anew. */
const rounded = (value) => Math.round(2 * value) / 2;
