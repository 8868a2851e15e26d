// @ts-check
/** The operator's own workload, by NASA-TLX: six sliders, and what they gave. */

import { element } from "./elements.js";
import { term, text, translated } from "./replay/language.js";

/** What is rated, with the words at both ends; in the order of the ratings. */
const SCALES = [
  [term("Mental demand"), term("How much thinking, deciding, searching?"), term("low"), term("high")],
  [term("Physical demand"), term("How much pressing, turning, holding?"), term("low"), term("high")],
  [term("Temporal demand"), term("How hurried was the pace?"), term("low"), term("high")],
  [term("Performance"), term("How successful were you?"), term("perfect|rating"), term("failed|rating")],
  [term("Effort"), term("How hard did you have to work for it?"), term("low"), term("high")],
  [term("Frustration"), term("How discouraged, irritated, stressed?"), term("low"), term("high")],
];

/** @typedef {{ratings: number[], raw: number}} Workload */

/**
 * @param {string} address  At which it is read and sent.
 * @param {boolean} isAsked  Whether the sliders are open at once: after an exam.
 * @returns {Promise<(() => HTMLElement) | null>} Gives the part as it stands; what was moved in it stays. Null: it cannot be rated now.
 */
export async function workloadPart(address, isAsked) {
  /** @type {Workload | null} */
  let given;
  try {
    const reply = await fetch(address, { cache: "no-store" });
    if (!reply.ok) return null;
    given = await reply.json();
  } catch {
    return null;
  }
  const sliders = form(address, isAsked, (sent) => { given = sent; });
  return () => (given === null ? sliders : result(given));
}

/** @param {Workload} workload */
function result({ ratings, raw }) {
  const parts = SCALES.map(([name], index) => `${text(name)} ${ratings[index]}`);
  return element("p", text("Workload {raw} of 100 (NASA-TLX, unweighted): {parts}", { raw: Math.round(raw), parts: parts.join(", ") }), { id: "workload", class: "about" });
}

/** @param {string} address @param {boolean} isAsked @param {(workload: Workload) => void} sent */
function form(address, isAsked, sent) {
  const send = /** @type {HTMLButtonElement} */ (element("button", text("send"), { type: "submit", disabled: "" }));
  const note = element("span", text("move each slider once"), { role: "status" });
  const sliders = SCALES.map(([name]) => (
    /** @type {HTMLInputElement} */ (element("input", "", { type: "range", min: "0", max: "100", step: "5", value: "50", "aria-label": text(name) }))
  ));
  /** Where a slider stands first is nobody's rating. @type {Set<HTMLInputElement>} */
  const moved = new Set();
  const lines = SCALES.map(([name, question, low, high], index) => {
    const slider = sliders[index];
    const value = element("output", "–");
    const touch = () => {
      moved.add(slider);
      value.textContent = slider.value;
      send.disabled = moved.size < SCALES.length;
      if (!send.disabled) note.textContent = "";
    };
    // A click where it stands already is a rating as well.
    for (const event of ["input", "pointerup"]) slider.addEventListener(event, touch);
    const scale = element("span", "", { class: "scale" }, [element("small", text(low)), slider, element("small", text(high))]);
    return element("label", "", {}, [element("span", "", {}, [element("b", text(name)), element("small", ` ${text(question)}`)]), scale, value]);
  });
  const made = /** @type {HTMLFormElement} */ (element("form", "", {}, [...lines, element("p", "", { class: "buttons" }, [send, note])]));
  const part = element("details", "", { id: "workload" }, [element("summary", text("How demanding was it? (NASA-TLX)")), made]);
  if (isAsked) part.setAttribute("open", "");
  made.addEventListener("submit", async (event) => {
    event.preventDefault();
    send.disabled = true;
    note.textContent = text("sending …");
    try {
      const body = JSON.stringify(sliders.map((slider) => Number(slider.value)));
      const reply = await fetch(address, { method: "POST", headers: { "Content-Type": "application/json" }, body });
      if (!reply.ok) throw new Error((await reply.text()).trim() || String(reply.status));
      const workload = await reply.json();
      sent(workload);
      part.replaceWith(result(workload));
    } catch (error) {
      note.textContent = text("not sent: {why}", { why: translated(/** @type {Error} */ (error).message) });
      send.disabled = false;
    }
  });
  return part;
}
