"""The examples in docstrings run and give what they say, and the calls that people begin with have one."""

from __future__ import annotations

import doctest
import warnings
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

import dampyr as dp
from dampyr.errors import DampyrWarning

SOURCE = Path(dp.__file__).parent
FIRST = (
    "records.read", "records.write", "records.read_campaign", "records.measure", "models.Damper.force", "models.Damper.save",
    "models.Damper.load", "models.Damper.at", "models.published.damper", "identification.fit", "identification.score",
    "ground_motions.read", "ground_motions.kanai_tajimi", "ground_motions.spectrum", "ground_motions.measures",
    "structures.respond", "structures.shear_building", "structures.control_law", "structures.ensemble", "structures.fragility",
    "campaigns.plan", "campaigns.perform", "rig.simulated", "export.export", "units.parse",
)  # fmt: skip


def examples() -> Iterator[doctest.DocTest]:
    """Every docstring with an example."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    for path in sorted(SOURCE.rglob("*.py")):
        if ">>> " in path.read_text(encoding="utf-8"):
            parts = path.relative_to(SOURCE.parent).with_suffix("").parts
            module = import_module(".".join(part for part in parts if part != "__init__"))
            yield from (test for test in finder.find(module) if test.examples)


@pytest.mark.prove  # they compile
@pytest.mark.parametrize("example", list(examples()), ids=lambda test: test.name)
def test_an_example_gives_what_it_says(
    example: doctest.DocTest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    example.globs = {}  # a reader has nothing but what the example imports
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        failed, tried = runner.run(example)
    assert tried
    assert not failed, capsys.readouterr().out


@pytest.mark.parametrize("name", FIRST)
def test_a_call_that_people_begin_with_has_an_example(name: str) -> None:
    package, *names = name.replace("models.published", "models/published").split(".")
    value = import_module(f"dampyr.{package.replace('/', '.')}")
    for each in names:
        value = getattr(value, each)
    assert ">>> " in (value.__doc__ or "")
