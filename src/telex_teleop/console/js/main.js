// @ts-check
/** Puts the console together. */

import { Aids } from "./aids/aids.js";
import { AttitudeView, STABILITY } from "./attitude.js";
import { BATTERY, BATTERY_RANGE, BatteryView } from "./battery.js";
import { Avatar } from "./avatar.js";
import { atBeat } from "./beat.js";
import { Bridge } from "./bridge.js";
import { onClick } from "./buttons.js";
import { CameraCommander } from "./camera_panel.js";
import { Cameras } from "./cameras.js";
import { MissionClock } from "./clock.js";
import { COMMAND_PERIOD, Commander } from "./commander.js";
import { locateBridge, waitForConfig } from "./config.js";
import { ControlView } from "./control.js";
import { browserHangs, keepPace, watchOperator } from "./deadman.js";
import { EmergencyStop } from "./emergency_stop.js";
import { FadingTexts } from "./fading.js";
import { GamepadInput } from "./gamepad.js";
import { GAS, GasView } from "./gas.js";
import { CONTACT, Gripper } from "./gripper.js";
import { Health, MISSING_NODES } from "./health.js";
import { Held } from "./held.js";
import { Line, LINK_STATE } from "./line.js";
import { Hud, ODOMETRY } from "./hud.js";
import { labelKeys, listenToKeys, listenToPointers, walkButtons } from "./input.js";
import { JointPositions } from "./joints.js";
import { KeyDialog } from "./key_dialog.js";
import { KeyMap } from "./keymap.js";
import { nextLanguage, text, translated } from "./language.js";
import { offerLayouts } from "./language/keyboard.js";
import { startLanguage } from "./language/page.js";
import { Lamps } from "./lamps.js";
import { Layouts } from "./layouts.js";
import { ModeSwitch } from "./modes.js";
import { Motion } from "./motion.js";
import { fetchPadMap } from "./pad_map.js";
import { Panels, all, byId, setText, showTwist } from "./panels.js";
import { leaveOut, showAction } from "./presence.js";
import { PictureSize } from "./picture_size.js";
import { DOSIMETER, DosimeterView } from "./radiation/dosimeter.js";
import { RadiationMap } from "./radiation/map.js";
import { FLIPPER_NODE, JOINT_NODES, RobotWatch, TRACK_NODE, TYPES, UNKNOWN, fetchRobot, fetchUrdf, isSameRobot } from "./robot.js";
import { RobotClient } from "./robot_client.js";
import { showRobot } from "./several_robots.js";
import { SURFACE, Sound } from "./sound/sound.js";
import { SILENT_AFTER, StatusView } from "./status.js";
import { storage } from "./storage.js";
import { TOOL_TYPES, ToolCommander, ToolPanel } from "./tool.js";
import { Tour } from "./tour.js";
import { ExerciseBrief } from "./training/brief.js";
import { ExerciseChooser } from "./training/chooser.js";
import { InstructorText } from "./training/instructor_text.js";
import { TrainingClient } from "./training/client.js";
import { TrainingStrip } from "./training/strip.js";
import { tellTelemetry } from "./training/telemetry.js";
import { RobotModel } from "./urdf.js";
import { fetchVocabulary } from "./vocabulary.js";

const JOINTS_PERIOD = 100; // ms between two updates of the joint table
const DISPLAY_PERIOD = 200; // ms between two updates of header and picture state
const MODEL_RETRY_AFTER = 2000; // ms between two attempts to get the robot's description

/** What the bridge says of topics that an exam closes: as they are asked for, and as this page, told of the exam, gives them up. */
const CLOSED = / is closed while an exam runs|^unsubscribe: .* has not been subscribed to$/;

/** What the operator was given with the page's address. */
const GIVEN = new URLSearchParams(location.search);

/**
 * Ask for the robot's description until there is one. The bridge tells no parameters while an exam runs.
 * @param {import("./bridge.js").Bridge} bridge
 * @returns {Promise<RobotModel>}
 */
