// @ts-check
/** Shows a score sheet: the verdict first, then each metric, then each repetition. */

import { element } from "./elements.js";
import { bringTexts, decimal, metricText, onLanguage, startLanguage, term, text, translated } from "./replay/language.js";
import { whoLooks } from "./replay/visitor.js";
import { workloadPart } from "./workload.js";

const GIVEN = new URLSearchParams(location.search);
const LEAD = 5; // s before a fault from which it is watched
const VERDICTS = /** @type {Record<string, string>} */ ({ passed: term("PASSED"), failed: term("NOT PASSED") });

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
  return value === null || value === undefined ? "–" : decimal(value, digits, 0);
}

/** @param {number | null} share */
function percent(share) {
  return share === null ? "–" : `${Math.round(100 * share)} %`;
}

/** @param {any} sheet */
function lead(sheet) {
  const { completed, faults, proficiency, reliability, confidence } = sheet.summary;
  const parts = [text("{completed} of {all} repetitions", { completed, all: completed + faults })];
  if (proficiency !== null) {
    parts.push(text("proficiency {share} of the expert", { share: percent(proficiency) }) + (sheet.expert.provisional ? text(" (provisional)") : ""));
  }
  if (reliability !== null) parts.push(text("reliability at least {share} ({confidence} confidence)", { share: percent(reliability), confidence: percent(confidence) }));
  return parts.join(" · ");
}

/** @param {any} metric */
function metricRow(metric) {
  const sign = metric.more_is_better ? "≥" : "≤";
  const within = /** @type {Record<string, string>} */ ({ true: "ok", false: "missed", null: "" })[String(metric.within)];
  // Without a figure nothing is within a bound, but nothing was missed that anybody tried.
  const value = metric.value === null ? element("td", text("no figure")) : element("td", `${number(metric.value)} ${metric.unit}`, { class: within });
  return [
    element("td", metricText(metric.text)),
    value,
    element("td", metric.pass === null ? "" : `${sign} ${number(metric.pass)}`),
    element("td", metric.expert === null ? "" : `${number(metric.expert[0])} ± ${number(metric.expert[1])}`),
  ];
}

/**
 * @param {any} repetition @param {number} index @param {number | undefined} ended sim time of its end (s)
 */
function repetitionRow(repetition, index, ended) {
  const result = translated(repetition.fault ?? "") || (repetition.passed ? text("passed") : text("completed"));
  // What led to a fault is just before it.
  const time = ended === undefined ? undefined : Math.max(0, ended - (repetition.fault ? LEAD : repetition.seconds));
  return [
    element("td", String(index + 1)),
    element("td", number(repetition.seconds, 1)),
    element("td", repetition.penalty === 0 ? "" : `+ ${number(repetition.penalty)}`),
    element("td", result, { class: repetition.fault ? "missed" : "ok" }),
    element("td", "", {}, [element("a", text("watch"), { href: replayAddress(time) })]),
  ];
}

/** What failed, and how soon the operator did something else. @param {any} failure */
function failureRow(failure) {
  const after = (/** @type {number | null} */ seconds) => (seconds === null ? "–" : text("after {seconds} s", { seconds: number(seconds, 2) }));
  return [
    element("td", `${failure.robot ? `${failure.robot}: ` : ""}${translated(failure.what)} ${translated(failure.kind)}${failure.announced ? "" : text(" (silent)")}`),
    element("td", after(failure.command)),
    element("td", after(failure.e_stop)),
    element("td", "", {}, [element("a", text("watch"), { href: replayAddress(Math.max(0, failure.time - LEAD)) })]),
  ];
}

/** What the line to the robot was set to. @param {any} setting */
function lineText({ time, profile, ...figures }) {
  const named = Object.entries(figures).map(([name, value]) => `${translated(name.replace(/_/g, " "))} ${number(/** @type {number} */ (value), 3)}`);
  return text("Line: {profile}{figures}, from {seconds} s", { profile: translated(profile), figures: named.length > 0 ? ` (${named.join(", ")})` : "", seconds: number(time, 1) });
}

/**
 * Which aids were on, in words: those of the robot's equipment first, then training aids, which stand in for what it lacks.
 * @param {{text: string, training: boolean, seconds: number, robot?: string}[]} aids  `robot`: of a team, which one, but the first.
 */
function aidsParts(aids) {
  const named = (/** @type {boolean} */ training) => {
    const those = aids.filter((aid) => aid.training === training);
    return those.map((aid) => `${translated(aid.text)} (${[...(aid.robot === undefined ? [] : [aid.robot]), `${number(aid.seconds, 0)} s`].join(", ")})`).join(", ");
  };
  const parts = [element("p", text("Aids that were on: {names}", { names: named(false) || text("none|count") }), { class: "about aids" })];
  const training = named(true);
  if (training !== "") {
    parts.push(element("p", text("Training aids that were on, which this robot has no equipment for: {names}", { names: training }), { class: "about aids training" }));
  }
  return parts;
}

/** @param {any} repetition @param {number | undefined} ended sim time of its end (s) */
function practisedRow(repetition, ended) {
  const cells = repetitionRow(repetition, 0, ended);
  cells[0] = element("td", translated(repetition.bookmark));
  cells[3] = element("td", translated(repetition.fault ?? "") || text("completed"));
  return cells;
}

