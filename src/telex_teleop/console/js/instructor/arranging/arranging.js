// @ts-check
/** Putting, moving and taking objects of the running scene, by pointing into the overview or on the plan. */

import { ask } from "../../ask.js";
import { onClick } from "../../buttons.js";
import { decimal, text, translated } from "../../language.js";
import { all, byId, check, setText } from "../../panels.js";
import { OVERVIEW } from "../../overview.js";
import { BEGUN } from "../../training/client.js";
import { Kinds, typeText } from "./kinds.js";
import { PicturePointer } from "./picture_pointer.js";
import { PlanView } from "./plan_view.js";
import { rayDown } from "./ray.js";
import { ScenePlan } from "./scene_plan.js";

const POSES_PERIOD = 250; // ms
const WITHIN = 20_000; // ms in which an object must have come

/** @typedef {"look" | "put" | "move" | "take"} Tool */
/** @typedef {import("./ray.js").Ray} Ray */
/** @typedef {import("../../training/client.js").State} State */

export class Arranging {
  /**
   * @param {import("../../robot_client.js").RobotClient} robot
   * @param {() => string} shown  The camera that is shown large.
   * @param {(light: {daylight: number, lamps: number}) => void} lit  Told what light the scene has.
   */
  constructor(robot, shown, lit) {
    this._robot = robot;
    this._lit = lit;
    /** @type {Tool} */
    this._tool = "look";
    /** Object that is picked to be moved. */
    this._picked = "";
    this._isBusy = false;
    this._isOpen = false;
    this._isListing = false;
    /** @type {ScenePlan | null} */
    this._plan = null;
    this._offered = "";
    this._world = "";
    this._isOtherWorld = true;
    /** @type {State | null} */
    this._state = null;
    /** Types that can be put. */
    this._kinds = new Kinds(byId("arrange-kinds"), (words) => this._say(words));
    const point = (/** @type {Ray} */ from, /** @type {Ray} */ to) => this._point(from, to);
    this._pointer = new PicturePointer(robot.bridge, robot.topic, () => shown() === OVERVIEW, point);
    this._view = new PlanView(
      /** @type {HTMLCanvasElement} */ (byId("plan")),
      (from, to) => {
        const ray = rayDown(...to, this._view.height);
        this._point(from === to ? ray : rayDown(...from, this._view.height), ray);
      },
      ([x, y]) => this._say(text("the cross is at {x}, {y} m", { x: decimal(x, 1), y: decimal(y, 1) })),
    );
    for (const button of this._tools) onClick(button, () => this._choose(/** @type {Tool} */ (button.dataset.tool)));
    this._what.addEventListener("change", () => this._whatChanged());
    onClick(byId("arrange-take"), () => this._takeNamed());
    onClick(byId("plan-fit"), () => this._view.fit());
    this._choose("look");
  }

  get _tools() {
    return all("#arrange-tools [data-tool]");
  }

  get _what() {
    return /** @type {HTMLSelectElement} */ (byId("arrange-what"));
  }

  /** How much it is turned (rad). */
  get _yaw() {
    const degrees = Number(/** @type {HTMLInputElement} */ (byId("arrange-turn")).value);
    return Number.isFinite(degrees) ? ((degrees % 360) * Math.PI) / 180 : 0;
  }

  // ---- what is there

  /**
   * Listen to where everything is only while it is shown.
   * @param {boolean} isOpen
   */
  open(isOpen) {
    this._isOpen = isOpen;
    if (!isOpen) {
      this._choose("look");
      this._robot.bridge.unsubscribe(this._robot.topic("sim/poses"));
      return;
    }
    this._robot.subscribe("sim/poses", "telex_msgs/ScenePoses", (message) => this._hear(message), POSES_PERIOD);
    this._view.draw();
  }

  /** @param {any} status  telex_msgs/SimStatus */
  setStatus({ world }) {
    if (world === this._world) return;
    this._world = world;
    this._isOtherWorld = true;
  }

  /** Hear how far the exercise is. @param {State} state */
  show(state) {
    this._state = state;
  }

  /** @param {any} message  telex_msgs/ScenePoses */
  _hear(message) {
    if (!this._isOpen) return;
    if (this._plan?.hear(message)) this._view.draw();
    else this._list(message);
  }

  /** Ask what there is. @param {any} message  Where it is; telex_msgs/ScenePoses */
  async _list(message) {
    if (this._isListing) return;
    this._isListing = true;
    try {
      const listed = await this._robot.call("sim/list_objects", { pictures: !this._kinds.isFilled });
      this._plan = new ScenePlan(listed);
      this._plan.hear(message);
      this._view.show(this._plan, this._isOtherWorld);
      this._isOtherWorld = false;
      this._lit(listed);
      if (!this._kinds.isFilled) this._kinds.fill(listed.library);
      this._fillWhat();
    } catch (error) {
      this._say(translated(/** @type {Error} */ (error).message));
    } finally {
      this._isListing = false;
    }
  }

  // ---- what is chosen

  /** @param {Tool} tool */
  _choose(tool) {
    this._tool = tool;
    this._pick("");
    check(this._tools, ({ dataset }) => dataset.tool === tool);
    this._pointer.set(tool !== "look");
    this._view.pans = tool === "look";
    byId("arrange-take").hidden = tool !== "take";
    byId("arrange-turning").hidden = tool !== "put" && tool !== "move";
    this._what.hidden = tool !== "move" && tool !== "take";
    this._kinds.place.hidden = tool !== "put";
    this._fillWhat();
    this._say({
      look: text("drag the picture or the map to look about"),
      put: text("point to where it shall stand"),
      move: text("drag an object, or point to it and then to its new place"),
      take: text("point to what shall go"),
    }[tool]);
  }

