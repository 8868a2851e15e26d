// @ts-check
/** Puts the instructor's page together: it watches everything, and commands the simulation rather than the robot. */

import { ask } from "./ask.js";
import { AttitudeView, STABILITY } from "./attitude.js";
import { atBeat } from "./beat.js";
import { Bridge } from "./bridge.js";
import { onClick } from "./buttons.js";
import { Cameras } from "./cameras.js";
import { locateBridge, waitForConfig } from "./config.js";
import { EmergencyStop } from "./emergency_stop.js";
import { FadingTexts } from "./fading.js";
import { Arranging } from "./instructor/arranging/arranging.js";
import { ExamList } from "./instructor/exam_list.js";
import { LightPanel } from "./instructor/light_panel.js";
import { LinePanel } from "./instructor/line_panel.js";
import { MalfunctionPanel } from "./instructor/malfunction_panel.js";
import { RobotsPanel } from "./instructor/robots_panel.js";
import { listenToTabs } from "./instructor/tabs.js";
import { TraineeCard } from "./instructor/trainee_card.js";
import { showTrials } from "./instructor/trials.js";
import { text, translated } from "./language.js";
import { startLanguage } from "./language/page.js";
import { Line, LINK_STATE } from "./line.js";
import { ODOMETRY, headingOf } from "./hud.js";
import { OVERVIEW, OverviewControl } from "./overview.js";
import { byId, fixed, setText } from "./panels.js";
import { PictureSize } from "./picture_size.js";
import { JOINT_NODES, TRACK_NODE, TYPES, UNKNOWN, fetchRobot } from "./robot.js";
import { RobotClient } from "./robot_client.js";
import { Roster } from "./roster.js";
import { SceneChooser } from "./scenes.js";
import { globalNames, showRobot } from "./several_robots.js";
import { StatusView } from "./status.js";
import { TrainingClient } from "./training/client.js";
import { InstructorBookmarks } from "./training/instructor_bookmarks.js";
import { ExercisePanel } from "./training/instructor_panel.js";
import { TrainingStrip } from "./training/strip.js";
import { fetchVocabulary } from "./vocabulary.js";

const DISPLAY_PERIOD = 200; // ms
const STEP = 0.1; // s of sim time that a step takes
const WARN = 4; // rosgraph_msgs/Log: level of a warning; what is worse has more

/** Role, token and name that this page connects with. */
const given = new URLSearchParams(location.search);
given.set("role", "instructor");
if (!given.get("name")) given.set("name", "instructor");

/**
 * @param {import("./config.js").Config} config
 * @param {Line} line
 */
function startCameras(config, line) {
  const topic = `${config.namespace}/cameras/${OVERVIEW}/image_raw`;
  const others = config.cameras.filter(({ name }) => name !== OVERVIEW);
  // The overview is large from the first picture on, even if nothing has offered it yet.
  const all = { ...config, cameras: [{ name: OVERVIEW, topic }, ...others], hidden_cameras: [], main_camera: OVERVIEW };
  const canvas = /** @type {HTMLCanvasElement} */ (byId("picture"));
  const cameras = new Cameras(
    all, line, canvas, [byId("thumbnails")], ([name]) => setText(byId("camera-name"), translated(name)), given,
  );
  cameras.start();
  return cameras;
}

/**
 * @param {number[]} values  The bridge makes null of one that is none.
 * @param {(...values: number[]) => string} format
 */
const figure = (values, format) => (values.every(Number.isFinite) ? format(...values) : "–");

const degrees = (/** @type {number} */ angle) => `${fixed((angle * 180) / Math.PI, 0)}°`;

