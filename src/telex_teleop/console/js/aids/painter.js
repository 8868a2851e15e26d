// @ts-check
/** Paints figures over a view, so that they can be seen before anything bright or dark. */

/** @typedef {import("./figures.js").Figure} Figure */
/** @typedef {import("./band.js").Ribbon} Ribbon */
/** @typedef {import("./band.js").Plates} Plates */

const DARK = "rgb(0 0 0 / 80%)", PLATE = "rgb(14 18 22 / 86%)", LIGHT = "#ffffff", FRAME = "#ffd35c";
const FONT = '600 13px system-ui, "DejaVu Sans", sans-serif';
const PAD = 5, LINE = 20, APART = 4; // px, of a plate
const GRID = 64, EDGE = 6; // px: steps in which a canvas grows, and what is drawn beside a figure's own points
const WIDEST_LETTER = 13; // px, of FONT

/** A canvas that lies over a view. */
export class Painter {
  /**
   * @param {HTMLElement} view  Gets the canvas.
   * @param {() => void} resized
   */
  constructor(view, resized) {
    this.view = view;
    this._canvas = document.createElement("canvas");
    this._canvas.className = "aids";
    this._canvas.hidden = true;
    this._canvas.setAttribute("aria-hidden", "true");
    // Below what stands over the picture.
    view.insertBefore(this._canvas, view.querySelector(".over"));
    this._last = "[]";
    /** Of the view inside its frame (CSS px); nobody has to lay out the page for it. */
    this.size = { width: view.clientWidth, height: view.clientHeight };
    new ResizeObserver(([{ contentRect: { width, height } }]) => {
      this.size = { width: Math.round(width), height: Math.round(height) };
      resized();
    }).observe(view);
  }

  /**
   * Show these figures, unless they are shown already.
   * @param {(Figure | Ribbon | Plates)[]} figures
   * @param {import("./sight.js").Box} [box]  Of the picture, beside which nothing is drawn.
   */
  paint(figures, box) {
    const { width, height } = this.size;
    const wanted = JSON.stringify(figures.length === 0 ? [] : [width, height, box, window.devicePixelRatio, figures]);
    if (wanted === this._last) return;
    this._last = wanted;
    this._canvas.hidden = figures.length === 0;
    if (figures.length === 0) return;
    const ratio = window.devicePixelRatio || 1;
    const used = boundsOf(figures, width, height);
    this._cover(used);
    const [columns, rows] = [Math.round(used.width * ratio), Math.round(used.height * ratio)];
    if (this._canvas.width !== columns || this._canvas.height !== rows) Object.assign(this._canvas, { width: columns, height: rows });
    const context = /** @type {CanvasRenderingContext2D} */ (this._canvas.getContext("2d"));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, used.width, used.height);
    context.translate(-used.left, -used.top);
    context.lineCap = context.lineJoin = "round";
    context.save();
    if (box !== undefined) {
      context.beginPath();
      context.rect(box.left, box.top, box.width, box.height);
      context.clip();
    }
    for (const figure of figures) draw(context, figure);
    context.restore();
  }

  /** Lie over this part of the view alone. @param {import("./sight.js").Box} part */
  _cover(part) {
    const { style } = this._canvas;
    for (const side of /** @type {("left" | "top" | "width" | "height")[]} */ (["left", "top", "width", "height"])) {
      const length = `${part[side]}px`;
      if (style[side] !== length) style[side] = length;
    }
  }
}

/**
 * The part of a view that figures are painted in, in steps: all of it is composited with every picture below it.
 * @param {(Figure | Ribbon | Plates)[]} figures
 * @param {number} width  Of the view (CSS px).
 * @param {number} height
 * @returns {import("./sight.js").Box}
 */
export function boundsOf(figures, width, height) {
  const corners = figures.flatMap(cornersOf);
  const xs = corners.map(([x]) => x), ys = corners.map(([, y]) => y);
  const down = (/** @type {number[]} */ values) => Math.max(0, GRID * Math.floor((Math.min(...values) - EDGE) / GRID));
  const up = (/** @type {number[]} */ values, /** @type {number} */ most) => Math.min(most, GRID * Math.ceil((Math.max(...values) + EDGE) / GRID));
  const left = Math.min(down(xs), width - 1), top = Math.min(down(ys), height - 1);
  return { left, top, width: Math.max(1, up(xs, width) - left), height: Math.max(1, up(ys, height) - top) };
}

/** Between which a figure is, but for its edge. @param {Figure | Ribbon | Plates} figure @returns {[number, number][]} */
function cornersOf(figure) {
  if (figure.kind === "lines") return figure.lines.flat();
  if (figure.kind === "sign") return [-figure.size, figure.size].map((size) => [figure.at[0] + size, figure.at[1] + size]);
  if (figure.kind === "label") {
    const [x, y] = figure.at, length = WIDEST_LETTER * figure.words.length;
    return [[x, y - LINE / 2], [figure.align === "left" ? x + length : x - length, y + LINE / 2]];
  }
  const { left, top } = figure;
  if (figure.kind === "ribbon") return [[left, top], [left + figure.width, top + figure.height]];
  // At worst every plate has a row of its own.
  return [[left, top], [figure.right, Math.min(figure.bottom, top + figure.plates.length * (LINE + APART))]];
}