  /** Offer the objects that the tool is for. */
  _fillWhat() {
    const { _tool: tool } = this;
    const there = (this._plan?.things ?? []).filter(({ movable }) => tool === "take" || movable).map(({ name }) => name).sort();
    const offered = JSON.stringify([tool, there]);
    if (this._what.hidden || offered === this._offered) return;
    this._offered = offered;
    const chosen = this._what.value;
    this._what.replaceChildren(new Option(text("by pointing, or choose one"), ""), ...there.map((name) => new Option(name, name)));
    this._what.value = there.includes(chosen) ? chosen : "";
  }

  _whatChanged() {
    if (this._tool === "move") this._pick(this._what.value);
  }

  /** @param {string} name  Of the object that shall be moved; empty: none. */
  _pick(name) {
    this._picked = this._view.picked = name;
    if (name !== "") this._say(text("{name} is picked: point to its new place", { name }));
    this._view.draw();
  }

  /** @param {string} sentence */
  _say(sentence) {
    setText(byId("arrange-note"), sentence);
    byId("arrange-note").title = sentence;
  }

  /** Say what was refused, here and among the messages. @param {string} sentence */
  _refuse(sentence) {
    this._say(sentence);
    this._robot.warn(sentence);
  }

  // ---- what is done

  /** @param {Ray} from  @param {Ray} to */
  async _point(from, to) {
    if (this._isBusy || this._tool === "look") return;
    this._isBusy = true;
    try {
      if (this._tool === "put") await this._put(to);
      else if (this._tool === "take") await this._takeAt(to);
      else if (this._picked !== "") await this._moveTo(to);
      else if ((await this._pickAt(from)) && from !== to) await this._moveTo(to);
    } catch (error) {
      this._refuse(translated(/** @type {Error} */ (error).message));
    } finally {
      this._isBusy = false;
    }
  }

  /** @param {Ray} ray */
  async _put(ray) {
    const type = this._kinds.value;
    if (type === "") return; // it is not known yet what there is
    const yaw = this._yaw;
    const found = await this._call("sim/find_place", { ...ray, object: `{type: ${type}}`, yaw });
    if (!(await this._mayChange(text("Put {name} there?", { name: typeText(type) }), text("put"), false))) return;
    const { x, y, z } = found.pose.position;
    const numbers = [x, y, z].map((number) => number.toFixed(4)).join(", ");
    const object = `{type: ${type}, position: [${numbers}], yaw: ${yaw.toFixed(4)}}`;
    this._done(await this._call("sim/spawn", { name: "", object, folder: "" }, WITHIN));
  }

  /** @param {Ray} ray @returns {Promise<boolean>} Whether something was picked. */
  async _pickAt(ray) {
    const { met, movable, robot } = await this._call("sim/find_place", { ...ray, object: "", yaw: 0 });
    if (movable) {
      this._what.value = met;
      this._pick(met);
      return true;
    }
    this._refuse(robot ? text("{name} is a robot: it is driven, not moved", { name: met })
      : met === "floor" ? text("there is nothing to move") : text("{name} stands fast: take it out and put it in elsewhere", { name: met }));
    return false;
  }

  /** @param {Ray} ray */
  async _moveTo(ray) {
    const name = this._picked;
    const { pose } = await this._call("sim/find_place", { ...ray, object: name, yaw: this._yaw });
    if (!(await this._mayChange(text("Move {name} there?", { name }), text("move"), false))) return;
    this._done(await this._call("sim/move", { name, pose }));
    this._what.value = "";
    this._pick("");
  }

  /** @param {Ray} ray */
  async _takeAt(ray) {
    const { met, robot } = await this._call("sim/find_place", { ...ray, object: "", yaw: 0 });
    if (robot) this._refuse(text("{name} is a robot: it cannot be taken out here", { name: met }));
    else if (met === "floor") this._refuse(text("there is nothing to take out"));
    else await this._take(met);
  }

  async _takeNamed() {
    const name = this._what.value;
    if (name === "") return this._say(text("choose what shall go, or point to it"));
    try {
      await this._take(name);
    } catch (error) {
      this._refuse(translated(/** @type {Error} */ (error).message));
    }
  }

  /** @param {string} name */
  async _take(name) {
    if (!(await this._mayChange(text("Take {name} out of the scene?", { name }), text("take out"), true))) return;
    this._done(await this._call("sim/delete", { name }));
  }

  /**
   * Ask first where a change has a cost: it invalidates a trial that is running.
   * @param {string} question
   * @param {string} deed
   * @param {boolean} always  Whether to ask where no trial goes on, too.
   */
  async _mayChange(question, deed, always) {
    const { phase = "idle", mode = "", operator = "" } = this._state ?? {};
    if (!BEGUN.includes(phase)) return always ? ask(question, deed) : true;
    const name = operator || text("the trainee");
    const loss = mode === "exam" ? text("The exam of {name} is invalid then.", { name })
      : text("The trial of {name} counts as not valid then.", { name });
    return ask(`${question} ${loss}`, deed);
  }

  /** @param {{message: string}} answer */
  _done({ message }) {
    this._say(translated(message));
    this._robot.log(translated(message));
  }

  /**
   * @param {string} service
   * @param {object} args
   * @param {number} [within]  ms
   * @returns {Promise<any>} Rejected with the reason where it was refused.
   */
  async _call(service, args, within) {
    const answer = await this._robot.call(service, args, within);
    if (!answer.success) throw new Error(answer.message);
    return answer;
  }
}
