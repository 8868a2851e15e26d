// @ts-check
/**
 * Gets, decodes and draws the pictures of all cameras on a thread of its own: whatever they cost, the page's thread is
 * free for keys and commands.
 *
 * From the page: `{start: {url, config}}` once; `{view: number, canvas, maxWidth}` for each view, once; `{show: camera[]}`, the camera of
 * each view, the large one first. To the page: `{cameras}` whenever there are others, `{views}` every REPORT_PERIOD; times as
 * Date.now() counts, since the two threads' performance.now() do not start at the same time.
 */

import { VideoSource } from "./video_source.js";
import { VideoView } from "./video.js";

const REPORT_PERIOD = 200; // ms

/**
 * Time (ms) that a small picture waits for the next large one. All are composited at once then, which is the dearest part where
 * there is no GPU.
 */
const PATIENCE = 60;

/** @type {VideoView[]} */
const views = [];
/** Draw what was waiting. @type {(() => void)[]} */
const waiting = [];
/** @type {ReturnType<typeof setTimeout> | null} */
let timer = null;
/** @type {VideoSource | null} */
let source = null;

function drawAll() {
  if (timer !== null) clearTimeout(timer);
  timer = null;
  for (const draw of waiting.splice(0)) draw();
}

/**
 * @param {string} camera
 * @param {Uint8Array} bytes
 * @param {number | null} captured
 */
async function show(camera, bytes, captured) {
  const view = views.find((each) => each.camera === camera);
  const draw = await view?.decode(camera, bytes, captured);
  if (draw === undefined || draw === null) return;
  await new Promise((resolve) => {
    waiting.push(() => resolve(draw()));
    if (view === views[0] || !views[0].live) drawAll();
    else timer ??= setTimeout(drawAll, PATIENCE);
  });
}

self.onmessage = ({ data }) => {
  if (data.start !== undefined) {
    source = new VideoSource(data.start.url, data.start.config, {
      cameras: (cameras) => self.postMessage({ cameras }),
      picture: show,
      complain: (camera, why) => {
        for (const view of views) if (camera === null || view.camera === camera) view.trouble = why;
      },
    });
    source.start();
  } else if (data.canvas !== undefined) {
    views[data.view] = new VideoView(data.canvas, data.maxWidth);
  } else if (data.show !== undefined) {
    data.show.forEach((/** @type {string} */ camera, /** @type {number} */ index) => views[index]?.show(camera));
    source?.show(data.show);
  }
};

setInterval(() => self.postMessage({ views: views.map((view) => view.report()) }), REPORT_PERIOD);
