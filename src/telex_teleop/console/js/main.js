// @ts-check
/** Puts the console together. */

import { AttitudeView, STABILITY } from "./attitude.js";
import { Avatar } from "./avatar.js";
import { Bridge } from "./bridge.js";
import { onClick } from "./buttons.js";
import { MOVED_CAMERA } from "./camera_actions.js";
import { CameraCommander } from "./camera_panel.js";
import { Cameras } from "./cameras.js";
import { MissionClock } from "./clock.js";
import { COMMAND_PERIOD, Commander } from "./commander.js";
import { locateBridge, waitForConfig } from "./config.js";
import { ControlView } from "./control.js";
import { browserHangs, keepPace, watchOperator } from "./deadman.js";
import { FadingTexts } from "./fading.js";
import { GamepadInput } from "./gamepad.js";
import { CONTACT, Gripper } from "./gripper.js";
import { Health, MISSING_NODES } from "./health.js";
import { Held } from "./held.js";
import { Hud, ODOMETRY } from "./hud.js";
import { labelKeys, listenToKeys, listenToPointers } from "./input.js";
import { JointPositions } from "./joints.js";
import { KeyDialog } from "./key_dialog.js";
import { KeyMap } from "./keymap.js";
import { ModeSwitch } from "./modes.js";
import { Motion } from "./motion.js";
import { fetchPadMap } from "./pad_map.js";
import { getParameter } from "./parameters.js";
import { Panels, byId, setText, showTwist } from "./panels.js";
import { PictureSize } from "./picture_size.js";
import { ACTIONS, FLIPPER_NODE, JOINT_NODES, TRACK_NODE, TYPES } from "./robot.js";
import { SILENT_AFTER, StatusView } from "./status.js";
import { TOOL_TYPES, ToolCommander, ToolPanel } from "./tool.js";
import { Tour } from "./tour.js";
import { RobotModel } from "./urdf.js";

const JOINTS_PERIOD = 100; // ms between two updates of the joint table
const DISPLAY_PERIOD = 200; // ms between two updates of header and picture state
const MODEL_RETRY_AFTER = 2000; // ms between two attempts to get the robot's description

/** What the operator was given with the page's address. */
const GIVEN = new URLSearchParams(location.search);

/** @param {import("./config.js").Config} config */
function startCameras(config) {
  const canvas = /** @type {HTMLCanvasElement} */ (byId("picture"));
  const cameras = new Cameras(config, canvas, byId("thumbnails"), (name) => {
    setText(byId("camera-name"), name);
  });
  cameras.start();
  return cameras;
}

/**
 * Ask for the robot's description until there is one.
 * @param {import("./bridge.js").Bridge} bridge
 * @param {string} parameter
 * @returns {Promise<RobotModel>}
 */
async function fetchModel(bridge, parameter) {
  for (;;) {
    if (bridge.connected) {
      try {
        const text = await getParameter(bridge, parameter);
        if (typeof text === "string") return new RobotModel(text);
      } catch (error) {
        console.info(`${parameter}: ${/** @type {Error} */ (error).message}`);
      }
    }
    await new Promise((resolve) => setTimeout(resolve, MODEL_RETRY_AFTER));
  }
}