async function fetchModel(bridge) {
  for (;;) {
    if (bridge.connected) {
      try {
        const urdf = await fetchUrdf(GIVEN);
        if (urdf !== null) return new RobotModel(urdf);
      } catch (error) {
        console.info(`the robot's description: ${/** @type {Error} */ (error).message}`);
      }
    }
    await new Promise((resolve) => setTimeout(resolve, MODEL_RETRY_AFTER));
  }
}

/**
 * @param {import("./config.js").Config} config
 * @param {import("./robot.js").Facts} facts
 * @param {Line} line
 */
function startCameras(config, { cameras: declared }, line) {
  // A view is kept for the camera that is to be large, even if nothing has offered it yet: of those that the robot has.
  const names = Object.keys(declared);
  if (names.length > 0 && !names.includes(config.main_camera)) config = { ...config, main_camera: names[0] };
  const canvas = /** @type {HTMLCanvasElement} */ (byId("picture"));
  const cameras = new Cameras(
    config, line, canvas, [byId("second"), byId("thumbnails")], ([name]) => setText(byId("camera-name"), translated(name)),
  );
  cameras.start();
  return cameras;
}

/** The console of one robot: what is shown, what is sent, and what must let go of held keys. */
class Console {
  /**
   * @param {import("./config.js").Config} config
   * @param {import("./vocabulary.js").Vocabulary} vocabulary  What can be done, and by which key.
   * @param {import("./robot.js").Facts} facts
   */
  constructor(config, vocabulary, facts) {
    this._vocabulary = vocabulary;
    this._facts = facts;
    const topic = (/** @type {string} */ name) => `${config.namespace}/${name}`;
    const warn = (/** @type {string} */ sentence) => this._status.warn(sentence);
    const letGo = (/** @type {string} */ reason) => this._letGo(reason);
    this._topic = topic;
    // What is shown.
    this._status = new StatusView();
    this._joints = new JointPositions(facts.gripper);
    this._panels = new Panels(this._joints, vocabulary, facts);
    this._hud = new Hud();
    this._drive = new FadingTexts();
    this._gripper = new Gripper(facts.gripper);
    this._battery = new BatteryView();
    this._clock = new MissionClock();
    this._avatar = new Avatar(
      /** @type {HTMLCanvasElement} */ (byId("avatar-side")), /** @type {HTMLCanvasElement} */ (byId("avatar-top")), facts,
    );
    this._attitude = new AttitudeView((sentence) => this._status.log(sentence, "warning"));
    this._dosimeter = new DosimeterView((sentence) => this._status.warn(sentence, "alarm"));
    this._map = new RadiationMap();
    this._gas = new GasView();
    /** @type {RobotModel | null} */
    this._model = null;
    this._pitch = 0; // rad, positive with the nose down
    this._line = new Line((sentence, level) => this._status.log(sentence, level));
    this._cameras = startCameras(config, facts, this._line);
    // What speaks to the robot.
    this._bridge = this._makeBridge();
    this._robot = new RobotWatch(GIVEN, (told) => this._setRobot(told));
    this._estop = new EmergencyStop(this._bridge, topic("e_stop"), (sentence) => this._status.warn(sentence, "alarm"));
    const robot = new RobotClient(this._bridge, topic, (sentence) => this._status.log(sentence), warn);
    const congested = () => this._commander.congested;
    this._commander = new Commander(vocabulary, this._bridge, topic, warn, facts);
    this._toolCommander = new ToolCommander(this._bridge, topic, congested, warn);
    this._cameraCommander = new CameraCommander(vocabulary, this._bridge, topic, congested);
    this._lamps = new Lamps(vocabulary, this._bridge, topic, byId("lamps"), "command");
    this._tool = new ToolPanel(vocabulary, this._toolCommander, robot, letGo);
    this._layouts = new Layouts(storage, config.namespace, vocabulary.layouts, GIVEN.get("layout") ?? "", this._cameras, vocabulary.all);
    this._aids = this._makeAids(config.namespace);
    this._modes = new ModeSwitch(vocabulary.modes, this._tool, letGo, this._layouts);
    this._tool.changed = this._cameras.grown = () => this._modes.show();
    this._modes.show();
    this._control = new ControlView(this._bridge, topic, letGo, warn);
    this._motion = new Motion(this._control, (device) => this._status.log(text("{device} moves the robot", { device }), "warning"));
    this._size = new PictureSize(this._bridge, topic);
    this._training = new TrainingClient(robot);
    this._strip = new TrainingStrip(this._training, GIVEN, letGo);
    this._chooser = new ExerciseChooser(this._training, GIVEN, letGo);
    this._text = new InstructorText(robot);
    /** Of the trial that is open, and of the bridge, which closes to trainees what an exam does not leave them. */
    this._isExam = this._listHolds = false;
    this._tellTelemetry = () => {}; // until there is somebody to tell it
    this._health = new Health(this._status, letGo);
    this._sound = new Sound(storage, (sentence) => this._status.log(sentence));
    this._sound.setRobot(facts);
    // What the operator presses.
    this._keymap = new KeyMap(storage, vocabulary);
    const relabel = () => labelKeys(document, this._keymap);
    this._keyDialog = new KeyDialog(vocabulary, this._keymap, relabel);
    this._keymap.changed = relabel;
    offerLayouts(/** @type {HTMLSelectElement} */ (byId("keyboard")), relabel);
    this._tour = new Tour(storage, vocabulary, relabel);
    this._brief = new ExerciseBrief(vocabulary, GIVEN, () => this._strip.start(), letGo, relabel);
    relabel();
    this._held = new Held(() => this._heldChanged());
    this._commands = this._makeCommands();
    this._gamepad = this._makeGamepad();
  }

