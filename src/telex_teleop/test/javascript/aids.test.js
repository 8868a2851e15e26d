import assert from "node:assert/strict";
import { test } from "node:test";

import "./browser.js";
import { bandFigures, ribbonOf, zoomText } from "../../console/js/aids/band.js";
import { Calibrations } from "../../console/js/aids/calibrations.js";
import { aimFigures, contactFigures, gapFigures, guideFigures } from "../../console/js/aids/figures.js";
import { fieldOf, lensOf, project, zoomed } from "../../console/js/aids/lens.js";
import { floorThrough, gearOf, guideLines, horizon, levelAhead, upward } from "../../console/js/aids/lines.js";
import { boundsOf } from "../../console/js/aids/painter.js";
import { Sight, boxOf } from "../../console/js/aids/sight.js";

/** @typedef {import("../../console/js/urdf.js").Vector} Vector */

const D = [-0.12, 0.02, 0.0002, -0.0003, 0];
const info = (/** @type {object} */ more = {}) => ({
  header: { frame_id: "eye" }, width: 640, height: 480, distortion_model: "plumb_bob", D, K: [400, 0, 319.5, 0, 400, 239.5, 0, 0, 1], ...more,
});
/** Places are rounded to halves of a pixel. */
const ROUNDED = 0.2501;
const near = (/** @type {number} */ a, /** @type {number} */ b, tolerance = 1e-9) => assert.ok(Math.abs(a - b) < tolerance, `${a} is not ${b}`);
const allNear = (/** @type {number[]} */ found, /** @type {number[]} */ wanted, tolerance = 1e-9) => {
  assert.equal(found?.length, wanted.length);
  found.forEach((each, index) => near(each, wanted[index], tolerance));
};

/** Looks along the robot's x axis from this height (m), level. @param {number} z */
const level = (z) => ({ rotation: [0, 0, 1, -1, 0, 0, 0, -1, 0], translation: /** @type {Vector} */ ([0, 0, z]) });
const FLAT = { z: 0, alongX: 0, alongY: 0 };
const GEAR = { front: 0.4, rear: -0.4, half: 0.2, bottom: 0 };

/** Without distortion; a pixel of the page is one of the camera. @param {any} pose */
const sight = (pose) => new Sight(lensOf(info({ D: [] })), pose, { left: 0, top: 0, width: 640, height: 480 });

test("a point is shown where plumb_bob says, worked out by hand", () => {
  // x 0.5, y 0.25: r2 0.3125, radial 1 - 0.0375 + 0.001953125 = 0.964453125;
  // u 0.4822265625 + 0.00005 - 0.00024375, v 0.24111328125 + 0.0000875 - 0.000075; times 400.
  allNear(project(lensOf(info()), [1, 0.5, 2]) ?? [], [512.313125, 335.9503125]);
  allNear(project(lensOf(info({ D: [] })), [1, 0.5, 2]) ?? [], [519.5, 339.5]);
  allNear(project(zoomed(lensOf(info()), 2), [1, 0.5, 2]) ?? [], [705.12625, 432.400625]);
});

test("what is behind the camera, or where the lens folds its picture back, is not shown", () => {
  const lens = lensOf(info({ D: [-0.5, 0, 0, 0, 0] })); // folds at r2 = 2/3
  assert.equal(project(lens, [0.5, 0, -1]), null);
  assert.equal(project(lens, [0.5, 0, 0]), null);
  assert.equal(project(lens, [0.9, 0, 1]), null);
  assert.notEqual(project(lens, [0.7, 0, 1]), null);
});

test("a calibration that is none is refused with the reason", () => {
  const why = (/** @type {object} */ more) => () => lensOf(info(more));
  assert.throws(why({ K: [0, 0, 0, 0, 0, 0, 0, 0, 0] }), /not calibrated/);
  assert.throws(why({ K: [null, 0, 1, 0, 400, 1, 0, 0, 1] }), /numbers that are none/);
  assert.throws(why({ distortion_model: "equidistant", D: [0.1, 0, 0, 0] }), /"equidistant" with 4 numbers; only plumb_bob/);
  assert.throws(why({ D: [0.1, 0, 0, 0, 0, 0.1, 0, 0] }), /"plumb_bob" with 8 numbers/);
  assert.doesNotThrow(why({ distortion_model: "", D: [] }));
});

