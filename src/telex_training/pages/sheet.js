// @ts-check
/** Shows a score sheet: the verdict first, then each metric, then each repetition. */

import { element } from "./elements.js";
import { whoLooks } from "./replay/visitor.js";
import { workloadPart } from "./workload.js";

const GIVEN = new URLSearchParams(location.search);
const LEAD = 5; // s before a fault from which it is watched
const VERDICTS = /** @type {Record<string, string>} */ ({ passed: "PASSED", failed: "NOT PASSED" });

/**
 * Address below the training's, with what this page's own says of who looks.
 * @param {string} path
 */
function address(path) {
  return `api/${path}/${encodeURIComponent(GIVEN.get("trial") ?? "")}?${whoLooks()}`;
}

/**
 * Address of the trial's replay.
 * @param {number} [time] sim time of what is to be seen (s)
 */
function replayAddress(time) {
  const query = whoLooks(time === undefined ? {} : { at: time });
  return `/replay/${encodeURIComponent(GIVEN.get("trial") ?? "")}?${query}`;
}

/**
 * Address of somebody's progress.
 * @param {string} person
 */
function progressOf(person) {
  return `/progress/?${whoLooks({ person })}`;
}

/**
 * @param {string[]} heads
 * @param {Node[][]} rows
 */
function table(heads, rows) {
  const head = element("thead", "", {}, [element("tr", "", {}, heads.map((name) => element(name === "" ? "td" : "th", name)))]);
  const body = element("tbody", "", {}, rows.map((cells) => element("tr", "", {}, cells)));
  return element("table", "", {}, [head, body]);
}

/** @param {number | null | undefined} value @param {number} [digits] */
function number(value, digits = 2) {
  return value === null || value === undefined ? "–" : String(Number(value.toFixed(digits)));
}

/** @param {number | null} share */
function percent(share) {
  return share === null ? "–" : `${Math.round(100 * share)} %`;
}

/** @param {any} sheet */
function lead(sheet) {
  const { completed, faults, proficiency, reliability, confidence } = sheet.summary;
  const parts = [`${completed} of ${completed + faults} repetitions`];
  if (proficiency !== null) {
    parts.push(`proficiency ${percent(proficiency)} of the expert${sheet.expert.provisional ? " (provisional)" : ""}`);
  }
  if (reliability !== null) parts.push(`reliability at least ${percent(reliability)} (${percent(confidence)} confidence)`);
  return parts.join(" · ");
}

/** @param {any} metric */
function metricRow(metric) {
  const sign = metric.more_is_better ? "≥" : "≤";
  const within = /** @type {Record<string, string>} */ ({ true: "ok", false: "missed", null: "" })[String(metric.within)];
  // Without a figure nothing is within a bound, but nothing was missed that anybody tried.
  const value = metric.value === null ? element("td", "no figure") : element("td", `${number(metric.value)} ${metric.unit}`, { class: within });
  return [
    element("td", metric.text),
    value,
    element("td", metric.pass === null ? "" : `${sign} ${number(metric.pass)}`),
    element("td", metric.expert === null ? "" : `${number(metric.expert[0])} ± ${number(metric.expert[1])}`),
  ];
}

/**
 * @param {any} repetition @param {number} index @param {number | undefined} ended sim time of its end (s)
 */
function repetitionRow(repetition, index, ended) {
  const result = repetition.fault || (repetition.passed ? "passed" : "completed");
  // What led to a fault is just before it.
  const time = ended === undefined ? undefined : Math.max(0, ended - (repetition.fault ? LEAD : repetition.seconds));
  return [
    element("td", String(index + 1)),
    element("td", number(repetition.seconds, 1)),
    element("td", repetition.penalty === 0 ? "" : `+ ${number(repetition.penalty)}`),
    element("td", result, { class: repetition.fault ? "missed" : "ok" }),
    element("td", "", {}, [element("a", "watch", { href: replayAddress(time) })]),
  ];
}

/** What failed, and how soon the operator did something else. @param {any} failure */
function failureRow(failure) {
  const after = (/** @type {number | null} */ seconds) => (seconds === null ? "–" : `after ${number(seconds, 2)} s`);
  return [
    element("td", `${failure.what} ${failure.kind}${failure.announced ? "" : " (silent)"}`),
    element("td", after(failure.command)),
    element("td", after(failure.e_stop)),
    element("td", "", {}, [element("a", "watch", { href: replayAddress(Math.max(0, failure.time - LEAD)) })]),
  ];
}

/** What the line to the robot was set to. @param {any} setting */
function lineText({ time, profile, ...figures }) {
  const named = Object.entries(figures).map(([name, value]) => `${name.replace(/_/g, " ")} ${number(/** @type {number} */ (value), 3)}`);
  return `Line: ${profile}${named.length > 0 ? ` (${named.join(", ")})` : ""}, from ${number(time, 1)} s`;
}

/**
 * Which aids were on, in words: those of the robot's equipment first, then training aids, which stand in for what it lacks.
 * @param {{text: string, training: boolean, seconds: number}[]} aids
 */
function aidsParts(aids) {
  const named = (/** @type {boolean} */ training) => {
    const those = aids.filter((aid) => aid.training === training);
    return those.map(({ text, seconds }) => `${text} (${number(seconds, 0)} s)`).join(", ");
  };
  const parts = [element("p", `Aids that were on: ${named(false) || "none"}`, { class: "about aids" })];
  const training = named(true);
  if (training !== "") {
    parts.push(element("p", `Training aids that were on, which this robot has no equipment for: ${training}`, { class: "about aids training" }));
  }
  return parts;
}

