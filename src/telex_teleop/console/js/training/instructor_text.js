// @ts-check
/** What the instructor says to the trainee: in the header until he acknowledges it, by key or button. */

import { makeButton } from "../buttons.js";
import { text } from "../language.js";
import { byId, element, keyCap, setText } from "../panels.js";

const TYPE = "telex_msgs/TrainingText";

/** @typedef {{number: number, text: string, by: string, read: boolean}} Told  telex_msgs/TrainingText */

export class InstructorText {
  /** @param {import("../robot_client.js").RobotClient} robot */
  constructor(robot) {
    this._robot = robot;
    /** @type {Told | null} */
    this._told = null;
    document.querySelector("body > header")?.append(build(() => this.read()));
  }

  subscribe() {
    this._robot.subscribe("training/text", TYPE, (told) => this._show(told));
  }

  /** @param {Told} told */
  _show(told) {
    this._told = told;
    const isShown = told.text !== "" && !told.read;
    byId("instructor-text").hidden = !isShown;
    if (!isShown) return;
    setText(byId("instructor-text-by"), text("{by} says:", { by: told.by }));
    setText(byId("instructor-text-words"), told.text);
  }

  /** Acknowledge what is shown. */
  async read() {
    const told = this._told;
    if (told === null || told.text === "" || told.read) return;
    await this._robot.request("training/read", { number: told.number });
  }
}

/** A line of the header. @param {() => void} read  Acknowledges it. */
function build(read) {
  const line = element("section", "instructor-text");
  Object.assign(line, { id: "instructor-text", hidden: true });
  line.setAttribute("role", "alert");
  const by = element("span"), words = element("b");
  by.id = "instructor-text-by";
  words.id = "instructor-text-words";
  const button = makeButton("", read);
  button.id = "instructor-text-read";
  button.append(keyCap("read"), " ", text("I have read it"));
  line.append(by, words, button);
  return line;
}