async function start() {
  const status = new StatusView();
  const joints = new JointPositions();
  const panels = new Panels(joints);
  const hud = new Hud();
  const drive = new FadingTexts();
  /** Show what goes to the tracks now. @param {any} twist  geometry_msgs/Twist */
  const showDrive = (twist) => {
    const [forward, turn] = showTwist(twist);
    drive.show("drive-linear", forward);
    drive.show("drive-angular", turn);
    drive.show("drive-hud", `${forward}  ${turn}`);
  };
  const gripper = new Gripper();
  const clock = new MissionClock();
  const avatar = new Avatar(
    /** @type {HTMLCanvasElement} */ (byId("avatar-side")), /** @type {HTMLCanvasElement} */ (byId("avatar-top")),
  );
  const keymap = new KeyMap(localStorage);
  const relabel = () => labelKeys(document, keymap);
  let pitch = 0; // rad, positive with the nose down
  const attitude = new AttitudeView((sentence) => status.log(sentence, "warning"));
  const config = await waitForConfig(GIVEN);
  const topic = (/** @type {string} */ name) => `${config.namespace}/${name}`;
  const cameras = startCameras(config);

  const held = new Held(() => {
    update();
    panels.showHeld(held.actions);
    panels.showSide(commander.sideOf(heldActions()));
    showMotion();
    if (!held.empty) clock.begin();
    tour.see(held.actions);
  });

  const heldActions = () => [...held.amounts].map(([name, amount]) => ({ ...ACTIONS[name], amount }));
  const update = () => {
    commander.update(heldActions());
    toolCommander.update(heldActions());
    cameraCommander.update(heldActions());
  };

  /** Let go of everything, and say why unless nothing was held. Returns whether something was. */
  const letGo = (/** @type {string} */ reason) => {
    const wasHeld = !held.empty;
    if (wasHeld) status.warn(`released: ${reason}`);
    release();
    return wasHeld;
  };
  const release = () => {
    gamepad.block();
    held.releaseAll();
  };

  const bridge = new Bridge(() => locateBridge(GIVEN), {
    opened: () => {
      status.log("connected");
      control.connected();
      cameraCommander.connected();
      gripper.ask(bridge, topic);
    },
    lost: (reason) => {
      release();
      commander.disconnected();
      toolCommander.disconnected();
      control.disconnected();
      health.forget();
      status.forgetSim();
      status.setLinkBand("Connection lost. Everything is released. Reconnecting …");
      status.log(`connection lost, everything is released: ${reason}`, "alarm");
    },
    refused: (sentence) => {
      // A stream of commands that was refused once stays so: the operator has to know, and to press anew.
      if (sentence.startsWith("publish to ")) letGo("the bridge refused a command");
      status.warn(`bridge: ${sentence}`);
    },
  });
  const warn = (/** @type {string} */ sentence) => status.warn(sentence);
  const commander = new Commander(bridge, topic, warn);
  const toolCommander = new ToolCommander(bridge, topic, () => commander.congested, warn);
  const call = (/** @type {string} */ name, /** @type {object} */ args) => bridge.call(topic(name), args);
  const cameraCommander = new CameraCommander(bridge, topic, () => commander.congested);
  const tool = new ToolPanel(toolCommander, call, letGo, warn);
  const modes = new ModeSwitch(tool, letGo);
  tool.changed = () => modes.show();
  modes.chosen = (mode) => cameras.borrow(mode === "CAMERA" ? MOVED_CAMERA : null);
  modes.show();
  const control = new ControlView(bridge, topic, letGo, warn);
  const motion = new Motion(control, (device) => status.log(`${device} moves the robot`, "warning"));
  const showMotion = () => motion.show(
    held.sources.map(({ source, name }) => ({ source, name, action: ACTIONS[name] })), commander.presets, (joint) => panels.format(joint),
    commander.sideOf(heldActions()),
  );
  const size = new PictureSize(bridge, topic);
  const health = new Health(status, letGo);
  const keyDialog = new KeyDialog(keymap, relabel);
  keymap.changed = relabel;
  const tour = new Tour(localStorage, relabel);
  relabel();

  const mayPress = () => {
    if (!bridge.connected) status.warn("not connected: nothing can be moved");
    else if (status.estopped) status.warn("e-stop is active: release it first");
    else if (control.isWatching) status.warn(`${control.holderName} has control: you are watching`);
    else if (keyDialog.isOpen) status.warn("close the list of keys first");
    else return true;
    return false;
  };
  const setEstop = (/** @type {boolean} */ data) => {
    release();
    if (!bridge.publish(topic("e_stop"), { data })) status.warn("not connected: e-stop was NOT sent", "alarm");
  };
  const commands = {
    slower: () => commander.changeSpeed(-1),
    faster: () => commander.changeSpeed(1),
    stop: () => {
      letGo("stop");
      commander.stopPresets();
    },
    estop: () => setEstop(true),
    mode: () => modes.toggle(),
    drive_mode: () => modes.set("DRIVE"),
    camera_mode: () => modes.set("CAMERA"),
    frame: () => tool.setFrame(),
    hold: () => tool.toggleHold(),
    guard: () => tool.toggleGuard(),
    view: () => cameras.next(),
    keys: () => {
      letGo("the list of keys");
      keyDialog.toggle();
    },
    "lamps:front": () => cameraCommander.toggle("lamps:front"),
    "lamps:rear": () => cameraCommander.toggle("lamps:rear"),
    "lamps:turret": () => cameraCommander.toggle("lamps:turret"),
    "lamps:gripper": () => cameraCommander.toggle("lamps:gripper"),
  };

  listenToKeys(held, mayPress, (code) => keymap.find(code, modes.mode), commands, (code) => keyDialog.take(code));
  const gamepad = new GamepadInput({
    held,
    mayPress,
    mode: () => modes.mode,
    presets: () => commander.presets,
    commands: { ...commands, release: () => setEstop(false), next_mode: () => modes.next() },
    letGo,
  });
  fetchPadMap().then(
    (map) => { gamepad.map = map; },
    (error) => status.warn(`no gamepad can be used: ${error.message}`),
  );
  listenToPointers(document.body, held, mayPress);
  watchOperator(letGo);
  onClick(byId("slower"), commands.slower);
  onClick(byId("faster"), commands.faster);
  onClick(byId("estop"), commands.estop);
  onClick(byId("release"), () => setEstop(false));
  onClick(byId("help"), commands.keys);
  onClick(byId("tour-start"), () => {
    keyDialog.toggle();
    tour.start();
  });
  onClick(byId("clock"), () => clock.reset());
  onClick(byId("control-button"), () => control.toggle());
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-command]"))) {
    onClick(button, commands[/** @type {import("./robot.js").Command} */ (button.dataset.command)]);
  }
  tool.listen(onClick);
  modes.listen(onClick);
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-side]"))) {
    button.addEventListener("click", () => {
      commander.side = /** @type {"left" | "both" | "right"} */ (button.dataset.side);
      panels.showSide(commander.side);
    });
  }
  panels.showSide(commander.side);

  commander.advertise();
  toolCommander.advertise();
  cameraCommander.advertise();
  control.subscribe();
  bridge.advertise(topic("e_stop"), TYPES.bool, { latch: true });
  const listen = (
    /** @type {string} */ name,
    /** @type {string} */ type,
    /** @type {(message: any) => void} */ heard,
    throttle = 0,
  ) => bridge.subscribe({ topic: topic(name), type, throttle, heard });
  listen("joint_states", TYPES.jointStates, (states) => {
    joints.set(states);
    panels.showJoints();
  }, JOINTS_PERIOD);
  listen(MISSING_NODES.topic, MISSING_NODES.type, (message) => health.hear(message));
  listen(CONTACT.topic, CONTACT.type, (message) => gripper.feel(message), DISPLAY_PERIOD);
  listen(ODOMETRY.topic, ODOMETRY.type, (odometry) => hud.setOdometry(odometry), ODOMETRY.period);
  listen(STABILITY.topic, STABILITY.type, (stability) => {
    attitude.set(stability);
    pitch = stability.pitch ?? 0;
  }, JOINTS_PERIOD);
  listen("sim/status", TYPES.simStatus, (sim) => {
    const wasPaused = status.paused;
    if (status.isOtherWorld(sim)) cameras.newScene();
    status.setSim(sim);
    // What was held before must not go on after it.
    if (status.paused && !wasPaused) letGo("the simulation is paused");
    // Releasing the e-stop must not bring back a motion that is still held.
    if (status.estopped) release();
  });
  for (const node of JOINT_NODES) {
    listen(`${node}/status`, TYPES.jointStatus, (report) => {
      commander.setJointStatus(node, report);
      motion.hear(node, report);
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
    motion.hear(TRACK_NODE, report);
    showDrive(report.command);
    status.logComplaint(TRACK_NODE, report.message);
  });

  keepPace(COMMAND_PERIOD, () => {
    gamepad.poll();
    if (!held.empty && bridge.silence > SILENT_AFTER) letGo("the robot does not answer");
    if (!held.empty && browserHangs()) letGo("the browser does not answer");
    if (!held.empty || commander.busy || toolCommander.busy) update();
  }, letGo);
  setInterval(() => {
    status.showLink(bridge);
    status.showSim();
    status.showSpeed(commander.speeds);
    status.showVideo(cameras, size.isReduced(cameras.main));
    cameras.refresh();
    hud.showLink(bridge, cameras.main);
    hud.showSpeed(status.stuck);
    drive.fade();
    showMotion();
    hud.showGripper(joints, gripper);
    avatar.draw((joint) => joints.position(joint) ?? 0, pitch);
    clock.show();
    status.fade();
    attitude.fade();
  }, DISPLAY_PERIOD);
  bridge.start();
  const model = await fetchModel(bridge, topic("robot_description"));
  panels.setModel(model);
  avatar.setModel(model);
}

start();
