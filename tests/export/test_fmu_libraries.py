"""Libraries of an FMU for other platforms: made on this one, with old C libraries, loaded wherever they can be."""

import os
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.export import export, fmu_libraries
from dampyr.export.fmu_libraries import PLATFORMS, _join_universal, check_platforms
from dampyr.studies import raminelli_2020

HERE = Path(__file__).parent
WINE = next((path for path in (shutil.which("wine64"), "/usr/lib/wine/wine64") if path and Path(path).exists()), None)
T = np.linspace(0.0, 2.0, 401)
X, U = 0.01 * np.sin(6.0 * T + 0.5 * T**2), 1.5 + 1.4 * np.sin(5.0 * T)
V = np.gradient(X, T)


def exported(folder: Path, fmi: int = 2, *platforms: str) -> dict[str, bytes]:
    """The files of an FMU of the published damper."""
    [path] = export(raminelli_2020.damper(), "fmu", folder, fmi=fmi, platforms=platforms)
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def glibc(library: bytes) -> list[tuple[int, ...]]:
    """The versions of glibc that a library asks for, rising."""
    return sorted(tuple(map(int, found.split(b"."))) for found in set(re.findall(rb"GLIBC_([\d.]+)\0", library)))


@pytest.mark.prove
@pytest.mark.skipif(sys.platform != "linux", reason="its library is loaded on Linux")
def test_the_linux_one_asks_for_an_old_glibc_and_has_the_force_of_dampyr(tmp_path: Path) -> None:
    import fmpy

    files = exported(tmp_path, 2, "linux64")
    needed = glibc(files["binaries/linux64/damper.so"])
    assert needed
    assert needed[-1] <= (2, 17)
    signals = np.rec.fromarrays([T, X, V, U], names=["time", "displacement", "velocity", "voltage"])
    result = fmpy.simulate_fmu(
        str(tmp_path / "damper.fmu"), start_time=0.0, stop_time=T[-1], step_size=T[1], output_interval=T[1],
        input=signals, output=["force"],
    )  # fmt: skip
    force = raminelli_2020.damper().force(T, X, velocity=V, voltage=U)
    np.testing.assert_allclose(result["force"][2:], force[1:-1], rtol=0.0, atol=1e-9 * np.abs(force).max())


@pytest.mark.prove
@pytest.mark.parametrize("fmi", [2, 3])
def test_all_platforms_are_made_here(tmp_path: Path, fmi: int) -> None:
    """By the first bytes and the exported names of each: a Windows DLL, macOS libraries of two processors, Linux ones."""
    files = exported(tmp_path, fmi, "all")
    libraries = {name.removeprefix("binaries/"): data for name, data in files.items() if name.startswith("binaries/")}
    step = b"fmi2DoStep" if fmi == 2 else b"fmi3DoStep"
    assert all(step in data for data in libraries.values())
    if fmi == 2:
        assert set(libraries) == {"linux64/damper.so", "win64/damper.dll", "darwin64/damper.dylib"}
        mark, count = struct.unpack(">II", libraries["darwin64/damper.dylib"][:8])
        assert (mark, count) == (0xCAFEBABE, 2)
        for k, kind in enumerate((0x01000007, 0x0100000C)):
            processor, _, begin, size, _ = struct.unpack(">5I", libraries["darwin64/damper.dylib"][8 + 20 * k :][:20])
            part = libraries["darwin64/damper.dylib"][begin : begin + size]
            assert processor == kind
            assert struct.unpack("<II", part[:8]) == (0xFEEDFACF, kind)
            assert step in part
    else:
        assert set(libraries) == {
            "x86_64-linux/damper.so", "x86_64-windows/damper.dll", "x86_64-darwin/damper.dylib",
            "aarch64-darwin/damper.dylib", "aarch64-linux/damper.so",
        }  # fmt: skip
        assert glibc(libraries["aarch64-linux/damper.so"])[-1] <= (2, 17)
    assert next(data for name, data in libraries.items() if "win" in name and name.endswith("dll"))[:2] == b"MZ"
    assert b"python" not in b"".join(libraries.values()).lower()


@pytest.mark.prove
@pytest.mark.skipif(WINE is None, reason="Wine is missing")
def test_the_windows_one_runs_in_wine_with_the_force_of_dampyr(tmp_path: Path) -> None:
    files = exported(tmp_path, 2, "win64")
    (tmp_path / "damper.dll").write_bytes(files["binaries/win64/damper.dll"])
    token = re.search(r'guid="([^"]+)"', files["modelDescription.xml"].decode())
    assert token is not None
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", "-O2", "-s"]
    subprocess.run([*compiler, str(HERE / "windows_master.c"), "-o", "master.exe"], cwd=tmp_path, check=True)
    run = subprocess.run(
        [str(WINE), "master.exe", "damper.dll", token[1]],
        cwd=tmp_path,
        input="\n".join(
            f"{t!r} {x!r} {v!r} {u!r}" for t, x, v, u in zip(*map(np.ndarray.tolist, (T, X, V, U)), strict=True)
        ),
        env=os.environ | {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stdout[:300] + run.stderr[:300]
    force = raminelli_2020.damper().force(T, X, velocity=V, voltage=U)
    np.testing.assert_allclose(
        np.array(run.stdout.split(), dtype=float), force, rtol=0.0, atol=1e-9 * np.abs(force).max()
    )


def test_a_universal_library_holds_each_part_whole() -> None:
    parts = [((7, 3), b"first" * 5000), ((12, 0), b"second")]
    joined = _join_universal(parts)
    assert struct.unpack(">II", joined[:8]) == (0xCAFEBABE, 2)
    for k, (processor, library) in enumerate(parts):
        *kind, begin, size, alignment = struct.unpack(">5I", joined[8 + 20 * k :][:20])
        assert tuple(kind) == processor
        assert begin % (1 << alignment) == 0
        assert joined[begin : begin + size] == library


@pytest.mark.parametrize(
    ("platforms", "fmi", "words"),
    [
        (("win32",), 2, "platform 'win32' is not known; choose from linux64, win64, darwin64, linux-arm64, all"),
        (("linux-arm64",), 2, "FMI 2.0 has no name for linux-arm64; write FMI 3"),
    ],
)
def test_a_platform_that_cannot_be_named_is_refused(platforms: tuple[str, ...], fmi: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        check_platforms(platforms, fmi)


def test_names_are_checked_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="platforms = 'win64' is one name; give a list"):
        export(raminelli_2020.damper(), "fmu", tmp_path / "none", platforms="win64")
    assert not (tmp_path / "none").exists()
    pytest.importorskip("ziglang", reason="Zig's C compiler is missing; pip install 'dampyr[fmu]'")
    assert check_platforms(["win64", "win64", "linux64"], 2) == ("win64", "linux64")
    assert check_platforms(["all"], 2) == ("linux64", "win64", "darwin64")
    assert check_platforms(["all"], 3) == tuple(PLATFORMS)


def test_what_is_missing_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fmu_libraries, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r'need Zig.s C compiler; install it: pip install "dampyr\[fmu\]"'):
        check_platforms(["win64"], 2)
    monkeypatch.setattr(fmu_libraries, "_find_compiler", lambda: None)
    with pytest.raises(InputError, match="an FMU needs a C compiler, and none is installed"):
        check_platforms([], 2)