  start() {
    this._advertise();
    this._subscribe();
    this._listenToOperator();
    this._listenToButtons();
    this._keepGoing();
    this._bridge.start();
    this._showModel();
  }

  _makeBridge() {
    return new Bridge(() => locateBridge(GIVEN), {
      opened: () => this._connected(),
      lost: (reason) => this._disconnected(reason),
      refused: (sentence) => {
        // A stream of commands that was refused once stays so: the operator has to know, and to press anew.
        if (sentence.startsWith("publish to ")) this._letGo(text("the bridge refused a command"));
        // The strip says that it is an exam, and the aids what of them it takes: names of topics tell a trainee nothing.
        else if (CLOSED.test(sentence)) return console.info(sentence);
        this._status.warn(text("bridge: {sentence}", { sentence: translated(sentence) }));
      },
    });
  }

  /** @param {string} robot  Its namespace. */
  _makeAids(robot) {
    const aids = new Aids({
      vocabulary: this._vocabulary, bridge: this._bridge, topic: this._topic, cameras: this._cameras, layouts: this._layouts,
      joints: this._joints, gripper: this._gripper, map: this._map, zooms: (camera) => this._cameraCommander.zooms(camera),
      paused: () => this._status.paused, warn: (sentence) => this._status.warn(sentence),
      guards: () => this._tool.guards,
    }, storage, robot);
    this._cameraCommander.zoomed = (camera, factor) => aids.zoom(camera, factor);
    aids.setRobot(this._facts);
    return aids;
  }

  _makeGamepad() {
    const gamepad = new GamepadInput({
      held: this._held,
      mayPress: () => this._mayPress(),
      mode: () => this._modes.mode,
      nameOf: (action) => this._vocabulary.nameOf(action, this._commander.presets),
      // A pad has one button for the mode.
      commandOf: (name) => (this._commandOf(name) === this._commands.mode ? () => this._modes.next() : this._commandOf(name)),
      letGo: (reason) => this._letGo(reason),
      warn: (sentence) => this._status.warn(sentence),
    });
    fetchPadMap().then(
      (map) => { gamepad.map = map; },
      (error) => this._status.warn(text("no gamepad can be used: {why}", { why: translated(error.message) })),
    );
    return gamepad;
  }

  /**
   * What an action does at once; undefined: it is held, or not known.
   * @param {string} name
   */
  _commandOf(name) {
    const does = this._vocabulary.get(name)?.does;
    if (does?.kind === "lamps") return () => this._toggleLamps(does.names);
    return does?.kind === "command" ? this._commands[does.name] : undefined;
  }