async function start() {
  startLanguage();
  const status = new StatusView();
  const attitude = new AttitudeView((sentence) => status.log(sentence, "warning"));
  const config = await waitForConfig(given);
  const topic = globalNames(config);
  const { vocabulary } = await fetchVocabulary(given);
  showRobot(config, byId("brand"));
  const line = new Line((sentence, level) => status.log(sentence, level));
  const cameras = startCameras(config, line);
  const warn = (/** @type {string} */ sentence) => status.warn(sentence);
  const log = (/** @type {string} */ sentence) => status.log(sentence);

  const bridge = new Bridge(() => locateBridge(given), {
    opened: () => {
      status.log(text("connected"));
      estop.connected();
      roster.connected();
      scenes.list();
      exercises.list();
      bookmarks.list();
      overview.connected();
    },
    lost: (reason) => {
      status.forgetSim();
      roster.disconnected();
      status.setLinkBand(text("Connection lost. Reconnecting …"));
      status.log(text("connection lost: {reason}", { reason: translated(reason) }), "alarm");
      estop.lost();
    },
    refused: (sentence) => status.warn(text("bridge: {sentence}", { sentence: translated(sentence) })),
  });
  const estop = new EmergencyStop(bridge, topic("e_stop"), (sentence) => status.warn(sentence, "alarm"));
  const robot = new RobotClient(bridge, topic, log, warn);
  const roster = new Roster(robot);
  const scenes = new SceneChooser(robot, () => cameras.newScene());
  const training = new TrainingClient(robot);
  const strip = new TrainingStrip(training, given, () => {}); // nothing is held here
  const exercises = new ExercisePanel(training, given, () => roster.drivers, log);
  const robots = new RobotsPanel(config, given, (sentence, level) => status.log(sentence, level));
  const examList = new ExamList(robot, () => robots.endExam());
  const linePanel = new LinePanel(robot);
  const malfunctions = new MalfunctionPanel(robot);
  const bookmarks = new InstructorBookmarks(robot, robots.first(config));
  const overview = new OverviewControl(bridge, topic, () => cameras.main.camera);
  const light = new LightPanel(vocabulary, robot);
  const trainee = new TraineeCard(vocabulary, robot, given.get("name") ?? "");
  const arranging = new Arranging(robot, () => cameras.main.camera, (lit) => light.show(lit));
  listenToTabs(byId("tabs"), (part) => arranging.open(part === "scene"));

  const size = new PictureSize(bridge, topic);

  /** What is known of the robot. */
  const facts = new FadingTexts();
  /** @type {any} */
  let sim = null;

  const call = (/** @type {string} */ service, args = {}) => robot.request(service, args, (why) => `${service}: ${why}`);

  onClick(byId("pause"), () => call(sim?.paused ? "sim/unpause" : "sim/pause"));
  onClick(byId("step"), () => call("sim/step", { steps: Math.round(STEP / (sim?.step_size || 0.002)) }));
  onClick(byId("reset"), async () => {
    if (await ask(text("Reset the scene? The robot and everything else go back to where they began."), text("reset"))) call("sim/reset");
  });
  const stopAll = () => {
    estop.set(true);
    robots.stopAll();
  };
  onClick(byId("estop"), stopAll);
  onClick(byId("release"), async () => {
    if (await ask(text("Release the e-stop? The robot obeys again, with the next new press."), text("release e-stop"))) estop.set(false);
  });
  window.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !event.repeat) stopAll();
  });
  const link = /** @type {HTMLAnchorElement} */ (byId("console-link"));
  link.href = `/?${given}`;

  estop.advertise();
  robot.subscribe(LINK_STATE.topic, LINK_STATE.type, (message) => {
    line.hear(message);
    linePanel.hear(message);
  });
  robot.subscribe("sim/status", TYPES.simStatus, (message) => {
    sim = message;
    estop.hear(message);
    if (status.isOtherWorld(message)) cameras.newScene();
    status.setSim(message);
    scenes.setStatus(message);
    arranging.setStatus(message);
    setText(byId("pause"), message.paused ? `▶ ${text("continue")}` : `❚❚ ${text("pause")}`);
    /** @type {HTMLButtonElement} */ (byId("step")).disabled = !message.paused;
    const late = message.late_cycles > 0 ? text(" · {count} late cycles", { count: message.late_cycles }) : "";
    setText(byId("sim-note"), text("{count} resets", { count: message.resets }) + late);
  });
  robot.subscribe(STABILITY.topic, STABILITY.type, (stability) => {
    attitude.set(stability);
    facts.show("robot-roll", figure([stability.roll], degrees));
    facts.show("robot-pitch", figure([stability.pitch], degrees));
    facts.show("robot-margin", figure([stability.margin], (margin) => `${Math.round(100 * Math.max(0, margin))} %`));
  }, DISPLAY_PERIOD);
  robot.subscribe("sim/base_pose", "geometry_msgs/PoseStamped", (message) => {
    overview.setRobot(message);
    const { x, y } = message.pose.position;
    facts.show("robot-place", figure([x, y], () => `${fixed(x, 1)} ${fixed(y, 1)} m`));
  }, DISPLAY_PERIOD);
  const { odometry } = await fetchRobot(given).catch(() => UNKNOWN);
  if (odometry !== null) robot.subscribe(odometry, ODOMETRY.type, ({ pose, twist }) => {
    facts.show("robot-speed", figure([twist.twist.linear.x], (speed) => `${fixed(speed, 2)} m/s`));
    // The operator's, so that both speak of the same.
    facts.show("robot-heading", headingOf(pose.pose.orientation));
  }, DISPLAY_PERIOD);
  for (const node of JOINT_NODES) {
    robot.subscribe(`${node}/status`, TYPES.jointStatus, (report) => status.logComplaint(node, report.message), DISPLAY_PERIOD);
  }
  robot.subscribe(`${TRACK_NODE}/status`, TYPES.trackStatus, (report) => status.logComplaint(TRACK_NODE, report.message), DISPLAY_PERIOD);
  bridge.subscribe({
    topic: "/rosout_agg", type: "rosgraph_msgs/Log", throttle: 0, heard: ({ level, name, msg }) => {
      if (level >= WARN) status.log(`${name.replace(`${config.namespace}/`, "")}: ${msg}`, level > WARN ? "alarm" : "warning");
    },
  });
  roster.subscribe();
  overview.subscribe();
  examList.subscribe();
  malfunctions.subscribe();
  light.subscribe();
  trainee.subscribe();
  showTrials(training, config, { strip, exercises, malfunctions, examList, bookmarks, arranging });

  const display = () => {
    status.showLink(bridge, line);
    status.showSim();
    status.showVideo(cameras, size.isReduced(cameras.main));
    status.fade();
    attitude.fade();
    facts.fade();
    trainee.fade();
    cameras.refresh();
    overview.refresh();
  };
  setInterval(() => atBeat(display), DISPLAY_PERIOD);
  bridge.start();
}

start();
