// @ts-check
/** What motors and tracks sound like, by how fast they run and what they carry. Numbers that are none count as rest. */

/** @typedef {{speed: number, load: number}} Run  Shares of the most, 0 to 1. */
/** @typedef {{pitch: number, tone: number, gain: number}} MotorSound  Hz; up to which pitch its overtones are heard (Hz); 0 to 1. */
/**
 * @typedef {object} GroundSound  Noise that swells with each tread.
 * @property {number} pitch   Hz
 * @property {number} width   Of its band (Hz).
 * @property {number} gain    0 to 1
 * @property {number} beat    Treads per s.
 * @property {number} stroke  How much of it comes with them, 0 to 1.
 */
/** @typedef {"tracks" | "flippers" | "arm"} Group  Motors that sound alike. */

/** Share of a joint's speed below which it rests: what holds a load trembles. */
const REST = 0.01;

/** Pitch (Hz) at rest and at full speed, and how loud at full load: a gear of the tracks is heavier than one of the arm. */
const MOTORS = /** @type {Record<Group, {low: number, high: number, gain: number}>} */ ({
  tracks: { low: 55, high: 240, gain: 1 },
  flippers: { low: 110, high: 380, gain: 0.7 },
  arm: { low: 210, high: 840, gain: 0.5 },
});

/**
 * Of each surface, as scenes name what they are made of: where its noise lies, how broad it is (Hz), how loud, and how much of it are the
 * strokes of the treads.
 */
const SURFACES = /** @type {Record<string, {pitch: number, width: number, gain: number, stroke: number}>} */ ({
  concrete: { pitch: 700, width: 900, gain: 0.5, stroke: 0.5 },
  asphalt: { pitch: 520, width: 700, gain: 0.45, stroke: 0.3 },
  gravel: { pitch: 2100, width: 3200, gain: 1, stroke: 0.2 },
  wood: { pitch: 260, width: 240, gain: 0.7, stroke: 0.8 },
  metal: { pitch: 1500, width: 500, gain: 0.9, stroke: 1 },
  rubber: { pitch: 180, width: 200, gain: 0.25, stroke: 0.1 },
  tiles: { pitch: 1100, width: 700, gain: 0.55, stroke: 0.9 },
});

/** What sounds like something else. @type {Record<string, string>} */
const ALIKE = {
  planks: "wood", crate: "wood", cardboard: "rubber", tread_plate: "metal", brushed_metal: "metal", painted_metal: "metal", brick: "tiles",
};

/** Treads that strike in a second at full speed. */
const STROKES = 18;

/**
 * A share of the most, 0 to 1.
 * @param {number | null | undefined} value
 * @param {number | null | undefined} most
 */
export function share(value, most) {
  const part = Math.abs(Number(value)) / Number(most);
  return Number.isFinite(part) && Number(most) > 0 ? Math.min(1, part) : 0;
}

/**
 * @param {Group} group
 * @param {Run} run
 * @returns {MotorSound}
 */
export function motorSound(group, { speed, load }) {
  const { low, high, gain } = MOTORS[group];
  const [fast, heavy] = [share(speed, 1), share(load, 1)];
  const pitch = low + (high - low) * fast;
  // A load makes it rough before it makes it loud.
  return { pitch, tone: pitch * (2 + 8 * heavy), gain: fast < REST ? 0 : gain * (0.25 + 0.35 * fast + 0.4 * heavy) };
}

/**
 * @param {string} surface  What the tracks run on; empty: nothing, or nobody knows.
 * @param {number} speed  Of the tracks, share of the most.
 * @returns {GroundSound}
 */
export function groundSound(surface, speed) {
  const name = ALIKE[surface] ?? surface, fast = share(speed, 1);
  const { pitch, width, gain, stroke } = SURFACES[name] ?? SURFACES.concrete;
  const isHeard = surface !== "" && fast >= REST;
  return { pitch: pitch * (0.8 + 0.4 * fast), width, gain: isHeard ? gain * Math.sqrt(fast) : 0, beat: STROKES * fast, stroke };
}

/** Speeds and efforts of the robot's motors, in groups by the nodes that move them: whatever no node of joints moves drives the robot. */
export class Motors {
  constructor() {
    /** Which group a joint belongs to. @type {Map<string, Group>} */
    this._groups = new Map();
    /** The most that joints are made for. @type {Map<string, {velocity: number, effort: number}>} */
    this._limits = new Map();
    /** Largest values that were seen, of joints that are made for nobody knows what. @type {Map<string, {velocity: number, effort: number}>} */
    this._seen = new Map();
    /** @type {Record<Group, Run>} */
    this.runs = { tracks: { speed: 0, load: 0 }, flippers: { speed: 0, load: 0 }, arm: { speed: 0, load: 0 } };
  }

  /**
   * @param {string} node
   * @param {string[]} joints  That it moves.
   */
  setNode(node, joints) {
    const group = node === "flipper_teleop" ? "flippers" : "arm";
    for (const joint of joints) this._groups.set(joint, group);
  }

  /** @param {Map<string, {velocity: number, effort: number}>} limits  Of the joints, as the robot's description has them. */
  setLimits(limits) {
    this._limits = limits;
  }

  /** @param {{name: string[], velocity?: (number | null)[], effort?: (number | null)[]}} states  sensor_msgs/JointState */
  hear({ name, velocity = [], effort = [] }) {
    const runs = { tracks: { speed: 0, load: 0 }, flippers: { speed: 0, load: 0 }, arm: { speed: 0, load: 0 } };
    // Of several motors the one that runs fastest is heard; what rests is not, whatever it carries.
    name.forEach((joint, index) => {
      const run = runs[this._groups.get(joint) ?? "tracks"], most = this._most(joint, velocity[index], effort[index]);
      const speed = share(velocity[index], most.velocity);
      if (speed <= run.speed) return;
      run.speed = speed;
      run.load = share(effort[index], most.effort);
    });
    this.runs = runs;
  }

  /** Nothing runs, as far as anybody knows. */
  forget() {
    this.hear({ name: [] });
  }

  /**
   * @param {string} joint
   * @param {number | null | undefined} velocity
   * @param {number | null | undefined} effort
   */
  _most(joint, velocity, effort) {
    const told = this._limits.get(joint);
    if (told !== undefined && told.velocity > 0 && told.effort > 0) return told;
    const seen = this._seen.get(joint) ?? { velocity: 1, effort: 1 };
    const larger = (/** @type {number | null | undefined} */ value, /** @type {number} */ before) =>
      Number.isFinite(value) ? Math.max(before, Math.abs(Number(value))) : before;
    const most = { velocity: told?.velocity || larger(velocity, seen.velocity), effort: told?.effort || larger(effort, seen.effort) };
    this._seen.set(joint, most);
    return most;
  }
}