  /** How each command of the vocabulary is carried out. @returns {Record<string, () => void>} */
  _makeCommands() {
    return {
      slower: () => this._commander.changeSpeed(-1),
      faster: () => this._commander.changeSpeed(1),
      stop: () => {
        this._letGo(text("stop|let go"));
        this._commander.stopPresets();
      },
      "e-stop": () => this._setEstop(true),
      "release e-stop": () => this._setEstop(false),
      mode: () => this._modes.toggle(),
      "drive mode": () => this._modes.set("DRIVE"),
      "camera mode": () => this._modes.set("CAMERA"),
      frame: () => this._tool.setFrame(),
      "hold tool": () => this._tool.toggleHold(),
      "proximity guard": () => this._tool.toggleGuard(),
      "next camera": () => this._cameras.next(),
      "next second camera": () => this._layouts.next(),
      "swap views": () => this._layouts.swap(),
      "second view": () => this._layouts.toggle("second"),
      "small views": () => this._layouts.toggle("small"),
      "walk the buttons": () => walkButtons(),
      "read text": () => this._text.read(),
      sound: () => this._sound.toggle(),
      "quiet alarms": () => this._sound.acknowledge(),
      bookmark: () => this._strip.bookmarks.set(),
      "go back": () => this._strip.bookmarks.back(),
      "next language": () => nextLanguage(),
      aids: () => this._aids.toggleMenu(),
      ...this._aids.commands,
      help: () => {
        this._letGo(text("the list of keys"));
        this._keyDialog.toggle();
      },
    };
  }

  // ---- what is held

  /** What is demanded by all that is held, and how far. @returns {import("./vocabulary.js").Demand[]} */
  get _demands() {
    return [...this._held.amounts].flatMap(([name, amount]) => {
      const action = this._vocabulary.get(name);
      return action === undefined ? [] : [{ ...action.does, amount }];
    });
  }

  _heldChanged() {
    this._update();
    this._panels.showHeld(this._held.actions);
    this._panels.showSide(this._commander.sideOf(this._demands));
    this._showMotion();
    if (!this._held.empty) this._clock.begin();
    this._tour.see(this._held.actions);
    this._tellTelemetry();
  }

  /** Command what is held. */
  _update() {
    const actions = this._demands;
    this._commander.update(actions);
    this._toolCommander.update(actions);
    this._cameraCommander.update(actions);
  }

  /**
   * Let go of everything, and say why unless nothing was held.
   * @param {string} reason
   * @returns {boolean} Whether something was held.
   */
  _letGo(reason) {
    const wasHeld = !this._held.empty;
    if (wasHeld) this._status.warn(text("released: {reason}", { reason }));
    this._release();
    return wasHeld;
  }

  _release() {
    this._gamepad.block();
    this._held.releaseAll();
  }

  /** Whether a press counts now; if not, the operator is told why. */
  _mayPress() {
    const { _status: status } = this;
    if (!this._bridge.connected) status.warn(text("not connected: nothing can be moved"));
    else if (status.estopped) status.warn(text("e-stop is active: release it first"));
    else if (!this._mayCommand()) return false;
    else if (this._keyDialog.isOpen) status.warn(text("close the list of keys first"));
    else if (this._chooser.isOpen) status.warn(text("close the list of exercises first"));
    else if (this._brief.isOpen) status.warn(text("close the brief first"));
    else return true;
    return false;
  }

  /** Whether control is not somebody else's; if it is, the operator is told. */
  _mayCommand() {
    const { _status: status, _control: control } = this;
    if (control.givesUp) status.warn(text("control is being given up: nothing is sent until the robot's side knows"));
    else if (control.isWatching) status.warn(text("{name} has control: you are watching", { name: control.holderName }));
    else return true;
    return false;
  }

  /** @param {string[]} lamps */
  _toggleLamps(lamps) {
    if (this._mayCommand() && !this._lamps.toggle(lamps)) this._status.warn(text("not connected"));
  }

  /** @param {boolean} data  Whether to stop. */
  _setEstop(data) {
    this._release();
    this._estop.set(data);
  }

  // ---- the connection

