// @ts-check
/** Line, malfunctions and trials as the instructor's panels understand them. */

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { FakeElement } from "./browser.js";
import { lineText } from "../../console/js/instructor/line_panel.js";
import { AtNextStep } from "../../console/js/instructor/malfunction_panel.js";

/** What the page has, by ids. @type {Map<string, any>} */
const page = new Map();
/** @param {string} id @returns {any} */
const get = (id) => page.get(id) ?? page.set(id, new PageElement("")).get(id);

class PageElement extends FakeElement {
  /** @param {string} [label]  @param {string} [value] */
  constructor(label = "", value = "") {
    super();
    Object.assign(this, { label, value });
  }

  /** @param {string} id */
  set id(id) {
    page.set(id, this);
  }

  get options() {
    return this.children;
  }

  /** @param {string} selector */
  querySelector(selector) {
    return new PageElement("", selector === "input:checked" ? "crate" : "");
  }

  show() {}

  focus() {}

  getContext() {}

  /** @param {string} key */
  type(key) {
    this._listeners.keydown({ key, preventDefault() {} });
  }
}

const putTool = new PageElement();
Object.assign(putTool, { dataset: { tool: "put" } });

// The panel's questions listen to the keys.
Object.assign(globalThis, {
  window: { addEventListener() {} },
  document: {
    createElement: () => new PageElement(),
    getElementById: get,
    querySelectorAll: (/** @type {string} */ selector) => (selector === "#arrange-tools [data-tool]" ? [putTool] : []),
  },
  Option: PageElement,
  ResizeObserver: class {
    observe() {}
  },
  fetch: () => new Promise(() => {}), // no bridge is ever found
});
const { stateText } = await import("../../console/js/training/instructor_panel.js");
const { Arranging } = await import("../../console/js/instructor/arranging/arranging.js");
const { ExamList } = await import("../../console/js/instructor/exam_list.js");
const { RobotsPanel } = await import("../../console/js/instructor/robots_panel.js");
const { showTrials } = await import("../../console/js/instructor/trials.js");
const { RobotClient } = await import("../../console/js/robot_client.js");
const { globalNames } = await import("../../console/js/several_robots.js");
const { TrainingClient } = await import("../../console/js/training/client.js");
const { InstructorBookmarks } = await import("../../console/js/training/instructor_bookmarks.js");

const PERFECT = { profile: "perfect", delay: 0, jitter: 0, loss: 0, bandwidth: 0, outage: false };
const RUNNING = { trial: "t1", phase: "running", repetition: 1, steps_done: [false, false] };
const FROZEN = { what: "front", kind: "frozen", value: 0, announced: false };

test("a line says what it does to what passes it", () => {
  assert.equal(lineText(PERFECT), "nothing is impaired");
  assert.equal(lineText({ ...PERFECT, delay: 0.3 }), "300 ms");
  assert.equal(lineText({ ...PERFECT, delay: 0.1, jitter: 0.1, loss: 0.085, bandwidth: 4e6 }), "100–200 ms, 8.5 % lost, 4 Mbit/s");
  assert.equal(lineText({ ...PERFECT, delay: 0.3, outage: true }), "nothing passes now");
});

test("what waits for the next step is due with it, once", () => {
  const waiting = new AtNextStep();
  assert.deepEqual(waiting.hear(RUNNING), []);
  waiting.add(FROZEN);
  assert.deepEqual(waiting.hear(RUNNING), []);
  assert.deepEqual(waiting.hear({ ...RUNNING, steps_done: [true, false] }), [FROZEN]);
  assert.deepEqual(waiting.hear({ ...RUNNING, steps_done: [true, true] }), []);
});

test("a step that was done before is no next one, and a new repetition is none", () => {
  const waiting = new AtNextStep();
  waiting.hear({ ...RUNNING, steps_done: [true, false] });
  waiting.add(FROZEN);
  assert.deepEqual(waiting.hear({ ...RUNNING, steps_done: [true, false] }), []);
  assert.deepEqual(waiting.hear({ ...RUNNING, repetition: 2 }), []);
  assert.deepEqual(waiting.hear({ ...RUNNING, repetition: 2, steps_done: [true, false] }), [FROZEN]);
});

