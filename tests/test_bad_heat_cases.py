"""Tables under [thermal] that make no sense: every problem is said, with its place."""

import pytest
from test_bad_cases import SHELL, added, assert_refused, changed, run

SOLID = "[thermal.solid.block]\nmaterial='al6061'\nbox={size=[0.1,0.1,0.1],elements=[2,2,2]}\n"

BROKEN: dict[str, tuple[str, list[str]]] = {
    "sides that one temperature round a tube cannot have": (
        changed(('initial = "20 degC"', 'initial = "20 degC"\nwall_points = 1')),
        ["thermal.wall.sun.hot: differs from cold, and thermal.wall_points = 1"],
    ),
    "sides of a rod of which the mean is computed": (
        changed(
            ('kind = "tube"', 'kind = "circle"'),
            ('mean_radius = "20 mm"', 'radius = "20 mm"'),
            ('\nthickness = "1 mm"', ""),
        ),
        ["thermal.wall.sun.hot: differs from cold, and only the mean of a circle"],
    ),
    "film on nothing": (
        added("[thermal.film.air]\nbody='bom'\ncoefficient=10\nsurroundings=300\n"),
        ["thermal.film.air.body: there is no body 'bom'"],
    ),
    "film without a body": (
        added("[thermal.film.air]\ncoefficient=10\nsurroundings=300\n"),
        ["thermal.film.air: give one of body, solid, part"],
    ),
    "negative film": (
        added("[thermal.film.air]\nbody='boom'\ncoefficient=-10\nsurroundings=300\n"),
        ["thermal.film.air.coefficient: "],
    ),
    "emissivity above one": (
        changed(("emissivity = 0.8", "emissivity = 1.2")),
        ["thermal.radiation.space.emissivity: "],
    ),
    "emissivity above one in a table": (
        changed(("emissivity = 0.8", "emissivity = { table = [[200, 0.5], [400, 1.5]] }")),
        ["thermal.radiation.space.emissivity.table[1][1]: "],
    ),
    "below absolute zero": (
        changed(('sink = "3 K"', 'sink = "-300 degC"')),
        ["thermal.radiation.space.sink: "],
    ),
    "a difference given as a temperature": (
        changed(('initial = "20 degC"', 'initial = "20 degC"\ntolerance = "1 degC"')),
        ["thermal.tolerance: "],
    ),
    "face that is not there": (
        changed(("emissivity = 0.8", "emissivity = 0.8\nface = 'outside'")),
        ["thermal.radiation.space.face: there is no face 'outside'"],
    ),
    "enclosure with short rows": (
        added(
            "[thermal.enclosure.in]\nfaces=[{body='boom',face='inner',emissivity=0.8}]\n"
            "view_factors=[[0.5,0.5]]\n"
        ),
        ["thermal.enclosure.in.view_factors: expected 1 rows of 1 numbers"],
    ),
    "enclosure that sees more than everything": (
        added(
            "[thermal.enclosure.in]\nfaces=[{body='boom',face='inner',emissivity=0.8},"
            "{body='boom',face='start',emissivity=0.8}]\nview_factors=[[0.5,0.6],[0.1,0.9]]\n"
        ),
        ["thermal.enclosure.in.view_factors[0]: sums to 1.1, more than 1"],
    ),
    "face of a part without area": (
        added("[thermal.flux.p]\npart='pin'\ndensity=100\n"),
        ["thermal.flux.p.part: thermal.part.pin has no face: give it an area"],
    ),
    "field of both kinds": (
        added("[thermal.field.f]\nbody='boom'\nfile='a.csv'\ntimes=[0]\n"),
        ["thermal.field.f.times: does not go with file"],
    ),
    "field without a file": (
        added("[thermal.field.f]\nbody='boom'\nfile='a.csv'\n"),
        ["thermal.field.f.file: ", "thermal.field.f: gives the temperature of 'boom' at 1 m"],
    ),
    "field of a ragged table": (
        added(
            "[thermal.field.f]\nbody='boom'\ntimes=[0,1]\ndistances=[0,1]\n"
            "temperatures=[[300,300],[300]]\n"
        ),
        ["thermal.field.f.temperatures: expected 2 rows of 2 temperatures"],
    ),
    "solid without a shape": (
        added("[thermal.solid.block]\nmaterial='al6061'\n"),
        ["thermal.solid.block.mesh: give either a mesh or a box"],
    ),
    "solid whose mesh is not there": (
        added("[thermal.solid.block]\nmaterial='al6061'\nmesh='block.msh'\n"),
        ["thermal.solid.block.mesh: "],
    ),
    "solid of nothing": (
        added(SOLID.replace("0.1,0.1,0.1", "0.1,0,0.1")),
        ["thermal.solid.block.box.size: must be positive"],
    ),
    "region that a solid does not have": (
        added(SOLID + "[thermal.flux.f]\nsolid='block'\nface='x2'\ndensity=100\n"),
        ["thermal.flux.f.face: there is no region 'x2'"],
    ),
    "contact of a tight joint": (
        added("[thermal.contact.c]\njoint='tip'\nby_force=[[0,0],[1,1]]\n"),
        ["thermal.contact.c.joint: joint.tip is a spherical: it has no clearance"],
    ),
    "contact without a bearing": (
        added("[thermal.contact.c]\njoint='hinge'\nby_force=[[0,0],[1,1]]\n"),
        ["thermal.contact.c.joint: no part or solid is of 'hinge.bearing'"],
    ),
    "contact without a law": (
        added("[thermal.contact.c]\njoint='hinge'\nroughness='1 um'\n"),
        [
            "thermal.contact.c.area: missing",
            "thermal.contact.c.hardness: missing",
            "thermal.contact.c.slope: missing",
        ],
    ),
    "heat of deformation of a shell": (
        added(SHELL + "[thermal.elastic]\nbodies=['s','bom']\n"),
        [
            "thermal.elastic.bodies[0]: 's' is no beam or cable",
            "thermal.elastic.bodies[1]: there is no body 'bom'",
        ],
    ),
    "link of nothing": (
        changed(('conductance = "1 W/K"', "")),
        ["thermal.link.pin.conductance: missing"],
    ),
    "interface to nothing": (
        added(
            SOLID + "[thermal.interface.i]\na={solid='block',face='x0'}\n"
            "b={solid='blok',face='x1'}\ncoefficient=100\n"
        ),
        ["thermal.interface.i.b.solid: there is no solid 'blok'"],
    ),
    "no such scheme": (
        changed(('initial = "20 degC"', 'initial = "20 degC"\nscheme = "euler"')),
        ["thermal.scheme: "],
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_heat(name, tmp_path):
    text, expected = BROKEN[name]
    (tmp_path / "case.toml").write_text(text)
    assert_refused(run("check", tmp_path), "case.toml", expected)
