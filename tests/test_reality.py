"""The study of measured tosses: its reader, its fit on tosses whose contact is known, and a sample of the real ones."""

import numpy as np
import pytest

from agents.ground.cli import UsageError
from agents.ground.places import SHIPPED
from agents.results.study import Amount
from benchmarks.studies import reality
from benchmarks.studies.reality import CUBE, SQUARE, Floor, read_drops, read_tosses
from tests.tools.commands import call_here

REAL = SHIPPED.parent / "shared" / "data" / "real_tosses"
FRICTION, RESTITUTION = 0.3, 0.3
COUNT = reality.FITTED + 8
FRAMES = 150


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Tosses and drops that the engine made with a known contact, in the form of the measured ones."""
    place, rng = tmp_path_factory.mktemp("tosses"), np.random.default_rng(5)
    cube, square = Floor(CUBE, FRICTION, RESTITUTION), Floor(SQUARE, 0.15, 0.4)
    tosses, drops = [], []
    for _ in range(COUNT):
        turn = rng.standard_normal(4)
        start = np.concatenate([[0, 0, 0.2], turn / np.linalg.norm(turn), [1.0, 0.2, -0.4], rng.normal(size=3)])
        tosses.append(cube.follow(start, FRAMES))
        start = [0.0, 0.10, rng.uniform(0, 3), 0.2, -2.2, rng.normal()]
        drops.append(reality._planar(square.follow(reality._in_space(np.array(start)), 70)))
    offset = FRAMES * np.arange(COUNT + 1)
    np.savez(place / "contactnets_cube_tosses.npz", state=np.concatenate(tosses).astype(np.float32), offset=offset)
    np.savez(place / "planar_square_drops.npz", state=np.array(drops, dtype=np.float32))
    return str(place)


def test_the_fit_finds_the_contact_that_made_the_tosses(folder, monkeypatch):
    monkeypatch.setattr(reality, "FITTED", 6)
    found = reality.cube({"data": folder}, Amount(8, 0))
    assert (found["friction"], found["restitution"]) == (FRICTION, RESTITUTION)
    # The first attitude is rounded to single precision, and the height of rest is that of the last frame.
    assert found["path"]["value"] < 0.05
    wrong = reality.cube({"data": folder, "friction": 0.15, "restitution": 0.0}, Amount(8, 0))
    assert wrong["path"]["value"] > 2.0 * found["path"]["value"]


def test_the_square_keeps_its_plane_and_its_contact_is_found(folder, monkeypatch):
    monkeypatch.setattr(reality, "FITTED", 12)
    found = reality.square({"data": folder}, Amount(20, 0))
    assert found["restitution"] == pytest.approx(0.4, abs=0.026)
    assert found["velocity_m_s"]["value"] < 0.1
    assert found["rise_ratio"] == pytest.approx(1.0, abs=0.1)
    drawn = reality.square({"data": folder, "spread": 0.35}, Amount(20, 0))
    assert drawn["velocity_m_s"]["value"] > 2.0 * found["velocity_m_s"]["value"]


def test_a_rise_above_the_bound_is_counted(folder):
    bound = {e: reality.rises({"data": folder, "body": "square", "restitution": e}, Amount(400, 0)) for e in (0.0, 0.9)}
    assert bound[0.0]["above"]["value"] > 0.5
    assert bound[0.9]["above"]["value"] == 0.0
    assert bound[0.0]["rise_median_m"] == bound[0.9]["rise_median_m"] > 0.005


def test_the_planar_state_and_the_state_in_space_are_one():
    planar = np.array([0.1, 0.2, 0.7, 0.3, -2.0, 4.0])
    np.testing.assert_allclose(reality._planar(reality._in_space(planar)[None])[0], planar, atol=1e-12)
    # theta turns x towards z: after a quarter turn the body's x axis points up.
    quarter = reality._in_space(np.array([0.0, 0.0, np.pi / 2, 0.0, 0.0, 0.0]))[3:7]
    w, x, y, z = quarter
    assert 2.0 * (x * z - w * y) == pytest.approx(1.0)


ROWS, BEGINS = np.zeros((13 * COUNT, 13)), 13 * np.arange(COUNT + 1)
READERS = {"contactnets_cube_tosses": read_tosses, "planar_square_drops": read_drops}
WRONG = {
    "no file": lambda place: None,
    "no archive": lambda place: place.write_bytes(b"not an archive"),
    "other arrays": lambda place: np.savez(place, velocity=np.zeros(3)),
    "text": lambda place: np.savez(place, state=np.array(["a", "b"])),
    "too few": lambda place: np.savez(place, state=np.zeros((40, 13)), offset=[0, 40]),
    "not finite": lambda place: np.savez(place, state=np.nan * ROWS, offset=BEGINS),
    "offsets that go back": lambda place: np.savez(place, state=ROWS, offset=BEGINS[::-1]),
    "offsets beyond the end": lambda place: np.savez(place, state=ROWS, offset=2 * BEGINS),
}


@pytest.mark.parametrize("make", WRONG.values(), ids=WRONG.keys())
@pytest.mark.parametrize(("name", "read"), READERS.items())
def test_a_wrong_file_is_refused_in_a_sentence(tmp_path, name, read, make):
    make(tmp_path / f"{name}.npz")
    with pytest.raises(UsageError) as refused:
        read(str(tmp_path))
    assert name in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_study_asks_for_its_data_and_other_studies_take_none(tmp_path):
    for study, words, answer in (
        ("reality", [], "--data is missing"),
        ("reality", ["--data", "none"], "--data is 'none'"),
        ("grip", ["--data", "."], "--data is for studies"),
    ):
        plan = SHIPPED / "configs" / "studies" / f"{study}.yaml"
        done = call_here("agents.benchmark", "--config", plan, "--out", "out.json", *words, folder=tmp_path)
        assert (done.returncode, list(tmp_path.iterdir())) == (2, [])
        assert answer in done.stderr


@pytest.mark.skipif(not REAL.is_dir(), reason="the measured tosses are not here")
def test_a_sample_of_the_real_tosses_is_followed():
    tosses = read_tosses(str(REAL))
    found = reality.compare_tosses(tosses[reality.FITTED : reality.FITTED + 57], 0.18, 0.0)
    assert found.path.mean() < 0.15
    assert found.turn.mean() < 22.0
    assert found.rest.mean() < 0.031
    assert found.same_face.mean() > 0.77
