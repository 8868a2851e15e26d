// @ts-check
/** Types of objects to choose one from, each with its picture, in the groups of the library. */

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
    place.addEventListener("change", () => chosen(this._kinds.find(({ type }) => type === this.value)?.text ?? ""));
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
    this._kinds = library;
    const groups = [...new Set(library.map(({ group }) => group))];
    this.place.replaceChildren(...groups.map((group) => {
      const part = element("fieldset");
      part.append(element("legend", "", group), ...library.filter((each) => each.group === group).map(choice));
      return part;
    }));
    const inputs = [...this.place.querySelectorAll("input")];
    const first = inputs.find(({ value }) => value === FIRST) ?? inputs[0];
    if (first !== undefined) first.checked = true;
  }
}

/** @param {{type: string, text: string, picture?: string}} kind */
function choice({ type, text, picture }) {
  const label = element("label"), input = /** @type {HTMLInputElement} */ (element("input"));
  Object.assign(input, { type: "radio", name: "arrange-kind", value: type });
  label.title = text;
  label.append(input);
  if (picture) {
    const image = /** @type {HTMLImageElement} */ (element("img"));
    Object.assign(image, { src: `data:image/jpeg;base64,${picture}`, alt: "" });
    label.append(image);
  }
  label.append(element("span", "", type.replaceAll("_", " ")));
  return label;
}
