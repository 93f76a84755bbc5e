"""Heat and motion together: resumed runs, and the shipped arm under every solver of heat."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from coupling import casefile
from coupling.compare_heat import compare
from coupling.overrides import parse
from coupling.reading import Results
from coupling.simulation import run
from coupling.verify.thermoelastic_heat import WARM

CASES = Path(__file__).parent.parent / "cases"
LIT = """
[thermal.environment]
sun = { direction = [0.3, 1, 0.2] }
[thermal.surface.skin]
body = "arm"
absorptivity = 0.8
emissivity = 0.5
[thermal.elastic]
bodies = ["arm"]
"""


# ----------------------------------------------------------------------------------- resumed runs


def flat(tree, name=""):
    if isinstance(tree, dict):
        return {k: v for key, part in tree.items() for k, v in flat(part, f"{name}/{key}").items()}
    return {name: np.asarray(tree)}


@pytest.mark.parametrize("scheme", ["serial", "corrected"])
def test_contacts_light_and_heat_of_deformation_go_on_bit_for_bit(tmp_path, scheme):
    """A run of half the time, resumed to its end, is the run that was never stopped."""

    def case(end):
        text = WARM.replace("[thermal.radiation.arm]", "[thermal.radiation.inside]").replace(
            'body = "arm"\nemissivity = 0.8', 'body = "arm"\nface = "inner"\nemissivity = 0.8'
        )
        settings = [f"time.end={end}", "time.window=0.1", f"coupling.scheme='{scheme}'"]
        return casefile.from_text(text + LIT, tmp_path, parse([*settings, "output.frames=4"]))

    whole = run(case(1.0), tmp_path / "whole")
    run(case(0.5), tmp_path / "halves")
    resumed = run(case(1.0), tmp_path / "halves", resume=True)
    with Results.open(whole.folder) as a, Results.open(resumed.folder) as b:
        expected, found = flat(a.read_state()), flat(b.read_state())
        assert expected.keys() == found.keys()
        assert {"/coupled/outside/contact.touch", "/coupled/outside/light.skin"} <= found.keys()
        assert float(expected["/coupled/elastic"]) != 0.0
        for name, value in expected.items():
            np.testing.assert_array_equal(found[name], value, name)
        ledgers = a.table("ledger"), b.table("ledger")
    for name, column in ledgers[0].items():
        np.testing.assert_array_equal(ledgers[1][name], column, name)


# --------------------------------------------------------------------------------- the main case


@pytest.fixture(scope="module")
def arm():
    """Rows of the shipped arm by solver, 2 s of it, with lines as fine as the reference."""
    scene = casefile.read(CASES / "arm_rotation", ["time.end='2 s'", "time.window='0.5 s'"])
    return {row.run.solver: row for row in compare(scene)}


def apart(arm, name, first):
    """Differences of mean and gradient from the finer wall, of stations ``first`` on."""
    found, standard = arm[name].run, arm["wall, finer"].run
    away = found.sections - standard.sections
    return np.abs(away[1:, first:STATIONS]), standard.sections[1:, first:STATIONS]


STATIONS = 17
# chords of 24 cells have their true length: the radius is that much too large
RADIUS = (np.pi / 24.0) / np.sin(np.pi / 24.0)


def test_every_solver_but_the_prescribed_takes_the_arm(arm):
    refused = {name for name, row in arm.items() if row.run.why}
    assert refused <= {"prescribed", "calculix"}
    assert "no condition gives the temperature" in arm["prescribed"].run.why


@pytest.mark.parametrize("name", ["line", "wall", "lumped"])
def test_sections_of_the_arm_agree(arm, name):
    away, _ = apart(arm, name, 0)
    assert away[..., 0].max() < 1e-3
    assert away[..., 1:].max() < 1e-3


def test_cubics_agree_beyond_what_the_jump_at_the_held_stretch_disturbs(arm):
    """Between a free and a held station cubics overshoot: there is heat of slopes in the root."""
    away, _ = apart(arm, "hermite", 1)
    assert away[..., 0].max() < 1e-3
    assert away[..., 1:].max() < 1e-3


@pytest.mark.parametrize("name", ["solid", "calculix"])
def test_3d_agrees_but_for_the_radius_of_its_polygon(arm, name):
    if name == "calculix" and shutil.which("ccx") is None:
        pytest.skip("ccx is not installed")
    away, standard = apart(arm, name, 1)
    found = arm[name].run.sections[1:, 1:STATIONS]
    assert away[..., 0].max() < 1e-3
    np.testing.assert_allclose(RADIUS * found[..., 1], standard[..., 1], rtol=1e-3)
