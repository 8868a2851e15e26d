// @ts-check
/** The robot from its right side and from above, in its present pose. */

import { transform } from "./urdf.js";

/** @typedef {import("./urdf.js").RobotModel} RobotModel */
/** @typedef {import("./urdf.js").Pose} Pose */
/** @typedef {import("./urdf.js").Vector} Vector */
/** @typedef {[number, number]} Point */

/** Region that is always shown (m, of the root link); the picture shrinks to show an arm that reaches further. */
const ROOM = 0.45;
const MARGIN = 6; // px
/** Half the height of a belt (m) that stands on the ground, where the URDF says it only by a mesh. */
const WHEEL_RADIUS = 0.085;
const TIP_RADIUS = 0.045;
const BELT_WIDTH = 0.07;
const HULL_HEIGHT = 0.155;
const BAR_RADIUS = 0.03; // m

const COLOURS = {
  belt: "#52606d", hull: "#6a7987", body: "#93a3b1", arm: "#4fb3ff", gripper: "#b7e3ff", ground: "#9aa8b5",
};

/**
 * Convex hull (Andrew's monotone chain).
 * @param {Point[]} points
 * @returns {Point[]}
 */
export function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (/** @type {Point[]} */ from) => {
    /** @type {Point[]} */
    const chain = [];
    for (const [x, y] of from) {
      for (;;) {
        const a = chain.at(-2), b = chain.at(-1);
        if (a === undefined || b === undefined) break;
        if ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) > 0) break;
        chain.pop();
      }
      chain.push([x, y]);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

/** @param {Point} centre @param {number} radius @returns {Point[]} */
function disc([x, y], radius) {
  return Array.from({ length: 20 }, (_, i) => {
    const angle = (Math.PI * i) / 10;
    return /** @type {Point} */ ([x + radius * Math.cos(angle), y + radius * Math.sin(angle)]);
  });
}

/** @type {Record<"side" | "top", (point: Vector) => Point>} */
const PROJECTIONS = {
  side: ([x, , z]) => [x, -z],
  top: ([x, y]) => [x, -y],
};

export class Avatar {
  /**
   * @param {HTMLCanvasElement} side
   * @param {HTMLCanvasElement} top
   * @param {import("./robot.js").Facts} facts  Which joints move flippers, arm and gripper.
   */
  constructor(side, top, { moves }) {
    this._canvases = { side, top };
    this._moves = moves ?? { arm: [], gripper: [], flipper: [] };
    /** @type {RobotModel | null} */
    this._model = null;
    this._last = "";
  }

  /** @param {RobotModel} model */
  setModel(model) {
    this._model = model;
    this._last = "";
  }

  /**
   * @param {(joint: string) => number} position  rad or m
   * @param {number} pitch  rad, positive with the nose down
   */
  draw(position, pitch) {
    if (this._model === null) return;
    const pose = JSON.stringify([
      ...this._model.joints.filter(({ limits }) => limits !== null).map(({ name }) => position(name).toFixed(2)),
      pitch.toFixed(2), ...Object.values(this._canvases).flatMap(({ clientWidth, clientHeight }) => [clientWidth, clientHeight]),
    ]);
    if (pose === this._last) return;
    this._last = pose;
    const poses = this._model.poses(position);
    for (const view of /** @type {("side" | "top")[]} */ (["side", "top"])) this._draw(view, poses, view === "side" ? pitch : 0);
  }

  /**
   * @param {"side" | "top"} view
   * @param {Map<string, Pose>} poses
   * @param {number} pitch
   */
  _draw(view, poses, pitch) {
    const canvas = this._canvases[view];
    const width = canvas.clientWidth, height = canvas.clientHeight;
    const density = window.devicePixelRatio;
    if (width === 0) return;
    if (canvas.width !== width * density) canvas.width = width * density;
    if (canvas.height !== height * density) canvas.height = height * density;
    const pieces = this._pieces(PROJECTIONS[view], poses);
    if (pieces.length === 0) return; // everything is a mesh
    const points = pieces.flatMap(({ outline }) => outline);
    const bounds = (/** @type {0 | 1} */ axis) => {
      const values = points.map((point) => point[axis]);
      return [Math.min(...values), Math.max(...values)];
    };
    const [left, right] = bounds(0), [up, down] = bounds(1);
    const spanX = Math.max(right, ROOM) - Math.min(left, -ROOM), spanY = Math.max(down - up, 0.4);
    const scale = Math.min((width - 2 * MARGIN) / spanX, (height - 2 * MARGIN) / spanY);
    const middle = (Math.max(right, ROOM) + Math.min(left, -ROOM)) / 2;
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.setTransform(density, 0, 0, density, 0, 0);
    context.clearRect(0, 0, width, height);
    context.translate(width / 2, view === "side" ? height - MARGIN : height / 2);
    context.scale(scale, scale);
    if (view === "side") {
      context.strokeStyle = COLOURS.ground;
      context.setLineDash([4 / scale, 3 / scale]);
      context.lineWidth = 1 / scale;
      context.beginPath();
      context.moveTo(-width, 0);
      context.lineTo(width, 0);
      context.stroke();
      context.setLineDash([]);
      context.translate(0, -down);
      context.rotate(pitch);
    } else {
      context.translate(0, -(up + down) / 2);
    }
    context.translate(-middle, 0);
    context.lineWidth = 0.7 / scale;
    context.lineJoin = "round";
    for (const { outline, colour } of pieces) {
      context.beginPath();
      for (const [x, y] of outline) context.lineTo(x, y);
      context.closePath();
      context.fillStyle = colour;
      context.strokeStyle = "#0e1216";
      context.fill();
      context.stroke();
    }
  }

