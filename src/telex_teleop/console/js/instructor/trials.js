// @ts-check
/** Shows on the instructor's page how far an exercise is. */

/** @typedef {import("../training/client.js").State} State */
/** @typedef {{show(state: State): void}} Panel */

/**
 * A further robot is told of a team's exercises alone. An exam's list, bookmarks and the scene concern whichever exercise goes on:
 * the first robot is told of all.
 * @param {import("../training/client.js").TrainingClient} training
 * @param {import("../config.js").Config} config
 * @param {object} panels
 * @param {Panel} panels.strip
 * @param {Panel} panels.exercises
 * @param {Panel} panels.malfunctions
 * @param {import("./exam_list.js").ExamList} panels.examList
 * @param {Panel} panels.bookmarks
 * @param {Panel} panels.arranging
 */
export function showTrials(training, config, { strip, exercises, malfunctions, examList, bookmarks, arranging }) {
  const showOfRobot = (/** @type {State} */ state) => {
    strip.show(state);
    exercises.show(state);
    malfunctions.show(state);
  };
  const showOfAny = (/** @type {State} */ state) => {
    examList.hear(state);
    bookmarks.show(state);
    arranging.show(state);
  };
  const first = config.simulator ?? config.namespace;
  if (first !== config.namespace) {
    training.subscribe(showOfRobot);
    training.subscribe(showOfAny, `${first}/training/state`);
    return;
  }
  training.subscribe((state) => {
    showOfRobot(state);
    showOfAny(state);
  });
}
