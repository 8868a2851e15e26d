// @ts-check
/** Aids for distance and direction, drawn over the large views: what they need to know, and when they are drawn. */

import { atBeat } from "../beat.js";
import { yawOf } from "../hud.js";
import { text } from "../language.js";
import { fixed } from "../panels.js";
import { transform } from "../urdf.js";
import { bandFigures, zoomText } from "./band.js";
import { Calibrations } from "./calibrations.js";
import { aimFigures, contactFigures, gapFigures, guideFigures, horizonFigures } from "./figures.js";
import { fieldOf } from "./lens.js";
import { column, differ, floorThrough, gearOf, levelAhead, plus, unit, upward } from "./lines.js";
import { Painter } from "./painter.js";
import { Sight, boxOf } from "./sight.js";
import { Switches } from "./switches.js";

/** @typedef {import("../urdf.js").Vector} Vector */
/** @typedef {import("../urdf.js").Pose} Pose */
/** @typedef {import("./figures.js").Aim} Aim */

const RANGE = "sensor_msgs/Range", WIDTH = "std_msgs/Float64";
const PERIOD = 67; // ms between two messages of what is measured, at least
const BUTTON = 56; // px that the second view's button takes of its upper edge
const FRESH = 1000; // ms that a message counts
const TOUCHES = 0.5; // N from which a pad counts as pressing
const WEAK = 0.8; // share of the friction in use from which a grip is nearly too weak

/**
 * @typedef {object} Sources  Of the page.
 * @property {import("../vocabulary.js").Vocabulary} vocabulary
 * @property {import("../bridge.js").Bridge} bridge
 * @property {(name: string) => string} topic
 * @property {import("../cameras.js").Cameras} cameras
 * @property {import("../layouts.js").Layouts} layouts
 * @property {import("../joints.js").JointPositions} joints
 * @property {import("../gripper.js").Gripper} gripper
 * @property {import("../radiation/map.js").RadiationMap} map
 * @property {(camera: string) => boolean} zooms
 * @property {() => boolean} paused
 * @property {(sentence: string) => void} warn
 * @property {() => boolean} guards  Whether the arm is held back from what is near.
 */

/** A message of another node, which counts for a while. @template Message */
class Heard {
  constructor() {
    /** @type {Message | null} */
    this._message = null;
    this._at = -Infinity;
  }

  /** @param {Message} message */
  take(message) {
    this._message = message;
    this._at = performance.now();
  }

  /** @param {boolean} paused  While the simulation stands nothing gets old. @returns {Message | null} */
  get(paused) {
    return paused || performance.now() - this._at < FRESH ? this._message : null;
  }
}

export class Aids {
  /**
   * @param {Sources} sources
   * @param {import("../storage.js").Keeper} storage
   * @param {string} robot  Its namespace.
   */
  constructor(sources, storage, robot) {
    this._sources = sources;
    const { bridge, topic, layouts, vocabulary, map, warn } = sources;
    this._switches = new Switches(storage, robot, vocabulary, layouts, warn);
    this._switches.changed = () => this._switched();
    layouts.changed = () => this._switched();
    map.closed = () => this._switches.set("plan", false);
    this._calibrations = new Calibrations(bridge, topic, warn);
    this._calibrations.changed = () => this.change();
    /** @type {Map<HTMLElement, Painter>} */
    this._painters = new Map();
    /** @type {import("../urdf.js").RobotModel | null} */
    this._model = null;
    /** @type {import("../robot.js").TrackFacts | null} */
    this._tracks = null;
    /** Link that is the tool; empty: there is none. */
    this._tool = "";
    /** @type {Record<string, any>} */
    this._equipment = {};
    /** What stands in for equipment that is not there, in practice. @type {Record<string, any>} */
    this._standIns = {};
    this._exam = false;
    /** Topics of range and width that are listened to; empty: none is. */
    this._followed = { range: "", width: "" };
    /** @type {Heard<any>} */
    this._joints = new Heard();
    /** @type {Heard<any>} */
    this._stability = new Heard();
    /** @type {Heard<any>} */
    this._contact = new Heard();
    /** @type {Heard<number>} */
    this._yaw = new Heard();
    /** @type {Heard<any>} */
    this._range = new Heard();
    /** Of what is aimed at (m). @type {Heard<any>} */
    this._width = new Heard();
    /** Under the guide lines, as it was when it last changed so much that it can be seen. @type {import("./lines.js").Floor | null} */
    this._floor = null;
    /** Whether nothing is drawn. */
    this._isClear = true;
    this._paint = this._paint.bind(this);
    this._switched();
  }