test("the angle of view is that of the lens, also when it bends", () => {
  near(fieldOf(lensOf(info({ D: [] }))), 2 * Math.atan(0.8));
  // 90 degrees: the edge at slope 1 is shown at 1 - 0.12 + 0.02 of the focal length.
  const fx = 320 / 0.9;
  near(fieldOf(lensOf(info({ K: [fx, 0, 319.5, 0, fx, 239.5, 0, 0, 1] }))), Math.PI / 2, 1e-6);
  assert.equal(zoomText(2.04, 0.5), "zoom 2.0×, 29° wide");
  assert.equal(zoomText(null, 0.5), "29° wide");
});

test("the floor is the plane through what carries the robot, where that is one", () => {
  const corners = /** @type {Vector[]} */ ([[0.3, 0.2, -0.05], [0.3, -0.2, -0.05], [-0.3, 0.2, -0.17], [-0.3, -0.2, -0.17]]);
  const floor = floorThrough(corners);
  assert.ok(floor);
  near(floor.z, -0.11);
  near(floor.alongX, 0.2);
  near(floor.alongY, 0);
  assert.equal(floorThrough(corners.slice(0, 2)), null);
  assert.equal(floorThrough([[0, 0, 0], [1, 0, 0], [2, 0, 0]]), null); // all in a line
  assert.equal(floorThrough([...corners, [NaN, 0, 0]]), null);
  assert.equal(floorThrough([[0, 0, 0], [0.3, 0, 0.3], [0, 0.3, 0]]), null); // a wall
});

test("guide lines lie on the floor, and count along it from the end of the tracks", () => {
  const gear = gearOf([[0.28, 0.17, 0.02], [-0.28, -0.17, 0.02]], 0.11, 0.2);
  assert.deepEqual(gear && [gear.half, gear.front.toFixed(3), gear.rear.toFixed(3), gear.bottom.toFixed(3)], [0.2, "0.390", "-0.390", "-0.090"]);
  assert.equal(gearOf([], 0.11, 0.2), null);
  assert.equal(gearOf([[0, 0, 0]], /** @type {any} */ (undefined), 0.2), null);
  const [half, one, two] = guideLines(GEAR, { z: -0.1, alongX: 0.75, alongY: 0 }, 1); // 3-4-5
  assert.deepEqual([half, one, two].map(({ distance }) => distance), [0.5, 1, 2]);
  allNear(one.rung[0], [1.2, 0.2, 0.8]);
  allNear(one.rung[1], [1.2, -0.2, 0.8]);
  allNear(one.sides[1][0], half.rung[1]);
  allNear(guideLines(GEAR, FLAT, -1)[1].rung[0], [-1.4, 0.2, 0]);
});

test("guide lines are drawn where the camera shows the floor, and not where it looks elsewhere", () => {
  const figures = guideFigures(sight(level(0.4)), GEAR, FLAT);
  const labels = figures.flatMap((each) => (each.kind === "label" ? [each.words] : []));
  assert.deepEqual(labels, ["0.5 m", "1 m", "2 m"]);
  const rung = figures.flatMap((each) => (each.kind === "lines" && each.width === 3 ? [each.lines.at(-1) ?? []] : []))[0];
  // 1.4 m ahead of the camera, 0.4 m below it and 0.2 m to either side, at a focal length of 400.
  allNear(rung[0], [320 - (400 * 0.2) / 1.4, 240 + (400 * 0.4) / 1.4], ROUNDED);
  allNear(rung[rung.length - 1], [320 + (400 * 0.2) / 1.4, 240 + (400 * 0.4) / 1.4], ROUNDED);
  const upwards = { rotation: [0, -1, 0, -1, 0, 0, 0, 0, -1].map((each) => -each), translation: /** @type {Vector} */ ([0, 0, 0.4]) };
  assert.deepEqual(guideFigures(sight(upwards), GEAR, FLAT), []);
});

test("the horizon is level in the world whatever the robot's attitude", () => {
  allNear(upward(0, 0.1), [-Math.sin(0.1), 0, Math.cos(0.1)]);
  allNear(upward(0.1, 0), [0, Math.sin(0.1), Math.cos(0.1)]);
  const lines = sight(level(0)).farLine(horizon(level(0), upward(0, 0.1)));
  // Nose down by 0.1 rad: the horizon is above the middle.
  assert.ok(lines[0].length > 5);
  for (const [, v] of lines[0]) near(v, 240 - 400 * Math.tan(0.1), ROUNDED);
  assert.deepEqual(horizon({ rotation: [0, -1, 0, -1, 0, 0, 0, 0, -1], translation: [0, 0, 0] }, [0, 0, 1]), []); // looks down
  assert.equal(levelAhead({ rotation: [0, -1, 0, -1, 0, 0, 0, 0, -1], translation: [0, 0, 0] }, [0, 0, 1]), null);
});