  _connected() {
    this._status.log(text("connected"));
    this._estop.connected();
    this._control.connected();
    this._aids.connected();
    this._robot.connected();
  }

  /** @param {import("./robot.js").Facts} facts  Where another robot was started in its place, this page is not about it. */
  _setRobot(facts) {
    if (!isSameRobot(facts, this._facts)) return location.reload();
    this._cameraCommander.setCameras(facts.cameras);
    this._aids.setRobot(facts);
    this._sound.setRobot(facts);
  }

  /** @param {string} reason */
  _disconnected(reason) {
    this._release();
    this._commander.disconnected();
    this._toolCommander.disconnected();
    this._control.disconnected();
    this._health.forget();
    this._dosimeter.forget();
    this._gas.forget();
    this._status.forgetSim();
    this._status.setLinkBand(text("Connection lost. Everything is released. Reconnecting …"));
    this._status.log(text("connection lost, everything is released: {reason}", { reason: translated(reason) }), "alarm");
    this._estop.lost();
  }

  _advertise() {
    this._commander.advertise();
    this._toolCommander.advertise();
    this._lamps.advertise();
    this._estop.advertise();
  }

  /**
   * @param {string} name
   * @param {string} type
   * @param {(message: any) => void} heard
   * @param {number} [throttle]  ms between two messages at least.
   */
  _listen(name, type, heard, throttle = 0) {
    this._bridge.subscribe({ topic: this._topic(name), type, throttle, heard });
  }

  _subscribe() {
    this._control.subscribe();
    this._showTraining(false);
    this._training.subscribe((state) => {
      this._showTraining(true);
      this._strip.show(state);
      this._brief.show(state);
      this._isExam = state.mode === "exam" && state.phase !== "idle" && state.phase !== "ended";
      this._followExam();
    });
    this._listen("bridge/exam", "std_msgs/String", ({ data }) => {
      const ends = this._listHolds && data === "";
      this._listHolds = data !== "";
      if (ends) this._bridge.subscribeAnew();
      this._followExam();
    });
    this._text.subscribe();
    const look = () => ({ ...this._cameras.seen, held: [...this._held.actions], aids: { ...this._aids.told, ...this._sound.told } });
    this._tellTelemetry = tellTelemetry(this._bridge, this._topic, () => this._control.isMine && this._control.isKnown ? look() : null);
    this._subscribeToSimulator();
    this._subscribeToNodes();
  }

  /** Have shown and heard what an exam leaves, while one is open and as long as its list holds: the recording is signed first. */
  _followExam() {
    const exam = this._isExam || this._listHolds;
    this._aids.setExam(exam);
    this._sound.setExam(exam);
  }

  /** Show what there is of exercises, which need the training node. @param {boolean} isThere */
  _showTraining(isThere) {
    byId("exercises-open").hidden = !isThere;
    for (const name of ["bookmark", "go back"]) {
      showAction(document, this._vocabulary.nameOf({ kind: "command", name }, []), isThere);
    }
  }

