// @ts-check
/** What the dosimeter has read, and where the odometry was meanwhile: all that the map of radiation knows. */

/** @typedef {{x: number, y: number, yaw: number}} Place  m, rad; in the odometry's frame. */
/** @typedef {Place & {rate: number, seen: number | null, bearing: number | null}} Measured
 *  Rate at the hull (Gy/h); what a shielded detector saw (Gy/h), and along which heading (rad, counter-clockwise). */

const APART = 0.1; // m between points that are kept
const STOOD = 0.02; // m; nearer than that, it is measured anew
const TURNED = 0.03; // rad; a detector that has turned by more has seen something else
const JUMP = 0.5; // m in one step: the odometry begins anew
const MOST = 4000;

/** Within so far of where the robot stands, what the detector sees by turning is of one place (m). */
const SAME_PLACE = 0.3;

const SECTORS = 72;

/** @param {number} angle  @returns {number} Within half a turn to both sides. */
const wrapped = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

/**
 * Whether a measurement is of another place than the last, or of another direction.
 * @param {Measured} last
 * @param {Measured} now
 */
function isElsewhere(last, now) {
  if (Math.hypot(now.x - last.x, now.y - last.y) > APART) return true;
  if (now.bearing === null || last.bearing === null) return now.bearing !== last.bearing;
  return Math.abs(wrapped(now.bearing - last.bearing)) > TURNED;
}

/** @template Each @param {Each[]} all @returns {Each[]}  Every second of them where there are too many. */
const thinned = (all) => (all.length > MOST ? all.filter((_, index) => index % 2 === 1) : all);

export class RadiationTrack {
  constructor() {
    /** The oldest first. @type {Measured[]} */
    this.points = [];
    /** Where it was, the oldest first. @type {Place[]} */
    this.trail = [];
    /** How often anything but its present place has changed. */
    this.changes = 0;
    /** Where the robot is. @type {Place | null} */
    this.place = null;
  }

  clear() {
    this.points = [];
    this.trail = [];
    this.changes += 1;
  }

  /** Note where the robot is by its odometry. @param {Place} place */
  move(place) {
    if (this.place !== null && Math.hypot(place.x - this.place.x, place.y - this.place.y) > JUMP) this.clear();
    this.place = place;
    const last = this.trail.at(-1);
    if (last !== undefined && Math.hypot(place.x - last.x, place.y - last.y) < APART) return;
    this.trail = thinned([...this.trail, place]);
    this.changes += 1;
  }

  /**
   * Note what was measured here.
   * @param {number} rate  At the hull (Gy/h).
   * @param {number | null} seen  By the detector (Gy/h); null: there is none that is shielded.
   * @param {number | null} direction  Of the detector's axis, from the robot's (rad).
   */
  measure(rate, seen, direction) {
    if (this.place === null || !Number.isFinite(rate)) return;
    const bearing = seen === null || direction === null ? null : wrapped(this.place.yaw + direction);
    const measured = { ...this.place, rate, seen: bearing === null ? null : seen, bearing };
    const last = this.points.at(-1);
    if (last === undefined || isElsewhere(last, measured)) this.points.push(measured);
    else if (Math.hypot(measured.x - last.x, measured.y - last.y) < STOOD) Object.assign(last, { rate, seen: measured.seen });
    this.points = thinned(this.points);
    this.changes += 1;
  }

  /** Least and greatest rate above 0 (Gy/h); null: none was measured. */
  get range() {
    const rates = this.points.map(({ rate }) => rate).filter((rate) => rate > 0);
    return rates.length === 0 ? null : { least: Math.min(...rates), most: Math.max(...rates) };
  }

  /** Where the rate was greatest. */
  get hottest() {
    return this.points.reduce((/** @type {Measured | null} */ best, each) => (best === null || each.rate > best.rate ? each : best), null);
  }

  /** What the detector saw from about here, by heading; the newest of each sector. @returns {{bearing: number, seen: number}[]} */
  get rose() {
    const { place } = this;
    if (place === null) return [];
    /** @type {Map<number, {bearing: number, seen: number}>} */
    const sectors = new Map();
    for (const { x, y, bearing, seen } of this.points) {
      if (bearing === null || seen === null || Math.hypot(x - place.x, y - place.y) > SAME_PLACE) continue;
      sectors.set(Math.round((bearing / (2 * Math.PI)) * SECTORS) % SECTORS, { bearing, seen });
    }
    return [...sectors.values()].sort((a, b) => a.bearing - b.bearing);
  }
}

/**
 * Heading in which the detector saw most (rad), where it has looked to both sides of it; null: not known yet.
 * @param {{bearing: number, seen: number}[]} rose
 */
export function bearingOf(rose) {
  if (rose.length < 3) return null;
  const best = rose.reduce((a, b) => (b.seen > a.seen ? b : a));
  const beside = (/** @type {number} */ sign) => rose.some(({ bearing, seen }) => {
    const off = sign * wrapped(bearing - best.bearing);
    return off > 0.1 && off < 1 && seen < 0.8 * best.seen;
  });
  return beside(1) && beside(-1) ? best.bearing : null;
}
