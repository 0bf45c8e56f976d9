"""The notebooks of docs/tutorials run as a notebook runs them, and every picture shows something.

python.ipynb is the walk through the Python face; first-damper.ipynb is written by `make docs` from the page of that name.

A cell's last expression is shown as a notebook does, unless a semicolon ends it. With ``DAMPYR_NOTEBOOK_PAGE=walk.html`` all
that was shown is written to a page, to look at.
"""

from __future__ import annotations

import ast
import base64
import json
import os
import re
import subprocess
import sys
import warnings
from collections.abc import Iterator
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from dampyr.errors import DampyrWarning
from dampyr.shown import Shown

TUTORIALS = Path(__file__).resolve().parents[2] / "docs" / "tutorials"
NOTEBOOK, FIRST = TUTORIALS / "python.ipynb", TUTORIALS / "first-damper.ipynb"
BLANK = 0.005  # of a picture's pixels: fewer dark ones are an empty frame


def cells(kind: str = "", notebook: Path = NOTEBOOK) -> list[dict[str, Any]]:
    """The cells of the notebook, or those of one kind."""
    return [
        each for each in json.loads(notebook.read_text(encoding="utf-8"))["cells"] if kind in ("", each["cell_type"])
    ]


def shown_by(source: str, names: dict[str, Any]) -> Any:
    """Run a cell; what its last expression gives, or None where a semicolon ends it."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    if last is None:
        return None
    value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    return None if source.rstrip().endswith(";") else value


def as_html(value: Any) -> str:
    """As a notebook would show it."""
    return value._repr_html_() if hasattr(value, "_repr_html_") else f"<pre>{escape(repr(value))}</pre>"


@pytest.fixture
def pyplot() -> Iterator[Any]:
    """Matplotlib without a screen."""
    from matplotlib import pyplot

    before = pyplot.get_backend()
    pyplot.switch_backend("agg")
    yield pyplot
    pyplot.close("all")
    pyplot.switch_backend(before)


def pictures(pyplot: Any) -> list[bytes]:
    """The figures that a cell has made, as PNG; none of them is blank."""
    files = []
    for number in pyplot.get_fignums():
        figure, file = pyplot.figure(number), BytesIO()
        figure.savefig(file, format="png", dpi=100)
        pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]
        assert np.mean(np.any(pixels < 250, axis=-1)) > BLANK
        files.append(file.getvalue())
    pyplot.close("all")
    return files


@pytest.mark.parametrize("notebook", sorted(TUTORIALS.glob("*.ipynb")), ids=lambda path: path.stem)
def test_no_output_is_stored(notebook: Path) -> None:
    code = cells("code", notebook)
    assert code
    assert not [each["id"] for each in code if each["outputs"] or each["execution_count"] is not None]


@pytest.mark.by_hand  # its cells are those of the page, which tests/test_docs.py runs
def test_the_first_tutorial_runs_as_a_notebook(
    campaign_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its data come from this machine; what its comments say is printed is tried on the page (tests/test_docs.py)."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", os.environ["PATH"])  # the first cell changes it
    names: dict[str, Any] = {}
    commands = 0
    for cell in cells("code", FIRST):
        source = "".join(cell["source"])
        if not source.startswith("!"):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DampyrWarning)
                exec(compile(source, cell["id"], "exec"), names)
            continue
        for line in source.splitlines():
            command = line.removeprefix("!dampyr ")
            assert command != line, line
            if command.startswith("datasets fetch"):
                command += f" --from '{campaign_folder}'"
            done = subprocess.run(
                f"'{sys.executable}' -m dampyr {command}", shell=True, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, f"{line}\n{done.stderr}"
            commands += 1
    assert commands >= 9
    assert capsys.readouterr().out.splitlines() == ["True", "8.7"]
    assert {"dahl.toml", "dahl.html", "building.html", "better.toml"} <= {each.name for each in tmp_path.iterdir()}


@pytest.mark.prove
def test_the_walk_runs_and_shows_what_it_says(
    pyplot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    names: dict[str, Any] = {}
    page, drawn, tables = ["<meta charset='utf-8'>"], 0, 0
    for cell in cells():
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            page.append(f"<pre style='font-family:serif'>{escape(source)}</pre>")
            continue
        page.append(f"<pre style='background:#eee'>{escape(source)}</pre>")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)
            value = shown_by(source, names)
        printed, images = capsys.readouterr().out, pictures(pyplot)
        assert ".plot" not in source or images, f"{cell['id']} draws nothing"
        page += [f"<pre>{escape(printed)}</pre>"] * bool(printed)
        if value is not None:
            html = as_html(value)
            assert not re.search(r"\b0x[0-9a-f]+", repr(value)), cell["id"]  # no address; a folder may be called so
            if isinstance(value, Shown):
                ElementTree.fromstring(html)
                assert not re.search(r"<script|\bsrc=", html)
                tables += 1
            page.append(html)
        page += [f"<img src='data:image/png;base64,{base64.b64encode(each).decode()}'>" for each in images]
        drawn += len(images)
    assert drawn >= 10
    assert tables >= 10
    if target := os.environ.get("DAMPYR_NOTEBOOK_PAGE"):
        Path(target).write_text("\n".join(page), encoding="utf-8")
