"""The field of point sources behind shields, against closed form and against sampled rays."""

import math

import numpy as np
import pytest

from telex_sim.radiation.field import NEAREST, Field, PointSource, Shield, ShieldForm
from telex_sim.radiation.nuclides import MATERIALS, NUCLIDES, attenuation

STRONG = PointSource("Co-60", 3.7e13)
# Energies (MeV) and yields of the lines, and mass energy-absorption coefficients of air at these
# energies (m2/kg): NIST Standard Reference Database 126.
LINES = {
    "Co-60": ((1.1732, 0.9985, 2.70e-3), (1.3325, 0.9998, 2.62e-3)),
    # The isomer of barium, its K-alpha and its K-beta.
    "Cs-137": (
        (0.6617, 0.9436 / 1.1102, 2.929e-3),
        (0.0321, 0.0554, 1.27e-2),
        (0.0366, 0.0132, 8.8e-3),
    ),
}


def unshielded(distance, source=STRONG):
    """Gy/h."""
    return NUCLIDES[source.nuclide].kerma_constant * source.activity * 3600.0 / distance**2


def box(x, y, z, material="lead", group=0):
    return Shield(ShieldForm.BOX, (0.5 * x, 0.5 * y, 0.5 * z), material, group)


def cylinder(radius, length, material="lead", group=0):
    return Shield(ShieldForm.CYLINDER, (radius, radius, 0.5 * length), material, group)


def sphere(radius, material="lead", group=0):
    return Shield(ShieldForm.SPHERE, (radius, radius, radius), material, group)


def rate(field, point):
    return float(field.rates(np.array([point], dtype=float))[0])