/** @param {any} sheet */
function show(sheet) {
  const { exercise } = sheet;
  // What did not count may have figures that would have passed.
  const verdict = sheet.valid ? sheet.verdict : "";
  document.title = `${translated(exercise.title)}: ${text(VERDICTS[verdict] ?? (sheet.valid ? "no verdict" : "not valid"))}`;
  const seed = exercise.seed === null ? "" : text(", seed {seed}", { seed: exercise.seed });
  const parts = [
    element("h1", text(VERDICTS[verdict] ?? (sheet.valid ? term("NO VERDICT") : term("INVALID"))), { "data-verdict": verdict }),
    element("p", lead(sheet), { class: "lead" }),
    element("p", `${translated(exercise.title)}, ${translated(exercise.setting)}${seed} · ${sheet.operator || text("no name")} · ${translated(sheet.mode)} · ${text("ended: {how}", { how: translated(sheet.ended) })}`, { class: "about" }),
  ];
  if (!sheet.valid) parts.push(element("p", text("Not valid: {why}", { why: sheet.invalid_because.map(translated).join("; ") }), { class: "invalid" }));
  for (const setting of sheet.link ?? []) parts.push(element("p", lineText(setting), { class: "about line" }));
  if (sheet.aids) parts.push(...aidsParts(sheet.aids)); // a page of old tells of none
  for (const mark of sheet.marks) parts.push(element("p", text("Instructor's mark: {verdict} ({reason})", { verdict: translated(mark.verdict), reason: mark.reason }), { class: "about" }));
  parts.push(buttons(sheet.operator));
  if (sheet.metrics.length > 0) parts.push(table([text("metric"), text("you"), text("pass"), text("expert")], sheet.metrics.map(metricRow)));
  const ends = sheet.events.filter((/** @type {any} */ each) => each.event === "repetition").map((/** @type {any} */ each) => each.time);
  const rows = sheet.repetitions.map((/** @type {any} */ each, /** @type {number} */ index) => repetitionRow(each, index, ends[index]));
  parts.push(table([text("repetition"), text("seconds"), text("penalty"), text("result"), ""], rows));
  const failures = sheet.malfunctions ?? []; // sheets of older recordings have none
  if (failures.length > 0) parts.push(table([text("malfunction"), text("other command"), text("emergency stop"), ""], failures.map(failureRow)));
  if (sheet.practised?.length > 0) {
    const practisedEnds = sheet.events.filter((/** @type {any} */ each) => each.event === "practised").map((/** @type {any} */ each) => each.time);
    parts.push(element("p", text("Practice only, from bookmarks: counts neither for the rate nor for reliability."), { class: "about" }));
    parts.push(table([text("from"), text("clock"), text("penalty"), text("result"), ""], sheet.practised.map((/** @type {any} */ each, /** @type {number} */ index) => practisedRow(each, practisedEnds[index]))));
  }
  parts.push(element("p", text("Trial {trial}, software {software}, log {hash}, {samples} samples, {gaps} gaps, real-time factor {factor}", { trial: sheet.trial, software: sheet.software, hash: sheet.log.sha256.slice(0, 16), samples: sheet.log.samples, gaps: sheet.log.gaps, factor: number(sheet.real_time_factor.mean, 3) }), { class: "about" }));
  const main = /** @type {HTMLElement} */ (document.getElementById("sheet"));
  main.replaceChildren(...parts);
  main.setAttribute("aria-busy", "false");
  for (const place of beside) place(main);
}

/** Put what was fetched beside the sheet in its place. Another language shows it anew, but does not fetch it again. @type {((main: HTMLElement) => void)[]} */
const beside = [];

/** @param {(main: HTMLElement) => void} place */
function add(place) {
  beside.push(place);
  place(/** @type {HTMLElement} */ (document.getElementById("sheet")));
}

/** @param {boolean} isAsked */
async function addWorkload(isAsked) {
  const part = await workloadPart(address("workload"), isAsked);
  if (part === null) return;
  add((main) => {
    if (isAsked) main.querySelector(".buttons")?.before(part());
    else main.append(part());
  });
}

/** Say what the signature of an exam is worth: without a valid one it is none. */
async function addSignature() {
  const reply = await fetch(address("signature"), { cache: "no-store" });
  const found = reply.ok ? String(await reply.json()) : term("it cannot be checked");
  const valid = found.startsWith("valid");
  add((main) => {
    const words = valid ? text("Signature: {found}", { found: translated(found) }) : text("No exam, for its signature is not valid: {found}", { found: translated(found) });
    main.querySelector(".about")?.after(element("p", words, { id: "signature", class: valid ? "about" : "invalid" }));
  });
}

/** @param {string} person */
function buttons(person) {
  const print = element("button", text("print"), { type: "button" });
  print.addEventListener("click", () => window.print());
  return element("div", "", { class: "buttons" }, [
    element("a", text("watch"), { href: replayAddress() }),
    print,
    element("a", "CSV", { href: address("csv"), download: "" }),
    ...(person ? [element("a", text("progress"), { href: progressOf(person) })] : []),
  ]);
}

const TRIES = 20; // a trial's recording is closed a moment after its end
const RETRY_AFTER = 500; // ms

async function main() {
  startLanguage();
  let reply = await fetch(address("sheet"), { cache: "no-store" });
  // After an exam it is closed to its trainee for that moment.
  for (let tries = 1; [403, 404].includes(reply.status) && tries < TRIES; tries += 1) {
    await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER));
    reply = await fetch(address("sheet"), { cache: "no-store" });
  }
  if (reply.ok) {
    const sheet = await reply.json();
    show(sheet);
    onLanguage(() => show(sheet));
    bringTexts(`api/texts?${whoLooks()}`);
    if (sheet.mode === "exam") addSignature();
    // The workload is the operator's own, and nobody else's to rate.
    if (GIVEN.get("role") !== "instructor") addWorkload(sheet.mode === "exam");
    return;
  }
  const note = /** @type {HTMLElement} */ (document.getElementById("note"));
  note.textContent = text("The sheet cannot be shown: {why}", { why: translated((await reply.text()).trim()) || reply.status });
}

main();