  _subscribeToSimulator() {
    this._listen("joint_states", TYPES.jointStates, (states) => {
      this._joints.set(states);
      this._panels.showJoints();
      this._aids.hearJoints(states);
      this._sound.hearJoints(states);
    }, JOINTS_PERIOD);
    this._listen(BATTERY.topic, BATTERY.type, (message) => this._battery.set(message), DISPLAY_PERIOD);
    this._listen(BATTERY_RANGE.topic, BATTERY_RANGE.type, (message) => this._battery.setRange(message), DISPLAY_PERIOD);
    if (this._facts.moves === null || this._facts.gripper !== null) this._listen(CONTACT.topic, CONTACT.type, (message) => {
      this._gripper.feel(message);
      this._aids.feel(message);
      this._sound.feel(message);
    }, JOINTS_PERIOD);
    this._listen(SURFACE.topic, SURFACE.type, (message) => this._sound.hearSurface(message));
    if (this._facts.odometry !== null) {
      this._listen(this._facts.odometry, ODOMETRY.type, (odometry) => {
        this._hud.setOdometry(odometry);
        this._map.move(odometry);
        this._aids.move(odometry);
      }, ODOMETRY.period);
    }
    // What stands fast does not tip over.
    if (this._facts.moves === null || this._facts.odometry !== null) {
      this._listen(STABILITY.topic, STABILITY.type, (stability) => {
        this._attitude.set(stability);
        this._pitch = stability.pitch ?? 0;
        this._aids.hearStability(stability);
      }, JOINTS_PERIOD);
    }
    this._listen(DOSIMETER.topic, DOSIMETER.type, (reading) => {
      this._dosimeter.set(reading);
      this._map.measure(reading, this._directionOf(reading.detector));
    });
    this._listen(GAS.topic, GAS.type, (reading) => this._gas.set(reading));
    this._listen("sim/status", TYPES.simStatus, (sim) => {
      const status = this._status;
      const wasPaused = status.paused;
      if (status.isOtherWorld(sim)) {
        this._cameras.newScene();
        this._dosimeter.forget();
        this._gas.forget();
        this._map.forget();
      }
      this._map.hearStatus(sim);
      this._estop.hear(sim);
      this._robot.hearStatus();
      status.setSim(sim);
      // What was held before must not go on after it.
      if (status.paused && !wasPaused) this._letGo(text("the simulation is paused"));
      // Releasing the e-stop must not bring back a motion that is still held.
      if (status.estopped) this._release();
    });
  }

  _subscribeToNodes() {
    this._listen(LINK_STATE.topic, LINK_STATE.type, (message) => this._line.hear(message));
    this._listen(MISSING_NODES.topic, MISSING_NODES.type, (message) => this._health.hear(message));
    for (const node of JOINT_NODES) {
      this._listen(`${node}/status`, TYPES.jointStatus, (report) => {
        this._commander.setJointStatus(node, report);
        this._motion.hear(node, report);
        this._panels.showMoved(node, report.joint_names);
        this._sound.hearNode(node, report.joint_names);
        this._panels.showLimited(node, report.limited);
        if (node === "arm_teleop") this._tool.setArmStatus(report);
        this._status.logComplaint(node, report.message);
      });
    }
    this._listen(`${FLIPPER_NODE}/presets`, TYPES.flipperPresets, ({ names, descriptions }) => {
      this._commander.presets = names;
      this._panels.showPresets(names, descriptions);
    });
    this._listen("arm_teleop/cartesian_status", TOOL_TYPES.cartesianStatus, (report) => this._tool.setStatus(report));
    this._listen(`${TRACK_NODE}/status`, TYPES.trackStatus, (report) => {
      this._commander.setTrackStatus(report);
      this._motion.hear(TRACK_NODE, report);
      this._showDrive(report.command);
      this._status.logComplaint(TRACK_NODE, report.message);
    });
  }

  // ---- keys, pointers, buttons

  _listenToOperator() {
    const mayPress = () => this._mayPress();
    const find = (/** @type {string} */ code) => this._keymap.find(code, this._modes.mode);
    listenToKeys(this._held, mayPress, find, (name) => this._commandOf(name), (code) => this._keyDialog.take(code), (reason) => this._letGo(reason));
    listenToPointers(document.body, this._held, mayPress);
    watchOperator((reason) => this._letGo(reason));
  }

  _listenToButtons() {
    const commands = this._commands;
    onClick(byId("estop"), commands["e-stop"]);
    onClick(byId("release"), commands["release e-stop"]);
    onClick(byId("help"), commands.help);
    onClick(byId("tour-start"), () => {
      this._keyDialog.toggle();
      this._tour.start();
    });
    onClick(byId("clock"), () => this._clock.reset());
    onClick(byId("control-button"), () => this._control.toggle());
    for (const button of all("[data-command]")) {
      onClick(button, () => this._commandOf(/** @type {string} */ (button.dataset.command))?.());
    }
    this._tool.listen();
    this._modes.listen((name) => this._vocabulary.nameOf({ kind: "command", name }, []));
    for (const button of all("[data-side]")) {
      button.addEventListener("click", () => {
        this._commander.side = /** @type {"left" | "both" | "right"} */ (button.dataset.side);
        this._panels.showSide(this._commander.side);
      });
    }
    this._panels.showSide(this._commander.side);
  }

