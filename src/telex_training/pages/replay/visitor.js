// @ts-check
/** Who looks at a page: what its own address says of it goes along with every request. It stands here, for both mounts show this folder. */

const SAID = ["token", "role", "name"];

/**
 * Query of a request.
 * @param {Record<string, string | number>} [more]
 */
export function whoLooks(more = {}) {
  const given = new URLSearchParams(location.search);
  const query = new URLSearchParams();
  for (const key of SAID) if (given.has(key)) query.set(key, given.get(key) ?? "");
  for (const [key, value] of Object.entries(more)) query.set(key, String(value));
  return query;
}
