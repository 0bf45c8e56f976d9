"""Forty files and more that are made to harm: each is refused in a sentence, beside it others are answered, nothing is left."""

from __future__ import annotations

import gzip
import io
import pickle
import struct
import threading
import time
import zipfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pytest
import scipy.io

pytest.importorskip("fastapi")
pytest.importorskip("openpyxl")
import httpx
from tests.console.conftest import served_here
from tests.console.memory import resident
from tests.console.record_files import BARE, CSV, ROWS, everything, made, unfolding
from tests.records.test_self_contained import PLANTS, planted

from dampyr import records
from dampyr.models import Damper

WAIT = 10.0  # s that another request may take meanwhile
GROWTH = 400.0  # MiB that the server itself may grow by over all of them
LONGEST = 30.0  # s until a file is refused
SENTENCE = 700  # characters
KIND = {"content-type": "application/octet-stream"}
SHEET = (
    '<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>{}</sheetData></worksheet>'
)
XML = {
    "[Content_Types].xml": '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="xml" ContentType="application/xml"/><Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Override PartName="/xl/workbook.xml" '
    'ContentType="application/vnd.openxmlformats-officedocument.spreadsheetml.sheet.main+xml"/>'
    '<Override PartName="/xl/worksheets/sheet1.xml" '
    'ContentType="application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml"/></Types>',
    "_rels/.rels": '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r" '
    'Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/officeDocument" Target="xl/workbook.xml"/>'
    "</Relationships>",
    "xl/workbook.xml": '<workbook xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main" '
    'xmlns:r="http://schemas.openxmlformats.org/officeDocument/2006/relationships"><sheets>'
    '<sheet name="s" sheetId="1" r:id="s1"/></sheets></workbook>',
    "xl/_rels/workbook.xml.rels": '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Id="s1" Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/worksheet" '
    'Target="worksheets/sheet1.xml"/></Relationships>',
}


