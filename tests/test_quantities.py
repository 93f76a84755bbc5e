import subprocess
import sys
from math import pi

import pytest

from coupling import quantities as q

CONVERSIONS = [
    ("0.05 mm", q.LENGTH, 5e-5),
    ("25 degC", q.TEMPERATURE, 298.15),
    ("-200 degC", q.TEMPERATURE, 73.15),  # exactly: it is the end of a material's range
    ("77 degF", q.TEMPERATURE, 298.15),
    ("300 K", q.TEMPERATURE, 300.0),
    ("20 K", q.DIFFERENCE, 20.0),
    ("20 delta_degC", q.DIFFERENCE, 20.0),
    ("36 delta_degF", q.DIFFERENCE, 20.0),
    ("45 deg", q.ANGLE, pi / 4),
    ("0.5 turn", q.ANGLE, pi),
    ("0.08 deg/s", q.ANGULAR_SPEED, 0.08 * pi / 180),
    ("5000 rpm", q.ANGULAR_SPEED, 5000 * 2 * pi / 60),
    ("2 kHz", q.FREQUENCY, 2000.0),
    ("69 GPa", q.PRESSURE, 69e9),
    ("167 W/m/K", q.CONDUCTIVITY, 167.0),
    ("167 W/(m·K)", q.CONDUCTIVITY, 167.0),
    ("167 W/m/degC", q.CONDUCTIVITY, 167.0),  # in a product a degree is a difference
    ("896 J/kg/K", q.HEAT_CAPACITY, 896.0),
    ("23.1e-6 1/K", q.PER_KELVIN, 23.1e-6),
    ("-1e-3 K^-1", q.PER_KELVIN, -1e-3),
    ("10 N m", q.MOMENT, 10.0),
    ("10 N*m", q.MOMENT, 10.0),
    ("9.81 m/s**2", q.ACCELERATION, 9.81),
    ("5 cm^2", q.AREA, 5e-4),
    ("12 cm^4", q.SECOND_MOMENT, 12e-8),
    ("20 min", q.TIME, 1200.0),
    ("2 h", q.TIME, 7200.0),
    ("  2ms ", q.TIME, 2e-3),
    ("1.5 N/m^1.5", q.HERTZ_STIFFNESS, 1.5),
    (3, q.LENGTH, 3.0),
    (0.33, q.NUMBER, 0.33),
]


@pytest.mark.parametrize(("text", "kind", "value"), CONVERSIONS)
def test_is_converted_to_si(text, kind, value):
    assert q.read(text, kind) == pytest.approx(value, rel=1e-12)


def test_a_celsius_temperature_is_exact():
    assert q.read("-200 degC", q.TEMPERATURE) == 73.15


REFUSALS = [
    ("25 C", q.TEMPERATURE, "did you mean 'degC'?"),
    ("25 F", q.TEMPERATURE, "did you mean 'degF'?"),
    ("25 Celsius", q.TEMPERATURE, "did you mean 'degC'?"),
    ("25 delta_degC", q.TEMPERATURE, "for differences"),
    ("20 degC", q.DIFFERENCE, "write it as '20 K'"),
    ("5 kg", q.LENGTH, "unit of a mass"),
    ("5 m m", q.LENGTH, "unit of an area"),
    ("10 Nm", q.MOMENT, "did you mean 'N m'?"),
    ("9.81 m/s2", q.ACCELERATION, "did you mean 'm/s^2'?"),
    ("5 meeters", q.LENGTH, "did you mean 'meter'?"),
    ("2 Hz", q.ANGULAR_SPEED, "unit of a frequency"),
    ("2 rad/s", q.FREQUENCY, "unit of an angular speed"),
    ("0.1 1/s", q.ANGULAR_SPEED, "unit of a frequency"),
    ("1 m/m", q.ANGLE, "unit of a plain number"),
    ("5", q.LENGTH, "has no unit"),
    ("five", q.LENGTH, "expected a length"),
    ("85 %", q.NUMBER, "expected a number"),
    ("nan m", q.LENGTH, "expected a length"),
    ("1e400 m", q.LENGTH, "finite"),
    (float("inf"), q.LENGTH, "finite"),
    (float("nan"), q.NUMBER, "finite"),
    (10**400, q.LENGTH, "finite"),
    pytest.param(9**20_000, q.LENGTH, "finite", id="more digits than Python prints"),
    (1e200, q.LENGTH, "too large"),
    ("1e-200 m", q.LENGTH, "too small"),
    (True, q.LENGTH, "got true"),
    ([1], q.LENGTH, "got [1]"),
    ({}, q.LENGTH, "got a table"),
    ("5 9^9^9 m", q.LENGTH, "unknown unit"),
    ("5 (m^99)^99", q.LENGTH, "unknown unit"),
    ("5 __import__('os')", q.LENGTH, "unknown unit"),
    ("5 $", q.LENGTH, "unknown unit"),
]


@pytest.mark.parametrize(("text", "kind", "words"), REFUSALS)
def test_is_refused_with_a_sentence(text, kind, words):
    with pytest.raises(ValueError) as refusal:
        q.read(text, kind)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_every_kind_can_be_written_as_its_example():
    for kind in vars(q).values():
        if isinstance(kind, q.Kind) and kind.unit:
            assert isinstance(q.read(kind.example, kind), float)


def test_plain_numbers_do_not_import_pint():
    code = (
        "import sys; from coupling.quantities import LENGTH, read; read(1.5, LENGTH);"
        "assert 'pint' not in sys.modules; read('1 m', LENGTH); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
