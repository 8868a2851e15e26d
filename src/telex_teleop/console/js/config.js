// @ts-check
/** Configuration of the pages from the video server, and the bridge's address. */

import { term } from "./language/term.js";

const RETRY_AFTER = 1000; // ms
const ANSWER_WITHIN = 10_000; // ms: what a network that was gone took is sent again by TCP after up to a minute

/** @typedef {{name: string, rosbridge: string | null}} Robot */
/**
 * What the video server tells: also of all robots, and of the simulator's namespace, where there are several.
 * @typedef {import("./video_source.js").VideoConfig & {rosbridge: string | null, robots?: Robot[], simulator?: string}} Config
 */

/** What this page's address says of who looks at it; meant for the bridge and the video server. */
const GIVEN = ["token", "role", "name"];

/**
 * @param {URLSearchParams} asked
 * @returns {Promise<Config>}
 */
async function fetchConfig(asked) {
  const query = new URLSearchParams([...asked].filter(([name]) => name === "role" || name === "robot"));
  const reply = await fetch(`/config.json?${query}`, { cache: "no-store", signal: AbortSignal.timeout(ANSWER_WITHIN) });
  if (!reply.ok) throw new Error(`the video server says ${reply.status}`);
  return reply.json();
}

/**
 * Ask until there is an answer.
 * @param {URLSearchParams} asked  Of this page: `role` and `robot` count.
 * @returns {Promise<Config>}
 */
export async function waitForConfig(asked) {
  for (;;) {
    try {
      return await fetchConfig(asked);
    } catch {
      await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER));
    }
  }
}

/**
 * Ask for the bridge's address, which may have changed.
 * @param {URLSearchParams} asked  Token, role and name to connect with, and which robot.
 * @returns {Promise<string>}
 */
export async function locateBridge(asked) {
  const { rosbridge } = await fetchConfig(asked);
  if (rosbridge === null) throw new Error(term("the bridge is not running"));
  const url = new URL(rosbridge);
  for (const name of GIVEN) if (asked.has(name)) url.searchParams.set(name, asked.get(name) ?? "");
  // The bridge is to say which commands it does not obey, and why.
  url.searchParams.set("status", "1");
  return url.href;
}
