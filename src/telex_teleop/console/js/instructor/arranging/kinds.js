// @ts-check
/** Types of objects to choose one from, each with its picture, in the groups of the library. */

import { onLanguage, text, translated } from "../../language.js";
import { element } from "../../panels.js";

const FIRST = "crate"; // what is chosen first

/** Types of objects: radio buttons, which keys go through as through any. */
export class Kinds {
  /**
   * @param {HTMLElement} place
   * @param {(text: string) => void} chosen  Told what a type is, once it is chosen.
   */
  constructor(place, chosen) {
    this.place = place;
    /** Types: telex_msgs/LibraryObject. @type {any[]} */
    this._kinds = [];
    place.addEventListener("change", () => chosen(translated(this._kinds.find(({ type }) => type === this.value)?.text ?? "")));
    onLanguage(() => this.fill(this._kinds));
  }

  /** Whether it is known what there is to choose from. */
  get isFilled() {
    return this._kinds.length > 0;
  }

  /** Name of the type that is chosen; empty: none is. */
  get value() {
    return /** @type {HTMLInputElement | null} */ (this.place.querySelector("input:checked"))?.value ?? "";
  }

  /** @param {any[]} library  telex_msgs/LibraryObject, with pictures. */
  fill(library) {
    const wanted = this.value || FIRST;
    this._kinds = library;
    const groups = [...new Set(library.map(({ group }) => group))];
    this.place.replaceChildren(...groups.map((group) => {
      const part = element("fieldset");
      part.append(element("legend", "", text(`${group}|group`)), ...library.filter((each) => each.group === group).map(choice));
      return part;
    }));
    const inputs = [...this.place.querySelectorAll("input")];
    const first = inputs.find(({ value }) => value === wanted) ?? inputs[0];
    if (first !== undefined) first.checked = true;
  }
}

/** @param {string} type  Of an object. */
export const typeText = (type) => text(`${type.replaceAll("_", " ")}|type`);

/** @param {{type: string, text: string, picture?: string}} kind */
function choice({ type, text: about, picture }) {
  const label = element("label"), input = /** @type {HTMLInputElement} */ (element("input"));
  Object.assign(input, { type: "radio", name: "arrange-kind", value: type });
  label.title = translated(about);
  label.append(input);
  if (picture) {
    const image = /** @type {HTMLImageElement} */ (element("img"));
    Object.assign(image, { src: `data:image/jpeg;base64,${picture}`, alt: "" });
    label.append(image);
  }
  label.append(element("span", "", typeText(type)));
  return label;
}
