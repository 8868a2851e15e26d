// @ts-check
/** Puts the console together. */

import { AttitudeView, STABILITY } from "./attitude.js";
import { Bridge } from "./bridge.js";
import { Cameras } from "./cameras.js";
import { COMMAND_PERIOD, Commander } from "./commander.js";
import { keepPace, watchOperator } from "./deadman.js";
import { Held } from "./held.js";
import { labelKeys, listenToKeys, listenToPointers } from "./input.js";
import { Panels, byId } from "./panels.js";
import { ACTIONS, ACTION_OF_KEY, FLIPPER_NODE, JOINT_NODES, TRACK_NODE, TYPES } from "./robot.js";
import { SILENT_AFTER, StatusView } from "./status.js";
import { TOOL_TYPES, ToolCommander, ToolPanel } from "./tool.js";

const JOINTS_PERIOD = 100; // ms between two updates of the joint table
const DISPLAY_PERIOD = 200; // ms between two updates of header and picture state
const RETRY_AFTER = 1000; // ms

/** @typedef {import("./cameras.js").VideoConfig & {rosbridge: string | null}} Config  What the video server tells. */

/** @returns {Promise<Config>} */
async function fetchConfig() {
  const reply = await fetch("/config.json", { cache: "no-store" });
  if (!reply.ok) throw new Error(`the video server says ${reply.status}`);
  return reply.json();
}

/** @returns {Promise<Config>} */
async function waitForConfig() {
  for (;;) {
    try {
      return await fetchConfig();
    } catch {
      await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER));
    }
  }
}

async function locateBridge() {
  const { rosbridge } = await fetchConfig();
  if (rosbridge === null) throw new Error("the bridge is not running");
  return rosbridge;
}

/** @param {Config} config */
function startCameras(config) {
  const canvas = /** @type {HTMLCanvasElement} */ (byId("picture"));
  const cameras = new Cameras(config, canvas, byId("thumbnails"), (name) => {
    byId("camera-name").textContent = name;
  });
  cameras.start();
  return cameras;
}

async function start() {
  const status = new StatusView();
  const panels = new Panels();
  const attitude = new AttitudeView();
  const config = await waitForConfig();
  const topic = (/** @type {string} */ name) => `${config.namespace}/${name}`;
  const cameras = startCameras(config);

  const held = new Held(() => {
    update();
    panels.showHeld(held.actions);
    panels.showSide(commander.sideOf(heldActions()));
  });

  const heldActions = () => [...held.actions].map((name) => ACTIONS[name]);
  const update = () => {
    commander.update(heldActions());
    toolCommander.update(heldActions());
  };

  const letGo = (/** @type {string} */ reason) => {
    if (!held.empty) status.warn(`released: ${reason}`);
    held.releaseAll();
  };

  const bridge = new Bridge(locateBridge, {
    opened: () => status.log("connected"),
    lost: (reason) => {
      letGo(reason);
      commander.disconnected();
      toolCommander.disconnected();
      status.forgetSim();
      status.setLinkBand("Connection lost. Everything is released. Reconnecting …");
      status.log(`connection lost: ${reason}`, true);
    },
    refused: (sentence) => status.warn(`bridge: ${sentence}`),
  });
  const warn = (/** @type {string} */ sentence) => status.warn(sentence);
  const commander = new Commander(bridge, topic, warn);
  const toolCommander = new ToolCommander(bridge, topic, () => commander.congested, warn);
  const call = (/** @type {string} */ name, /** @type {object} */ args) => bridge.call(topic(name), args);
  const tool = new ToolPanel(toolCommander, call, letGo, warn);
  labelKeys(document).catch(() => {}); // without a layout the caps of a US keyboard stay

  const mayPress = () => {
    if (!bridge.connected) status.warn("not connected: nothing can be moved");
    else if (status.estopped) status.warn("e-stop is active: release it first");
    else return true;
    return false;
  };
  const setEstop = (/** @type {boolean} */ data) => {
    letGo("e-stop");
    if (!bridge.publish(topic("e_stop"), { data })) status.warn("not connected: e-stop was NOT sent");
  };
  const commands = {
    slower: () => commander.changeSpeed(-1),
    faster: () => commander.changeSpeed(1),
    stop: () => {
      letGo("stop");
      commander.stopPresets();
    },
    estop: () => setEstop(true),
    mode: () => tool.setMode(),
    frame: () => tool.setFrame(),
    hold: () => tool.toggleHold(),
  };

  listenToKeys(held, mayPress, (code) => tool.actionOfKey(code, ACTION_OF_KEY.get(code)), commands);
  listenToPointers(document.body, held, mayPress);
  watchOperator(letGo);
  onClick(byId("slower"), commands.slower);
  onClick(byId("faster"), commands.faster);
  onClick(byId("estop"), commands.estop);
  onClick(byId("release"), () => setEstop(false));
  tool.listen(onClick);
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-side]"))) {
    button.addEventListener("click", () => {
      commander.side = /** @type {"left" | "both" | "right"} */ (button.dataset.side);
      panels.showSide(commander.side);
    });
  }
  panels.showSide(commander.side);

  commander.advertise();
  toolCommander.advertise();
  bridge.advertise(topic("e_stop"), TYPES.bool, { latch: true });
  const listen = (
    /** @type {string} */ name,
    /** @type {string} */ type,
    /** @type {(message: any) => void} */ heard,
    throttle = 0,
  ) => bridge.subscribe({ topic: topic(name), type, throttle, heard });
  listen("joint_states", TYPES.jointStates, (states) => panels.showJoints(states), JOINTS_PERIOD);
  listen(STABILITY.topic, STABILITY.type, (stability) => attitude.set(stability));
  listen("sim/status", TYPES.simStatus, (sim) => {
    status.setSim(sim);
    // Releasing the e-stop must not bring back a motion that is still held.
    if (status.estopped) letGo("e-stop");
  });
  for (const node of JOINT_NODES) {
    listen(`${node}/status`, TYPES.jointStatus, (report) => {
      commander.setJointStatus(node, report);
      panels.showLimited(node, report.limited);
      if (node === "arm_teleop") tool.setArmStatus(report);
      status.logComplaint(node, report.message);
    });
  }
  listen(`${FLIPPER_NODE}/presets`, TYPES.flipperPresets, ({ names, descriptions }) => {
    commander.presets = names;
    panels.showPresets(names, descriptions);
  });
  listen("arm_teleop/cartesian_status", TOOL_TYPES.cartesianStatus, (report) => tool.setStatus(report));
  listen(`${TRACK_NODE}/status`, TYPES.trackStatus, (report) => {
    commander.setTrackStatus(report);
    panels.showDrive(report.command);
    status.logComplaint(TRACK_NODE, report.message);
  });

  keepPace(COMMAND_PERIOD, () => {
    if (!held.empty && bridge.silence > SILENT_AFTER) letGo("the robot does not answer");
    if (!held.empty || commander.busy || toolCommander.busy) update();
  }, letGo);
  setInterval(() => {
    status.showLink(bridge);
    status.showSim();
    status.showSpeed(commander.speeds);
    status.showVideo(cameras.main);
    cameras.refresh();
    status.fade();
    attitude.fade();
  }, DISPLAY_PERIOD);
  bridge.start();
}

/**
 * @param {HTMLElement} button
 * @param {() => void} act
 */
function onClick(button, act) {
  // The focus stays where it is: Space must never click a button that was clicked before.
  button.addEventListener("pointerdown", (event) => event.preventDefault());
  button.addEventListener("mousedown", (event) => event.preventDefault());
  button.addEventListener("click", act);
}

start();