  // ---- what happens at a pace

  _keepGoing() {
    const letGo = (/** @type {string} */ reason) => this._letGo(reason);
    keepPace(COMMAND_PERIOD, () => {
      this._gamepad.poll();
      if (!this._held.empty && this._bridge.silence > SILENT_AFTER) letGo(text("the robot does not answer"));
      if (!this._held.empty && browserHangs()) letGo(text("the browser does not answer"));
      if (!this._held.empty || this._commander.busy || this._toolCommander.busy) this._update();
    }, letGo);
    const display = () => this._display();
    setInterval(() => atBeat(display), DISPLAY_PERIOD);
  }

  _display() {
    const { _status: status, _cameras: cameras, _hud: hud } = this;
    status.showLink(this._bridge, this._line);
    status.showSim();
    status.showSpeed(this._commander.speeds);
    status.showVideo(cameras, this._size.isReduced(cameras.main));
    cameras.refresh();
    hud.showLink(this._bridge, this._line, cameras.main);
    hud.showSpeed(status.stuck);
    this._drive.fade();
    this._showMotion();
    hud.showGripper(this._joints, this._gripper, (joint) => this._panels.format(joint));
    this._avatar.draw((joint) => this._joints.position(joint) ?? 0, this._pitch);
    this._clock.show();
    status.fade();
    this._attitude.fade();
    this._dosimeter.fade(status.paused);
    this._gas.fade(status.paused);
    this._map.draw();
    this._aids.change();
    this._sound.refresh(this._troubles, status.stuck);
  }

  /** Names of the alarms that there are now. @returns {string[]} */
  get _troubles() {
    const { _status: status, _hud: hud } = this;
    // While it is paused nothing happens, and no pictures come; a hidden page asks for none.
    const isSeen = document.hidden || status.paused || this._cameras.awaitsScene || hud.picture !== "lost";
    /** @type {Record<string, boolean>} */
    const troubles = {
      tipping: this._attitude.isTipping, "e-stop": status.estopped, "link lost": hud.link === "lost", "picture old": !isSeen,
      dose: this._dosimeter.alarm, guard: this._tool.isGuarded, "link poor": hud.link === "poor", battery: this._battery.isLow,
    };
    return Object.keys(troubles).filter((name) => troubles[name]);
  }

  /** Show who moves what. */
  _showMotion() {
    const sources = this._held.sources.flatMap(({ source, name }) => {
      const action = this._vocabulary.get(name);
      return action === undefined ? [] : [{ source, name, action }];
    });
    const side = this._commander.sideOf(this._demands);
    this._motion.show(sources, this._commander.presets, (joint) => this._panels.format(joint), side);
  }

  /** Show what goes to the tracks now. @param {any} twist  geometry_msgs/Twist */
  _showDrive(twist) {
    this._drive.show("drive-hud", showTwist(twist).join("  "));
  }

  /**
   * Heading of a link's x axis, from the robot's (rad); null: there is no such link.
   * @param {string} link
   */
  _directionOf(link) {
    const pose = link === "" ? undefined : this._model?.poses((joint) => this._joints.position(joint) ?? 0).get(link);
    return pose === undefined ? null : Math.atan2(pose.rotation[3], pose.rotation[0]);
  }

  async _showModel() {
    const model = await fetchModel(this._bridge);
    this._model = model;
    this._panels.setModel(model);
    this._avatar.setModel(model);
    this._aids.setModel(model);
    this._sound.setModel(model);
  }
}

/** Start the console, also where it is not told what can be done. */
async function main() {
  startLanguage();
  const config = await waitForConfig(GIVEN);
  showRobot(config, byId("brand"));
  const facts = await fetchRobot(GIVEN).catch(() => UNKNOWN);
  const { vocabulary, problem } = await fetchVocabulary(GIVEN);
  leaveOut(document, vocabulary);
  byId("keys-band").hidden = problem === "";
  setText(byId("keys-band"), problem);
  new Console(config, vocabulary, facts).start();
}

main();
