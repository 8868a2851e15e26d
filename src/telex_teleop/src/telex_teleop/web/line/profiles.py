"""Named profiles of the line, and what a request makes of them."""

from __future__ import annotations

import dataclasses
import io
from dataclasses import dataclass, field
from typing import Any, Dict, Mapping, Optional, Tuple

import yaml

from telex_control.common.params import ConfigError, read_struct, require, shown
from telex_control.common.yaml_files import load_yaml

from ...files import FromFile
from .fields import PERFECT, LineFields
from .signal_curve import SignalCurve, SignalPoint

PERFECT_NAME = "perfect"
FIELDS_NAME = "fields"
"""Name of a line of which only figures were given."""

MOST_TEXT = 2000
"""Characters of the fields that a request may have."""


@dataclass(frozen=True)
class Profile:
    """One entry of the file.

    Attributes
    ----------
    description
        For whoever chooses.
    by_signal
        Figures by the quality of the radio signal instead; empty: they do not depend on it.

    Raises
    ------
    telex_control.common.params.ConfigError
        It has both.
    """

    description: str = ""
    fields: LineFields = PERFECT
    by_signal: Tuple[SignalPoint, ...] = ()

    def __post_init__(self) -> None:
        require(
            not self.by_signal or self.fields == PERFECT,
            "fields and by_signal are both given; by_signal has the fields in its points",
        )
        self.curve()  # which checks the points

    def curve(self) -> Optional[SignalCurve]:
        """Return the figures by the signal, None if they do not depend on it."""
        return SignalCurve(self.by_signal) if self.by_signal else None


@dataclass(frozen=True)
class LineSetting:
    """What the line is to be.

    Attributes
    ----------
    name
        What it is called: its profile, or `fields` where only figures were given.
    profile
        Its profile in the file.
    fields
        Its figures, while no signal is known.
    by_signal
        Its figures by the signal, None if they do not depend on it.
    changes
        Figures that were given over the profile's.
    """

    name: str = PERFECT_NAME
    profile: str = PERFECT_NAME
    fields: LineFields = PERFECT
    by_signal: Optional[SignalCurve] = None
    changes: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_perfect(self) -> bool:
        """Whether nothing is impaired, whatever the signal."""
        return self.by_signal is None and self.fields.is_perfect

    def at(self, signal: Optional[float]) -> LineFields:
        """Return the figures at a quality of the signal; None: nobody knows it."""
        if self.by_signal is None or signal is None:
            return self.fields
        return self.by_signal.at(signal).replace(self.changes)

    @property
    def described(self) -> str:
        """The setting in a few words."""
        extra = ", ".join(f"{key} {value:g}" for key, value in sorted(self.changes.items()))
        return f"{self.name} ({extra})" if extra else self.name


@dataclass(frozen=True)
class Profiles(FromFile):
    """The file `config/link_profiles.yaml`.

    Attributes
    ----------
    profiles
        By name.

    Raises
    ------
    telex_control.common.params.ConfigError
        The profile `perfect` is missing or impairs something, or one has the reserved name.
    """

    SHIPPED = "link_profiles.yaml"

    profiles: Dict[str, Profile]

    def __post_init__(self) -> None:
        perfect = self.profiles.get(PERFECT_NAME)
        require(
            perfect is not None and perfect.fields.is_perfect and not perfect.by_signal,
            f"profiles/{PERFECT_NAME} is missing or impairs something; it must be there, and empty",
        )
        require(
            FIELDS_NAME not in self.profiles,
            f"profiles/{FIELDS_NAME} is reserved for lines of which only fields are given",
        )

    def choose(self, profile: str, fields: str = "") -> LineSetting:
        """Return what a request asks for.

        Parameters
        ----------
        profile
            Name of one of the profiles; empty: `perfect`.
        fields
            YAML mapping of the figures that differ; may be empty.

        Raises
        ------
        telex_control.common.params.ConfigError
            There is no such profile, or the fields cannot be used.
        """
        require(len(fields) <= MOST_TEXT, f"fields has {len(fields)} characters; {MOST_TEXT} fit")
        try:
            content = load_yaml(io.StringIO(fields))
        except yaml.YAMLError as error:
            raise ConfigError(f"fields is no YAML: {str(error)[:200]}") from None
        return self.combine(profile, {} if content is None else content)

    def combine(self, profile: str, changes: Any) -> LineSetting:
        """Return a profile with some figures changed, as `choose` does with those of a text."""
        profile = profile or PERFECT_NAME
        base = self.profiles.get(profile)
        if base is None:
            known = ", ".join(self.profiles)
            raise ConfigError(f"profile is {profile[:60]!r}; known are {known}")
        if not isinstance(changes, Mapping):
            raise ConfigError(
                f"fields is {shown(changes)}; a mapping is needed, such as {{delay: 0.4}}"
            )
        pairs = {str(key): value for key, value in changes.items()}
        changed = read_struct(LineFields, {**dataclasses.asdict(base.fields), **pairs})
        given = {key: getattr(changed, key) for key in pairs}
        for point in base.by_signal:
            point.fields.replace(given)
        only_fields = profile == PERFECT_NAME and changed != PERFECT
        name = FIELDS_NAME if only_fields else profile
        return LineSetting(name, profile, changed, base.curve(), given)
