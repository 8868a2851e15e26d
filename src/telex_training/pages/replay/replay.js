// @ts-check
/** Shows a trial again: a picture of any moment from any camera, and what happened along a timeline. */

import { KINDS, STRETCHES, ceiling, clock, current, outline, sentence } from "./marks.js";
import { aheadText, offerRuns } from "./ghosts.js";
import { bringTexts, decimal, onLanguage, startLanguage, text, translated } from "./language.js";
import { listenToNotes } from "./notes.js";
import { whoLooks } from "./visitor.js";

/** @typedef {import("./marks.js").Mark} Mark */

const GIVEN = new URLSearchParams(location.search);
const TRIAL = location.pathname.split("/").pop() ?? "";
const OUTSIDE = "outside";
const SVG = "http://www.w3.org/2000/svg";
const RETRY_AFTER = 1000; // ms
const SILENT_PERIOD = 100; // ms

/** @template {HTMLElement | SVGElement} T @param {string} id @returns {T} */
const get = (id) => /** @type {any} */ (document.getElementById(id));
const canvas = /** @type {HTMLCanvasElement} */ (get("picture"));
const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
const slider = /** @type {HTMLInputElement} */ (get("slider"));
const seen = /** @type {HTMLInputElement} */ (get("seen"));
const ghost = /** @type {HTMLSelectElement} */ (get("ghost"));

const view = { azimuth: 2.6, elevation: 0.5, distance: 4.0, x: 0, y: 0, z: 0.3 };
const state = { time: 0, duration: 1, period: 0.02, speed: 1, playing: false, camera: OUTSIDE };
/** @type {Mark[]} */
let marks = [];

/** @param {string} path @param {Record<string, string | number>} [more] */
function address(path, more = {}) {
  return `api/${path}/${TRIAL}?${whoLooks(more)}`;
}

/** @param {string} words */
function say(words) {
  get("note").textContent = words;
}

// --- pictures: one at a time, of what is wanted when the last one has come -------------------------

let wanted = false;
let fetching = false;
let playedAt = 0;
let shown = "";

function want() {
  wanted = true;
  void pump();
}

async function pump() {
  if (fetching) return;
  fetching = true;
  while (wanted || state.playing) {
    if (state.playing) advance();
    wanted = false;
    try {
      await picture();
    } catch (error) {
      say(translated(String(error instanceof Error ? error.message : error)));
      await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER));
      playedAt = performance.now();
    }
  }
  fetching = false;
}

function advance() {
  const now = performance.now();
  const time = state.time + (state.speed * (now - playedAt)) / 1000;
  playedAt = now;
  if (time >= state.duration) play(false);
  show(Math.min(time, state.duration));
}

async function picture() {
  const { camera, time } = state;
  const asked = camera === OUTSIDE ? view : { seen: seen.checked ? 1 : 0 };
  // The operator's cameras do not show it, but what draws keeps it in its scene.
  const beside = /** @type {Record<string, string>} */ (ghost.value ? { ghost: ghost.value } : {});
  const reply = await fetch(address("picture", { time: time.toFixed(4), camera, ...asked, ...beside }), { cache: "no-store" });
  if (!reply.ok) throw new Error((await reply.text()).trim() || text("the picture is refused: {status}", { status: reply.status }));
  const silent = reply.headers.get("X-Replay-Silent");
  if (silent !== null) {
    context.fillRect(0, 0, canvas.width, canvas.height);
    drawn(reply, camera, silent);
    // Nothing is drawn that would set the pace.
    await new Promise((resolve) => setTimeout(resolve, SILENT_PERIOD));
    return;
  }
  const bitmap = await createImageBitmap(await reply.blob());
  if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
  }
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  drawn(reply, camera, "");
  get("ahead").textContent = aheadText(camera === OUTSIDE ? reply.headers.get("X-Replay-Ghost-Ahead") : null);
  // Cameras set their exposure by the picture before: what stands still is drawn once more.
  const moment = `${camera} ${time} ${seen.checked}`;
  if (camera !== OUTSIDE && moment !== shown && !state.playing) wanted = true;
  shown = moment;
}

