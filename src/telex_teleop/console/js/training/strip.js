// @ts-check
/** The strip above the picture: the exercise as it stands, questions, and what can be pressed. */

import { makeButton, onClick } from "../buttons.js";
import { language, term, text, translated } from "../language.js";
import { answerOf, choiceText } from "../language/exercise.js";
import { byId, element, setText } from "../panels.js";
import { StripBookmarks } from "./bookmarks.js";
import { addressOf, clockText } from "./client.js";

const PHASES = /** @type {Record<string, string>} */ ({
  ready: term("read the task, then start"),
  preparing: term("putting everything back …"),
  waiting: term("ready: the clock starts when you begin"),
  running: "",
  between: term("repetition ended"),
  ended: term("trial ended"),
});
const MARKS = /** @type {Record<string, string>} */ ({ passed: "✔" });

/** @typedef {import("./client.js").State} State */

/**
 * The same on every page that has a `<section id="training">`. With `data-watched` whoever is at the
 * page is not the trainee, and does nothing in his name.
 */
export class TrainingStrip {
  /**
   * @param {import("./client.js").TrainingClient} client
   * @param {URLSearchParams} given  What this page's address says.
   * @param {(reason: string) => void} letGo  Let go of all keys.
   */
  constructor(client, given, letGo) {
    this._client = client;
    this._given = given;
    this._letGo = letGo;
    this._isWatched = byId("training").dataset.watched === "true";
    this._asked = "";
    /** @type {State | null} */
    this._state = null;
    build(byId("training"));
    this.bookmarks = new StripBookmarks(byId("training-bookmarks"), client, letGo);
    this._listen();
  }

  /** Whether a trial is under way. */
  get isOpen() {
    return this._state !== null && this._state.phase !== "idle";
  }

  _listen() {
    const press = (/** @type {string} */ id, /** @type {() => void} */ act) => onClick(byId(id), act);
    press("training-start", () => this.start());
    press("training-again", () => this._act("again"));
    press("training-give-up", () => this._act("abort"));
    // Held keys stay held: asking changes nothing on the robot.
    press("training-help", () => this._client.act("help", { data: !this._state?.help }));
    press("training-sheet", () => window.open(sheetAddress(/** @type {State} */ (this._state), this._given), "_blank"));
  }

  start() {
    this._act("start");
  }

  /** @param {string} name */
  _act(name) {
    // Robot and scene are put back: held keys must not go on after it.
    this._letGo(text("the exercise"));
    this._client.act(name);
  }

  /** @param {State} state */
  show(state) {
    this._state = state;
    const strip = byId("training");
    strip.hidden = state.phase === "idle";
    if (strip.hidden) return;
    strip.dataset.phase = state.phase;
    strip.dataset.valid = String(state.valid);
    setText(byId("training-title"), [translated(state.title), state.setting === "standard" ? "" : translated(state.setting), state.mode === "exam" ? text("EXAM") : ""].filter(Boolean).join(" · "));
    setText(byId("training-repetition"), repetitionText(state));
    setText(byId("training-results"), state.results.map((result) => MARKS[result] ?? "✘").join(" "));
    byId("training-results").title = state.results.map(translated).join(", ");
    setText(byId("training-clock"), clockText(state.elapsed + state.penalty));
    setText(byId("training-limit"), state.trial_limit > 0 && state.phase !== "ready" ? text("trial {time} left", { time: clockText(state.trial_limit - state.trial_elapsed) }) : "");
    setText(byId("training-step"), stepText(state));
    setText(byId("training-faults"), state.faults.length === 0 ? "" : `! ${state.faults.map(translated).join(", ")}`);
    setText(byId("training-malfunctions"), malfunctionsText(state));
    setText(byId("training-hint"), noteOf(state));
    this._showButtons(state);
    if (this._isWatched) byId("training-bookmarks").hidden = true;
    else this.bookmarks.show(state);
    this._showQuestions(state);
  }

  /** @param {State} state */
  _showButtons({ phase, valid, invalid_because, help }) {
    const goesOn = ["waiting", "running", "between"].includes(phase);
    const shown = { start: phase === "ready", again: goesOn && !this._isWatched, sheet: phase === "ended" };
    for (const [name, visible] of Object.entries(shown)) byId(`training-${name}`).hidden = !visible;
    byId("training-give-up").hidden = ["ready", "ended"].includes(phase) || this._isWatched;
    const helpButton = byId("training-help");
    helpButton.hidden = (phase === "ended" || this._isWatched) && !help;
    helpButton.setAttribute("aria-pressed", String(help));
    setText(helpButton, help ? `${text("help is asked for")} ✕` : text("ask for help"));
    helpButton.title = help ? text("Press when it is no longer needed") : text("The instructor sees it on the page of the class");
    byId("training-again").dataset.wanted = String(phase === "between");
    byId("training-invalid").hidden = valid;
    byId("training-invalid").title = invalid_because.map(translated).join("; ");
  }

