// @ts-check
/** What the page lets be heard and felt: motors, tracks, what the gripper touches, alarms. */

import { onClick } from "../buttons.js";
import { text } from "../language.js";
import { byId, setText } from "../panels.js";
import { Alarms } from "./alarms.js";
import { areAids, rights } from "./allowed.js";
import { microphoneSound } from "./microphone.js";
import { Motors, groundSound, motorSound } from "./motors.js";
import { ALARMS, lengthOf } from "./patterns.js";
import { rumble } from "./rumble.js";
import { Synth } from "./synth.js";
import { Touch } from "./touch.js";
import { hush, say } from "./voice.js";

/** What the tracks run on, as the robot's microphone hears it; it says so when that changes. */
export const SURFACE = { topic: "microphone/surface", type: "std_msgs/String" };

const STORED_AS = "telex.sound";
const STEPS = 5; // of the volume
const SILENT_AFTER = 500; // ms after which what was heard of motors or touched counts no more
const RESTS_AFTER = 2000; // ms of silence after which the browser makes no sound, which costs it
const RUMBLES = 160; // ms

/** Of the browser's sounds: few large pieces cost less than many small ones, and all that is heard lies below 8 kHz. @type {AudioContextOptions} */
const CONTEXT = { latencyHint: 0.06, sampleRate: 16000 };

/** What lets a page make sounds. */
const GESTURES = ["keydown", "pointerup", "click"];

export class Sound {
  /**
   * @param {import("../storage.js").Keeper} storage  Keeps volume, and whether it is on.
   * @param {(sentence: string) => void} log
   */
  constructor(storage, log) {
    this._storage = storage;
    const { on = true, volume = 3 } = this._load();
    this._on = on;
    /** In STEPS of all there is. */
    this._volume = volume;
    this._alarms = new Alarms(ALARMS);
    this._motors = new Motors();
    this._touch = new Touch();
    this._motorsHeard = -Infinity;
    this._slip = { strength: 0, at: -Infinity };
    this._surface = "";
    this._stuck = false;
    /** @type {Record<string, unknown>} */
    this._equipment = {};
    this._isExam = false;
    /** Null until somebody has pressed or clicked something. @type {AudioContext | null} */
    this._context = null;
    /** Whether the browser has let the page make sounds. */
    this._begun = false;
    /** @type {Synth | null} */
    this._synth = null;
    /** Until when (ms) something is to be heard. */
    this._soundsUntil = -Infinity;
    const begin = () => this._begin();
    for (const gesture of GESTURES) addEventListener(gesture, begin, { capture: true });
    onClick(byId("sound-quieter"), () => this._setVolume(this._volume - 1));
    onClick(byId("sound-louder"), () => this._setVolume(this._volume + 1));
    this._show();
    if (this._on) log(text("Sound is on; it starts with your first key press or click"));
  }

  /** As the recording has it: whether sound is on, and true where a part of it is a training aid. @returns {Record<string, boolean>} */
  get told() {
    return this._on ? { sound: areAids(this._rights) } : {};
  }

  get _rights() {
    return rights(this._equipment, this._isExam);
  }

  /** Whether the browser lets the page make sounds by now. */
  get _runs() {
    return this._on && this._synth !== null && this._begun;
  }

  /** Switch everything on or off. */
  toggle() {
    this._on = !this._on;
    if (this._on) {
      this._begin();
      this._play();
      this._wake(RESTS_AFTER);
    } else {
      this._synth?.quiet();
      hush();
      this._soundsUntil = -Infinity;
      this._rest();
    }
    this._save();
    this._show();
  }

  /** Hear no more of the alarms that there are now. */
  acknowledge() {
    this._alarms.acknowledge();
    this._synth?.quiet();
    hush();
    this._show();
  }

  // ---- what the robot says

  /** @param {{equipment?: Record<string, any>}} robot  As /robot.json has it. */
  setRobot({ equipment = {} }) {
    this._equipment = equipment;
    this._synth?.setMicrophone(microphoneSound(equipment.microphone));
    this._show();
  }

  /** @param {import("../urdf.js").RobotModel} model */
  setModel(model) {
    this._motors.setLimits(new Map(model.joints.map(({ name, most }) => [name, most])));
  }

  /** @param {boolean} isExam  Whether equipment is all that may be heard. */
  setExam(isExam) {
    if (isExam === this._isExam) return;
    this._isExam = isExam;
    this._show();
  }

  /** @param {string} node @param {string[]} joints  That it moves. */
  hearNode(node, joints) {
    this._motors.setNode(node, joints);
  }

  /** @param {any} states  sensor_msgs/JointState */
  hearJoints(states) {
    this._motors.hear(states);
    this._motorsHeard = performance.now();
    this._play();
  }

  /** @param {{data: string}} message  std_msgs/String */
  hearSurface({ data }) {
    this._surface = data;
  }

  /** @param {any} contact  telex_msgs/GripperContact */
  feel(contact) {
    const { knock, slip } = this._touch.feel(contact);
    this._slip = { strength: slip, at: performance.now() };
    if (!this._on || this._rights.touch === "none") return;
    if (knock > 0) {
      this._wake(RESTS_AFTER);
      this._synth?.knock(knock);
    }
    if (knock + slip > 0) rumble(navigator.getGamepads(), knock, slip, RUMBLES);
    this._play();
  }

