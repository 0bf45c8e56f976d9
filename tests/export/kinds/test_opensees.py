"""The materials that are written for OpenSees, in chapter 5's building under El Centro."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.export.opensees_process import FIRST_FLOOR, model
from tests.invariants.test_every_part import typical

import dampyr as dp
from dampyr.errors import InputError
from dampyr.export import export
from dampyr.models import Damper, Interpolation
from dampyr.studies import raminelli_2020


@pytest.mark.usefixtures("opensees")
def test_the_text_gives_chapter_5_within_half_a_per_cent(tmp_path: Path) -> None:
    """With steps of 5 ms, the motion's 20 ms in four."""
    python, _ = export(raminelli_2020.damper(), "opensees", tmp_path, inputs=[0.0, 1.98])
    answer = model(0.005, text=str(python), voltage=0.0)
    assert 1e3 * answer["peaks"][0] == pytest.approx(FIRST_FLOOR, rel=5e-3)


@pytest.mark.prove
@pytest.mark.usefixtures("opensees")
def test_the_text_gives_the_response_at_another_voltage(tmp_path: Path) -> None:
    python, _ = export(raminelli_2020.damper(), "opensees", tmp_path, inputs=[0.0, 1.98])
    expected = dp.structures.respond(
        dp.structures.two_storey(), dp.ground_motions.el_centro(), {1: raminelli_2020.damper()}, voltage=1.98
    )
    fine = model(0.001, text=str(python), voltage=1.98)
    np.testing.assert_allclose(fine["peaks"], expected.peak_displacement, rtol=5e-3)


def test_one_material_for_each_node_of_the_laws(tmp_path: Path) -> None:
    laws = {"dahl.kx": Interpolation((0.0, 1.0, 3.0), (500.0, 600.0, 700.0)), "dahl.kw": 50.0, "dahl.rho": 900.0}
    python, tcl = export(Damper("dahl", laws), "opensees", tmp_path, name="mine")
    text = python.read_text()
    assert [float(u) for u in re.findall(r"^    ([\d.]+): \{", text, re.MULTILINE)] == [0.0, 1.0, 3.0]
    assert tcl.read_text().count("uniaxialMaterial BoucWen") == 3
    assert "backward Euler" in text
    assert "'beta': 900.0" in text
    with pytest.raises(ValueError, match=r"voltage = 2 V has no material; choose from 0.0, 1.0, 3.0 V"):
        exec(text + "\ndefine(None, 1, 2)", {})
    if shutil.which("tclsh"):
        script = "proc uniaxialMaterial {args} {puts $args}\n" + tcl.read_text()
        shown = subprocess.run(["tclsh"], input=script, capture_output=True, text=True, check=True).stdout
        assert shown.splitlines()[2].split() == ["Parallel", "1", "2", "3"]


def test_bouc_wen_in_opensees_letters(tmp_path: Path) -> None:
    """The rate of z of the exported letters is that of the normalised equation."""
    values = {"c0": 600.0, "k0": 90.0, "kw": 120.0, "rho": 800.0, "sigma": 0.7, "n": 1.6}
    damper = Damper("bouc_wen + spring", {**{f"bouc_wen.{k}": v for k, v in values.items()}, "spring.k0": 10.0})
    python, _ = export(damper, "opensees", tmp_path)
    names: dict[str, Any] = {}
    exec(python.read_text(), names)
    m = next(iter(names["MATERIALS"].values()))
    assert (m["ko"], m["E"], m["eta"], m["n"]) == (120.0, 100.0, 600.0, 1.6)
    for z in (-0.8, 0.3):
        for v in (-0.05, 0.02):
            theirs = (m["Ao"] - abs(z) ** m["n"] * (m["gamma"] + m["beta"] * np.sign(v * z))) * v
            s, rho, n = values["sigma"], values["rho"], values["n"]
            ours = rho * (v - s * abs(v) * abs(z) ** (n - 1) * z + (s - 1) * v * abs(z) ** n)
            assert theirs == pytest.approx(ours, rel=1e-12)


def test_a_model_without_a_material_is_refused(tmp_path: Path) -> None:
    for name, words in (
        ("lugre", "lugre has no material"),
        ("dahl + compliance", "compliance has no material"),
        ("spring", "no such part"),
    ):
        with pytest.raises(InputError, match=f"{words}.*dampyr serve CARD --opensees PORT"):
            export(Damper(name, typical(name)), "opensees", tmp_path / "new")
    with pytest.raises(InputError, match="calibrated"):
        export(raminelli_2020.damper(), "opensees", tmp_path / "new", inputs=[9.0])
    assert not (tmp_path / "new").exists()