/**
 * @param {Response} reply
 * @param {string} camera
 * @param {string} said  What is wrong; empty: nothing.
 */
function drawn(reply, camera, said) {
  say(translated(said));
  canvas.dataset.camera = camera;
  canvas.dataset.time = reply.headers.get("X-Replay-Time") ?? "";
  canvas.dataset.number = String(Number(canvas.dataset.number ?? 0) + 1);
}

// --- time -------------------------------------------------------------------------------------------

/** @param {number} time */
function show(time) {
  state.time = time;
  slider.value = String(time);
  get("clock").textContent = `${clock(time)} / ${clock(state.duration)}`;
  slider.setAttribute("aria-valuetext", clock(time));
  const track = get("track").getBoundingClientRect();
  const line = get("timeline").getBoundingClientRect();
  get("cursor").style.left = `${line.left - track.left + (line.width * time) / state.duration}px`;
  const number = current(marks, time);
  get("marks").querySelectorAll("button").forEach((button, index) => {
    const is = String(index === number);
    if (button.getAttribute("aria-current") !== is) button.setAttribute("aria-current", is);
  });
}

/** @param {number} time */
function seek(time) {
  show(Math.min(Math.max(time, 0), state.duration));
  playedAt = performance.now();
  want();
}

/** @param {boolean} on */
function play(on) {
  if (on && state.time >= state.duration) show(0);
  state.playing = on;
  playedAt = performance.now();
  get("play").textContent = on ? text("pause") : text("play");
  if (on) void pump();
}

/** @param {number} by */
function step(by) {
  play(false);
  seek(state.time + by);
}

// --- what happened ----------------------------------------------------------------------------------

/**
 * @param {string} kind @param {Record<string, string | number>} attributes @param {string} [title]
 */
function shape(kind, attributes, title = "") {
  const made = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  if (title) made.append(Object.assign(document.createElementNS(SVG, "title"), { textContent: title }));
  return made;
}

/** @param {SVGElement} line */
function seekable(line) {
  line.addEventListener("pointerdown", (event) => {
    const box = line.getBoundingClientRect();
    seek(((event.clientX - box.left) / box.width) * state.duration);
  });
}

/** @param {any} about */
function drawTimeline(about) {
  const line = /** @type {SVGElement} */ (get("timeline"));
  line.setAttribute("viewBox", `0 0 ${state.duration} 1`);
  const width = state.duration / 500;
  for (const { kind, begin, end } of about.stretches) {
    line.append(shape("rect", { x: begin, y: 0, width: Math.max(end - begin, width), height: 1, fill: STRETCHES[kind] ?? "#444" }, translated(kind)));
  }
  line.append(shape("g", { id: "ticks" }));
  seekable(line);
}

function drawMarks() {
  const width = state.duration / 500;
  const ticks = marks.map((mark) => {
    const { color, top } = KINDS[mark.kind] ?? KINDS.other;
    return shape("rect", { x: mark.time - width / 2, y: top, width, height: 1 - top, fill: color }, `${clock(mark.time)} ${sentence(mark)}`);
  });
  get("ticks").replaceChildren(...ticks);
}

/** @param {string} name @param {SVGElement} line @param {string} kind */
function addStrip(name, line, kind) {
  const row = document.createElement("div");
  row.className = `strip ${kind}`;
  const label = document.createElement("span");
  label.textContent = name;
  row.append(label, line);
  get("strips").append(row);
  seekable(line);
}