/** @param {any} repetition @param {number | undefined} ended sim time of its end (s) */
function practisedRow(repetition, ended) {
  const cells = repetitionRow(repetition, 0, ended);
  cells[0] = element("td", repetition.bookmark);
  cells[3] = element("td", repetition.fault || "completed");
  return cells;
}

/** @param {any} sheet */
function show(sheet) {
  const { exercise, verdict } = sheet;
  document.title = `${exercise.title}: ${VERDICTS[verdict] ?? "no verdict"}`;
  const seed = exercise.seed === null ? "" : `, seed ${exercise.seed}`;
  const parts = [
    element("h1", VERDICTS[verdict] ?? (sheet.valid ? "NO VERDICT" : "INVALID"), { "data-verdict": verdict }),
    element("p", lead(sheet), { class: "lead" }),
    element("p", `${exercise.title}, ${exercise.setting}${seed} · ${sheet.operator || "no name"} · ${sheet.mode} · ended: ${sheet.ended}`, { class: "about" }),
  ];
  if (!sheet.valid) parts.push(element("p", `Not valid: ${sheet.invalid_because.join("; ")}`, { class: "invalid" }));
  for (const setting of sheet.link ?? []) parts.push(element("p", lineText(setting), { class: "about line" }));
  if (sheet.aids) parts.push(...aidsParts(sheet.aids)); // a page of old tells of none
  for (const mark of sheet.marks) parts.push(element("p", `Instructor's mark: ${mark.verdict} (${mark.reason})`, { class: "about" }));
  parts.push(buttons(sheet.operator));
  if (sheet.metrics.length > 0) parts.push(table(["metric", "you", "pass", "expert"], sheet.metrics.map(metricRow)));
  const ends = sheet.events.filter((/** @type {any} */ each) => each.event === "repetition").map((/** @type {any} */ each) => each.time);
  const rows = sheet.repetitions.map((/** @type {any} */ each, /** @type {number} */ index) => repetitionRow(each, index, ends[index]));
  parts.push(table(["repetition", "seconds", "penalty", "result", ""], rows));
  const failures = sheet.malfunctions ?? []; // sheets of older recordings have none
  if (failures.length > 0) parts.push(table(["malfunction", "other command", "emergency stop", ""], failures.map(failureRow)));
  if (sheet.practised?.length > 0) {
    const practisedEnds = sheet.events.filter((/** @type {any} */ each) => each.event === "practised").map((/** @type {any} */ each) => each.time);
    parts.push(element("p", "Practice only, from bookmarks: counts neither for the rate nor for reliability.", { class: "about" }));
    parts.push(table(["from", "clock", "penalty", "result", ""], sheet.practised.map((/** @type {any} */ each, /** @type {number} */ index) => practisedRow(each, practisedEnds[index]))));
  }
  parts.push(element("p", `Trial ${sheet.trial}, software ${sheet.software}, log ${sheet.log.sha256.slice(0, 16)}, ${sheet.log.samples} samples, ${sheet.log.gaps} gaps, real-time factor ${number(sheet.real_time_factor.mean, 3)}`, { class: "about" }));
  const main = /** @type {HTMLElement} */ (document.getElementById("sheet"));
  main.replaceChildren(...parts);
  main.setAttribute("aria-busy", "false");
  if (sheet.mode === "exam") showSignature(main);
  // The workload is the operator's own, and nobody else's to rate.
  if (GIVEN.get("role") !== "instructor") showWorkload(main, sheet.mode === "exam");
}

/** @param {HTMLElement} main @param {boolean} isAsked */
async function showWorkload(main, isAsked) {
  const part = await workloadPart(address("workload"), isAsked);
  if (part === null) return;
  if (isAsked) main.querySelector(".buttons")?.before(part);
  else main.append(part);
}

/** Say what the signature of an exam is worth: without a valid one it is none. @param {HTMLElement} main */
async function showSignature(main) {
  const reply = await fetch(address("signature"), { cache: "no-store" });
  const found = reply.ok ? String(await reply.json()) : "it cannot be checked";
  const valid = found.startsWith("valid");
  const text = valid ? `Signature: ${found}` : `No exam, for its signature is not valid: ${found}`;
  main.querySelector(".about")?.after(element("p", text, { id: "signature", class: valid ? "about" : "invalid" }));
}

/** @param {string} person */
function buttons(person) {
  const print = element("button", "print", { type: "button" });
  print.addEventListener("click", () => window.print());
  return element("div", "", { class: "buttons" }, [
    element("a", "watch", { href: replayAddress() }),
    print,
    element("a", "CSV", { href: address("csv"), download: "" }),
    ...(person ? [element("a", "progress", { href: progressOf(person) })] : []),
  ]);
}

const TRIES = 20; // a trial's recording is closed a moment after its end
const RETRY_AFTER = 500; // ms

async function main() {
  let reply = await fetch(address("sheet"), { cache: "no-store" });
  // After an exam it is closed to its trainee for that moment.
  for (let tries = 1; [403, 404].includes(reply.status) && tries < TRIES; tries += 1) {
    await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER));
    reply = await fetch(address("sheet"), { cache: "no-store" });
  }
  if (reply.ok) {
    show(await reply.json());
    return;
  }
  const note = /** @type {HTMLElement} */ (document.getElementById("note"));
  note.textContent = `The sheet cannot be shown: ${(await reply.text()).trim() || reply.status}`;
}

main();
