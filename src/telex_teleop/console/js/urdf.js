// @ts-check
/** The robot as its URDF describes it: limits of its joints, and where its links are for given joint positions. */

/** @typedef {[number, number, number]} Vector */
/** @typedef {{rotation: number[], translation: Vector}} Pose  Rotation: 3x3, row by row. */

/**
 * @typedef {object} Limits  Of a joint's position (rad or m).
 * @property {number} lower
 * @property {number} upper
 * @property {number} softLower  Where the robot's own controllers begin to hold it back.
 * @property {number} softUpper
 */

/** @typedef {{velocity: number, effort: number}} Most  That a joint is made for (rad/s or m/s; Nm or N); 0: not known. */

/**
 * @typedef {object} UrdfJoint
 * @property {string} name
 * @property {string} type
 * @property {string} parent
 * @property {string} child
 * @property {Pose} origin
 * @property {Vector} axis
 * @property {Limits | null} limits
 * @property {Most} most
 */

/** @typedef {{points: Vector[]}} Shape  Corners in the link's frame; its outline is their convex hull. */

const CYLINDER_CORNERS = 16;

/** @type {Pose} */
const IDENTITY = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] };

/**
 * @param {Pose} pose
 * @param {Vector} point
 * @returns {Vector}
 */
export function transform({ rotation: r, translation: t }, [x, y, z]) {
  return [
    r[0] * x + r[1] * y + r[2] * z + t[0],
    r[3] * x + r[4] * y + r[5] * z + t[1],
    r[6] * x + r[7] * y + r[8] * z + t[2],
  ];
}

/**
 * @param {Pose} a
 * @param {Pose} b
 * @returns {Pose}
 */
export function compose(a, b) {
  const rotation = [];
  for (let row = 0; row < 9; row += 3) {
    for (let column = 0; column < 3; column += 1) {
      const [x, y, z] = a.rotation.slice(row, row + 3);
      rotation.push(x * b.rotation[column] + y * b.rotation[column + 3] + z * b.rotation[column + 6]);
    }
  }
  return { rotation, translation: transform(a, b.translation) };
}

/**
 * Rotation about a unit vector (Rodrigues).
 * @param {Vector} axis
 * @param {number} angle  rad
 */
function aboutAxis([x, y, z], angle) {
  const c = Math.cos(angle), s = Math.sin(angle), k = 1 - c;
  return [
    c + x * x * k, x * y * k - z * s, x * z * k + y * s,
    y * x * k + z * s, c + y * y * k, y * z * k - x * s,
    z * x * k - y * s, z * y * k + x * s, c + z * z * k,
  ];
}

/** @param {string | null | undefined} text  @returns {Vector} */
function vector(text) {
  const numbers = (text ?? "0 0 0").trim().split(/\s+/).map(Number);
  if (numbers.length !== 3 || !numbers.every(Number.isFinite)) throw new Error(`"${text}" are not three numbers`);
  return /** @type {Vector} */ (numbers);
}

/** @param {Element | null} element  With an <origin>, or without. @returns {Pose} */
function originOf(element) {
  const origin = element?.querySelector(":scope > origin");
  if (!origin) return IDENTITY;
  const [roll, pitch, yaw] = vector(origin.getAttribute("rpy"));
  const turn = (/** @type {Vector} */ axis, /** @type {number} */ angle) =>
    /** @type {Pose} */ ({ rotation: aboutAxis(axis, angle), translation: [0, 0, 0] });
  const { rotation } = compose(compose(turn([0, 0, 1], yaw), turn([0, 1, 0], pitch)), turn([1, 0, 0], roll));
  return { rotation, translation: vector(origin.getAttribute("xyz")) };
}

/** @param {Element} element  A <collision>, or a <visual>. @returns {Shape | null} */
function shapeOf(element) {
  const origin = originOf(element);
  const box = element.querySelector("geometry > box");
  const cylinder = element.querySelector("geometry > cylinder");
  const sphere = element.querySelector("geometry > sphere");
  /** @type {Vector[]} */
  let points = [];
  if (box) {
    const [x, y, z] = vector(box.getAttribute("size")).map((size) => size / 2);
    for (const i of [-x, x]) for (const j of [-y, y]) for (const k of [-z, z]) points.push([i, j, k]);
  } else if (cylinder) {
    const radius = Number(cylinder.getAttribute("radius")), half = Number(cylinder.getAttribute("length")) / 2;
    for (let i = 0; i < CYLINDER_CORNERS; i += 1) {
      const angle = (2 * Math.PI * i) / CYLINDER_CORNERS;
      for (const z of [-half, half]) points.push([radius * Math.cos(angle), radius * Math.sin(angle), z]);
    }
  } else if (sphere) {
    const radius = Number(sphere.getAttribute("radius"));
    for (let i = 0; i < CYLINDER_CORNERS; i += 1) {
      const angle = (2 * Math.PI * i) / CYLINDER_CORNERS, a = radius * Math.cos(angle), b = radius * Math.sin(angle);
      points.push([a, b, 0], [a, 0, b], [0, a, b]);
    }
  }
  points = points.map((point) => transform(origin, point));
  return points.length > 0 ? { points } : null;
}

