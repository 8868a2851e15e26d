// @ts-check
/** Marks words for the tables of other languages. Workers have it without the tables, and speak English to their page. */

/**
 * Mark English words that are translated where they are shown: those of a constant, or of a worker.
 * @param {string} english
 */
export const term = (english) => english;
