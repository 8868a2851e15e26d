"""One trial, from the opening of its exercise to its sheet, without services and pages.

Everything that may take a while (loading the scene, putting the apparatus back, closing the
recording) happens in a thread of its own; every other method returns at once.
"""

from __future__ import annotations

import contextlib
import itertools
import secrets
import threading
import time
from datetime import datetime
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import rospy
from telex_msgs.msg import SimStatus

from ..exercises.exercise_file import ExerciseFile
from ..exercises.model import EXAM, PRACTICE, Exercise, Failure
from ..exercises.readings import draw
from ..judging.entries import INPUTS, ODOMETRY, Entry
from ..judging.judge import Judge
from ..judging.trial_record import ENDED, PREPARING, READY, RUNNING, WAITING, JudgeEvent
from ..recording.inbox import Inbox
from ..recording.signature import sealing
from ..recording.station_keys import StationKeyError, station_key
from ..recording.trial_file import (
    SHEET,
    SUFFIX,
    Trial,
    attachments,
    safe_name,
    serialised_input,
    sheet_attachment,
)
from ..recording.writer import Attachment, RecordingError, RecordingWriter, Seal, check_room
from .apparatus import Apparatus, ApparatusError
from .channels import Channels
from .configuration import ConfigurationWatch
from .trial.bookmarks import TrialBookmarks, Wanted

_MOST_SEED = 2**31
_SETTLING = 0.3
"""Sim time for which the robot settles on its tracks before a repetition can begin (s)."""
_CLOSING = 30.0
_MOST_REASON = 200


class SessionError(RuntimeError):
    """Something cannot be done now; the message says why and what would be right."""


