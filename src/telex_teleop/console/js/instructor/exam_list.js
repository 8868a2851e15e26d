// @ts-check
/** Shows that an exam's list holds, and lets an instructor end it. */

import { ask } from "../ask.js";
import { onClick } from "../buttons.js";
import { text } from "../language.js";
import { byId, setText } from "../panels.js";
import { BEGUN } from "../training/client.js";

/** A line of the exercise's card, which is there while the list holds. */
export class ExamList {
  /**
   * @param {import("../robot_client.js").RobotClient} robot
   * @param {() => Promise<boolean>} [endElsewhere]  Ends it at other robots' bridges, and tells whether none holds there any more.
   */
  constructor(robot, endElsewhere = async () => true) {
    this._robot = robot;
    this._endElsewhere = endElsewhere;
    this._holdsFor = "";
    this._runs = false;
    onClick(byId("exam-end"), () => this._end());
  }

  subscribe() {
    this._robot.subscribe("bridge/exam", "std_msgs/String", ({ data }) => {
      this._holdsFor = data;
      this._show();
    });
  }

  /** Hear of the trial that runs, whichever robot does it. @param {import("../training/client.js").State} state */
  hear({ trial, phase }) {
    this._runs = BEGUN.includes(phase) && trial === this._holdsFor;
    this._show();
  }

  _show() {
    byId("exam-list").hidden = this._holdsFor === "";
    setText(byId("exam-note"), this._runs ? text("Exam: trainees have its list only") : text("An exam's list holds, and the exam does not run"));
  }

  async _end() {
    const sentence = this._runs ? text("End the exam's list? The trial that runs becomes invalid.") : text("End the exam's list? Trainees may use everything again.");
    if (!(await ask(sentence, text("end the list")))) return;
    const [here, elsewhere] = await Promise.all([
      this._robot.request("bridge/end_exam", {}, (why) => text("exam: {why}", { why })),
      this._endElsewhere(),
    ]);
    if (here && elsewhere) this._robot.log(text("the exam's list is ended"));
  }
}