  /**
   * Outlines, the furthest first.
   * @param {(point: Vector) => Point} project
   * @param {Map<string, Pose>} poses
   */
  _pieces(project, poses) {
    const model = /** @type {RobotModel} */ (this._model);
    const isTop = project === PROJECTIONS.top;
    /** @type {{outline: Point[], colour: string, depth: number}[]} */
    const pieces = [];
    /** Flippers by their end and side. @type {Map<string, Vector>} */
    const axles = new Map();
    for (const joint of model.joints) {
      const pose = poses.get(joint.child);
      if (!this._moves.flipper.includes(joint.name) || pose === undefined) continue;
      const axle = pose.translation;
      const side = axle[1] > 0 ? "left" : "right";
      axles.set(`${side} ${axle[0] >= 0 ? "front" : "rear"}`, axle);
      // Twice as far as its centre of mass is about its length, and its tip is thinner than its root.
      const [x, y, z] = model.centres.get(joint.child) ?? [0, 0, 0];
      const tip = transform(pose, [2.05 * x, y, 2.05 * z]);
      pieces.push({ ...this._belt(project, isTop, axle, tip, WHEEL_RADIUS, TIP_RADIUS), depth: side === "left" ? -1 : 3 });
    }
    for (const side of ["left", "right"]) {
      const front = axles.get(`${side} front`), rear = axles.get(`${side} rear`);
      if (front === undefined || rear === undefined) continue;
      const inward = (/** @type {Vector} */ [x, y, z]) =>
        /** @type {Vector} */ ([x, y - Math.sign(y) * BELT_WIDTH, z]);
      pieces.push({
        ...this._belt(project, isTop, inward(front), inward(rear), WHEEL_RADIUS, WHEEL_RADIUS), depth: side === "left" ? 0 : 2,
      });
    }
    const [frontLeft, rearRight] = [axles.get("left front"), axles.get("right rear")];
    if (frontLeft !== undefined && rearRight !== undefined) {
      // The hull itself is a mesh; it is drawn between the belts, up to the lowest part that stands on it.
      const inset = 1.5 * BELT_WIDTH;
      /** @type {Point[]} */
      const corners = [];
      for (const x of [frontLeft[0], rearRight[0]]) {
        for (const y of [frontLeft[1] - inset, rearRight[1] + inset]) {
          for (const z of [0, HULL_HEIGHT]) corners.push(project([x, y, frontLeft[2] + z]));
        }
      }
      pieces.push({ outline: hull(corners), colour: COLOURS.hull, depth: isTop ? 3 : 1 });
    }
    const gripper = model.movedBy(this._moves.gripper), arm = model.movedBy(this._moves.arm);
    // A link that is a mesh is drawn as bars to the links that it carries.
    for (const { name, type, parent, child } of model.joints) {
      const from = poses.get(parent), to = poses.get(child);
      const isDrawn = !model.meshes.has(parent) || type === "fixed" || this._moves.flipper.includes(name) || (axles.size > 0 && parent === model.root);
      if (from === undefined || to === undefined || isDrawn) continue;
      const outline = hull([from, to].flatMap(({ translation }) => disc(project(translation), BAR_RADIUS)));
      const colour = gripper.has(parent) ? COLOURS.gripper : arm.has(parent) ? COLOURS.arm : COLOURS.body;
      pieces.push({ outline, colour, depth: isTop ? 4 + to.translation[2] : 4 });
    }
    for (const [link, shapes] of model.shapes) {
      const pose = poses.get(link);
      if (pose === undefined) continue;
      const isGripper = gripper.has(link), isArm = arm.has(link);
      const colour = isGripper ? COLOURS.gripper : isArm ? COLOURS.arm : COLOURS.body;
      for (const { points } of shapes) {
        const corners = points.map((point) => transform(pose, point));
        const mean = (/** @type {1 | 2} */ axis) => corners.reduce((sum, corner) => sum + corner[axis], 0) / corners.length;
        // Seen from the right, what is nearer is in front: an arm before the hull, wheels on either side of it.
        const depth = isTop ? 4 + mean(2) : isGripper ? 6 : isArm ? 4 : 1 - mean(1);
        pieces.push({ outline: hull(corners.map(project)), colour, depth });
      }
    }
    return pieces.sort((a, b) => a.depth - b.depth);
  }

  /**
   * @param {(point: Vector) => Point} project
   * @param {boolean} isTop
   * @param {Vector} from
   * @param {Vector} to
   * @param {number} fromRadius
   * @param {number} toRadius
   */
  _belt(project, isTop, from, to, fromRadius, toRadius) {
    const ends = /** @type {[Vector, number][]} */ ([[from, fromRadius], [to, toRadius]]);
    const corners = ends.flatMap(([centre, radius]) => {
      if (!isTop) return disc(project(centre), radius);
      const [x, y] = project(centre);
      const half = BELT_WIDTH / 2;
      return /** @type {Point[]} */ ([[x - radius, y - half], [x + radius, y - half], [x - radius, y + half], [x + radius, y + half]]);
    });
    return { outline: hull(corners), colour: COLOURS.belt };
  }
}
