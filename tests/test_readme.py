"""The example of a case in the README is one."""

import re
from pathlib import Path

from coupling.casefile import read
from coupling.model import build

README = Path(__file__).parents[1] / "README.md"
REST = """
[time]
end = "2 s"
window = "1 s"
[section.tube]
kind = "tube"
mean_radius = "20 mm"
thickness = "1 mm"
"""


def test_the_example_is_a_case(tmp_path):
    found = re.search(r"```toml\n(.*?)```", README.read_text(), re.DOTALL)
    assert found is not None
    text = found[1].replace(
        'mesh = "bracket.msh"', "box = {size = [1, 1, 1], elements = [1, 1, 1]}"
    )
    (tmp_path / "case.toml").write_text(REST + text.replace('at = "foot"', 'at = "x0"'))
    model = build(read(tmp_path))
    assert "thermal.environment" in model.plan
    assert list(model.pair.heat_solver.regions) == ["mast", "panel", "bracket"]
