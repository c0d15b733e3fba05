"""Arm against jet: the equations against numbers computed by hand, and streams against the formula of Poisson."""

from dataclasses import replace

import numpy as np
import pytest

from agents.line.jets import AirJets, Diverter, Outlines, ejected, fractions_of, sort_stream, stations_text
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from tests.tools.plant import plant

JETS = AirJets()


def outlines(x: list[float], y: list[float], mass: float = 0.02) -> Outlines:
    """Objects of 0.10 x 0.06 m."""
    alike = np.ones(len(x))
    return Outlines(np.array(x), np.array(y), 0.10 * alike, 0.06 * alike, mass * alike)


def test_a_nozzle_by_hand():
    # 3 mm: 7.069 mm2; 1.268 x 7 bar - 1.013 bar = 7.863 bar; 0.0404 x 7e5 / sqrt(293) = 1652 kg/s/m2.
    assert JETS.thrust == pytest.approx(7.069e-6 * 7.863e5, rel=1e-3)
    assert JETS.flow == pytest.approx(7.069e-6 * 1652.0, rel=1e-3)
    assert JETS.radius == pytest.approx(0.00653, abs=1e-5)
    assert JETS.window(3.0) == (pytest.approx(0.030), pytest.approx(0.025 + 0.01305, abs=1e-5))


def test_the_heaviest_object_that_a_jet_moves_by_hand():
    # Two nozzles of 5.558 N push 0.10 / 3 s; 1.286 m/s clear 0.15 m on 0.35 m at 3 m/s: 0.288 kg.
    limit = JETS.limit(outlines([0.0], [0.0]), 3.0)
    assert limit == pytest.approx([2 * 5.558 * (0.10 / 3.0) / (0.15 * 3.0 / 0.35)], rel=1e-3)
    assert JETS.moves(outlines([0.0], [0.0], 0.28), 3.0).all()
    assert not JETS.moves(outlines([0.0], [0.0], 0.29), 3.0).any()
    # An object narrower than a pitch is still met by one nozzle; at half the speed twice the impulse, half the need.
    assert JETS.limit(outlines([0.0], [0.0])._replace(width=np.array([0.01])), 3.0) == pytest.approx(limit / 2.0)
    assert JETS.limit(outlines([0.0], [0.0]), 1.5) == pytest.approx(4.0 * limit)


def test_the_air_of_an_object_by_hand():
    # 0.06 / 0.025 + 1 = 3.4 nozzles of 0.01168 kg/s open for 0.10 / 3 + 0.01 s: 1.72 g, 1.43 l, 4e5 J/m3.
    assert JETS.energy(outlines([0.0], [0.0]), 3.0) == pytest.approx([3.4 * 0.01168 / 1.204 * 0.04333 * 4e5], rel=1e-3)


def test_what_goes_along_by_hand():
    # Lengths of 0.10 and a window of 0.03 reach 0.115 along; widths of 0.06 and one of 0.038 reach 0.079 across.
    objects = outlines([0.0, 0.114, 0.116, 0.0, 0.0], [0.0, 0.0, 0.0, 0.078, 0.080])
    targets = np.array([True, False, False, False, False])
    assert ejected(JETS, objects, targets, 3.0).tolist() == [True, True, False, True, False]
    # A flap of 0.3 s takes the whole width, and 0.05 + 0.05 + 0.3 / 2 x 0.4 m along.
    objects = outlines([0.0, 0.159, 0.161], [0.0, 0.3, 0.3])
    assert ejected(Diverter(), objects, targets[:3], 0.4).tolist() == [True, True, False]
    # What is too heavy stays, as a target and as a neighbour, and a target that stays takes nobody along.
    heavy = objects._replace(mass=np.array([9.0, 0.02, 9.0]))
    assert not ejected(JETS, heavy, targets[:3], 3.0).any()
    near = outlines([0.0, 0.05], [0.0, 0.0])._replace(mass=np.array([0.02, 9.0]))
    assert ejected(JETS, near, targets[:2], 3.0).tolist() == [True, False]


def test_neighbours_of_a_poisson_stream_are_as_many_as_its_formula_says():
    # Middles at random, 40 a square metre; none other lies within 0.115 m along and 0.079 m across by chance.
    random, side, density = np.random.default_rng(0), 8.0, 40.0
    count = int(density * side * side)
    objects = outlines([*random.random(count) * side], [*random.random(count) * side])
    alone = 0
    area = 4.0 * ((0.10 + 0.03) - 0.03 / 2) * (0.06 + JETS.window(3.0)[1] / 2)
    middle = np.flatnonzero((np.abs(objects.x - 4) < 3.5) & (np.abs(objects.y - 4) < 3.5))[:400]
    for index in middle:
        targets = np.zeros(count, dtype=np.bool_)
        targets[index] = True
        alone += int(ejected(JETS, objects, targets, 3.0).sum() == 1)
    expected = np.exp(-density * area)
    assert alone / len(middle) == pytest.approx(expected, abs=4.0 * np.sqrt(expected * (1 - expected) / len(middle)))


def test_items_of_the_same_bins_are_one_fraction():
    assert fractions_of(LineConfig.load(plant())).tolist() == [0, 1, 2]
    together = plant()
    together["cell"]["bins"]["fixed"][0]["accepts"] = ["hdpe", "alu"]
    together["cell"]["bins"]["fixed"][2]["accepts"] = ["hdpe", "alu"]
    assert fractions_of(LineConfig.load(together)).tolist() == [0, 1, 0]


def test_far_objects_are_all_sorted_and_near_ones_are_not():
    config = LineConfig.load({**plant(), "throws": "flight", "duration": 60.0})
    stream = LineCell(config, 2).stream
    seen = replace(stream.objects.measured, kind=stream.objects.kind)
    spread = replace(stream, objects=replace(stream.objects, measured=seen), x=10.0 * stream.x)
    assert sort_stream(AirJets(), spread, config).sorted_share == 1.0
    result = sort_stream(AirJets(), stream, config)
    flaps = sort_stream(Diverter(), stream, config)
    assert result.stations == flaps.stations == 2
    assert 0.9 < result.sorted_share <= 1.0
    assert 0.2 < flaps.sorted_share < result.sorted_share
    assert np.isnan(flaps.energy)
    # The commonest fraction passes all stations: with jets that move nothing, exactly its objects are right.
    weak = sort_stream(AirJets(nozzle=1e-6), spread, config)
    assert weak.sorted_share == pytest.approx((stream.objects.kind == 0).mean())


def test_a_single_fraction_needs_no_sorting():
    figures = {"jets": {"stations": 0}, "diverters": {"stations": 0}}
    assert "nothing to sort" in stations_text(figures, 0.9, None)