/** @param {any} about */
function drawStrips(about) {
  for (const strip of about.strips) {
    const top = strip.name === "margin" ? 1 : ceiling(strip.high);
    const line = shape("svg", { viewBox: `0 0 ${strip.high.length} 1`, preserveAspectRatio: "none" });
    line.append(shape("path", { d: outline(strip, top), fill: "#6ea3d4", stroke: "#6ea3d4", "stroke-width": 1, "vector-effect": "non-scaling-stroke" }));
    const empty = strip.high.every((/** @type {number | null} */ value) => value === null);
    addStrip(empty ? text("{figure}: not told", { figure: translated(strip.name) }) : text("{figure}, to {top}", { figure: translated(strip.name), top: `${decimal(top, 4, 0)} ${strip.unit}`.trim() }), /** @type {SVGElement} */ (line), "figure");
  }
  for (const [node, spans] of Object.entries(about.keys)) {
    const line = shape("svg", { viewBox: `0 0 ${state.duration} 1`, preserveAspectRatio: "none" });
    for (const [begin, end] of /** @type {[number, number][]} */ (spans)) line.append(shape("rect", { x: begin, y: 0, width: end - begin, height: 1, fill: "#5fbf77" }));
    addStrip(text("{node} keys", { node: translated(node.replace("_teleop", "")) }), /** @type {SVGElement} */ (line), "keys");
  }
}

function listMarks() {
  const items = marks.map((mark) => {
    const item = document.createElement("li");
    const button = document.createElement("button");
    const dot = document.createElement("i");
    dot.style.background = (KINDS[mark.kind] ?? KINDS.other).color;
    const time = document.createElement("span");
    time.textContent = clock(mark.time);
    const said = document.createElement("span");
    said.textContent = sentence(mark);
    button.append(dot, time, said);
    button.addEventListener("click", () => seek(mark.time));
    item.append(button);
    return item;
  });
  get("marks").replaceChildren(...items);
}

/** @param {any} about */
function explain(about) {
  const kinds = new Set(marks.map((mark) => mark.kind));
  const entries = Object.entries(KINDS).filter(([kind]) => kinds.has(kind)).map(([, { color, text: words }]) => [words, color]);
  const stretches = new Set(about.stretches.map((/** @type {any} */ each) => each.kind));
  for (const [words, color] of [...entries, ...Object.entries(STRETCHES).filter(([kind]) => stretches.has(kind))]) {
    const part = document.createElement("span");
    const dot = document.createElement("i");
    dot.style.background = color;
    part.append(dot, translated(words));
    get("legend").append(part);
  }
}

/**
 * What happened, with all that has been noted by now.
 * @param {any} about
 */
function tell(about) {
  marks = about.marks;
  drawMarks();
  listMarks();
}

/**
 * Write a note; all marks come back with it.
 * @param {{at: number, text: string}} note
 */
async function writeNote(note) {
  const body = JSON.stringify(note);
  const reply = await fetch(address("notes"), { method: "POST", headers: { "Content-Type": "application/json" }, body });
  if (!reply.ok) throw new Error((await reply.text()).trim() || String(reply.status));
  tell(await reply.json());
  show(state.time);
}

/** @param {string[]} names */
function offerCameras(names) {
  const buttons = [OUTSIDE, ...names].map((name) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = translated(name);
    button.dataset.name = name;
    button.addEventListener("click", () => choose(name));
    return button;
  });
  get("cameras").append(...buttons);
  choose(OUTSIDE);
}

/** @param {string} name */
function choose(name) {
  state.camera = name;
  get("cameras").querySelectorAll("button").forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.name === name)));
  get("hint").style.visibility = name === OUTSIDE ? "visible" : "hidden";
  get("seenbox").style.visibility = name === OUTSIDE ? "hidden" : "visible";
  want();
}

// --- hands --------------------------------------------------------------------------------------------

