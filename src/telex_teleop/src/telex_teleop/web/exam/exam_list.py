"""An exam that runs: its list holds for every connection without the instructor's token.

The training node says by `TRAINING_TOPIC` that an exam runs. The bridge hears it, applies the list,
and says by `BRIDGE_TOPIC` that the list holds; the video server follows the bridge. The list stays
until the training node or an instructor ends it, whoever crashes meanwhile.
"""

from __future__ import annotations

from typing import Callable, FrozenSet

from ..rights import ExamRights, NamePatterns

TRAINING_TOPIC = "training/exam"
"""std_msgs/String, latched: the trial of the exam that runs, empty when none does."""

BRIDGE_TOPIC = "bridge/exam"
"""std_msgs/String, latched: the trial for which the exam's list holds, empty when it does not."""

PARAMETER = "exam"
"""Private parameter of the bridge that says the same, for those who start during an exam."""

EQUIPMENT = "equipment"
"""Parameter in the robot's namespace: what its variant declares, of which each may have a topic."""

_LONGEST = 250


class Exam:
    """What may be used while an exam runs, and whether one does.

    Beside the list, the topics of the robot's equipment may be heard, and no others for what it
    lacks.

    Parameters
    ----------
    namespace
        The robot's, with slashes around it.

    Attributes
    ----------
    trial
        Of the exam that runs; empty when none does.
    changed
        Called when an exam begins or ends.
    """

    def __init__(self, rights: ExamRights, namespace: str) -> None:
        self._lists = {
            use: NamePatterns(patterns, namespace) for use, patterns in vars(rights).items()
        }
        self.trial = ""
        self._equipment: FrozenSet[str] = frozenset()
        self.changed: Callable[[], None] = lambda: None

    def equip(self, equipment: object) -> None:
        """Take what the robot has, as the parameter `EQUIPMENT` tells it; else it has nothing."""
        pieces = equipment.values() if isinstance(equipment, dict) else ()
        topics = (piece.get("topic") for piece in pieces if isinstance(piece, dict))
        self._equipment = frozenset(topic for topic in topics if isinstance(topic, str))

    def set(self, trial: object) -> None:
        """Let the exam of a trial begin, or none; what is no text means none."""
        trial = trial[:_LONGEST] if isinstance(trial, str) else ""
        if trial != self.trial:
            self.trial = trial
            self.changed()

    def allows(self, use: str, name: str) -> bool:
        """Tell whether a name may be used in this way now; see `ExamRights` for the uses."""
        if not self.trial or (use == "subscribe" and name in self._equipment):
            return True
        return self._lists[use].match(name)

    @staticmethod
    def refusal(use: str, name: str) -> str:
        """Say that a name may not be used while the exam runs."""
        return (
            f"{name[:200]} is closed while an exam runs, but to the instructor's token ('{use}' in "
            "the file that the bridge's parameter ~exam_rights names)"
        )
