"""Files of the field, each with its right value: the energy per cycle of a closed form, the peak of a ground motion."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dampyr import ground_motions
from dampyr.errors import FileError, InputError
from dampyr.records import Record, read
from dampyr.records.cycle_analysis.measure import measure
from dampyr.units import STANDARD_GRAVITY
from tests.text_cases import DT, ENERGY, PGA, SAMPLES, A, damper, european, ground, in_rows, table

RIGHT = 5e-4  # of the energy: 200 samples a cycle


def quoted_decimal_commas() -> str:
    rows = damper()[:, [0, 1, 3]] * [1, 1, 1e-3]
    body = table([], rows, ["{:.3f}", "{:.4f}", "{:.6f}"], ";").replace(".", ",")
    lines = [",".join(f'"{cell}"' for cell in line.split(";")) for line in body.splitlines()]
    return "\ufeff" + "\n".join(['"Time","Extension","Load"', '"(s)","(mm)","(kN)"', *lines]) + "\n"


def thousands(mark: str) -> str:
    rows = damper()[:, [0, 1, 3]] * [1, 1, 20]
    body = table([], rows, ["{:.3f}", "{:.3f}", "{:,.3f}"], ";")
    body = european(body) if mark == "." else body.replace(",", mark)
    return "time [s];displacement [mm];force [N]\n" + body


def units_row(names: str, units: str, scale: list[float]) -> str:
    return "Shock dyno\n\n" + table([names, units], damper() / scale, ["{:.3f}", "{:.5f}", "{:.4f}", "{:.4f}"])


LBS = units_row("Time,Displacement,Velocity,Force", "sec,inches,in/sec,lbs", [1, 25.4, 25.4, 4.4482216152605])
KN = table(
    ["Time,Displacement,Force", "s,Inch,KN"], damper()[:, [0, 1, 3]] / [1, 25.4, 1e3], ["{:.3f}", "{:.6f}", "{:.6f}"]
)
KGF = units_row("Time,Displacement,Velocity,Force", "sec.,in.,ips,kgf", [1, 25.4, 25.4, 9.80665])
COUNTS = table(
    ["time [s],encoder [counts],force [N]"], damper()[:, [0, 1, 3]] * [1, 200, 1], ["{:.3f}", "{:.0f}", "{:.3f}"]
)
GERMAN = "Zeit (s);Weg (mm);Kraft (N)\n" + table(
    [], damper()[:, [0, 1, 3]], ["{:.3f}", "{:.4f}", "{:.3f}"], ";"
).replace(".", ",")
PORTUGUESE = table(
    ["tempo [s];deslocamento [mm];força [N]"], damper()[:, [0, 1, 3]], ["{:.3f}", "{:.4f}", "{:.3f}"], ";"
)


@pytest.mark.parametrize(
    ("text", "options", "times", "said"),
    [
        (quoted_decimal_commas(), {"columns": {"displacement": "Extension"}}, 1, ("decimal commas",)),
        (thousands("."), {}, 20, ("decimal commas", "thousands marks '.' left out")),
        (thousands(","), {}, 20, ("thousands marks ',' left out",)),
        (thousands("'"), {"thousands": "'"}, 20, ('thousands marks "\'" left out',)),
        (LBS, {}, 1, ()),
        (KN, {}, 1, ()),
        (KGF, {}, 1, ()),
        (GERMAN, {}, 1, ("decimal commas",)),
        (PORTUGUESE, {}, 1, ()),
        (
            COUNTS,
            {"columns": {"displacement": "encoder"}, "factors": {"displacement": "0.005 mm"}},
            1,
            ("displacement is 0.005 mm times 'encoder' in the file [counts], as declared",),
        ),
    ],
    ids=[
        "quotes",
        "thousands, European",
        "thousands",
        "apostrophes",
        "lbs",
        "KN",
        "kgf",
        "German",
        "Portuguese",
        "counts",
    ],
)
def test_a_file_of_the_field_gives_its_energy(
    tmp_path: Path, text: str, options: dict[str, Any], times: float, said: tuple[str, ...]
) -> None:
    path = tmp_path / "test.csv"
    path.write_text(text, encoding="utf-8")
    record = read(path, no_input=True, **options)
    assert measure(record).energy_per_cycle == pytest.approx(times * ENERGY, rel=RIGHT)
    assert record.history == ("read from columns, converted to SI", *said)


def test_the_closed_form_is_the_one_of_the_field() -> None:
    assert pytest.approx(9.969, abs=5e-4) == ENERGY
    assert np.max(np.abs(damper()[:, 3])) == pytest.approx(275.4, abs=0.2)


def test_counts_without_a_factor_say_how_to_state_one(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text(COUNTS)
    with pytest.raises(
        FileError, match=r"the unit 'counts' does not measure .* such as --factor displacement='0.005 m'"
    ):
        read(path, columns={"displacement": "encoder"})


def test_factors_and_offsets(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text(table(["time [s],displacement [mm],bridge [V]"], damper()[:, [0, 1, 3]] / [1, 1, 250], ["{}"] * 3))
    request: dict[str, Any] = {"columns": {"force": "bridge"}, "factors": {"force": "250 N", "displacement": 1.02}}
    record = read(path, **request, offsets={"force": "-12 N", "displacement": 0.001})
    assert record.force == pytest.approx(damper()[:, 3] - 12)
    assert record.displacement == pytest.approx(1.02e-3 * damper()[:, 1] + 1e-3)
    assert record.history[1:] == (
        "displacement is 1.02 times 'displacement' in the file [mm] plus 0.001 m, as declared",
        "force is 250 N times 'bridge' in the file [V] plus -12 N, as declared",
    )
    for wrong, message in {
        "3 mm": "does not measure what 'N' measures", "nan": "must be finite and not 0", "0": "must be finite and not 0",
    }.items():  # fmt: skip
        with pytest.raises(InputError, match=rf"factors\['force'\].*{message}"):
            read(path, factors={"force": wrong})
    with pytest.raises(InputError, match=r"offsets\['force'\]: the unit 'mm' does not measure"):
        read(path, offsets={"force": "3 mm"})
    with pytest.raises(FileError, match="'5 mm' has a unit, but the displacement is in 'mm'; give a number alone"):
        read(path, columns={"force": "bridge"}, factors={"force": "250 N", "displacement": "5 mm"})
    toml = '[columns]\nforce = "bridge"\n[factors]\nforce = "250 N"\n[offsets]\nforce = "-12 N"\n'
    (tmp_path / "reading.toml").write_text(toml)
    assert np.array_equal(read(path).force, record.force)


def test_a_unit_that_is_none_gives_way_to_the_declared_one(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text(
        table(["time [s],displacement [mm],force [kg]"], damper()[:, [0, 1, 3]] / [1, 1, 9.80665], ["{}"] * 3)
    )
    with pytest.raises(
        FileError, match=r"the unit 'kg' does not measure what 'N' measures; .* weight of a mass write kgf"
    ):
        read(path)
    record = read(path, units={"force": "kgf"})
    assert record.force == pytest.approx(damper()[:, 3])
    assert "force in kgf as declared, 'kg' in the file" in record.history


def jittered() -> tuple[np.ndarray, str]:
    """Stamps of a microcontroller, 1 to 7 ms apart, and its file."""
    t = np.cumsum(np.random.default_rng(7).choice([1.0, 2.5, 4.0, 5.5, 7.0], 1484))
    return t, table(
        ["time [ms],displacement [mm],force [N]"], damper(0, 1e-3 * t)[:, [0, 1, 3]] * [1e3, 1, 1], ["{:.2f}"] * 3
    )


def test_stamps_that_jitter_are_one_line_and_an_interval_goes_before_them(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    t, text = jittered()
    path.write_text(text)
    record = read(path, no_input=True)
    assert measure(record).energy_per_cycle == pytest.approx(ENERGY, rel=2e-3)
    [stamps] = [str(finding) for finding in record.findings if "time stamps" in str(finding) or "gap" in str(finding)]
    assert "the time stamps jitter" in stamps
    assert "--dt 0.00" in stamps
    mean = 1e-3 * (t[-1] - t[0]) / (len(t) - 1)
    even = read(path, dt=mean)
    assert even.time == pytest.approx(mean * np.arange(len(t)))
    assert even.history[-1] == f"time from the sampling interval, {mean:g} s, in the place of the stamps 'time'"
    with pytest.raises(FileError, match=r"dt = 0.01 s was given, but the column 'time' is the time and steps by 0.00"):
        read(path, dt=0.01)


@pytest.mark.parametrize("unit", ["ms", ""])
def test_equal_stamps_are_refused_in_one_line_that_says_how_to_read_them(tmp_path: Path, unit: str) -> None:
    rows = damper()[:, [0, 1, 3]]
    rows[:, 0] = np.floor(rows[:, 0] * 100) * 10  # a clock of 10 ms for samples of 5 ms
    path = tmp_path / "test.csv"
    path.write_text(
        table([f"time{f' [{unit}]' * bool(unit)},displacement [mm],force [N]"], rows, ["{:.0f}", "{:.4f}", "{:.4f}"])
    )
    with pytest.raises(FileError, match=r"lines 2 and 3 have the same time stamp \(600 such pairs\); .*--dt 0.004996"):
        read(path, units={} if unit else {"time": "ms"})
    record = read(path, dt=0.005, no_input=True)
    assert measure(record).energy_per_cycle == pytest.approx(ENERGY, rel=RIGHT)


def test_what_may_be_a_thousands_or_a_decimal_mark_is_asked(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text("time [s];displacement [mm];force [N]\n" + "".join(f"{k};{k % 5};1,{200 + k}\n" for k in range(20)))
    with pytest.raises(FileError, match=r"line 2: '1,200' may be 1200 or 1.200; .* --thousands , or --thousands \."):
        read(path)
    assert read(path, thousands=",").force[3] == 1203.0
    assert read(path, thousands=".").force[3] == 1.203
    with pytest.raises(
        InputError, match=r"thousands = ';' is not a mark between thousands; choose from ',' '\.' \"'\" ' '"
    ):
        read(path, thousands=";")


def fields(width: int) -> str:
    """Records in fields of one width, some of which touch."""
    return "".join(
        "".join(f"{value:>{width}.4f}" for value in row) + "\n" for row in damper()[:, [0, 1, 3]] * [1, 1, 10]
    )


def test_fields_of_one_width_that_touch(tmp_path: Path) -> None:
    path = tmp_path / "test.txt"
    path.write_text(fields(12))
    said = {
        "columns": {"time": 0, "displacement": 1, "force": 2},
        "units": {"time": "s", "displacement": "mm", "force": "N"},
    }
    assert "fields of" not in str(read(path, **said).history)
    path.write_text(fields(8))  # -10.0000-2754.0000 and so on: the force fills its field and more
    with pytest.raises(
        FileError, match=r"line \d+ is .*: numbers touch, and no width of a field parts all lines into numbers"
    ):
        read(path, **said)
    path.write_text(fields(10))
    record: Record = read(path, **said)
    assert "fields of 10 characters" in record.history
    assert record.force == pytest.approx(10 * damper()[:, 3], abs=6e-5)


# ---------------------------------------------------------------------------------------------------- ground motions


def plain(decimals: int = 5) -> list[str]:
    return [f"{value:10.{decimals}f}" for value in ground()]


def named() -> str:
    a = ground()
    v = np.cumsum(a) * DT * STANDARD_GRAVITY
    rows = np.column_stack([DT * np.arange(SAMPLES), a, v, np.cumsum(v) * DT])
    head = ["\ufeffTime [s],Acceleration [g],Velocity [m/s],Displacement [m]"]
    return table(head, rows, ["{:.2f}", "{:.5f}", "{:.6f}", "{:.6f}"])


PAIRS = np.column_stack([DT * np.arange(SAMPLES), ground()])
SEMICOLONS = "Time (s);Acceleration (g)\n" + table([], PAIRS, ["{:.2f}", "{:.5f}"], ";").replace(".", ",")
EL_CENTRO = f"# X\n# {SAMPLES} points at equal spacing of 0.01 sec\n# The units are (g)\n"


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (lambda: in_rows(plain(), 8), {"units": "g", "dt": DT}),
        (lambda: EL_CENTRO + in_rows(plain(), 8), {}),
        (lambda: in_rows([f"{value:+.3E}" for value in ground()], 6), {"units": "g", "dt": DT}),
        (lambda: SEMICOLONS, {}),
        (named, {}),
        (lambda: named().replace("Acceleration", "Horizontal"), {"columns": {"acceleration": "Horizontal"}}),
        (lambda: "X\n1203 0.0100\n" + "\n".join(f"{value:.6e}" for value in ground()), {"units": "g"}),
        (lambda: "1203 0.0100\n" + in_rows(plain(), 8), {"units": "g"}),
        (lambda: "\n".join(f"{value:.5f}" for value in ground()).replace(".", ","), {"units": "g", "dt": DT}),
        (lambda: "\n".join(f"{value:.5f}" for value in ground()), {"units": {"acceleration": "g"}, "dt": DT}),
        (lambda: table(["t [ms];a [gal]"], PAIRS * [1e3, 980.665], ["{:.0f}", "{:.7f}"], ";"), {}),
        (lambda: table(["t [s];counts"], PAIRS / [1, 1e-5], ["{}", "{:.0f}"], ";"),
         {"columns": {"acceleration": "counts"}, "factors": {"acceleration": "1e-5 g"}}),
    ],
    ids=["8 values a line", "El Centro", "touching", "semicolons", "four columns", "a column by its name", "count and step",
         "count, step and 8 a line", "one column of commas", "one column", "ms and gal", "counts"],
)  # fmt: skip
def test_a_ground_motion_of_the_field_gives_its_peak(
    tmp_path: Path, text: Callable[[], str], options: dict[str, Any]
) -> None:
    path = tmp_path / "motion.dat"
    path.write_text(text(), encoding="utf-8")
    motion = ground_motions.read(path, **options)
    assert (motion.n, motion.dt) == (SAMPLES, DT)
    rounding = 6e-4 * PGA if "+" in path.read_text()[:9] else 1e-9
    assert motion.acceleration / STANDARD_GRAVITY == pytest.approx(ground(), abs=rounding)
    assert motion.pga / STANDARD_GRAVITY == pytest.approx(PGA, abs=rounding)


def test_what_was_taken_stands_in_the_history(tmp_path: Path) -> None:
    path = tmp_path / "motion.dat"
    path.write_text(in_rows(plain(), 8))
    assert ground_motions.read(path, units="g", dt=DT).history == ("8 values a line, read line by line",)
    with pytest.raises(
        InputError, match="columns names 'force', which is not a channel; choose from time, acceleration"
    ):
        ground_motions.read(path, columns={"force": 1})
    with pytest.raises(FileError, match=r"no column is the acceleration \(there: 8 columns without names, 0 to 7\)"):
        ground_motions.read(path, units="g", columns={"time": 0})


def test_a_motion_with_uneven_times_takes_its_step_from_the_call(tmp_path: Path) -> None:
    path = tmp_path / "motion.csv"
    times = np.floor(PAIRS[:, 0] * 50) / 50  # a clock of 20 ms
    path.write_text(table(["time [s],acceleration [g]"], np.column_stack([times, PAIRS[:, 1]]), ["{:.2f}", "{:.5f}"]))
    with pytest.raises(
        FileError, match=r"time does not increase .*or give the step in the place of the times: --dt 0.01"
    ):
        ground_motions.read(path)
    motion = ground_motions.read(path, dt=0.01)
    assert (motion.dt, motion.n) == (0.01, SAMPLES)
    assert motion.history == ("time from the sampling interval, 0.01 s, in the place of the stamps 'time'",)


def test_a_sine_is_ten_millimetres() -> None:
    assert np.ptp(damper()[:, 1]) == pytest.approx(2 * A)
