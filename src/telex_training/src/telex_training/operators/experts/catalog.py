"""Experts of the shipped exercises."""

from __future__ import annotations

from typing import Dict

from . import (
    driving_exercises,
    handling_exercises,
    mounted_exercises,
    pair_exercises,
    panel_exercises,
    reading,
)
from .brief import Expert

EXPERTS: Dict[str, Expert] = {
    "acuity": reading.acuity,
    "beam": pair_exercises.beam,
    "briefcase": handling_exercises.briefcase,
    "confinement": driving_exercises.confinement,
    "connector": panel_exercises.connector,
    "continuous_ramps": driving_exercises.over_ramps,
    "crossing_ramps": driving_exercises.over_crossing_ramps,
    "cube_to_bin": handling_exercises.cube_to_bin,
    "door": mounted_exercises.door,
    "extract_place": panel_exercises.extract_place,
    "gap": driving_exercises.over_gap,
    "hurdle": driving_exercises.over_hurdle,
    "incline": driving_exercises.incline,
    "inspect": mounted_exercises.inspect,
    "leak_search": reading.leak_search,
    "maze": reading.maze,
    "pallet": handling_exercises.pallet,
    "radiation_survey": driving_exercises.radiation_survey,
    "radio_range": reading.radio_range,
    "rails": driving_exercises.over_rails,
    "rotate": panel_exercises.rotate,
    "slalom": driving_exercises.slalom,
    "source_to_pot": handling_exercises.source_to_pot,
    "stairs": driving_exercises.over_stairs,
    "stepfield": driving_exercises.over_posts,
    "swab": panel_exercises.swab,
    "touch": panel_exercises.touch,
    "valve": mounted_exercises.valve,
}
"""By exercise; of one for several robots, what the operator of each does."""