test("a line ends where it comes behind the camera", () => {
  const [line] = sight(level(0.4)).line([[-1, 0.1, 0], [3, 0.1, 0]]);
  for (const [, v] of line) assert.ok(v > 240 && v <= 480 * 1.5);
  assert.deepEqual(sight(level(0.4)).line([[-2, 0.1, 0], [-1, 0.1, 0]]), []);
});

test("a canvas covers no more of its view than is painted", () => {
  /** @type {import("../../console/js/aids/figures.js").Figure[]} */
  const figures = [
    { kind: "lines", lines: [[[300, 400], [500, 450]]], colour: "#fff", width: 3 },
    { kind: "sign", shape: "ring", at: [600, 420], colour: "#fff", size: 9 },
    { kind: "label", at: [310, 440], words: "1 m", align: "right" },
  ];
  assert.deepEqual(boundsOf(figures, 1000, 700), { left: 256, top: 384, width: 384, height: 128 });
  // What lies beside the view needs no canvas.
  const { left, top, width, height } = boundsOf([{ ...figures[0], lines: [[[-900, 650], [1900, 1200]]] }], 1000, 700);
  assert.deepEqual([left, top + height], [0, 700]);
  assert.ok(width === 1000 && height > 0);
  const beyond = boundsOf([{ ...figures[0], lines: [[[1400, 100], [1900, 200]]] }], 1000, 700);
  assert.ok(beyond.width >= 1 && beyond.height >= 1 && Number.isFinite(beyond.left));
});

test("a picture that is shown whole has its place in its view", () => {
  const lens = lensOf(info());
  assert.deepEqual(boxOf(320, 300, lens, "top"), { left: 0, top: 0, width: 320, height: 240 });
  assert.deepEqual(boxOf(320, 300, lens, "middle"), { left: 0, top: 30, width: 320, height: 240 });
  assert.deepEqual(boxOf(500, 240, lens, "middle"), { left: 90, top: 0, width: 320, height: 240 });
});

/** @type {import("../../console/js/aids/figures.js").Aim} */
const AIM = { origin: [0.2, 0, 0], ahead: [1, 0, 0], across: [0, 1, 0], middle: [0.3, 0, 0] };
const words = (/** @type {import("../../console/js/aids/figures.js").Shown} */ shown) => shown.plates.map((each) => each.words);

test("the aim line says its range, and differs where it has none", () => {
  const measured = aimFigures(sight(level(0.2)), AIM, 0.42, "", true), none = aimFigures(sight(level(0.2)), AIM, null, "", false);
  assert.deepEqual([measured.plates, none.plates], [[{ words: "range 0.42 m", isAid: true }], []]);
  assert.deepEqual(words(aimFigures(sight(level(0.2)), AIM, null, "> 10 m", false)), ["range > 10 m"]);
  const shapes = (/** @type {any[]} */ figures) => figures.flatMap((each) => (each.kind === "sign" ? [each.shape] : []));
  assert.deepEqual([shapes(measured.figures), shapes(none.figures)], [["disc", "ring"], ["disc", "disc", "disc", "triangle"]]);
  const at = /** @type {any} */ (measured.figures.find((each) => each.kind === "sign" && each.shape === "ring")).at;
  allNear(at, [320, 240 + (400 * 0.2) / 0.62], 0.06);
});

test("the gap of the fingers stands at the object, and says whether it fits", () => {
  const gap = (/** @type {number | null} */ width, aim = AIM) => gapFigures(sight(level(0.2)), aim, 0.1, 0.3, width, false);
  const [left, right] = /** @type {any} */ (gap(null).figures[1]).lines;
  near(left[0][0], 320 - (400 * 0.05) / 0.6, ROUNDED);
  near(right[0][0], 320 + (400 * 0.05) / 0.6, ROUNDED);
  assert.deepEqual(gap(null).plates, [{ words: "gap 100 mm", isAid: false }]);
  assert.deepEqual(gap(0.09).plates, [{ words: "gap 100 mm", isAid: false }, { words: "✔ fits", isAid: true }]);
  assert.deepEqual(words(gap(0.098)), ["gap 100 mm", "✖ does not fit"]);
  assert.deepEqual(gap(null, { ...AIM, across: null }).figures, []);
});

test("contact, a weak grip and slip differ by shape and word", () => {
  const pad = { at: /** @type {Vector} */ ([0.5, 0, 0.2]), force: 12.4, slips: false, speed: 0.012, weak: false };
  const shown = contactFigures(sight(level(0.2)), [pad, { ...pad, weak: true }, { ...pad, slips: true }], false);
  assert.deepEqual(words(shown), ["● 12 N", "▲ weak 12 N", "◆ SLIPS 12 mm/s"]);
  assert.equal(new Set(shown.figures.flatMap((each) => (each.kind === "sign" ? [each.shape] : []))).size, 3);
});

