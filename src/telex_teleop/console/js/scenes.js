// @ts-check
/** The list of the simulator's scenes, and loading of another one. */

import { ask } from "./ask.js";
import { makeButton } from "./buttons.js";
import { decimal, text, translated } from "./language.js";
import { byId, element, setText } from "./panels.js";

const WITHIN = 60_000; // ms in which a scene must be loaded; as the bridge's own service_timeout
const PROGRESS_PERIOD = 100; // ms

export class SceneChooser {
  /**
   * @param {import("./robot_client.js").RobotClient} robot
   * @param {() => void} loaded  Called when another scene is there.
   */
  constructor(robot, loaded) {
    this._robot = robot;
    this._loaded = loaded;
    this._isLoading = false;
    /** What the simulator said last. */
    this._world = "";
    this._listed = "";
  }

  /** Ask which scenes there are. */
  async list() {
    try {
      const answer = await this._robot.call("sim/list_scenes", {});
      this._fill(answer.scenes, answer.current);
    } catch (error) {
      this._robot.warn(text("the scenes cannot be listed: {why}", { why: translated(/** @type {Error} */ (error).message) }));
    }
  }

  /** @param {any} status  telex_msgs/SimStatus */
  setStatus({ world }) {
    setText(byId("scene-name"), translated(world));
    // Somebody else may have loaded it.
    if (this._world !== "" && world !== this._world) this.list();
    this._world = world;
  }

  /**
   * @param {any[]} scenes    telex_msgs/SceneFile
   * @param {string} current  Path of the one that is loaded.
   */
  _fill(scenes, current) {
    // A hidden scene, for measurements, is loaded by its name; while it is loaded, it can be reloaded.
    const shown = scenes.filter(({ hidden, path }) => !hidden || path === current);
    const listed = JSON.stringify([shown, current]);
    if (listed === this._listed) return;
    this._listed = listed;
    // The loaded scene comes first, where it is visible without scrolling.
    const sorted = [...shown].sort((a, b) => Number(b.path === current) - Number(a.path === current));
    byId("scenes").replaceChildren(...sorted.map((scene) => {
      const line = element("li");
      line.dataset.scene = scene.name;
      line.dataset.loaded = String(scene.path === current);
      const button = makeButton(scene.path === current ? text("load anew") : text("load"), () => this._load(scene.name));
      button.disabled = scene.problem !== "";
      if (scene.picture) {
        const picture = /** @type {HTMLImageElement} */ (element("img"));
        Object.assign(picture, { src: `data:image/jpeg;base64,${scene.picture}`, alt: "" });
        line.append(picture);
      }
      line.append(element("b", "", translated(scene.name)), button, element("p", scene.problem ? "problem" : "", translated(scene.problem || scene.description)));
      line.title = `${translated(scene.description)}\n${scene.path}`;
      return line;
    }));
  }

  /** @param {string} name */
  async _load(name) {
    if (this._isLoading) return;
    if (!(await ask(text("Load {scene}? The robot starts anew there, and what was done in {before} is lost.", { scene: translated(name), before: this._world === "" ? text("this scene") : translated(this._world) }), text("load")))) return;
    this._isLoading = true;
    const begun = performance.now();
    const showProgress = () => this._note(text("loading {scene} … {seconds} s", { scene: translated(name), seconds: decimal((performance.now() - begun) / 1000, 1) }), true);
    showProgress();
    const timer = setInterval(showProgress, PROGRESS_PERIOD);
    try {
      const answer = await this._robot.call("sim/load_scene", { world: name }, WITHIN);
      if (answer.success) {
        this._loaded();
        this._robot.log(translated(answer.message));
      } else {
        this._robot.warn(translated(answer.message));
      }
      this._note(answer.success ? translated(answer.message) : text("refused"));
    } catch (error) {
      const { name: kind, message } = /** @type {Error} */ (error);
      const reason = kind === "TimeoutError" ? text("no answer yet; it may still be loading") : translated(message);
      this._robot.warn(text("loading {scene}: {why}", { scene: translated(name), why: reason }));
      this._note(reason);
    } finally {
      clearInterval(timer);
      this._isLoading = false;
      await this.list();
    }
  }

  /**
   * @param {string} words
   * @param {boolean} [isBusy]
   */
  _note(words, isBusy = false) {
    setText(byId("scene-note"), words);
    byId("scene-note").classList.toggle("busy", isBusy);
    byId("scene-progress").hidden = !isBusy;
  }
}