def turned(angle):
    """About z."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


class TestNuclides:
    @pytest.mark.parametrize("nuclide", sorted(LINES))
    def test_the_constant_is_that_of_the_lines(self, nuclide):
        joules = 1.602177e-13  # per MeV
        lines = sum(energy * share * air for energy, share, air in LINES[nuclide])
        assert NUCLIDES[nuclide].kerma_constant == pytest.approx(
            lines * joules / (4.0 * math.pi), rel=0.02
        )

    def test_37_terabecquerel_of_cobalt_give_11_gray_an_hour_at_a_metre(self):
        assert unshielded(1.0) == pytest.approx(11.4, rel=0.01)

    def test_half_value_layers(self):
        """Of narrow beams (m), as handbooks have them."""
        for material, energy, half in (
            ("lead", 1.25, 0.0104),
            ("lead", 0.662, 0.0055),
            ("steel", 1.25, 0.0165),
            ("concrete", 1.25, 0.052),
            ("water", 0.662, 0.081),
        ):
            assert math.log(2.0) / attenuation(material, energy) == pytest.approx(half, rel=0.02)

    @pytest.mark.parametrize("material", MATERIALS)
    def test_coefficients_fall_with_the_energy(self, material):
        found = [attenuation(material, energy) for energy in np.linspace(0.3, 1.5, 40)]
        assert found == sorted(found, reverse=True)

    def test_refuses_energies_outside_of_the_table(self):
        with pytest.raises(ValueError, match="energy is 2.0 MeV"):
            attenuation("lead", 2.0)


class TestField:
    def test_falls_with_the_square_of_the_distance(self):
        field = Field([STRONG], [])
        field.positions[0] = (1.0, 2.0, 0.5)
        for distance in (0.1, 1.0, 30.0):
            assert rate(field, (1.0, 2.0 + distance, 0.5)) == pytest.approx(
                unshielded(distance), rel=1e-9
            )

    def test_sources_add_up(self):
        field = Field([STRONG, PointSource("Cs-137", 1e12)], [])
        field.positions[1] = (3.0, 0.0, 0.0)
        expected = unshielded(1.0) + unshielded(2.0, PointSource("Cs-137", 1e12))
        assert rate(field, (1.0, 0.0, 0.0)) == pytest.approx(expected, rel=1e-9)

    def test_is_finite_within_a_source(self):
        field = Field([STRONG], [])
        assert rate(field, (0.0, 0.0, 0.0)) == pytest.approx(unshielded(NEAREST))

    def test_without_sources_is_nothing(self):
        assert rate(Field([], [box(1.0, 1.0, 1.0)]), (1.0, 0.0, 0.0)) == 0.0

    @pytest.mark.parametrize("nuclide", NUCLIDES)
    @pytest.mark.parametrize("material", MATERIALS)
    def test_a_slab_attenuates_along_the_slanting_ray(self, nuclide, material):
        source = PointSource(nuclide, 1e12)
        field = Field([source], [box(0.05, 4.0, 4.0, material)])
        field.centers[0] = (1.0, 0.0, 0.0)
        mu = attenuation(material, NUCLIDES[nuclide].energy)
        expected = unshielded(math.hypot(2.0, 1.0), source)
        expected *= math.exp(-mu * 0.05 * math.hypot(2.0, 1.0) / 2.0)
        assert rate(field, (2.0, 1.0, 0.0)) == pytest.approx(expected, rel=1e-6)

    def test_a_turned_slab(self):
        field = Field([STRONG], [box(0.02, 4.0, 4.0)])
        field.centers[0], field.rotations[0] = (1.0, 0.0, 0.0), turned(math.pi / 3.0)
        mu = attenuation("lead", NUCLIDES["Co-60"].energy)
        expected = unshielded(2.0) * math.exp(-mu * 0.02 / math.cos(math.pi / 3.0))
        assert rate(field, (2.0, 0.0, 0.0)) == pytest.approx(expected, rel=1e-6)

    def test_cylinders_from_the_side_along_the_axis_and_past(self):
        field = Field([STRONG], [cylinder(0.03, 0.2)])
        mu = attenuation("lead", NUCLIDES["Co-60"].energy)
        chord = 2.0 * math.sqrt(0.03**2 - 0.01**2)
        for source, point, way in (
            ((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.06),
            ((-1.0, 0.01, 0.05), (1.0, 0.01, 0.05), chord),
            ((0.01, 0.0, -1.0), (0.01, 0.0, 1.0), 0.2),
            ((-1.0, 0.0301, 0.0), (1.0, 0.0301, 0.0), 0.0),
            ((-1.0, 0.0, 0.101), (1.0, 0.0, 0.101), 0.0),
        ):
            field.positions[0] = source
            assert rate(field, point) == pytest.approx(
                unshielded(2.0) * math.exp(-mu * way), rel=1e-6
            )

    def test_a_source_within_a_sphere_and_a_point_within_it(self):
        field = Field([STRONG], [sphere(0.1, "water")])
        mu = attenuation("water", NUCLIDES["Co-60"].energy)
        assert rate(field, (0.0, 0.0, 2.0)) == pytest.approx(
            unshielded(2.0) * math.exp(-0.1 * mu), rel=1e-6
        )
        assert rate(field, (0.0, 0.05, 0.0)) == pytest.approx(
            unshielded(0.05) * math.exp(-0.05 * mu), rel=1e-6
        )

    def test_what_lies_behind_the_point_or_the_source_does_not_shield(self):
        field = Field([STRONG], [box(0.2, 1.0, 1.0), box(0.2, 1.0, 1.0)])
        field.centers[:] = (-0.5, 0.0, 0.0), (2.0, 0.0, 0.0)
        assert rate(field, (1.0, 0.0, 0.0)) == pytest.approx(unshielded(1.0), rel=1e-9)

    def test_what_overlaps_counts_once_within_a_group_and_twice_across_groups(self):
        mu = attenuation("lead", NUCLIDES["Co-60"].energy)
        for groups, way in (((0, 0), 0.06), ((0, 1), 0.08)):
            field = Field([STRONG], [box(0.04, 1.0, 1.0, group=group) for group in groups])
            field.centers[:] = (1.0, 0.0, 0.0), (1.02, 0.0, 0.0)
            assert rate(field, (2.0, 0.0, 0.0)) == pytest.approx(
                unshielded(2.0) * math.exp(-mu * way), rel=1e-6
            )

    def test_many_turned_shields_agree_with_sampled_rays(self):
        random = np.random.default_rng(4)
        makers = (
            lambda: box(*random.uniform(0.1, 0.6, 3), "water"),
            lambda: cylinder(random.uniform(0.1, 0.3), random.uniform(0.1, 0.6), "water"),
            lambda: sphere(random.uniform(0.1, 0.3), "water"),
        )
        shields = [makers[n % 3]() for n in range(60)]
        shields = [Shield(s.form, s.size, s.material, n) for n, s in enumerate(shields)]
        field = Field([STRONG, STRONG], shields)
        field.positions[:] = random.uniform(-2.0, 2.0, (2, 3))
        field.centers[:] = random.uniform(-2.0, 2.0, (60, 3))
        for number in range(60):
            turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
            field.rotations[number] = turn * np.sign(np.linalg.det(turn))
        points = random.uniform(-2.0, 2.0, (5, 3))
        mu = attenuation("water", NUCLIDES["Co-60"].energy)
        expected = np.zeros(5)
        shares = (np.arange(20000) + 0.5) / 20000
        for source in field.positions:
            for number, point in enumerate(points):
                length = float(np.linalg.norm(point - source))
                ray = source + shares[:, None] * (point - source)
                way = sum(
                    _within(shield, (ray - center) @ turn).mean()
                    for shield, center, turn in zip(shields, field.centers, field.rotations)
                )
                expected[number] += unshielded(length) * math.exp(-mu * length * way)
        assert field.rates(points) == pytest.approx(expected, rel=2e-3)


def _within(shield, points):
    if shield.form is ShieldForm.BOX:
        return (np.abs(points) <= shield.size).all(axis=1)
    if shield.form is ShieldForm.SPHERE:
        return np.linalg.norm(points, axis=1) <= shield.size[0]
    beside = np.hypot(points[:, 0], points[:, 1]) <= shield.size[0]
    return beside & (np.abs(points[:, 2]) <= shield.size[2])