test("the ribbon shows headings on both sides of north, and the nose", () => {
  const { ticks, nose } = ribbonOf(-5, 40, { left: 0, top: 0, width: 248 });
  assert.deepEqual(ticks.map((tick) => tick.words).filter(Boolean), ["300", "330", "000", "030"]);
  assert.equal(nose, 210);
  assert.equal(ribbonOf(170, -100, { left: 0, top: 0, width: 248 }).nose, null);
  assert.equal(ribbonOf(170, -160, { left: 0, top: 0, width: 248 }).nose, 180);
});

test("the band keeps to the upper third of the picture, below what stands there", () => {
  const box = { left: 0, top: 0, width: 600, height: 450 }, compass = { heading: 0, nose: 0 };
  const kinds = (/** @type {number} */ top) => bandFigures(box, top, compass, [{ words: "zoom", isAid: false }], 0).map(({ kind }) => kind);
  assert.deepEqual([40, 100, 130].map(kinds), [["ribbon", "plates"], ["ribbon", "plates"], ["plates"]]);
  const [, plates] = /** @type {any[]} */ (bandFigures(box, 40, compass, [{ words: "✔ fits", isAid: true }], 56));
  assert.deepEqual([plates.top, plates.bottom, plates.right], [74, 150, 540]);
  assert.deepEqual(plates.plates.map((/** @type {any} */ each) => each.words), ["✔ fits", "training aid"]);
});

/** A bridge of whose topics messages are played. */
class FakeBridge {
  connected = true;
  /** @type {Map<string, (message: any) => void>} */
  heard = new Map();

  /** @param {{topic: string, heard: (message: any) => void}} subscription */
  subscribe({ topic, heard }) {
    this.heard.set(topic, heard);
  }

  /** @param {string} topic */
  unsubscribe(topic) {
    this.heard.delete(topic);
  }
}

test("a calibration is asked for once, follows the zoom, and is asked for anew when it rests", (context) => {
  /** What waits for its time. @type {(() => void)[]} */
  const timers = [];
  // node:test's own timers are called otherwise by every version of Node.
  context.mock.method(globalThis, "setTimeout", (/** @type {() => void} */ timer) => timers.push(timer));
  context.mock.method(globalThis, "clearTimeout", () => timers.splice(0));
  const bridge = new FakeBridge();
  /** @type {string[]} */
  const warned = [];
  const calibrations = new Calibrations(/** @type {any} */ (bridge), (name) => `/r/${name}`, (sentence) => warned.push(sentence));
  const eye = "/r/cameras/eye/camera_info";
  assert.deepEqual(calibrations.of(["eye"]), [null]);
  bridge.heard.get(eye)?.(info());
  assert.equal(bridge.heard.size, 0);
  const fx = () => calibrations.of(["eye"])[0]?.lens.fx;
  assert.equal(fx(), 400);
  // Nobody had said with which zoom that was.
  calibrations.hearZoom("eye", 2);
  assert.equal(fx(), undefined);
  bridge.heard.get(eye)?.(info({ K: [800, 0, 319.5, 0, 800, 239.5, 0, 0, 1] }));
  calibrations.hearZoom("eye", 3);
  assert.equal(fx(), 1200);
  assert.equal(bridge.heard.size, 0);
  timers.splice(0).forEach((timer) => timer());
  assert.equal(fx(), 1200);
  bridge.heard.get(eye)?.(info({ K: [1190, 0, 319.5, 0, 1190, 239.5, 0, 0, 1] }));
  assert.equal(fx(), 1190);
  assert.deepEqual(warned, []);
});

test("a camera that looks away is not asked any more, and one that cannot be drawn by is told once", () => {
  const bridge = new FakeBridge();
  /** @type {string[]} */
  const warned = [];
  const calibrations = new Calibrations(/** @type {any} */ (bridge), (name) => name, (sentence) => warned.push(sentence));
  calibrations.of(["eye", "fish"]);
  assert.equal(bridge.heard.size, 2);
  calibrations.of(["fish"]);
  assert.deepEqual([...bridge.heard.keys()], ["cameras/fish/camera_info"]);
  bridge.heard.get("cameras/fish/camera_info")?.(info({ distortion_model: "fisheye" }));
  assert.deepEqual(calibrations.of(["fish"]), [null]);
  assert.equal(bridge.heard.size, 0);
  assert.equal(warned.length, 1);
  assert.match(warned[0], /^camera fish: its lens has the distortion model "fisheye"/);
});