/** @param {CanvasRenderingContext2D} context @param {Figure | Ribbon | Plates} figure */
function draw(context, figure) {
  if (figure.kind === "lines") drawLines(context, figure);
  else if (figure.kind === "sign") drawSign(context, figure);
  else if (figure.kind === "label") drawLabel(context, figure);
  else if (figure.kind === "ribbon") drawRibbon(context, figure);
  else drawPlates(context, figure);
}

/** @param {CanvasRenderingContext2D} context @param {import("./figures.js").Lines} figure */
function drawLines(context, { lines, colour, width, dash = [] }) {
  context.beginPath();
  for (const line of lines) line.forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.setLineDash(dash);
  for (const [style, wide] of /** @type {[string, number][]} */ ([[DARK, width + 3], [colour, width]])) {
    context.strokeStyle = style;
    context.lineWidth = wide;
    context.stroke();
  }
  context.setLineDash([]);
}

/** @param {CanvasRenderingContext2D} context @param {import("./figures.js").Sign} figure */
function drawSign(context, { shape, at: [x, y], colour, size }) {
  context.beginPath();
  if (shape === "rhomb") polygon(context, [[x, y - size], [x + size, y], [x, y + size], [x - size, y]]);
  else if (shape === "triangle") polygon(context, [[x, y - size], [x + size, y + size], [x - size, y + size]]);
  else context.arc(x, y, size, 0, 2 * Math.PI);
  context.strokeStyle = DARK;
  context.lineWidth = shape === "ring" ? 5 : 3;
  context.stroke();
  if (shape === "ring") {
    context.strokeStyle = colour;
    context.lineWidth = 2;
    context.stroke();
  } else {
    context.fillStyle = colour;
    context.fill();
  }
}

/** @param {CanvasRenderingContext2D} context @param {[number, number][]} corners */
function polygon(context, corners) {
  corners.forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.closePath();
}

/** @param {CanvasRenderingContext2D} context @param {import("./figures.js").Label} figure */
function drawLabel(context, { at: [x, y], words, align }) {
  context.font = FONT;
  context.textBaseline = "middle";
  context.textAlign = align;
  context.strokeStyle = DARK;
  context.lineWidth = 5;
  context.strokeText(words, x, y);
  context.fillStyle = LIGHT;
  context.fillText(words, x, y);
}

/** @param {CanvasRenderingContext2D} context @param {Plates} figure */
function drawPlates(context, { left, right, top, bottom, plates }) {
  context.font = FONT;
  context.textBaseline = "middle";
  context.textAlign = "left";
  let [x, y] = [left, top];
  for (const { words, isAid } of plates) {
    const said = isAid ? `◇ ${words}` : words;
    const width = context.measureText(said).width + 2 * PAD;
    if (x > left && x + width > right) [x, y] = [left, y + LINE + APART];
    if (y + LINE > bottom) return;
    context.fillStyle = PLATE;
    context.fillRect(x, y, width, LINE);
    if (isAid) {
      context.strokeStyle = FRAME;
      context.lineWidth = 1.5;
      context.setLineDash([4, 3]);
      context.strokeRect(x + 1, y + 1, width - 2, LINE - 2);
      context.setLineDash([]);
    }
    context.fillStyle = LIGHT;
    context.fillText(said, x + PAD, y + LINE / 2 + 1);
    x += width + APART;
  }
}

/** @param {CanvasRenderingContext2D} context @param {Ribbon} ribbon */
function drawRibbon(context, { left, top, width, height, ticks, nose }) {
  context.save();
  context.translate(left, top);
  context.fillStyle = PLATE;
  context.fillRect(0, 0, width, height);
  context.beginPath();
  context.rect(0, 0, width, height);
  context.clip();
  context.strokeStyle = context.fillStyle = LIGHT;
  context.font = FONT;
  context.textAlign = "center";
  context.textBaseline = "alphabetic";
  context.lineWidth = 1;
  context.beginPath();
  for (const { x, words } of ticks) {
    context.moveTo(x + 0.5, height);
    context.lineTo(x + 0.5, height - (words === "" ? 5 : 9));
    context.fillText(words, x, height - 13);
  }
  context.stroke();
  // The middle, where the camera looks; and the robot's nose.
  context.strokeStyle = FRAME;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(width / 2, height);
  context.lineTo(width / 2, height - 12);
  context.stroke();
  if (nose !== null) {
    context.fillStyle = FRAME;
    context.beginPath();
    polygon(context, [[nose, height - 12], [nose + 6, height], [nose - 6, height]]);
    context.fill();
  }
  context.restore();
}
