// @ts-check
/**
 * Words that servers say and the pages show: names of the shipped robot and of states, and short sentences. The tables translate them; whatever
 * else a server says is shown as it is. Nothing imports this file: the test of the tables reads it.
 */

export const WORDS = [
  // cameras, and what replays call theirs
  "front", "rear", "arm", "gripper", "turret", "mast", "overview", "outside",
  // frames of the tool
  "tool", "base", "world",
  // roles, states and modes of a trial, verdicts, settings
  "operator", "instructor", "watcher", "idle", "ready", "preparing", "waiting", "running", "between", "ended", "practice", "exam", "passed", "failed",
  "standard", "complete", "time", "aborted", "connecting", "gone",
  // what an exercise needs
  "tracks", "flippers", "camera", "lamps",
  // equipment
  "range finder", "laser dots", "proximity", "microphone", "pads",
  // what a button says beside an arrow
  "ahead|arrow", "back|arrow", "up|arrow", "down|arrow", "left|arrow", "right|arrow", "in|arrow", "out|arrow", "close|arrow", "open|arrow",
  // states of a curriculum's module
  "proficient|state", "working|state", "open|state", "locked|state", "spent|state",
  // link, picture, grip
  "good", "fair", "poor", "lost", "slipping", "weak",
  // what fails, and how
  "joint", "belt", "lamp", "key", "battery", "left_belt", "right_belt", "stuck", "limp", "thrown", "bias", "dead", "frozen", "dark", "noisy",
  "dirty", "blurred", "low", "gives only a part of its effort", "is jammed where it is", "gives no effort, and its brake does not hold",
  "its clutch slips", "the belt is off its wheels", "loses force", "its gyroscope drifts about the vertical", "does not burn",
  "goes on sending its last picture", "its pictures are dark", "its pictures are noisy", "its window is dirty", "is out of focus",
  "runs down from this charge", "goes on commanding when it is released",
  "share that is left", "N m that it bears", "share that is lost", "share of the light that is lost", "grey levels of 255", "share of it",
  "share of the picture's width", "share of a full charge",
  // figures of a replay, and its stretches
  "speed", "force", "margin", "picture age", "slow", "stopped", "paused", "flipper", "track",
  // figures of a sheet
  "time of a repetition with its penalties", "penalties", "share of the questions answered rightly", "contacts that are not allowed",
  "largest 20 ms mean of the force", "largest impulse of 0.2 s", "contact beyond the first 0.2 s", "drops", "slip of what is held",
  "dose received", "points of the survey that were missed", "mean difference from the survey's speed",
  "largest error of a map by the odometry, along the survey", "path of the base", "path of the tool", "path of the base to the expert's",
  "path of the tool to the expert's", "reversals of the driving direction", "smoothness of the tool's sub-movements",
  "least tip-over margin", "time with little tip-over margin", "times tipped over", "times stuck", "time without a command",
  "share of short moves with a wait behind them", "changes of the main view", "changes of the arm's mode",
  "motions ended by the dead-man's watchdog", "emergency stops", "refused commands", "median age of the picture",
  "95th percentile of the picture's age", "completed repetitions", "repetitions with a fault", "completed repetitions of all",
  "repetitions per minute", "rate to the expert's", "lower bound of the reliability",
  // reports of progress
  "Progress of {name}", "{count} people, {rest}", "{count} person, {rest}", "{count} trials from {first} to {last}, as of {day}",
  "{count} trial from {first} to {last}, as of {day}", "{count} trials, as of {day}", "Nothing is due: all modules are mastered.",
  "Nothing is due: all modules are mastered, the exam is passed.", "Nothing is due: all modules are mastered; to be shown again by {day}.",
  "Nothing is due: all modules are mastered, the exam is passed; to be shown again by {day}.", "Due",
  "{what}; {count} of {all} repetitions are left", "{what}, then {count} more passed",
  "{what}: {count} more passed in a row, after {before}", "{what}: {count} passed in a row", "{what}: {count} more passed",
  "{what}: talk to the instructor; {count} repetitions are done, and not more count",
  "exam in {what}: {count} repetitions, of them at most {faults} with a fault",
  "{what}: again, a passed repetition; the last one counted for {days} days, which ended {ago} ago", "{count} days", "{count} day",
  "Trials", "module", "exercise", "state", "not passed", "passed: {trial}", "{count} tries, {unsigned} without a valid signature",
  "{count} tries", "{count} try", "after {modules}", "not mastered within {count} repetitions", "mastered with {count} repetitions",
  "mastered with {count} repetition", "begun", "not begun", "{count} of {all} in a row, {more} of {most} more",
  "{count} of {all} in a row", "{count} trials, none of them with a valid repetition",
  "{count} trial, none of them with a valid repetition", "{count} completed, {passed} passed", "reliability", "proficiency",
  "rate of the last repetitions to the expert's", "rate of the last repetitions to the expert's (provisional: a script's)", "best",
  "with penalties", "tenth next", "failures", "workload", "NASA-TLX, unweighted, of 100; median", "weakest metric",
  "weakest metric {count}", "lower bound of the share of completed repetitions, {percent} % sure; last n = {count} with {faults} faults",
  "lower bound of the share of completed repetitions, {percent} % sure; last n = {count} with {faults} fault",
  "from {count} completed repetitions on; there are {number}", "{seconds} s ({least} to {most} s)",
  "repetition {count} by the learning curve; {percent} % band", "not decided yet", "acceptable", "unacceptable",
  "CUSUM: at most {least} % are acceptable, {most} % are not", "beyond its bound {count} of {all}",
  "Times and learning curve with its band, n = {count}", "Times, n = {count}", "CUSUM of failures, n = {count}; down: good",
  "completed repetition", "decisions", "began", "faults", "verdict", "mark", "invalid", "and {count} older ones", "exam {count}",
  "● mastered · ◐ begun, with passed repetitions · ○ open · - after others · ! too many repetitions",
  "Times of completed repetitions, n = {count}; bars: medians", "Reliability: lower bound, {percent} % sure, of the last repetitions.",
  "Reliability: lower bound, {percent} % sure, of the last repetitions. Proficiency: to a script's rate, provisional.",
  // sentences
  "help was given", "no answer within {seconds} s", "the video server says {status}",
];