def workbook(sheet: str, prologue: str = "", repeated: int = 1) -> bytes:
    """An .xlsx file with one sheet: the rows in ``sheet``, ``repeated`` times, written as they come."""
    page = io.BytesIO()
    head, tail = SHEET.split("{}")
    with zipfile.ZipFile(page, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in XML.items():
            archive.writestr(name, text)
        with archive.open("xl/worksheets/sheet1.xml", "w", force_zip64=True) as part:
            part.write((prologue + head).encode())
            for _ in range(repeated):
                part.write(sheet.encode())
            part.write(tail.encode())
    return page.getvalue()


def lying_workbook() -> bytes:
    """A sheet of 60 MB of which the archive's directory says that it has 1 kB."""
    content = bytearray(workbook("<row><c><v>1</v></c></row>" * 40_000, repeated=60))
    with zipfile.ZipFile(io.BytesIO(bytes(content))) as archive:
        [part] = [part for part in archive.infolist() if part.filename.endswith("sheet1.xml")]
    true = struct.pack("<I", part.file_size)
    return bytes(content).replace(true, struct.pack("<I", 1000))


ENTITIES = "<!DOCTYPE x [" + "".join(
    f'<!ENTITY e{k} "{f"&e{k - 1};" * 10 if k else "ha" * 20}">' for k in range(12)
) + "]>"  # fmt: skip
OUTSIDE = '<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>'
ROW = '<row><c t="inlineStr"><is><t>{}</t></is></c></row>'


def mat(**variables: Any) -> bytes:
    """A MATLAB file, version 5."""
    page = io.BytesIO()
    scipy.io.savemat(page, variables)
    return page.getvalue()


def header_of_mat(size: int) -> bytes:
    """A MATLAB file whose first element says that it has so many bytes."""
    return b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HHIi", 0x0100, 0x4D49, 14, size) + b"\0" * 400


def tdms(size: int) -> bytes:
    """A TDMS file whose segment says that it has so many bytes."""
    return b"TDSm" + struct.pack("<iiqq", 0x0E, 4713, size, size) + b"\xff" * 200


def written(folder: Path, suffix: str) -> bytes:
    """A good record as a file of this kind."""
    path = folder / f"good.{suffix}"
    records.write(records.with_velocity(made()), path)
    return path.read_bytes()


def hostile_records(folder: Path) -> Iterator[tuple[str, bytes | str, dict[str, Any]]]:
    """Name, content and what is said of each."""
    nothing: dict[str, Any] = {}
    cell = "<row><c><v>1</v></c><c><v>2</v></c></row>"
    yield "600 MB of sheet.xlsx", workbook(cell * 50_000, repeated=300), nothing
    yield "lies.xlsx", lying_workbook(), nothing
    yield "entities.xlsx", workbook(ROW.format("&e11;"), ENTITIES), nothing
    yield "outside.xlsx", workbook(ROW.format("&e;") * 9, OUTSIDE), nothing
    yield "deep.xlsx", workbook("<row>" * 100_000), nothing
    yield "csv in disguise.xlsx", CSV, nothing
    yield "cut.xlsx", workbook(cell * 500)[:-400], nothing
    for k, (name, plant) in enumerate(PLANTS.items()):
        (place := folder / str(k)).mkdir()
        yield f"{name.replace('/', ' ')}.h5", planted(place / "test.h5", plant).read_bytes(), nothing
    yield "unfolds.h5", unfolding(), nothing
    good = written(folder, "h5")
    yield "cut.h5", good[: len(good) // 2], nothing
    yield "polyglot.h5", b"<html><script>alert(1)</script>" + good, nothing
    yield "objects.mat", mat(Ts=0.01, dist=np.array([[{"a": 1}]], dtype=object), forc=np.zeros(20)), nothing
    yield "negative.mat", header_of_mat(-1), nothing
    yield "endless.mat", header_of_mat(2**31 - 8), nothing
    yield "pickle.mat", pickle.dumps(print), nothing
    yield "negative.tdms", tdms(-5), nothing
    yield "endless.tdms", tdms(2**62), nothing
    yield "pickle.parquet", b"PAR1" + pickle.dumps(print) + struct.pack("<i", -9) + b"PAR1", nothing
    yield "endless.parquet", b"PAR1" + b"\0" * 90 + struct.pack("<I", 2**31) + b"PAR1", nothing
    yield (
        "dimensions.nc",
        b"CDF\x01" + struct.pack(">iiii4si", 0, 10, 1, 4, b"time", -7) + b"\xff" * 80,
        nothing,
    )
    yield (
        "counts.uff",
        f"{'    -1':80}\n{'    58':80}\n" + "x\n" * 5 + f"{'1 0 1 0 NONE':80}\n" * 2 + "-999999999 " * 9,
        nothing,
    )
    yield "deep.lvm", "LabVIEW Measurement\t\n" + "Separator\tTab\n" * 100_000, nothing
    yield "wide.csv", "1," * 1_000_000 + "1\n", nothing
    yield "one line.csv", "1" * 20_000_000, nothing
    yield "zero.csv", CSV.replace("0.5", "0\0.5"), nothing
    yield "binary.csv", bytes(range(256)) * 4000, nothing
    yield "gzip.csv", gzip.compress(b"1,2,3\n" * 10_000_000), nothing
    yield "words.csv", "a word, another\n" * 1_000_000, nothing
    yield "brackets.csv", "[(" * 100_000 + "\n" + BARE, nothing
    yield "large.csv", CSV.replace("force [N]\n", "force [N]\n0,1e400,-1e400\n"), nothing
    yield "larger.csv", CSV.replace("[mm]", "[m]").replace("8.0", "9e307"), nothing
    yield (
        "backwards.csv",
        "time [s],displacement [mm],force [N]\n" + "".join(f"{-k},{x},{f}\n" for k, x, f in ROWS),
        nothing,
    )
    yield "utf-16 without a mark.csv", CSV.encode("utf-16-le"), nothing
    yield "escapes.csv", CSV, {"encoding": "unicode_escape", "column": ["force=\\x00"]}
    yield "codec.csv", CSV, {"encoding": "zlib_codec"}
    yield "values.csv", CSV, {"factor": ["force=1e400"], "dt": -1e300}
    yield "html.csv", "<script>alert(1)</script>,<img src=x onerror=alert(2)>\n" + BARE.replace(",", "<b>,"), nothing
    yield "empty.txt", b"", nothing
    for name in (
        "../../up.csv",
        "..\\up.csv",
        "con.csv",
        "NUL.txt",
        "a\n.csv",
        "\u202egnp.csv",
        "a" * 300 + ".csv",
        ".hidden.csv",
        "x.csv\0.h5",
    ):
        yield name, CSV, nothing


STRUCTURE = 'kind = "matrices"\n'


def hostile_files(good_card: str) -> Iterator[tuple[str, str, bytes | str]]:
    """Kind, name and content of each that Building would keep."""
    for kind in ("cards", "structures"):
        yield kind, "nested.toml", "a = " + "[" * 200_000 + "]" * 200_000
        yield kind, "tables.toml", "".join(f"[{'a.' * 60}b{k}]\n" for k in range(2000))
        yield kind, "dotted.toml", f"{'a.' * 100_000}b = 1\n"
        yield kind, "huge.toml", "x = [" + "1.0," * 8_000_000 + "]\n"
        yield kind, "digits.toml", "x = " + "9" * 2_000_000 + "\n"
        yield kind, "zero.toml", "a = 1\0\n"
        yield kind, "latin.toml", "name = 'Dämpfer'\n".encode("latin-1")
        yield kind, "html.toml", 'name = "<script>alert(1)</script>"\n'
        yield kind, "con.toml", good_card
        yield kind, "../up.toml", good_card
        yield kind, "link.toml", good_card
    yield "cards", "code.toml", good_card.replace('"dahl"', "\"__import__('os').abort()\"")
    yield "cards", "values.toml", good_card.replace("900.0", "inf")
    yield "cards", "cut.toml", good_card[: len(good_card) // 2]
    yield (
        "structures",
        "outside.toml",
        'M = { file = "/etc/passwd" }\nC = { file = "/etc/passwd" }\nK = { file = "/etc/passwd" }\n',
    )
    yield "structures", "above.toml", 'M = { file = "../../etc/passwd" }\nC = [[1.0]]\nK = [[1.0]]\n'
    yield "structures", "negative.toml", "M = [[-1.0]]\nC = [[0.0]]\nK = [[-5e300]]\n"
    yield "motions", "endless.at2", "a\nb\nc\nNPTS= 999999999999, DT= .0000001 SEC\n" + "1.0 " * 50
    yield "motions", "negative.at2", "a\nb\nc\nNPTS= -5, DT= -.01 SEC\n" + "1.0 " * 50
    yield "motions", "words.csv", "a word, another\n" * 1_000_000
    yield "motions", "binary.csv", bytes(range(256)) * 4000
    yield "motions", "large.csv", "time [s],acceleration [m/s^2]\n" + "".join(f"{k / 100},1e400\n" for k in range(300))
    yield "motions", "page.html", "<script>alert(1)</script>"


class Others(threading.Thread):
    """Another page, which asks for something light again and again."""

    PATHS = ("/api/records/list", "/api/building/choices", "/api/console")

    def __init__(self, address: str) -> None:
        super().__init__(daemon=True)
        self.address, self.ended, self.longest, self.count = address, threading.Event(), 0.0, 0

    def run(self) -> None:
        with httpx.Client(base_url=self.address, timeout=120) as client:
            while not self.ended.is_set():
                for path in self.PATHS:
                    begun = time.monotonic()
                    assert client.get(path).status_code == 200
                    self.longest, self.count = max(self.longest, time.monotonic() - begun), self.count + 1
                self.ended.wait(0.05)


def faults(answer: httpx.Response, data: Path, before: list[str]) -> Iterator[str]:
    """What is wrong with the answer to a hostile file."""
    is_json = answer.headers["content-type"].startswith("application/json")
    detail = answer.json().get("detail", "") if is_json else ""
    if not (400 <= answer.status_code < 500 and 8 < len(detail) <= SENTENCE):
        yield f"{answer.status_code} {answer.text[:200]}"
    if any(secret in answer.text for secret in (str(data), "Traceback", "root:", "password", "incoming-")):
        yield f"tells {answer.text[:200]}"
    if (took := answer.elapsed.total_seconds()) > LONGEST:
        yield f"{took:.0f} s"
    if (left := everything(data)) != before:
        yield f"left {sorted(set(left) ^ set(before))}"


def send_without_end(client: httpx.Client) -> None:
    """Bodies of which the length is not announced: the console answers at its limit and hangs up."""
    sent = 0

    def endless() -> Iterator[bytes]:
        nonlocal sent
        while sent < 2000:
            sent += 1
            yield b"1,2,3\n" * 100_000

    for path in ("records/uploads/endless.csv", "building/files/cards/endless.toml"):
        with suppress(httpx.TransportError):
            assert client.put(f"/api/{path}", content=endless(), headers=KIND).status_code == 413
        assert sent < 2000


@pytest.mark.prove
def test_hostile_files_are_refused_in_a_sentence_while_others_are_answered(data: Path, tmp_path: Path) -> None:
    records.write(made(), data / "good.h5")
    Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 3000.0}).save(tmp_path / "secret.toml")
    card = (tmp_path / "secret.toml").read_text("utf-8")
    for kind in ("cards", "structures"):
        (data / kind).mkdir()
        (data / kind / "link.toml").symlink_to(tmp_path / "secret.toml")
    (work := tmp_path / "work").mkdir()
    uploads = [(f"records/uploads/{quote(name, safe='')}", *rest) for name, *rest in hostile_records(work)]
    files = [(f"building/files/{kind}/{quote(name, safe='')}", text, {}) for kind, name, text in hostile_files(card)]
    before, wrong = everything(data), []
    with served_here(data) as address, httpx.Client(base_url=address, timeout=120) as client:
        for path in Others.PATHS:  # the first ones load what they need
            assert client.get(path).status_code == 200
        start, others = resident(), Others(address)
        others.start()
        for path, content, said in [*uploads, *files]:
            answer = client.put(f"/api/{path}", content=content, params=said, headers=KIND)
            wrong += [f"{path}: {fault}" for fault in faults(answer, data, before)]
        send_without_end(client)
        grown = resident() - start
        others.ended.set()
        others.join(60)
    assert wrong == []
    assert everything(data) == before
    assert len(uploads) + len(files) >= 80
    assert others.count > 20
    assert others.longest < WAIT
    assert grown < GROWTH
    assert (tmp_path / "secret.toml").read_text("utf-8") == card