  get commands() {
    return this._switches.commands;
  }

  toggleMenu() {
    this._switches.toggleMenu();
  }

  /** Which are on, as the training node is told: true for a training aid. */
  get told() {
    const { told } = this._switches;
    // The line itself needs no equipment, what it says of the range does.
    if ("aim line" in told && this._finder !== undefined) told.range = told["aim line"];
    if ("aim line" in told) told["aim line"] = false;
    if ("finger gap" in told && this._followed.width !== "") told["finger gap"] = true;
    // In an exam the guard knows what the robot itself can tell, and nothing else.
    const hasSensors = "proximity" in this._equipment;
    if (this._sources.guards() && (hasSensors || !this._exam)) told["proximity guard"] = !hasSensors;
    return told;
  }

  // ---- what is heard

  /** @param {import("../urdf.js").RobotModel} model */
  setModel(model) {
    this._model = model;
    this.change();
  }

  /** After every new connection cameras may be others. */
  connected() {
    this._calibrations.forget();
    this.change();
  }

  /** @param {import("../robot.js").Facts} robot */
  setRobot({ equipment = {}, training_aids: standIns = {}, tracks = null, tool = null }) {
    this._equipment = equipment;
    this._standIns = standIns;
    this._tracks = tracks;
    this._tool = tool ?? "";
    this._allow();
  }

  /** @param {boolean} exam  Whether equipment is all that may be shown. */
  setExam(exam) {
    if (exam === this._exam) return;
    this._exam = exam;
    this._allow();
  }

  _allow() {
    this._switches.allow({ equipment: this._equipment, exam: this._exam });
  }

  /** @param {any} states  sensor_msgs/JointState */
  hearJoints(states) {
    this._joints.take(states);
    this.change();
  }

  /** @param {any} stability  telex_msgs/Stability */
  hearStability(stability) {
    this._stability.take(stability);
    this.change();
  }

  /** @param {any} contact  telex_msgs/GripperContact */
  feel(contact) {
    this._contact.take(contact);
    if (this._switches.isOn("contact marks")) this.change();
  }

  /** @param {any} odometry  nav_msgs/Odometry */
  move({ pose }) {
    this._yaw.take(yawOf(pose.pose.orientation));
    if (this._switches.isOn("compass")) this.change();
  }

  /** @param {string} camera @param {number} factor */
  zoom(camera, factor) {
    this._calibrations.hearZoom(camera, factor);
  }

  _switched() {
    this._switches.show();
    this._sources.map.showPlan(this._switches.isOn("plan"));
    const gap = this._switches.isOn("finger gap");
    this._follow("range", RANGE, gap || this._switches.isOn("aim line") ? this._finder?.topic ?? "" : "", (message) => {
      // Over the bridge what is too near is null, as what is too far: the number before says which.
      const before = this._range.get(true);
      const isNear = message.range === null && before !== null && (before.isNear || (before.range ?? Infinity) < 2 * message.min_range);
      this._range.take({ ...message, isNear });
    });
    this._follow("width", WIDTH, gap && !this._exam ? this._standIns.object_width?.topic ?? "" : "", ({ data }) => this._width.take(data));
    this.change();
  }

  /** The range finder, or in practice what stands in for one. @returns {{topic: string, frame: string} | undefined} */
  get _finder() {
    return this._equipment.range_finder ?? (this._exam ? undefined : this._standIns.range_finder);
  }

