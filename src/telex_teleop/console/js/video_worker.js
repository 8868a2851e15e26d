// @ts-check
/**
 * Gets, decodes and draws the pictures of all cameras on a thread of its own: whatever they cost, the page's thread is
 * free for keys and commands.
 *
 * From the page: `{start: {url, access, config}}` once; `{view: number, canvas, maxWidth}` for each view, once; `{show: camera[], shown: camera[]}`, the camera of
 * each view, the large one first, and those that somebody can see; `{left}`, whether the page was left. To the page: `{cameras}` whenever there are others, `{views}` every REPORT_PERIOD; times as
 * Date.now() counts, since the two threads' performance.now() do not start at the same time.
 */

import { term } from "./language/term.js";
import { Tally } from "./tally.js";
import { VideoSource } from "./video_source.js";
import { VideoView, decode } from "./video.js";

const REPORT_PERIOD = 200; // ms

/**
 * Time (ms) that a small picture waits for the next large one, or for other small ones. All are composited at once then, which
 * is the dearest part where there is no GPU. Longer than the time between two large ones at their full rate, shorter than that between two
 * small ones of a camera.
 */
const PATIENCE = 45;

/** @type {VideoView[]} */
const views = [];
/** Draw what was waiting. @type {(() => void)[]} */
const waiting = [];
/** @type {ReturnType<typeof setTimeout> | null} */
let timer = null;
/** @type {VideoSource | null} */
let source = null;
const tally = new Tally();
// Asked for in the worker itself: no page needs it.
Object.assign(self, { takeTally: () => ({ ...tally.take(), served: source?.served ?? {} }) });

function drawAll() {
  if (timer !== null) clearTimeout(timer);
  timer = null;
  for (const draw of waiting.splice(0)) draw();
}

/** @param {string} camera */
const viewOf = (camera) => views.find((each) => each.camera === camera);

/**
 * @param {string} camera
 * @param {Uint8Array} bytes
 * @param {number | null} captured
 */
async function showPicture(camera, bytes, captured) {
  const received = performance.now();
  if (viewOf(camera) === undefined) return;
  /** @type {ImageBitmap | VideoFrame} */
  let picture;
  try {
    picture = await decode(bytes);
  } catch {
    const view = viewOf(camera);
    if (view !== undefined) view.trouble = term("the camera's picture cannot be decoded");
    return;
  }
  const decoded = performance.now();
  await new Promise((resolve) => {
    waiting.push(() => {
      const view = viewOf(camera);
      if (view !== undefined) {
        view.draw(picture, captured);
        tally.add(camera, { captured, received, decoded, painted: performance.now() });
      }
      picture.close();
      resolve(null);
    });
    if (viewOf(camera) === views[0] || !views[0].live) drawAll();
    else timer ??= setTimeout(drawAll, PATIENCE);
  });
}

/** @param {string[]} cameras  Of all views, the large one first. */
function turn(cameras) {
  const changed = cameras.map((_, index) => index).filter((index) => views[index] && views[index].camera !== cameras[index]);
  /** @type {Map<string | null, import("./video.js").Shown>} */
  const before = new Map(changed.map((index) => [views[index].camera, views[index].leave()]));
  for (const index of changed) views[index].show(cameras[index], before.get(cameras[index]));
}

self.onmessage = ({ data }) => {
  if (data.start !== undefined) {
    source = new VideoSource(data.start.url, data.start.access, data.start.config, {
      cameras: (cameras) => self.postMessage({ cameras }),
      picture: showPicture,
      complain: (camera, why) => {
        for (const view of views) if (camera === null || view.camera === camera) view.trouble = why;
      },
    });
    source.start();
  } else if (data.canvas !== undefined) {
    views[data.view] = new VideoView(data.canvas, data.maxWidth);
  } else if (data.left !== undefined) {
    if (data.left) source?.stop();
    else source?.start();
  } else if (data.show !== undefined) {
    turn(data.show);
    source?.show(data.shown);
  }
};

setInterval(() => self.postMessage({ views: views.map((view) => view.report()) }), REPORT_PERIOD);
