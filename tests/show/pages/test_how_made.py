"""A page says when, by what command, by which version and from which files it was made."""

import hashlib
import re
from datetime import datetime
from pathlib import Path

import pytest
from click.testing import CliRunner
from tests.identification.synthetic import sine
from tests.show.pages.test_html_page import Reader

from dampyr import records
from dampyr.cli import cli
from dampyr.ground_motions import el_centro
from dampyr.models import Damper, Interpolation
from dampyr.origin import combined
from dampyr.show.pages.how_made import how_made, made_by, moment
from dampyr.show.pages.result_page import write_page
from dampyr.source_digest import full_version
from dampyr.source_file import source_file

CARD = Damper(
    "dahl",
    {"dahl.kx": Interpolation((0.0, 2.0), (800.0, 1800.0)), "dahl.kw": 200.0, "dahl.rho": 3000.0},
    provenance={"dampyr": "0.1.0"},
)


def facts(html: str) -> dict[str, str]:
    reader = Reader(html)
    values = [" ".join(part.split()) for part in re.findall(r"<dd[^>]*>(?:<code>)?(.*?)(?:</code>)?</dd>", html)]
    return dict(zip(reader.inside("dt"), values, strict=True))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A card, and two records of a named damper."""
    CARD.save(tmp_path / "mine.toml")
    for k in range(2):
        one = sine(CARD, 1.0, f"r{k}", 0.005, 1.2, noise=1.0, seed=k)
        one = one.replace(note="named", specimen="RD 8041-1, no. 7", provenance={"operator": "A. Ferreira"})
        records.write(one, tmp_path / f"r{k}.h5")
    return tmp_path


@pytest.mark.usefixtures("figures_not_rendered")
def test_a_command_leaves_its_own_words_the_moment_the_version_and_the_checksums(folder: Path) -> None:
    words = ["validate", str(folder / "mine.toml"), str(folder / "r0.h5"), str(folder / "r1.h5")]
    words += ["--report", str(folder / "a page.html")]
    assert CliRunner().invoke(cli, words, catch_exceptions=False).exit_code == 0
    html = (folder / "a page.html").read_text("utf-8")
    shown = facts(html)
    assert shown["command"] == f"dampyr {' '.join(words[:-1])} &#39;{words[-1]}&#39;"
    at, _, version = shown["made"].partition(" by dampyr ")
    assert version == full_version()
    assert abs((datetime.fromisoformat(at) - datetime.now().astimezone()).total_seconds()) < 60
    assert shown["earlier versions of the card"] == "dampyr 0.1.0"
    for name in ("mine.toml", "r0.h5", "r1.h5"):
        digits = hashlib.sha256((folder / name).read_bytes()).hexdigest()
        assert f'<span>{name}</span> <code>{digits[:12]}<span class="rest">{digits[12:]}</span></code>' in html
    assert shown["specimen"] == "RD 8041-1, no. 7"
    assert shown["operator"] == "A. Ferreira"
    assert re.search(r"<li>operator A. Ferreira</li>\s*<li>specimen RD 8041-1, no. 7</li>", html)


@pytest.mark.usefixtures("figures_not_rendered")
def test_a_script_of_ones_own_is_named_with_the_call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = tmp_path / "my script.py"
    script.write_text("")
    monkeypatch.setattr("sys.argv", [str(script), "7"])
    html = write_page(el_centro(), tmp_path / "m.html").read_text("utf-8")
    assert f"python '{script}' 7: dampyr.show.write_page(result, 'm.html')".replace("'", "&#39;") in html
    monkeypatch.setattr("sys.argv", [""])
    assert how_made("f()").command == "f()"
    assert how_made().command == "Python"


def test_the_moment_has_a_zone_and_can_be_fixed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert datetime.fromisoformat(moment()).tzinfo is not None
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    assert moment() == "1970-01-01T00:00:00+00:00"


def test_only_files_are_listed_and_the_request_before_comes_back(tmp_path: Path) -> None:
    (tmp_path / "there.toml").write_text("a")
    with made_by("outer"):
        with made_by("inner", [tmp_path / "there.toml", tmp_path / "published_name"]):
            assert [one.name for one in how_made().files] == ["there.toml"]
        assert how_made().command == "outer"


def test_a_record_remembers_the_file_that_it_was_read_from(folder: Path) -> None:
    one = records.read(folder / "r0.h5")
    assert one.source_file == source_file(folder / "r0.h5")
    whole = combined(record.origin for record in (one, one.until(2.0), sine(CARD, 1.0, "made", 0.005, 1.0)))
    assert whole.sources == (one.source_file,)
    records.write(one, folder / "copy.h5")
    copy = records.read(folder / "copy.h5")
    assert copy.source_file is not None
    assert copy.source_file.name == "copy.h5"
    assert dict(copy.provenance) == dict(one.provenance)


def test_many_specimens_are_counted() -> None:
    many = [sine(CARD, 1.0, f"r{k}", 0.005, 1.2).replace(note="n", specimen=f"s{k}") for k in range(8)]
    assert combined(record.origin for record in many).facts() == {"specimen": "s0, s1, s2, s3, s4, s5 and 2 more"}
    assert combined([]).facts() == {}
