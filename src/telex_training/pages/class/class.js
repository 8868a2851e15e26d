// @ts-check
/** The page of a class: all stations, an exercise for several of them, and everybody's progress. */

import { element } from "../elements.js";
import { bringTexts, onLanguage, startLanguage, text, translated } from "../replay/language.js";
import { Card, orderText } from "./cards.js";

/** @typedef {import("./cards.js").Station} Station */
/** @typedef {{name: string, title: string, settings: string[], modes: string[]}} Exercise */

const PERIOD = 1000; // ms
const PROGRESS_PERIOD = 60_000; // ms
const PATIENCE = 5000; // ms
const GIVEN = new URLSearchParams(location.search);
const MARKS = /** @type {Record<string, string>} */ ({ proficient: "●", working: "◐", open: "○", locked: "-", spent: "!" });

const byId = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (byId(id));
const choice = (/** @type {string} */ id) => /** @type {HTMLSelectElement} */ (byId(id));

/**
 * Address below this page, with what its own says of who looks.
 * @param {string} path
 * @param {Record<string, string>} [more]
 */
function address(path, more = {}) {
  const query = new URLSearchParams(more);
  for (const key of ["token", "name"]) if (GIVEN.has(key)) query.set(key, GIVEN.get(key) ?? "");
  return `${path}?${query}`;
}

/** @param {string} path @param {Record<string, string>} [more] @param {number} [patience] ms */
async function ask(path, more = {}, patience = PATIENCE) {
  const reply = await fetch(address(path, more), { cache: "no-store", signal: AbortSignal.timeout(patience) });
  if (!reply.ok) throw new Error((await reply.text()).trim() || String(reply.status));
  return reply.json();
}

/** @param {string} path @param {object} content */
async function send(path, content) {
  const headers = { "Content-Type": "application/json" };
  const reply = await fetch(address(path), { method: "POST", headers, body: JSON.stringify(content), signal: AbortSignal.timeout(PATIENCE) });
  if (!reply.ok) throw new Error((await reply.text()).trim() || String(reply.status));
  return reply.json();
}

/** @param {string} words */
function trouble(words) {
  byId("trouble").hidden = words === "";
  if (byId("trouble").textContent !== words) byId("trouble").textContent = words;
}

/** @type {Map<string, Card>} */
const cards = new Map();
/** @type {Station[]} */
let stations = [];
/** What went wrong with the last thing that was pressed. */
let failed = "";

/** @param {string} name */
async function endHelp(name) {
  try {
    await send(`api/help/${encodeURIComponent(name)}`, {});
    failed = "";
  } catch (error) {
    failed = `${name}: ${translated(/** @type {Error} */ (error).message)}`;
  }
}

async function look() {
  const pictures = field("pictures").checked;
  try {
    // Nobody looks at pictures of a page that is hidden.
    stations = (await ask("api/state", pictures && !document.hidden ? { pictures: "1" } : {})).stations;
    trouble(failed);
  } catch (error) {
    trouble(text("The class's server does not answer: {why}", { why: translated(/** @type {Error} */ (error).message) }));
    return;
  }
  dropGone(cards);
  for (const station of stations) {
    let card = cards.get(station.name);
    if (card === undefined) {
      card = new Card(station.name, address, endHelp);
      cards.set(station.name, card);
      byId("stations").append(card.root);
    }
    card.show(station, pictures);
  }
  showCounts();
  order.showOutcomes();
}

/**
 * Take out what stands for stations that the class does not have any more: its file may name others since its server was started again.
 * @param {Map<string, {root: HTMLElement}>} shown  By names of stations.
 */
function dropGone(shown) {
  for (const [name, { root }] of shown) {
    if (stations.some((station) => station.name === name)) continue;
    root.remove();
    shown.delete(name);
  }
}

function showCounts() {
  const count = (/** @type {(station: Station) => boolean} */ is) => stations.filter(is).length;
  const gone = count(({ phase }) => phase === "gone");
  const asking = count(({ phase, state }) => phase === "here" && state !== null && state.help !== null);
  const parts = [text("{count} of {all} stations", { count: count(({ phase }) => phase === "here"), all: stations.length })];
  if (gone > 0) parts.push(text("{count} gone", { count: gone }));
  if (asking > 0) parts.push(asking === 1 ? text("1 asks for help") : text("{count} ask for help", { count: asking }));
  const words = parts.join(" · ");
  if (byId("counts").textContent !== words) byId("counts").textContent = words;
  document.title = asking > 0 ? `(${asking}) ${text("Class")}` : text("Class");
}