/** Seen from the camera, drag turns the scene under it, with Shift the scene goes along with the pointer. */
function listenToPointer() {
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!canvas.hasPointerCapture(event.pointerId) || state.camera !== OUTSIDE) return;
    const scale = 3.2 / canvas.clientHeight;
    const dx = event.movementX * scale;
    const dy = event.movementY * scale;
    if (event.shiftKey) {
      const reach = 0.35 * view.distance;
      view.x += reach * (dx * -Math.sin(view.azimuth) - dy * Math.cos(view.azimuth));
      view.y += reach * (dx * Math.cos(view.azimuth) - dy * Math.sin(view.azimuth));
    } else {
      view.azimuth = Math.atan2(Math.sin(view.azimuth - dx), Math.cos(view.azimuth - dx));
      view.elevation = Math.min(Math.max(view.elevation + dy, -0.2), 1.5);
    }
    want();
  });
  canvas.addEventListener("wheel", (event) => {
    if (state.camera !== OUTSIDE) return;
    event.preventDefault();
    view.distance = Math.min(Math.max(view.distance * Math.exp(event.deltaY / 600), 0.4), 60);
    want();
  }, { passive: false });
}

/** @param {KeyboardEvent} event */
function onKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target instanceof HTMLSelectElement) return;
  if (event.target instanceof HTMLInputElement && event.target.type === "text") return;
  const far = event.shiftKey ? 1 : state.period;
  if (event.key === " " && !(event.target instanceof HTMLButtonElement || event.target === seen)) play(!state.playing);
  else if (event.key === "ArrowLeft") step(-far);
  else if (event.key === "ArrowRight") step(far);
  else return;
  event.preventDefault();
}

function listen() {
  slider.addEventListener("input", () => seek(Number(slider.value)));
  get("play").addEventListener("click", () => play(!state.playing));
  get("back").addEventListener("click", () => step(-state.period));
  get("on").addEventListener("click", () => step(state.period));
  const speed = /** @type {HTMLSelectElement} */ (get("speed"));
  speed.addEventListener("change", () => { state.speed = Number(speed.value); });
  seen.addEventListener("change", want);
  ghost.addEventListener("change", want);
  document.addEventListener("keydown", onKey);
  addEventListener("resize", () => show(state.time));
  listenToPointer();
  listenToNotes(get("write"), () => state.time, writeNote);
}

async function findGhosts() {
  const reply = await fetch(address("ghosts"), { cache: "no-store" });
  offerRuns(ghost, reply.ok ? await reply.json() : []);
}

/** @param {any} about */
function introduce(about) {
  document.title = `${text("Replay")}: ${translated(about.title)}`;
  get("title").textContent = translated(about.title);
  const verdict = about.valid ? translated(about.verdict) || text("no verdict") : text("not valid");
  const parts = [translated(about.setting), about.operator || text("no name"), translated(about.mode), verdict, clock(about.duration)];
  get("about").textContent = parts.join(" · ");
}

async function main() {
  startLanguage();
  const reply = await fetch(address("trial"), { cache: "no-store" });
  if (!reply.ok) {
    say(text("The trial cannot be shown: {why}", { why: translated((await reply.text()).trim()) || reply.status }));
    return;
  }
  const about = await reply.json();
  Object.assign(state, { duration: Math.max(about.duration, 1e-3), period: about.period });
  slider.max = String(about.duration);
  slider.step = "any";
  introduce(about);
  onLanguage(() => {
    introduce(about);
    tell({ marks });
  });
  bringTexts(`/training/api/texts?${whoLooks()}`);
  for (const problem of about.problems) get("problems").append(Object.assign(document.createElement("li"), { textContent: translated(problem) }));
  drawTimeline(about);
  drawStrips(about);
  tell(about);
  explain(about);
  listen();
  say(text("drawing the first picture …"));
  // "at" is sim time, as sheets have it.
  const begin = GIVEN.has("at") ? Number(GIVEN.get("at")) - about.began : Number(GIVEN.get("time"));
  show(Math.min(Math.max(begin || 0, 0), state.duration));
  offerCameras(about.cameras);
  get("replay").setAttribute("aria-busy", "false");
  await findGhosts();
}

main().catch((error) => say(text("The trial cannot be shown: {why}", { why: translated(error.message) })));
