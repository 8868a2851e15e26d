"""Nuclides that are used as sources, and materials that attenuate their photons.

Sources of the figures:

* Air-kerma rate constants of photons above 20 keV: M. M. Ninkovic, F. Adrovic, "Air kerma rate
  constants for nuclides important to gamma ray dosimetry and practical application", in: Gamma
  Radiation, InTech 2012, table 1 (doi 10.5772/39170); but that of Cs-137, see below.
* Lines of Cs-137: Laboratoire National Henri Becquerel, Table of Radionuclides (Decay Data
  Evaluation Project), 137-Cs: 94.36 % of its decays lead to the isomer of Ba-137, which emits
  0.6617 MeV 1 time in 1.1102, else K x-rays of 32 to 37 keV: 85.0 and 6.9 in 100 decays.
* Mass energy-absorption coefficients of air: Hubbell and Seltzer as below, table 4.
* Mass attenuation coefficients, with coherent scattering: J. H. Hubbell, S. M. Seltzer, NIST
  Standard Reference Database 126, tables 3 and 4. Densities: ibid., tables 1 and 2.

The coefficients agree within 0.1 % with an independent library of cross sections (xraylib 4.3, up
to 0.8 MeV, which is as far as that goes). The constants of Co-60 and Ir-192 agree within 1 % with
the sum over their lines, E yield mu_en/rho of air / 4 pi. That sum is the constant of Cs-137. The
2.281e-17 of Ninkovic and Adrovic's table are 7 % more: within 1 % what a decay of the isomer
gives, as if each decay of Cs-137 led to it.

Between the energies of the tables, coefficients are interpolated on logarithmic axes.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import Dict, NamedTuple, Tuple


class Nuclide(NamedTuple):
    """What a nuclide emits.

    Attributes
    ----------
    kerma_constant : float
        Air-kerma rate at 1 m of 1 Bq, without any shield (Gy m2 / (Bq s)).
    energy : float
        Of the photons (MeV), by which shields attenuate them: where there are several lines, their
        mean, weighted by yield. Shields harden the spectrum of such a nuclide, which one energy
        does not show: behind thick ones too little is left, most of all of Ir-192.
    """

    kerma_constant: float
    energy: float


class ShieldMaterial(NamedTuple):
    """What attenuates photons.

    Attributes
    ----------
    density : float
        g/cm3.
    coefficients : tuple of float
        Mass attenuation coefficients (cm2/g) at `ENERGIES`.
    """

    density: float
    coefficients: Tuple[float, ...]


NUCLIDES: Dict[str, Nuclide] = {
    "Co-60": Nuclide(8.583e-17, 1.253),
    "Cs-137": Nuclide(2.134e-17, 0.662),
    "Ir-192": Nuclide(3.031e-17, 0.370),
}
"""By their names in scene files; that of Cs-137 includes its daughter."""

ENERGIES = (0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5)
"""Of the materials' coefficients (MeV)."""

MATERIALS: Dict[str, ShieldMaterial] = {
    "aluminium": ShieldMaterial(
        2.699, (0.1042, 0.09276, 0.08445, 0.07802, 0.06841, 0.06146, 0.05496, 0.05006)
    ),
    "concrete": ShieldMaterial(
        2.3, (0.1097, 0.09783, 0.08915, 0.08236, 0.07227, 0.06495, 0.05807, 0.05288)
    ),
    "lead": ShieldMaterial(
        11.35, (0.4031, 0.2323, 0.1614, 0.1248, 0.08870, 0.07102, 0.05876, 0.05222)
    ),
    "steel": ShieldMaterial(
        7.874, (0.1099, 0.09400, 0.08414, 0.07704, 0.06699, 0.05995, 0.05350, 0.04883)
    ),
    "tungsten": ShieldMaterial(
        19.3, (0.3238, 0.1925, 0.1378, 0.1093, 0.08066, 0.06618, 0.05577, 0.05000)
    ),
    "water": ShieldMaterial(
        1.0, (0.1186, 0.1061, 0.09687, 0.08956, 0.07865, 0.07072, 0.06323, 0.05754)
    ),
}
"""By their names in scene files. Concrete is ordinary concrete, steel is counted as pure iron."""


def attenuation(material: str, energy: float) -> float:
    """Linear attenuation coefficient of a material.

    Parameters
    ----------
    material : str
        One of `MATERIALS`.
    energy : float
        Of the photons (MeV), within `ENERGIES`.

    Returns
    -------
    float
        1/m.

    Raises
    ------
    ValueError
        The energy is outside of the table.
    """
    if not ENERGIES[0] <= energy <= ENERGIES[-1]:
        raise ValueError(f"energy is {energy} MeV; {ENERGIES[0]} to {ENERGIES[-1]} are known")
    density, coefficients = MATERIALS[material]
    upper = max(1, bisect_left(ENERGIES, energy))
    below, above = ENERGIES[upper - 1], ENERGIES[upper]
    share = math.log(energy / below) / math.log(above / below)
    mass = coefficients[upper - 1] * (coefficients[upper] / coefficients[upper - 1]) ** share
    return 100.0 * density * mass