class Session:
    """A trial of one operator.

    Parameters
    ----------
    exercise : Exercise
        In its setting.
    folder : Path
        For the recording.
    about : mapping
        ``urdf``, ``cameras`` and ``meshes`` of the robot, ``urdfs`` of further ones, see
        `attachments`.
    recorded : sequence of str
        Further topics that are recorded.
    changed : callable
        Told whenever the state may have changed; from any thread.
    happened : callable
        Told the trial and each event of the judge, in the inbox's thread.
    ended : callable
        Told the trial and the text of its sheet, once the recording is closed.
    others : mapping of str to str, optional
        Namespaces of the exercise's further robots, by its names.
    station : sequence of str
        Namespaces of all further robots.

    Raises
    ------
    ExerciseError
    """

    def __init__(
        self,
        file: ExerciseFile,
        exercise: Exercise,
        mode: str,
        operator: str,
        software: str,
        folder: Path,
        about: Mapping[str, Any],
        apparatus: Apparatus,
        recorded: List[str],
        changed: Callable[[], None],
        happened: Callable[[str, JudgeEvent], None],
        ended: Callable[[str, str], None],
        others: Optional[Mapping[str, str]] = None,
        station: Sequence[str] = (),
    ) -> None:
        self.exercise = exercise
        self.others = others or {}
        self._station = station
        self.mode = mode
        self.operator = operator
        self.path: Optional[Path] = None
        self.message = ""
        self._file = file
        self._software = software
        self._folder = folder
        self._about = about
        self._apparatus = apparatus
        self._recorded = recorded
        self._changed, self._happened, self._ended = changed, happened, ended
        self._draw()
        self._judging = threading.Lock()
        self._writer: Optional[RecordingWriter] = None
        self._seal: Optional[Seal] = None
        self._inbox: Optional[Inbox] = None
        self._channels: Optional[Channels] = None
        self._watches: List[ConfigurationWatch] = []
        self._bookmarks = TrialBookmarks()
        # The simulator's number of resets when this session has last put all to a start.
        self._resets: Optional[int] = None
        self._has_line = False
        self._closing = self._restoring = False
        self._done = threading.Event()
        self._ending: Dict[str, Attachment] = {}
        self._sheet = ""
        self._left = False
        self._failures: List[Failure] = []
        stamp = datetime.now().strftime("%Y-%m-%d_%H%M%S")
        self.trial = free_name(folder, f"{stamp}_{safe_name(operator)}_{safe_name(exercise.name)}")

    def _draw(self) -> None:
        """Make the scene, of a seed that is drawn where the exercise gives none."""
        seed = self.exercise.seeds.of(self.mode)
        self._seed = secrets.randbelow(_MOST_SEED) if seed is None else seed
        self._drawn = draw(self.exercise, self._seed)
        about = self._about
        urdf, urdfs = str(about["urdf"]), about.get("urdfs", {})
        self._judge = Judge(self.exercise, self._drawn.scene, urdf, urdfs)

    # --- what is asked for -----------------------------------------------------------------------

    @property
    def phase(self) -> str:
        """As in telex_msgs/TrainingState."""
        return READY if self._inbox is None and self._judge.phase != ENDED else self._judge.phase

    def state(self) -> Dict[str, Any]:
        """Return the fields of telex_msgs/TrainingState, but its header."""
        with self._judging:
            made = self._judge.state()
        if self._inbox is None and made["phase"] != ENDED:
            made.update(phase=READY, trial=self.trial, mode=self.mode, operator=self.operator)
        made["message"] = self.message or made["message"]
        made["bookmarks"] = self._bookmarks.names() if self.begun else []
        return made

    def load(self) -> None:
        """Load the scene already, in practice: the robot stands at the start while one reads."""
        threading.Thread(target=self._load_quietly, name="apparatus", daemon=True).start()

    def _load_quietly(self) -> None:
        with self._apparatus.busy:
            if self._resets is not None or self._left:
                return
            try:
                self._resets = self._apparatus.load(self._drawn.scene)
            except ApparatusError as error:
                self.message = f"the scene cannot be loaded: {error}"
            self._changed()

    def start(self) -> None:
        """Begin the trial: from now on everything is recorded.

        Raises
        ------
        SessionError
            It has begun already, or the recording cannot be made.
        """
        if self.phase != READY:
            raise SessionError(f"the trial is {self.phase}; it can be started once")
        try:
            if self.exercise.seeds.of(self.mode) is None:
                # Anew, so that nothing that anybody has learnt of the trial so far is of its seed.
                with self._judging:
                    self._draw()
            if self.mode == EXAM:
                self._seal = sealing(station_key())
            check_room(self._folder)
            self._open_recording()
        except (RecordingError, StationKeyError) as error:
            raise SessionError(f"the trial cannot be recorded: {error}") from error
        except ValueError as error:  # of the exercise, the scene or the URDF
            raise SessionError(f"the scene cannot be made: {error}") from error
        self.message = ""
        self._put(
            {
                "input": "open",
                "trial": self.trial,
                "operator": self.operator,
                "mode": self.mode,
                "setting": self.exercise.setting,
                "seed": self._seed,
                "software": self._software,
            }
        )
        self._put({"input": "start"})
        odometry = [ODOMETRY] if self.exercise.survey is not None else []
        more = [*self._recorded, *odometry]
        self._channels = Channels(self._hear, more, self.others, self._station)
        self._watches = [
            ConfigurationWatch(self._reconfigured, namespace=namespace)
            for namespace in ("", *(f"{each}/" for each in self.others.values()))
        ]
        self._prepare()

    def _open_recording(self) -> None:
        path = self._folder / f"{self.trial}{SUFFIX}"
        trial = Trial(
            self.trial,
            str(self._file.path),
            self.exercise.setting,
            self.mode,
            self.operator,
            self._software,
            self._seed,
        )
        about = self._about
        self._writer = RecordingWriter(
            path,
            attachments(
                trial,
                self._file.text,
                self._drawn.scene,
                about["urdf"],
                about["cameras"],
                about["meshes"],
                about.get("urdfs", {}),
            ),
        )
        self.path = path
        self._inbox = Inbox(self._judge_entry, self._writer)

    def again(self) -> None:
        """Begin the next repetition: robot and apparatus are put back.

        Raises
        ------
        SessionError
        """
        if self.phase in (READY, ENDED):
            raise SessionError(f"the trial is {self.phase}; there is no repetition to begin")
        if self.phase == PREPARING or self._restoring:
            return
        self._put({"input": "again"})
        self._prepare()

    def bookmark(self, name: str = "") -> str:
        """Set a bookmark of the repetition that waits or runs, in practice.

        Parameters
        ----------
        name : str
            Empty: a number, and the repetition.

        Returns
        -------
        str
            Its name.

        Raises
        ------
        SessionError
        """
        self._require_practice()
        try:
            wanted = self._bookmarks.of_operator(name, self._judge.repetition)
        except ValueError as error:
            raise SessionError(str(error)) from error
        self._set(wanted)
        return wanted.name

    def _set(self, wanted: Wanted) -> None:
        # Not while all is put back: it would be a bookmark of something else.
        with self._apparatus.busy:
            if self._restoring or self.phase not in (WAITING, RUNNING):
                raise SessionError(
                    f"the trial is {self.phase}; bookmarks are set while a repetition waits or runs"
                )
            # The judge's notes are of a moment before the bookmark: what happens in between it sees
            # again.
            self._put({"input": "bookmark", "name": wanted.name})
            try:
                there = self._apparatus.bookmark(wanted.name, wanted.replaces)
            except ApparatusError as error:
                raise SessionError(f"no bookmark is set: {error}") from error
        self._bookmarks.add(wanted, there)
        self._changed()

    def back(self, name: str = "") -> str:
        """Go on from a bookmark, in practice: the repetition ends, and the next counts for nothing.

        Parameters
        ----------
        name : str
            Empty: the newest.

        Returns
        -------
        str
            Its name.

        Raises
        ------
        SessionError
        """
        self._require_practice()
        if self.phase in (READY, ENDED):
            raise SessionError(f"the trial is {self.phase}; there is nothing to go back in")
        if self.phase == PREPARING or self._restoring:
            raise SessionError("robot and apparatus are being put back; again in a moment")
        try:
            found = self._bookmarks.newest(name)
        except ValueError as error:
            raise SessionError(str(error)) from error
        self._put({"input": "back", "bookmark": found})
        self._prepare(found)
        return found

    def _require_practice(self) -> None:
        if self.mode != PRACTICE:
            raise SessionError(f"mode is {self.mode}; bookmarks are for practice, an exam has none")

    def answer(self, question: str, answer: str) -> None:
        """Answer a question.

        Raises
        ------
        SessionError
            There is no such question, or it is not asked now.
        """
        known = {each.name: each for each in self.exercise.questions}
        if question not in known:
            names = ", ".join(known) or "none"
            raise SessionError(f"question is '{question}'; there are: {names}")
        choices = known[question].choices
        if choices and answer not in choices:
            raise SessionError(f"answer is '{answer}'; there are: {', '.join(choices)}")
        if self.phase != RUNNING:
            raise SessionError(f"the trial is {self.phase}; questions are answered while it runs")
        self._put({"input": "answer", "question": question, "answer": answer})

    def abort(self, reason: str, by: str = "", given_up: bool = False) -> None:
        """End the trial.

        Parameters
        ----------
        given_up : bool
            Whether it is its operator who leaves it: a repetition that runs then counts as such.

        Raises
        ------
        SessionError
            It has ended.
        """
        if self.phase == ENDED:
            raise SessionError("the trial has ended already")
        if self._inbox is None:
            raise SessionError("the trial has not begun; there is nothing to abort")
        left = {"given_up": True} if given_up else {}
        self._put({"input": "abort", "reason": reason, "by": by, **left})

    def note(self, content: Mapping[str, Any]) -> None:
        """Put an instructor's note, an input of the judge, where it belongs in time."""
        self._put(content)

    def leave(self) -> None:
        """Touch the apparatus no more: another session begins."""
        self._left = True

    def wait_closed(self) -> bool:
        """Wait until its recording is complete, if one was begun; returns whether it is."""
        return self._inbox is None or self._done.wait(_CLOSING)

    def hear_status(self, status: SimStatus) -> None:
        """Hear the simulator's status; in a thread of ROS."""
        writer = self._writer
        if writer is not None and writer.problem and not self.message:
            self.message = f"the recording is broken off: {writer.problem}"
            self.outside(self.message)
            self._changed()

    def outside(self, what: str) -> None:
        """Note that somebody has interfered, which makes the trial invalid."""
        self._put({"input": "outside", "what": what})

    def _reconfigured(self, what: str) -> None:
        self.outside(f"other {what}")

    @property
    def closed(self) -> bool:
        """Whether its recording is complete."""
        return self._done.is_set()

    @property
    def begun(self) -> bool:
        """Whether its recording has begun and it has not ended."""
        return self._inbox is not None and self.phase != ENDED

    # --- threads ---------------------------------------------------------------------------------

    def _prepare(self, bookmark: str = "") -> None:
        self._restoring = True
        threading.Thread(
            target=self._put_back, args=(bookmark,), name="apparatus", daemon=True
        ).start()

    def _put_back(self, bookmark: str) -> None:
        """Put all to the start, or as it was at a bookmark; then say that a repetition may begin.

        Where the bookmark has ended meanwhile, all is put to the start.
        """
        with self._apparatus.busy:
            if self._left or self.phase == ENDED:
                return
            try:
                found, missed = self._go_back(bookmark) if bookmark else (None, "")
                resets = self._begin_anew() if found is None else found
            except Exception as error:  # whatever it is, the trial must not wait for ever
                self.message = f"the apparatus cannot be put back: {error}"
                rospy.logerr("training: %s", self.message)
                with contextlib.suppress(SessionError):
                    self.abort(self.message[:_MOST_REASON], "training")
                return
            self._resets = resets
            if found is None:
                self._put({"input": "drawn", "answers": self._drawn.answers})
            self._put(
                {
                    "input": "ready",
                    "resets": resets,
                    **({} if found is None else {"bookmark": bookmark}),
                    **({"missed": missed} if missed else {}),
                }
            )
            self._restoring = False
            self._changed()

    def _go_back(self, bookmark: str) -> Tuple[Optional[int], str]:
        """Go back to a bookmark; returns the number of resets, or why there is none."""
        try:
            return self._apparatus.back(bookmark), ""
        except ApparatusError as error:
            rospy.logwarn("training/back: %s", error)
            return None, f"{error}; all is put to the start"[:_MOST_REASON]

    def _begin_anew(self) -> int:
        """Put robot and apparatus to the start; returns the simulator's number of resets."""
        resets = self._restore()
        self._set_line()
        if self._bookmarks.names():
            # Objects that were drawn anew have ended them.
            self._bookmarks.keep(self._apparatus.bookmarks())
        self._settle()
        self._require_upright()
        return resets

    def _restore(self) -> int:
        if self._resets is None:
            return self._apparatus.load(self._drawn.scene)
        self._failures.clear()
        if self._drawn.entries:
            # What was read before must not be right again.
            self._drawn = draw(self.exercise, self._seed)
        if not self._has_scene():
            return self._apparatus.load(self._drawn.scene)
        return self._apparatus.reset(self._drawn.entries)

    def _has_scene(self) -> bool:
        """Whether the exercise's scene is there still, as far as can be told."""
        status = self._apparatus.status
        if status is not None and status.resets == self._resets:
            return True
        # Others have reset it, or loaded another one, or the simulator has begun anew. Bookmarks
        # end with their scene, not with a reset.
        kept = self._bookmarks.names()
        return bool(kept) and not set(kept).isdisjoint(self._apparatus.bookmarks())

    def _set_line(self) -> None:
        """Set the line that the exercise asks for, once: what an instructor changes later stays."""
        if self.exercise.link is not None and not self._has_line:
            self._apparatus.set_line(self.exercise.link, self.others.values())
            self._has_line = True

    def _require_upright(self) -> None:
        """Refuse to begin where the robot has tipped over as it was put down."""
        status = self._apparatus.status
        if status is not None and status.tipped_over:
            raise ApparatusError("the robot lies on its side at its start; the scene is wrong")

    def _settle(self) -> None:
        until = rospy.get_time() + _SETTLING
        wall = time.monotonic() + 10.0 * _SETTLING
        while rospy.get_time() < until and time.monotonic() < wall and not rospy.is_shutdown():
            time.sleep(0.02)

    def _hear(self, channel: str, kind: str, data: bytes) -> None:
        inbox = self._inbox
        if inbox is not None:
            inbox.put(channel, kind, data, rospy.get_rostime().to_nsec())

    def _put(self, content: Mapping[str, Any]) -> None:
        self._hear(INPUTS, "std_msgs/String", serialised_input(content))

    def _judge_entry(self, entry: Entry) -> None:
        """Feed the judge; in the inbox's thread."""
        before = self._judge.phase
        with self._judging:
            events = [each for each in self._judge.feed(entry) if not each.secret]
            due, resets = self._judge.take_due(), self._judge.resets
        for failure in due:
            threading.Thread(target=self._fail, args=(failure, resets), daemon=True).start()
        try:
            for event in events:
                self._happened(self.trial, event)
        except Exception as error:  # telling must not end the judging
            rospy.logerr("training/events: %s", error)
        phase = self._judge.phase
        if phase != before or events:
            self._changed()
        steps = [event.name for event in events if event.event == "step"]
        if steps and phase == RUNNING and self.mode == PRACTICE:
            wanted = self._bookmarks.of_step(steps[-1], self._judge.repetition)
            threading.Thread(
                target=self._set_quietly, args=(wanted,), name="bookmark", daemon=True
            ).start()
        if phase == ENDED and not self._closing:
            self._closing = True
            threading.Thread(target=self._close, name="sheet").start()

    def _fail(self, failure: Failure, resets: int) -> None:
        """Let something of the robot fail, until the next repetition or the trial's end.

        Parameters
        ----------
        failure : Failure
        resets : int
            The simulator's number of resets when the repetition began whose failure it is.
        """
        with self._apparatus.busy:
            if self._resets != resets:
                return  # that repetition is over
            self._failures.append(failure)
            try:
                self._apparatus.fail(failure, robot=self.others.get(failure.robot, ""))
            except ApparatusError as error:
                rospy.logerr("training: %s %s does not fail: %s", failure.what, failure.kind, error)
                self._put({"input": "outside", "what": "a malfunction that could not be made"})

    def _mend(self) -> None:
        """Let work again what the exercise has let fail and no reset has mended."""
        with self._apparatus.busy:
            self._resets = None
            while self._failures:
                # Most have ended already: that is no mistake.
                with contextlib.suppress(ApparatusError):
                    failure = self._failures.pop()
                    self._apparatus.fail(failure, False, self.others.get(failure.robot, ""))

    def _set_quietly(self, wanted: Wanted) -> None:
        try:
            self._set(wanted)
        except SessionError as error:
            rospy.logwarn("training: %s: %s", wanted.name, error)

    def _close(self) -> None:
        """Close the recording of a trial that has ended, show its sheet, and give all back."""
        try:
            for step in (
                self._hear_no_more,
                self._make_sheet,
                self._close_recording,
                self._show_sheet,
                # After the recording: a bridge that has ended takes its time not to answer.
                self._restore_line,
                self._changed,
                self._mend,
            ):
                try:
                    step()
                except Exception as error:  # whatever it is, the next steps have to be taken
                    self._failed(f"the trial has not ended as it should: {error}")
                    self._changed()
        finally:
            self._done.set()

    def _failed(self, message: str) -> None:
        self.message = message
        rospy.logerr("training: %s", message)

    def _hear_no_more(self) -> None:
        assert self._inbox is not None
        for watch in self._watches:
            watch.close()
        if self._channels is not None:
            self._channels.close()
        self._inbox.close()

    def _make_sheet(self) -> None:
        with self._judging:
            text = self._judge.text()
        self._ending[SHEET] = sheet_attachment(text)
        self._sheet = text

    def _close_recording(self) -> None:
        assert self._writer is not None
        try:
            self._writer.close(self._ending, self._seal)
        except RecordingError as error:
            self._failed(f"the recording is not complete: {error}")

    def _show_sheet(self) -> None:
        if self._sheet:
            self._ended(self.trial, self._sheet)

    def _restore_line(self) -> None:
        """Give the line back as it was before the trial."""
        # With the apparatus: nobody sets the line for this trial after that.
        with self._apparatus.busy:
            try:
                self._apparatus.restore_line()
            except ApparatusError as error:
                self._failed(f"the line is not as it was before the trial: {error}")

    def close(self, reason: str) -> None:
        """End it, whatever it is doing, and wait until its recording is closed."""
        if self.begun:
            with contextlib.suppress(SessionError):
                self.abort(reason, "training")
        self.wait_closed()


def free_name(folder: Path, name: str) -> str:
    """Name of a recording that there is not yet: the name, or with a number where it is taken."""
    names = itertools.chain([name], (f"{name}_{number}" for number in itertools.count(2)))
    return next(each for each in names if not (folder / f"{each}{SUFFIX}").exists())