test("what waits is forgotten with the trial, or when it is cancelled", () => {
  for (const over of [{ ...RUNNING, phase: "ended" }, { ...RUNNING, trial: "t2" }]) {
    const waiting = new AtNextStep();
    waiting.hear(RUNNING);
    waiting.add(FROZEN);
    assert.deepEqual(waiting.hear({ ...over, steps_done: [true, false] }), []);
    assert.deepEqual(waiting.wishes, []);
  }
  const waiting = new AtNextStep();
  waiting.hear(RUNNING);
  waiting.add(FROZEN);
  waiting.remove(FROZEN);
  assert.deepEqual(waiting.hear({ ...RUNNING, steps_done: [true, false] }), []);
});

test("a trial that is not valid is said to be that once it has ended, whatever its figures are", () => {
  const state = /** @type {any} */ ({ operator: "ann", title: "Slalom", setting: "standard", mode: "practice", phase: "ended", verdict: "passed", valid: true });
  assert.equal(stateText(state), "ann · Slalom · practice · passed");
  assert.equal(stateText({ ...state, verdict: "" }), "ann · Slalom · practice · no verdict");
  assert.equal(stateText({ ...state, valid: false }), "ann · Slalom · practice · not valid");
  assert.equal(stateText({ ...state, valid: false, phase: "running" }), "ann · Slalom · practice · running");
  assert.equal(stateText(null), "none is open");
});

/** A bridge that remembers what it was asked for. */
class FakeBridge {
  constructor() {
    /** @type {Map<string, (message: any) => void>} */
    this.heard = new Map();
    /** Names of the services that were called. @type {string[]} */
    this.asked = [];
    /** Why nothing is answered; empty: it is. */
    this.broken = "";
  }

  /** @param {{topic: string, heard: (message: any) => void}} subscription */
  subscribe({ topic, heard }) {
    this.heard.set(topic, heard);
  }

  unsubscribe() {}

  /** @param {string} service */
  async call(service) {
    this.asked.push(service);
    if (this.broken) throw new Error(this.broken);
    return { success: true, message: `${service} is done`, names: [], pose: { position: { x: 1, y: 2, z: 0 } } };
  }

  /** @param {string} topic  @param {object} message */
  tell(topic, message) {
    this.heard.get(topic)?.(message);
  }
}

const IDLE = { phase: "idle", trial: "", mode: "", operator: "", bookmarks: [] };
const EXAM = { phase: "running", trial: "t1", mode: "exam", operator: "Ann", bookmarks: [] };
const settled = () => new Promise((resolve) => setImmediate(resolve));

/**
 * The instructor's page of a robot.
 * @param {string} namespace
 * @param {{others?: () => Promise<boolean>}} [given]
 */
function openPage(namespace, { others } = {}) {
  const config = /** @type {any} */ ({ namespace, simulator: "/telex", robots: [{ name: "telex" }, { name: "telex_b" }] });
  const bridge = new FakeBridge(), firstBridge = new FakeBridge();
  /** @type {string[]} */
  const log = [];
  const say = (/** @type {string} */ sentence) => log.push(sentence);
  const robot = new RobotClient(/** @type {any} */ (bridge), globalNames(config), say, say);
  const first = new RobotClient(/** @type {any} */ (firstBridge), (name) => `/telex/${name}`, say, say);
  const examList = new ExamList(robot, others);
  examList.subscribe();
  /** Phases that were shown of the robot's own exercise. @type {string[]} */
  const own = [];
  const strip = { show: (/** @type {any} */ { phase }) => own.push(phase) }, none = { show() {} };
  const bookmarks = new InstructorBookmarks(robot, namespace === "/telex" ? undefined : first);
  const arranging = new Arranging(robot, () => "front", () => {});
  showTrials(new TrainingClient(robot), config, { strip, exercises: none, malfunctions: none, examList, bookmarks, arranging });
  return { bridge, firstBridge, own, log };
}

beforeEach(() => page.clear());