  /**
   * Sound what is due; call it every now and then.
   * @param {string[]} wrong  Names of the alarms that there are.
   * @param {boolean} stuck  Whether the belts run and the robot does not.
   */
  refresh(wrong, stuck) {
    const now = performance.now();
    this._stuck = stuck;
    if (now - this._motorsHeard > SILENT_AFTER) this._motors.forget();
    this._alarms.see(wrong, now / 1000);
    this._play();
    const due = this._runs ? this._alarms.next(now / 1000) : null;
    if (due !== null) this._sound(due);
    this._rest();
    this._show();
  }

  // ---- what is heard

  /** Let be heard what runs, and what it runs on. */
  _play() {
    const synth = this._synth;
    if (synth === null || !this._runs) return;
    const { motors, tracks, touch } = this._rights, { runs } = this._motors;
    let loudest = 0;
    for (const group of /** @type {import("./motors.js").Group[]} */ (["tracks", "flippers", "arm"])) {
      const sound = motorSound(group, motors === "none" ? { speed: 0, load: 0 } : runs[group]);
      loudest = Math.max(loudest, sound.gain);
      synth.setMotor(group, sound);
    }
    const isHeard = tracks !== "none";
    synth.setGround(groundSound(isHeard ? this._surface : "", runs.tracks.speed));
    const fingers = touch !== "none" && performance.now() - this._slip.at < SILENT_AFTER ? this._slip.strength : 0;
    const slip = Math.max(fingers, isHeard && this._stuck ? runs.tracks.speed : 0);
    synth.setScrape(slip);
    if (Math.max(loudest, slip) > 0) this._wake(RESTS_AFTER);
  }

  /** @param {{alarm: import("./patterns.js").Alarm, isFirst: boolean}} due */
  _sound({ alarm, isFirst }) {
    const length = 1000 * lengthOf(alarm);
    this._wake(length + RESTS_AFTER);
    hush();
    // Tones tell at once which one it is, the voice after them what it is called.
    this._synth?.sound(alarm.tones);
    if (isFirst) setTimeout(() => this._say(alarm), length);
  }

  /** @param {import("./patterns.js").Alarm} alarm */
  _say({ name, words }) {
    // Whoever has quieted it meanwhile, or hears a graver one, is told nothing.
    if (this._on && this._alarms.sounds(name, performance.now() / 1000)) say(words(), this._volume / STEPS);
  }

  // ---- the browser

  /** Begin to make sounds, as the browser allows it from a gesture on. */
  _begin() {
    if (!this._on || this._begun || globalThis.AudioContext === undefined) return;
    if (this._context === null) {
      this._context = new AudioContext(CONTEXT);
      this._synth = new Synth(this._context);
      this._synth.setVolume(this._volume / STEPS);
      this._synth.setMicrophone(microphoneSound(this._equipment.microphone));
      this._context.onstatechange = () => {
        this._begun ||= this._context?.state === "running";
        this._show();
      };
    }
    this._wake(RESTS_AFTER);
    // What the browser refuses waits: the next gesture asks again.
    this._context.resume().catch(() => {});
  }

  /** Have the browser make sounds for a while. @param {number} length  ms */
  _wake(length) {
    this._soundsUntil = Math.max(this._soundsUntil, performance.now() + length);
    if (this._begun && this._on && this._context?.state === "suspended") this._context.resume().catch(() => {});
  }

  /** Silence costs the browser as much as sound, unless it is told. */
  _rest() {
    if (performance.now() > this._soundsUntil && this._context?.state === "running") this._context.suspend().catch(() => {});
  }

  // ---- the panel

  /** @param {number} volume  In STEPS of all there is. */
  _setVolume(volume) {
    this._volume = Math.max(0, Math.min(STEPS, volume));
    this._synth?.setVolume(this._volume / STEPS);
    this._save();
    this._show();
  }

  _show() {
    const button = byId("sound"), checked = String(this._on);
    if (button.getAttribute("aria-checked") !== checked) button.setAttribute("aria-checked", checked);
    setText(byId("sound-volume"), `${Math.round((100 * this._volume) / STEPS)} %`);
    /** @type {HTMLButtonElement} */ (byId("quiet")).disabled = !this._on || this._alarms.pending.length === 0;
    setText(byId("sound-note"), this._note);
  }

  get _note() {
    if (!this._on) return "";
    if (globalThis.AudioContext === undefined) return text("This browser makes no sounds");
    if (!this._begun) return text("Starts with your first key press or click");
    return areAids(this._rights) ? text("Training aid: motors and touch as the robot itself does not tell them") : "";
  }

  /** @returns {{on?: boolean, volume?: number}} */
  _load() {
    try {
      const { on, volume } = JSON.parse(this._storage.getItem(STORED_AS) ?? "{}");
      const isVolume = Number.isInteger(volume) && volume >= 0 && volume <= STEPS;
      return { ...(typeof on === "boolean" ? { on } : {}), ...(isVolume ? { volume } : {}) };
    } catch {
      return {}; // what another version or another program left there
    }
  }

  _save() {
    this._storage.setItem(STORED_AS, JSON.stringify({ on: this._on, volume: this._volume }));
  }
}
