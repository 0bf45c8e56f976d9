"""The walk through the Python face, docs/tutorials/python.ipynb, runs as a notebook runs it, and every picture shows something.

A cell's last expression is shown as a notebook does, unless a semicolon ends it. With ``DAMPYR_NOTEBOOK_PAGE=walk.html`` all
that was shown is written to a page, to look at.
"""

from __future__ import annotations

import ast
import base64
import json
import os
import re
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

NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "tutorials" / "python.ipynb"
BLANK = 0.005  # of a picture's pixels: fewer dark ones are an empty frame


def cells(kind: str = "") -> list[dict[str, Any]]:
    """The cells of the notebook, or those of one kind."""
    return [
        each for each in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"] if kind in ("", each["cell_type"])
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


def test_no_output_is_stored() -> None:
    assert not [each["id"] for each in cells("code") if each["outputs"] or each["execution_count"] is not None]


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
            assert "0x" not in repr(value), cell["id"]
            if hasattr(value, "_summary"):
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