  /** @param {State} state */
  _showQuestions({ phase, questions }) {
    const open = phase === "running" ? questions.filter(({ answered }) => !answered) : [];
    const asked = JSON.stringify([open, language().code]);
    if (asked === this._asked) return; // a field that is being typed into must stay
    this._asked = asked;
    byId("training-questions").replaceChildren(...open.slice(0, 3).map((question) => this._question(question)));
  }

  /** @param {State["questions"][number]} question */
  _question({ name, ask, choices }) {
    if (this._isWatched) return element("div", "", `${translated(ask)} ${choices.map(choiceText).join(", ")}`);
    const line = element("form"), label = element("label", "", translated(ask));
    line.append(label);
    const answer = (/** @type {string} */ words) => this._client.act("answer", { question: name, answer: words });
    if (choices.length > 0) {
      line.append(...choices.map((choice) => makeButton(choiceText(choice), () => answer(choice))));
      return line;
    }
    const field = document.createElement("input");
    field.maxLength = 200;
    field.setAttribute("aria-label", translated(ask));
    label.append(" ", field);
    field.addEventListener("focus", () => this._letGo(text("an answer is typed")));
    line.addEventListener("submit", (event) => {
      event.preventDefault();
      if (field.value.trim() !== "") answer(answerOf(field.value.trim()));
    });
    return line;
  }
}

/** @param {HTMLElement} strip */
function build(strip) {
  const part = (/** @type {string} */ tag, /** @type {string} */ name, /** @type {string} */ className = "", role = "") => {
    const made = element(tag, className);
    made.id = `training-${name}`;
    if (role !== "") made.setAttribute("role", role);
    return made;
  };
  const button = (/** @type {string} */ name, /** @type {string} */ words) => {
    return Object.assign(makeButton(words), { id: `training-${name}`, hidden: true });
  };
  const invalid = part("span", "invalid", "badge");
  Object.assign(invalid, { hidden: true, textContent: text("NOT VALID") });
  invalid.dataset.state = "silent";
  const line = element("div", "training-line");
  line.append(
    part("b", "title"), invalid, part("span", "repetition", "num"), part("span", "results"), part("b", "clock", "num"),
    part("span", "step"), part("span", "faults", "", "status"), element("span", "fill"), part("span", "limit", "num note"),
    part("span", "bookmarks"), button("help", text("ask for help")), button("brief", text("brief")), button("start", text("start")), button("again", text("again")), button("give-up", text("give up")), button("sheet", text("score sheet")),
  );
  const failing = part("div", "malfunctions", "training-malfunctions", "status");
  strip.replaceChildren(line, failing, part("div", "hint", "training-hint", "status"), part("div", "questions", "training-questions"));
}

/**
 * Where the sheet of a trial is shown.
 * @param {State} state
 * @param {URLSearchParams} given  What this page's address says.
 */
export function sheetAddress({ trial, operator }, given) {
  // An instructor reads it under a name of his own: notes to the replay that it leads to bear it.
  const name = given.get("role") === "instructor" ? given.get("name") ?? "" : operator;
  return addressOf("/training/sheet.html", given, { trial, name });
}

/** @param {State} state */
export function repetitionText({ repetition, repetitions, phase, from_bookmark: bookmark }) {
  if (repetition === 0 || phase === "ended") return "";
  if (bookmark !== "") return text("practice only, from: {bookmark}", { bookmark: translated(bookmark) });
  return text("rep {count}", { count: repetitions > 0 ? `${repetition}/${repetitions}` : repetition });
}

/** @param {State} state */
export function stepText({ steps, steps_done: done, phase }) {
  const next = steps.findIndex((_, index) => !done[index]);
  if (!["waiting", "running"].includes(phase) || next < 0) return text(PHASES[phase] ?? "");
  const made = done.filter(Boolean).length;
  return phase === "waiting" ? text("{ready} · first: {step}", { ready: text(PHASES.waiting), step: translated(steps[next]) }) : `${made + 1}/${steps.length} ${translated(steps[next])}`;
}

/** What has failed as far as the trainee is told. @param {State} state */
export function malfunctionsText({ malfunctions }) {
  return malfunctions.length === 0 ? "" : text("Malfunction: {names}", { names: malfunctions.map(translated).join(" · ") });
}

/** What is said under the strip: what went wrong before what helps. @param {State} state */
export function noteOf({ message, hint, phase, valid, verdict, results, mode, from_bookmark: bookmark, steps_done: done, faults }) {
  if (message !== "") return translated(message);
  if (phase === "ended" && !valid) return text("not valid: see the sheet");
  if (phase === "ended") return verdict === "" ? text("no verdict: see the sheet") : text("{verdict}: see the sheet", { verdict: translated(verdict).toUpperCase() });
  if (phase === "between" && bookmark !== "") return done.every(Boolean) ? text("done, as practice only") : text("fault: {fault}; practice only", { fault: translated(faults.at(-1) ?? "") });
  if (phase === "between") return results.at(-1) === "passed" ? text("passed") : text("fault: {fault}", { fault: translated(results.at(-1) ?? "") });
  return mode === "practice" ? translated(hint) : "";
}