/** The dialog that opens an exercise on several stations. */
class OrderDialog {
  constructor() {
    this._dialog = /** @type {HTMLDialogElement} */ (byId("order"));
    /** @type {Exercise[]} */
    this._exercises = [];
    /** Rows by station. @type {Map<string, {root: HTMLElement, chosen: HTMLInputElement, trainee: HTMLInputElement, outcome: HTMLElement}>} */
    this._rows = new Map();
    /** Stations that refused the last order because of one before it, and why. @type {Record<string, string>} */
    this._busy = {};
    /** Whether an order was sent since the dialog was opened. */
    this._sent = false;
    byId("order-open").addEventListener("click", () => this._open());
    byId("order-close").addEventListener("click", () => this._dialog.close());
    byId("order-exercise").addEventListener("change", () => this._showChoices());
    field("order-all").addEventListener("change", () => {
      for (const { chosen } of this._rows.values()) if (!chosen.disabled) chosen.checked = field("order-all").checked;
    });
    byId("order-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this._send();
    });
  }

  async _open() {
    this._sent = false;
    this._busy = {};
    this._note("");
    this._fillRows();
    this._dialog.showModal();
    if (this._exercises.length > 0) return;
    try {
      this._exercises = await ask("api/exercises", {}, 30_000);
    } catch (error) {
      this._note(text("no exercises: {why}", { why: translated(/** @type {Error} */ (error).message) }));
      return;
    }
    fill(choice("order-exercise"), this._exercises.map(({ name, title }) => [name, translated(title || name)]));
    this._showChoices();
  }

  _showChoices() {
    const exercise = this._exercises.find(({ name }) => name === choice("order-exercise").value);
    fill(choice("order-setting"), (exercise?.settings ?? []).map((each) => [each, translated(each)]));
    fill(choice("order-mode"), (exercise?.modes ?? []).map((each) => [each, translated(each)]));
  }

  /** Choose none, and name whoever sits there now: the last opening may have been another day. */
  _fillRows() {
    field("order-all").checked = false;
    dropGone(this._rows);
    const rows = byId("order-rows");
    for (const { name, state } of stations) {
      let row = this._rows.get(name);
      if (row === undefined) {
        const chosen = /** @type {HTMLInputElement} */ (element("input", "", { type: "checkbox", "aria-label": text("Open it on {name}", { name }) }));
        const trainee = /** @type {HTMLInputElement} */ (element("input", "", { maxlength: "40", autocomplete: "off", "aria-label": text("Trainee at {name}", { name }) }));
        trainee.addEventListener("input", () => { chosen.checked = trainee.value.trim() !== ""; });
        const outcome = element("td");
        const root = element("tr", "", { "data-station": name }, [element("td", "", {}, [chosen]), element("td", name), element("td", "", {}, [trainee]), outcome]);
        row = { root, chosen, trainee, outcome };
        this._rows.set(name, row);
        rows.append(root);
      }
      row.chosen.checked = false;
      // Who sits there is who did the last trial there, or who has control.
      row.trainee.value = state?.operator || state?.holder || "";
    }
    this.showOutcomes();
  }

  showOutcomes() {
    if (!this._dialog.open) return;
    dropGone(this._rows);
    for (const { name, phase, order: given } of stations) {
      const row = this._rows.get(name);
      if (row === undefined) continue;
      row.chosen.disabled = phase !== "here";
      const own = this._busy[name] ?? (this._sent && row.chosen.checked ? orderText(given) : "");
      const words = phase === "here" ? own : translated(phase);
      if (row.outcome.textContent !== words) row.outcome.textContent = words;
    }
  }

  async _send() {
    const chosen = [...this._rows].filter(([, row]) => row.chosen.checked && !row.chosen.disabled);
    const nameless = chosen.find(([, row]) => row.trainee.value.trim() === "");
    if (chosen.length === 0 || nameless !== undefined) {
      this._note(nameless === undefined ? text("choose a station at least") : `${nameless[0]}: ${text("whose trial will it be? type a name")}`);
      nameless?.[1].trainee.focus();
      return;
    }
    const named = Object.fromEntries(chosen.map(([name, { trainee }]) => [name, trainee.value.trim()]));
    const [exercise, setting, mode] = ["order-exercise", "order-setting", "order-mode"].map((id) => choice(id).value);
    try {
      this._busy = (await send("api/open", { stations: named, exercise, setting, mode, start: field("order-start").checked })).busy;
      this._sent = true;
      this._note(text("sent; outcomes stand with the stations"));
    } catch (error) {
      this._note(translated(/** @type {Error} */ (error).message));
    }
  }

  /** @param {string} words */
  _note(words) {
    byId("order-note").textContent = words;
  }
}

/** @param {HTMLSelectElement} where @param {string[][]} choices  Values and their texts. */
function fill(where, choices) {
  where.replaceChildren(...choices.map(([value, words]) => new Option(words, value)));
  where.disabled = choices.length < 2;
}

/** @param {{title: string, modules: string[], people: Record<string, string[]>}} course */
function courseTable({ title, modules, people }) {
  const head = element("tr", "", {}, [element("th"), ...modules.map((name) => element("th", name))]);
  const rows = Object.entries(people).map(([name, states]) => element("tr", "", {}, [
    element("th", name || text("no name")),
    ...states.map((state) => element("td", MARKS[state] ?? state, { "data-state": state, title: text(`${state}|state`) })),
  ]));
  return element("section", "", {}, [element("h2", translated(title)), element("table", "", {}, [element("thead", "", {}, [head]), element("tbody", "", {}, rows)])]);
}

async function showProgress() {
  if (!(/** @type {HTMLDetailsElement} */ (byId("progress"))).open || document.hidden) return;
  const note = byId("progress-note");
  if (byId("courses").childElementCount === 0) note.textContent = text("asking the stations …");
  try {
    const { courses, missing } = await ask("api/progress", {}, 30_000);
    byId("courses").replaceChildren(...courses.map(courseTable));
    const without = Object.entries(missing).map(([name, why]) => text("without {name}: {why}", { name, why: translated(String(why)) }));
    const legend = courses.length === 0 ? text("Nobody has begun a curriculum.") : text("● mastered · ◐ begun · ○ open · - after others · ! too many repetitions");
    note.textContent = [legend, ...without].join(" · ");
  } catch (error) {
    note.textContent = text("no progress: {why}", { why: translated(/** @type {Error} */ (error).message) });
  }
}

const order = new OrderDialog();
byId("progress").addEventListener("toggle", showProgress);
setInterval(showProgress, PROGRESS_PERIOD);
onLanguage(showProgress);

async function main() {
  startLanguage();
  bringTexts(address("api/texts"));
  for (;;) {
    await look();
    await new Promise((resolve) => setTimeout(resolve, PERIOD));
  }
}

main();