  /**
   * @param {"range" | "width"} what
   * @param {string} type
   * @param {string} topic  To be listened to; empty: none.
   * @param {(message: any) => void} heard
   */
  _follow(what, type, topic, heard) {
    const { bridge } = this._sources;
    const before = this._followed[what];
    if (topic === before) return;
    if (before !== "") bridge.unsubscribe(before);
    this._followed[what] = topic;
    this[`_${what}`] = new Heard();
    if (topic === "") return;
    bridge.subscribe({
      topic, type, throttle: PERIOD, heard: (message) => {
        heard(message);
        this.change();
      },
    });
  }

  // ---- what is drawn

  /** Those that are drawn into pictures. */
  get _drawn() {
    return this._switches.on.filter((name) => name !== "plan");
  }

  /** Have the aids drawn anew, with whatever else changes in the page. */
  change() {
    if (!document.hidden && !(this._isClear && this._drawn.length === 0)) atBeat(this._paint);
  }

  _paint() {
    const on = this._drawn;
    this._isClear = on.length === 0;
    const views = on.length === 0 ? [] : this._sources.cameras.large.filter(({ live }) => live);
    const calibrations = this._calibrations.of(views.map(({ camera }) => camera));
    const joints = this._joints.get(this._sources.paused());
    const poses = views.length === 0 || joints === null ? undefined : this._model?.poses((joint) => this._sources.joints.position(joint) ?? 0);
    const shown = new Map(views.map(({ element }, index) => [element, index]));
    for (const { element } of views) {
      if (!this._painters.has(element)) this._painters.set(element, new Painter(element, () => this.change()));
    }
    for (const [element, painter] of this._painters) {
      const index = shown.get(element) ?? -1;
      const calibration = calibrations[index] ?? null;
      const pose = calibration === null ? undefined : poseOf(poses, calibration.frame);
      const { width, height } = painter.size;
      if (calibration === null || pose === undefined || poses === undefined || width === 0) painter.paint([]);
      else {
        const sight = new Sight(calibration.lens, pose, boxOf(width, height, calibration.lens, views[index].isFirst ? "top" : "middle"));
        painter.paint(this._figures(on, sight, poses, { ...views[index], lens: calibration.lens }), sight.box);
      }
    }
  }

  /**
   * @param {string[]} on
   * @param {Sight} sight
   * @param {Map<string, Pose>} poses
   * @param {{camera: string, over: HTMLElement | null, isFirst: boolean, lens: import("./lens.js").Lens}} view
   */
  _figures(on, sight, poses, { camera, over, isFirst, lens }) {
    const { paused, zooms, gripper, joints } = this._sources;
    const stability = this._stability.get(paused());
    const up = [stability?.roll, stability?.pitch].every(Number.isFinite) ? upward(stability.roll, stability.pitch) : null;
    const figures = [], plates = [];
    const show = (/** @type {import("./figures.js").Shown} */ shown) => {
      figures.push(...shown.figures);
      plates.push(...shown.plates);
    };
    if (on.includes("horizon") && up !== null) figures.push(...horizonFigures(sight, up));
    if (on.includes("guide lines")) figures.push(...this._guides(sight, poses, stability));
    const aim = this._aim(poses);
    const isAid = this._switches.isTrainingAid("aim line");
    const measured = this._range.get(paused());
    const range = measured?.range ?? null;
    if (on.includes("aim line") && aim !== null) show(aimFigures(sight, aim, range, measured === null ? "" : beyondText(measured), isAid));
    const opening = gripper.opening(joints);
    if (on.includes("finger gap") && aim !== null && opening !== null) {
      const width = this._width.get(paused());
      show(gapFigures(sight, aim, opening, range === null ? null : range - aim.beyond, width, isAid));
    }
    if (on.includes("contact marks")) show(contactFigures(sight, this._pads(poses), this._switches.isTrainingAid("contact marks")));
    if (on.includes("zoom factor") && zooms(camera)) plates.push({ words: zoomText(this._calibrations.zoom(camera), fieldOf(lens)), isAid: false });
    const yaw = this._yaw.get(paused());
    const compass = isFirst && on.includes("compass") && yaw !== null ? headings(yaw, levelAhead(sight.pose, up ?? [0, 0, 1])) : null;
    return [...figures, ...bandFigures(sight.box, over?.offsetHeight ?? 0, compass, plates, isFirst ? 0 : BUTTON)];
  }