/** @param {Element} joint  @returns {Limits | null} */
function limitsOf(joint) {
  const limit = joint.querySelector(":scope > limit");
  const [lower, upper] = ["lower", "upper"].map((name) => limit?.getAttribute(name));
  if (joint.getAttribute("type") === "continuous" || !lower || !upper || Number(lower) >= Number(upper)) return null;
  const safety = joint.querySelector(":scope > safety_controller");
  return {
    lower: Number(lower),
    upper: Number(upper),
    softLower: Number(safety?.getAttribute("soft_lower_limit") ?? lower),
    softUpper: Number(safety?.getAttribute("soft_upper_limit") ?? upper),
  };
}

/** @param {Element} joint  @returns {Most} */
function mostOf(joint) {
  const limit = joint.querySelector(":scope > limit");
  const [velocity, effort] = ["velocity", "effort"].map((name) => {
    const most = Number(limit?.getAttribute(name) ?? 0);
    return Number.isFinite(most) ? Math.max(0, most) : 0;
  });
  return { velocity, effort };
}

export class RobotModel {
  /** @param {string} text  URDF. Throws an Error that says what is wrong with it. */
  constructor(text) {
    const robot = new DOMParser().parseFromString(text, "text/xml").querySelector("robot");
    if (robot === null) throw new Error("robot_description is no URDF");
    /** @type {UrdfJoint[]} */
    this.joints = [...robot.querySelectorAll(":scope > joint")].map((joint) => ({
      name: joint.getAttribute("name") ?? "",
      type: joint.getAttribute("type") ?? "fixed",
      parent: joint.querySelector(":scope > parent")?.getAttribute("link") ?? "",
      child: joint.querySelector(":scope > child")?.getAttribute("link") ?? "",
      origin: originOf(joint),
      axis: vector(joint.querySelector(":scope > axis")?.getAttribute("xyz") ?? "1 0 0"),
      limits: limitsOf(joint),
      most: mostOf(joint),
    }));
    /** Shapes by link. @type {Map<string, Shape[]>} */
    this.shapes = new Map();
    /** Links of which the URDF shows nothing but a mesh. @type {Set<string>} */
    this.meshes = new Set();
    /** Centre of mass by link, in its frame. @type {Map<string, Vector>} */
    this.centres = new Map();
    for (const link of robot.querySelectorAll(":scope > link")) {
      const name = link.getAttribute("name") ?? "";
      const of = (/** @type {string} */ kind) => [...link.querySelectorAll(`:scope > ${kind}`)].flatMap((each) => shapeOf(each) ?? []);
      const shapes = of("collision");
      this.shapes.set(name, shapes.length > 0 ? shapes : of("visual"));
      if (this.shapes.get(name)?.length === 0 && link.querySelector("geometry > mesh")) this.meshes.add(name);
      this.centres.set(name, originOf(link.querySelector(":scope > inertial")).translation);
    }
    const children = new Set(this.joints.map(({ child }) => child));
    this.root = [...this.shapes.keys()].find((link) => !children.has(link)) ?? "";
    /** @type {Map<string, UrdfJoint[]>} */
    this._below = new Map();
    for (const joint of this.joints) {
      const siblings = this._below.get(joint.parent) ?? [];
      siblings.push(joint);
      this._below.set(joint.parent, siblings);
    }
  }

  /** @param {string} name */
  limits(name) {
    return this.joints.find((joint) => joint.name === name)?.limits ?? null;
  }

  /**
   * Links that some of the joints move.
   * @param {Iterable<string>} joints
   * @returns {Set<string>}
   */
  movedBy(joints) {
    const names = new Set(joints);
    /** @type {Set<string>} */
    const moved = new Set();
    const visit = (/** @type {string} */ link, /** @type {boolean} */ isMoved) => {
      if (isMoved) moved.add(link);
      for (const joint of this._below.get(link) ?? []) {
        if (!moved.has(joint.child)) visit(joint.child, isMoved || names.has(joint.name));
      }
    };
    visit(this.root, false);
    return moved;
  }

  /**
   * Where the links are, in the root link's frame.
   * @param {(joint: string) => number} position  rad or m
   * @returns {Map<string, Pose>}
   */
  poses(position) {
    const poses = new Map([[this.root, IDENTITY]]);
    const links = [this.root];
    for (let link = links.pop(); link !== undefined; link = links.pop()) {
      for (const joint of this._below.get(link) ?? []) {
        if (poses.has(joint.child)) continue; // a loop: no tree
        poses.set(joint.child, compose(compose(/** @type {Pose} */ (poses.get(link)), joint.origin), motion(joint, position)));
        links.push(joint.child);
      }
    }
    return poses;
  }
}

/**
 * @param {UrdfJoint} joint
 * @param {(joint: string) => number} position
 * @returns {Pose}
 */
function motion({ name, type, axis }, position) {
  if (type === "prismatic") {
    const shift = position(name);
    return { rotation: IDENTITY.rotation, translation: /** @type {Vector} */ (axis.map((part) => part * shift)) };
  }
  if (type === "fixed") return IDENTITY;
  return { rotation: aboutAxis(axis, position(name)), translation: [0, 0, 0] };
}