test("a further robot's page knows of the first robot's exam", async () => {
  const { bridge, own } = openPage("/telex_b");
  bridge.tell("/telex_b/bridge/exam", { data: "t1" });
  bridge.tell("/telex/training/state", EXAM);
  bridge.tell("/telex_b/training/state", IDLE);
  await settled();
  assert.equal(get("exam-note").textContent, "Exam: trainees have its list only");
  assert.deepEqual(own, ["idle"], "its own exercise is another matter");
  assert.equal(get("bookmarks-set").title, "An exam has no bookmarks");
  get("exam-end").fire("click");
  assert.equal(get("ask-sentence").textContent, "End the exam's list? The trial that runs becomes invalid.");
  get("ask-no").onclick();
  putTool.fire("click");
  get("plan").type("ArrowUp");
  get("plan").type("Enter");
  await settled();
  assert.equal(get("ask-sentence").textContent, "Put crate there? The exam of Ann is invalid then.");
  get("ask-no").onclick();
  await settled();
  assert.equal(bridge.asked.includes("/telex/sim/spawn"), false);
});

test("an object is put at once while no exercise goes on", async () => {
  const { bridge } = openPage("/telex_b");
  bridge.tell("/telex/training/state", IDLE);
  putTool.fire("click");
  get("plan").type("ArrowUp");
  get("plan").type("Enter");
  await settled();
  assert.ok(bridge.asked.includes("/telex/sim/spawn"));
});

test("the first robot's page hears of one exercise", () => {
  const { bridge, own } = openPage("/telex");
  bridge.tell("/telex/bridge/exam", { data: "t1" });
  bridge.tell("/telex/training/state", EXAM);
  assert.equal(get("exam-note").textContent, "Exam: trainees have its list only");
  assert.deepEqual(own, ["running"]);
});

test("bookmarks of the first robot's practice are set and gone back to at its bridge", async () => {
  const { bridge, firstBridge, log } = openPage("/telex_b");
  bridge.tell("/telex/training/state", { ...EXAM, mode: "practice", bookmarks: ["start", "door"] });
  await settled();
  assert.deepEqual(get("bookmarks-names").options.map(({ value }) => value), ["door", "start"]);
  get("bookmarks-set").fire("click");
  get("bookmarks-back").fire("click");
  await settled();
  assert.deepEqual(firstBridge.asked, ["/telex/training/bookmark", "/telex/training/back"]);
  assert.deepEqual(log, ["/telex/training/bookmark is done", "/telex/training/back is done"]);
  assert.deepEqual([...new Set(bridge.asked)], ["/telex/sim/list_bookmarks"]);
});

test("an exam's list is ended once no bridge has it", async () => {
  for (const elsewhere of [true, false]) {
    page.clear();
    const { bridge, log } = openPage("/telex_b", { others: async () => elsewhere });
    bridge.tell("/telex_b/bridge/exam", { data: "t1" });
    get("exam-end").fire("click");
    assert.equal(get("ask-sentence").textContent, "End the exam's list? Trainees may use everything again.");
    get("ask-yes").onclick();
    await settled();
    assert.ok(bridge.asked.includes("/telex_b/bridge/end_exam"));
    assert.deepEqual(log, elsewhere ? ["the exam's list is ended"] : []);
  }
});

test("other robots' bridges end the list where they have it, and say why not", async () => {
  const robots = ["telex", "telex_b", "telex_c"].map((name) => ({ name, rosbridge: null }));
  /** @type {string[]} */
  const log = [];
  const panel = new RobotsPanel(/** @type {any} */ ({ namespace: "/telex_b", simulator: "/telex", robots }), new URLSearchParams(), (said) => log.push(said));
  const bridges = [new FakeBridge(), new FakeBridge()];
  panel._others.forEach(({ client }, index) => {
    const heard = /** @type {any} */ (client.bridge)._subscriptions.get(client.topic("bridge/exam")).heard;
    bridges[index].heard.set("exam", heard);
    client.bridge = /** @type {any} */ (bridges[index]);
  });
  assert.equal(panel.first(/** @type {any} */ ({ simulator: "/telex" })), panel._others[0].client);
  assert.equal(panel.first(/** @type {any} */ ({})), undefined);
  assert.equal(await panel.endExam(), true);
  bridges[0].tell("exam", { data: "t1" });
  assert.equal(await panel.endExam(), true);
  assert.deepEqual(bridges.map(({ asked }) => asked), [["/telex/bridge/end_exam"], []]);
  bridges[1].tell("exam", { data: "t1" });
  bridges[1].broken = "not connected";
  assert.equal(await panel.endExam(), false);
  assert.deepEqual(log, ["telex_c: exam: not connected"]);
});