  /** @param {Sight} sight @param {Map<string, Pose>} poses @param {any} stability  telex_msgs/Stability */
  _guides(sight, poses, stability) {
    if (this._tracks === null) return [];
    const axles = this._tracks.axles.flatMap((name) => {
      const link = this._model?.joints.find((joint) => joint.name === name)?.child;
      const pose = link === undefined ? undefined : poses.get(link);
      return pose === undefined ? [] : [pose.translation];
    });
    const gear = gearOf(axles, this._tracks.radius, this._tracks.half_width);
    if (gear === null) return [];
    const corners = (stability?.support ?? []).map((/** @type {any} */ { x, y, z }) => /** @type {Vector} */ ([x, y, z]));
    // What it stands on is known from what carries it; else it stands on its tracks.
    const floor = floorThrough(corners) ?? { z: gear.bottom, alongX: 0, alongY: 0 };
    if (this._floor === null || differ(floor, this._floor)) this._floor = floor;
    return guideFigures(sight, gear, this._floor);
  }

  /**
   * Where the tool aims; null: there is none.
   * @param {Map<string, Pose>} poses
   * @returns {(Aim & {beyond: number}) | null}  `beyond`: of a range, how much lies before the middle of the fingers (m).
   */
  _aim(poses) {
    const tool = poses.get(this._tool);
    const finder = this._finder === undefined ? undefined : poseOf(poses, this._finder.frame);
    const from = finder ?? tool;
    if (from === undefined) return null;
    const ahead = column(from.rotation, 0);
    const [left, right] = (this._contact.get(this._sources.paused())?.pads ?? []).map((/** @type {any} */ { link }) => poses.get(link)?.translation);
    // Pads that nobody tells of move along the tool's y axis.
    const told = left === undefined || right === undefined ? null : unit(plus(left, right, -1));
    const across = told ?? (tool === undefined ? null : column(tool.rotation, 1));
    const beyond = tool === undefined ? 0 : plus(tool.translation, from.translation, -1).reduce((sum, part, index) => sum + part * ahead[index], 0);
    return { origin: from.translation, ahead, across, middle: tool?.translation ?? null, beyond };
  }

  /** Pads that press, each by its centre of mass. @param {Map<string, Pose>} poses @returns {import("./figures.js").Pressed[]} */
  _pads(poses) {
    const contact = this._contact.get(this._sources.paused());
    if (contact === null) return [];
    return contact.pads.flatMap((/** @type {any} */ { link, normal_force: force, friction_use: use, slip_speed: speed }) => {
      const pose = poses.get(link);
      if (pose === undefined || !(force > TOUCHES)) return [];
      const at = transform(pose, this._model?.centres.get(link) ?? [0, 0, 0]);
      return [{ at, force, slips: contact.slipping && contact.object !== "", speed: speed ?? 0, weak: contact.object !== "" && use > WEAK }];
    });
  }
}

/** What a range finder says that has no figure. @param {any} range  sensor_msgs/Range */
const beyondText = ({ isNear, min_range: least, max_range: most }) =>
  isNear ? text("< {length} m", { length: fixed(least ?? 0, 2) }) : text("> {length} m", { length: fixed(most ?? 0, 0) });

/**
 * Pose of a frame, which in the messages of a further robot has the robot's name before it.
 * @param {Map<string, Pose> | undefined} poses
 * @param {string} frame
 */
const poseOf = (poses, frame) => poses?.get(frame) ?? poses?.get(frame.split("/").at(-1) ?? "");

/**
 * @param {number} yaw           Of the robot (rad, counter-clockwise).
 * @param {Vector | null} ahead  Where the camera looks, level, from the robot; null: straight up or down.
 */
function headings(yaw, ahead) {
  const degrees = (/** @type {number} */ angle) => (-angle * 180) / Math.PI;
  const nose = Math.round(2 * degrees(yaw)) / 2;
  return { nose, heading: ahead === null ? nose : Math.round(2 * degrees(yaw + Math.atan2(ahead[1], ahead[0]))) / 2 };
}
