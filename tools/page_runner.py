"""Follow a page of the documentation as a reader does: its commands, its Python, its files, and what these show.

tests/test_docs.py follows the pages and compares what is printed with what they say; the site (tools/make_site.py) has what
each block printed and drew below it::

    python tools/page_runner.py how-to/inverse.md OUT  # OUT/blocks.json, the figures and the pages that commands wrote
"""

from __future__ import annotations

import ast
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import asdict, dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
RUN_KINDS = ("sh", "python")
PRINTED = re.compile(r"^(print\(.*\))\s+# (.*)$", re.MULTILINE)
# Blocks of commands and of Python that are not run with their page, by the page and their first words, and why.
NOT_RUN = {
    ("README.md", "make demo"): "tests/stories/test_the_chain.py runs what it runs, and this is what make test is",
    ("docs/how-to/power.md", "avrdude"): "reads and writes the fuses of a chip",
    ("docs/how-to/add-a-model.md", "r\"\"\"A dashpot"): "test_the_model_of_the_how_to_is_a_model",
    ("docs/how-to/bench.md", "dampyr console"): "serves until it is stopped: tests/console",
    ("docs/how-to/bring-up.md", "dampyr doctor --rig"): "asks a person at a real rig; the next block is the simulated one",
    ("docs/how-to/bring-up.md", "dampyr doctor --simulated --bring-up --stand-in --out faulty.json"): (
        "a step fails: tests/rig/test_bring_up.py"
    ),
    ("docs/how-to/protocols.md", "dampyr protocol"): "of a protocol that was run: tests/campaigns/test_protocol_result.py",
    ("docs/how-to/laboratory.md", "dampyr specimens"): "of records of several days: tests/records/test_specimen_history.py",
    ("docs/how-to/laboratory.md", "dampyr run"): "asks for each damper to be mounted: tests/cli/test_run.py",
    ("docs/how-to/console.md", "pip install"): "serves until it is stopped: tests/console",
    ("docs/how-to/console.md", "dampyr console"): "serves until it is stopped: tests/console",
    ("docs/how-to/console.md", "curl"): "asks the server: tests/console/test_api.py",
    ("docs/how-to/ensembles.md", "dampyr ensemble damper.toml --synthetic 1000 --limit 12mm --cluster"): (
        "needs a cluster; on this machine tests/structures/test_cluster.py"
    ),
    ("docs/how-to/ensembles.md", "from distributed"): "needs a cluster; on this machine tests/structures/test_cluster.py",
    ("docs/how-to/export.md", "cc "): "test_the_c_of_the_how_to_compiles_and_runs",
    ("docs/how-to/firmware.md", "avrdude"): "needs an Uno",
    ("docs/how-to/firmware.md", "gcc"): "tests/rig/firmware/test_uno_binary.py compiles and runs it",
    ("docs/how-to/hybrid-test.md", "dampyr hybrid --voltage 0.8712 --dry-run"): "the run below it is planned so first",
    ("docs/how-to/opensees.md", "import mr_damper"): "a line of a model: tests/export/kinds/test_opensees.py",
    ("docs/how-to/opensees.md", "ops.element"): "a line of a model: tests/export/test_opensees_server.py",
    ("docs/how-to/opensees.md", "dampyr serve"): "serves until a model ends: tests/export/test_opensees_server.py",
    ("docs/how-to/plan-tests.md", "dampyr plan --card damper.toml --tests 3"): "tests/cli/test_examples.py runs its like",
    ("docs/how-to/plan-tests.md", "dampyr plan --card damper.toml --goal"): "tests/cli/test_examples.py runs its like",
    ("docs/how-to/plan-tests.md", "dampyr plan --card damper.toml --tests 6 --per"): "tests/cli/test_examples.py runs its like",
    ("docs/how-to/protocols.md", "dampyr run"): "tests/cli/test_judge.py and tests/campaigns/test_judgement.py",
    ("docs/how-to/rig.md", "dampyr doctor"): "needs a rig; on the simulated one tests/cli/test_doctor.py",
    ("docs/how-to/rig.md", "dampyr calibrate"): "needs a rig; on the simulated one tests/rig/test_calibration.py",
    ("docs/reference/commands.md", "dampyr accept"): "tests/cli/test_examples.py runs each of them",
    ("docs/reference/cycle-figures.md", "dampyr cycles"): "tests/cli/test_examples.py runs it",
}  # fmt: skip
# Pages that a test of their own follows, in an environment that is made for it: only the site runs them here.
FOLLOWED_ELSEWHERE = {"docs/tutorials/newcomer.md": "tests/stories/test_newcomer.py"}

# What stands for the programs of a reader's machine: the data set comes from this one, what would need a network or an hour is
# a trial, and a batch system runs its jobs one after the other.
SHELL = r"""
dampyr() {
  if [ "${1:-} ${2:-}" = "datasets fetch" ]; then set -- "$@" --from "$DATA"; fi
  "$PYTHON" -m dampyr "$@"
}
make() { command make --dry-run -C "$ROOT" "$@" > /dev/null; mkdir -p .venv/bin; : > .venv/bin/activate; }
python() { if [ "${1:-} ${2:-}" = "-m venv" ]; then mkdir -p "$3/bin"; : > "$3/bin/activate"; else "$PYTHON" "$@"; fi; }
pip() {
  [ "$1" = install ]
  "$PYTHON" -m pip install --quiet --dry-run --no-index --no-deps --no-build-isolation "${2/#./$ROOT}"
}
expect() {
  local code=0
  "${@:2}" || code=$?
  [ "$code" = "$1" ]
}
sbatch() {
  local script="${*: -1}" array tasks=1 first last
  array=$(sed -n 's/^#SBATCH --array=//p' "$script")
  case "$*" in *--array=*) array=${*#*--array=}; array=${array%% *} ;; esac
  case "$array" in
    *-*) tasks=$(seq "${array%-*}" "${array#*-}") ;;
    *,*) tasks=${array//,/ } ;;
  esac
  for task in $tasks; do
    SLURM_ARRAY_TASK_ID=$task SLURM_CPUS_PER_TASK=$(sed -n 's/^#SBATCH --cpus-per-task=//p' "$script") bash "$script" >&2
  done
  echo 4711
}
export -f dampyr
"""
PLAIN = re.compile(r"(dampyr [^|<>;&$`()]*\n)+")  # lines that ask nothing of a shell but the names of files
NEEDS_DATA = ("datasets fetch", "locate(", "labcontrol-mr-damper")
PROGRESS = re.compile(r" *\d+\.\d s  \w")
MOST_FIGURES = 2  # of a page that a command writes: the page itself is beside them
MOST_LINES = 60  # of what a block prints


@dataclass
class BlockResult:
    """What one block did: what it printed, the figures that it drew, the pages that it wrote; or why it was not run."""

    text: str = ""
    figures: list[tuple[str, str]] = field(default_factory=list)  # file, and in words what it shows
    pages: list[str] = field(default_factory=list)
    why_not: str = ""


class Desk:
    """A folder in which a reader follows a page: its commands, its Python, and what it says these print.

    ``data`` is the folder of the measured campaign. With ``out`` the figures and pages of each block are left there.
    ``strict``: what a block prints and how a command ends has to be as the page says.
    """

    def __init__(self, folder: Path, data: Path | None, out: Path | None = None, strict: bool = True) -> None:
        self.folder, self.data, self.out, self.strict = folder, data, out, strict
        self.names: dict[str, object] = {}
        self.faults: list[str] = []  # text of figures that cannot be read
        self.shown: dict[int, Any] = {}  # figures, held so that none gets the number of another

    def run(self, commands: str) -> str:
        """Lines of a shell, as a user types them; a data set is fetched from this machine. What they print.

        Lines that do nothing but call dampyr are run in this process, which has loaded it already.
        """
        if PLAIN.fullmatch(commands):
            return "".join(self.call(line) for line in commands.replace("\\\n", " ").splitlines())
        lines = re.sub(r"^(.*\S) +# exit code (\d+)$", r"expect \2 \1", commands, flags=re.MULTILINE)
        places = {"PYTHON": sys.executable, "ROOT": str(ROOT), "DATA": str(self.data)}
        done = subprocess.run(
            ["bash", "-c", f"set -euo pipefail\n{SHELL}\n{lines}"],
            cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
            env={**os.environ, **places},
        )  # fmt: skip
        assert done.returncode == 0 or not self.strict, f"{commands}\n{done.stdout[-6000:]}"
        return done.stdout

    def call(self, line: str) -> str:
        """One line that calls dampyr, and what it prints; files that it names with an asterisk are those of the folder."""
        from click.testing import CliRunner

        from dampyr.cli import cli

        expected = re.search(r"# exit code (\d+)$", line)
        words = shlex.split(line, comments=True)[1:]
        words = [each for word in words for each in (sorted(map(str, self.matching(word))) if "*" in word else [word])]
        if words[:2] == ["datasets", "fetch"]:
            words += ["--from", str(self.data)]
        done = CliRunner().invoke(cli, words, prog_name="dampyr", catch_exceptions=False)
        code = int(expected[1]) if expected else 0
        assert done.exit_code == code or not self.strict, f"{line}\n{done.output[-4000:]}"
        return done.output

    def matching(self, pattern: str) -> list[Path]:
        """The files of this name, as a shell tells them."""
        files = [path.relative_to(self.folder) for path in self.folder.glob(pattern)]
        assert files, pattern
        return files

    def execute(self, text: str) -> str:
        """One block of Python and what it prints; each ``print(...)  # so`` must print so.

        An expression that ends the block is shown, as a notebook does, unless a semicolon ends it.
        """
        expected = [said for _, said in PRINTED.findall(text)]
        tree = ast.parse(text)
        last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
        out = StringIO()
        with redirect_stdout(out), warnings.catch_warnings():
            warnings.simplefilter("ignore", _warning())
            exec(compile(tree, "page", "exec"), self.names)
            value = None if last is None else eval(compile(ast.Expression(last.value), "page", "eval"), self.names)
        printed = out.getvalue()
        assert printed.splitlines() == expected or not self.strict, f"{text}\nprints\n{printed}"
        hidden = value is None or text.rstrip().endswith(";") or isinstance(value, np.ndarray | Path)  # axes, a file
        return printed if hidden else f"{printed}{value!r}\n"

    def do(self, number: int, kind: str, block: str) -> BlockResult:
        """Run a block, and what it showed."""
        from tools.figure_text import unreadable

        from dampyr.show import figure_files, save

        run = self.execute if kind == "python" else self.run
        if self.out is None:
            text = run(block)
            _drawn()
            return BlockResult(text)
        _drawn()  # what was left open before is of no block
        before = self._pages()
        drawn = self.out / f"drawn-{number}"
        with figure_files(drawn, (".svg",)):
            text = run(block)
        figures = [*sorted(drawn.glob("*.svg"))[:MOST_FIGURES]] if drawn.exists() else []
        shown = BlockResult(self._plain(text))
        for place, figure in enumerate(figures):
            section = figure.stem.partition("-")[2].replace("-", " ")
            shown.figures.append((self._keep(figure, f"{number:02d}-page-{place}.svg"), f"From the page: {section}"))
        shutil.rmtree(drawn, ignore_errors=True)
        for place, figure in enumerate([*_drawn(), *self._new_figures()]):
            shown.figures.append((save(figure, self.out / f"{number:02d}-{place}.svg").name, in_words(figure)))
            self.faults += [f"block {number}, its figure: {fault}" for fault in unreadable(figure)]
        for page in sorted(path for path, when in self._pages().items() if before.get(path) != when):
            shown.pages.append(self._keep(page, f"{number:02d}-{page.name}"))
        return shown

    def _new_figures(self) -> list[Any]:
        """The figures without pyplot that have a name and were not shown yet."""
        figures = {id(value): value for value in self.names.values() if type(value).__name__ == "Figure"}
        new = [figure for key, figure in figures.items() if key not in self.shown and figure.canvas.manager is None]
        self.shown.update(figures)
        return new

    def _keep(self, file: Path, name: str) -> str:
        assert self.out is not None
        shutil.copy(file, self.out / name)
        return name

    def _pages(self) -> dict[Path, int]:
        """The pages in the folder, with their times."""
        return {path: path.stat().st_mtime_ns for path in self.folder.rglob("*.html")}

    def _plain(self, text: str) -> str:
        """What was printed, without the folders of this machine and not too long to read."""
        text = re.sub(r"\x1b\[[0-9;]*m", "", text)
        text = text.replace(f"{self.folder.resolve()}/", "").replace(f"{self.folder}/", "").replace(f"{ROOT}/", "")
        text = re.sub(rf"{re.escape(tempfile.gettempdir())}/\w+", "folder", text)
        lines = [line.rpartition("\r")[2].rstrip() for line in text.split("\n") if not PROGRESS.match(line)]
        if len(lines) > MOST_LINES:
            lines = [*lines[:MOST_LINES], f"... and {len(lines) - MOST_LINES} lines more"]
        return "\n".join(lines).strip("\n")


def in_words(figure: Any) -> str:
    """What a figure shows, for those who cannot see it: what stands on its axes."""
    across = [*(panel.get_xlabel() for panel in figure.axes), figure.get_supxlabel()]
    up = [*(panel.get_ylabel() for panel in figure.axes), figure.get_supylabel()]
    sides = [", ".join(dict.fromkeys(filter(None, side))) for side in (up, across)]
    return " over ".join(filter(None, sides)) or "A figure"


def _warning() -> type[Warning]:
    from dampyr.errors import DampyrWarning

    return DampyrWarning


def _drawn() -> list[Any]:
    """The figures that are open in pyplot, which are closed."""
    if "matplotlib.pyplot" not in sys.modules:
        return []
    from matplotlib import pyplot

    figures = [pyplot.figure(number) for number in pyplot.get_fignums()]
    pyplot.close("all")
    return figures


# The files of a page


def follow(page: str, text: str, desk: Desk) -> Iterator[BlockResult | None]:
    """Follow a page in the folder of ``desk``, which is the current one: what each fenced block showed, None of a file."""
    blocks = FENCE.findall(text)
    for number, (info, block) in enumerate(blocks):
        kind, file = info.split(" ")[0], named(info, block)
        if why := why_not(page, block):
            yield BlockResult(why_not=why)
        elif kind == "text" and "Stroke LVDT" in block:
            write_own_file(desk.folder, block)
            yield None
        elif kind == "text" and "Displacement" in block:
            write_laboratory(desk.folder / "tests", block)
            yield None
        elif file:
            (desk.folder / file).parent.mkdir(exist_ok=True)
            (desk.folder / file).write_text(block, encoding="utf-8")
            yield None
        elif kind in RUN_KINDS:
            yield desk.do(number, kind, block)
        else:
            yield None


def needs_data(text: str) -> bool:
    """Whether a page reads the measured campaign."""
    return any(words in text for words in NEEDS_DATA)


def lay_out(folder: Path, text: str, data: Path | None) -> None:
    """What a reader has before the first line: the examples, and the data where the page does not fetch them."""
    (folder / "examples").symlink_to(ROOT / "examples")  # a reader of the README has them
    if data and "datasets fetch" not in text:
        (folder / "data").mkdir()
        (folder / "data" / "labcontrol-mr-damper").symlink_to(data)


def write_own_file(folder: Path, text: str) -> None:
    """The file that "read your own files" shows, with enough of it to identify a damper from."""
    import dampyr as dp

    header, first = text.splitlines()[:2]
    t = np.arange(0.0, 6.0, 0.002)
    x, v = 8.0 * np.sin(6.0 * t), 48.0 * np.cos(6.0 * t)
    w = dp.models.Damper("dahl", {"dahl.kx": 0.0, "dahl.kw": 1.0, "dahl.rho": 20e3}).force(t, 1e-3 * x, voltage=0.0)
    rows = np.column_stack([t, x, v, 0.1 + 0.2 * w + 1e-3 * v, np.full(t.size, 0.45)])
    lines = [";".join(f"{value:.5f}".replace(".", ",") for value in row) for row in rows]
    assert first.count(";") == lines[0].count(";")
    (folder / "test.csv").write_text("\n".join([header, *lines]), encoding="utf-8")


def write_laboratory(folder: Path, text: str) -> None:
    """The files that "another laboratory" shows: twelve sines at four currents, and a motion like an earthquake's."""
    [header, first, *_] = text.splitlines()
    folder.mkdir()
    rng = np.random.default_rng(7)
    t = np.arange(0.0, 6.0, 0.002)
    for current in (0.0, 0.5, 1.0, 1.5):
        for amplitude, frequency in ((5.0, 1.0), (10.0, 0.5), (10.0, 1.0)):
            x = amplitude * np.sin(2.0 * np.pi * frequency * t)
            name = f"sine_{amplitude:g}mm_{frequency:g}Hz_{current:g}A.txt"
            write_test(folder / name, header, t, x, current, rng)
    t = np.arange(0.0, 12.0, 0.002)
    frequencies = np.linspace(0.2, 4.0, 40)
    waves = np.sin(2.0 * np.pi * np.outer(t, frequencies) + rng.uniform(0.0, 2.0 * np.pi, 40)) / frequencies
    x = waves.sum(axis=1) * np.minimum(1.0, t / 2.0) * np.exp(-np.maximum(0.0, t - 6.0) / 3.0)
    write_test(folder / "earthquake_1A.txt", header, t, 9.0 * x / np.abs(x).max(), 1.0, rng)
    assert first.count("\t") == header.count("\t")


def write_test(path: Path, header: str, t: np.ndarray, x: np.ndarray, current: float, rng: np.random.Generator) -> None:
    """One test of that laboratory, mm and N, with noise on the force and on the current."""
    import dampyr as dp

    over = (0.0, 1.5)
    laws = {"kx": (900.0, 700.0), "kw": (60.0, 420.0), "rho": (4000.0, -1200.0)}
    dahl = dp.models.Damper(
        "dahl", {f"dahl.{key}": dp.models.Polynomial(c, *over) for key, c in laws.items()}, input="A"
    )
    v = np.gradient(x, t)
    force = dahl.force(t, 1e-3 * x, velocity=1e-3 * v, current=current)
    force = force + (20.0 + 150.0 * current) * np.tanh(v / 10.0) + 35.0 + rng.normal(0.0, 2.0, t.size)
    measured = current + rng.normal(0.0, 0.004, t.size)
    rows = zip(t, x, v, force, measured, strict=True)
    lines = [f"{a:.3f}\t{b:.4f}\t{c:.3f}\t{d:.2f}\t{e:.3f}" for a, b, c, d, e in rows]
    path.write_text("\n".join([header, *lines]), encoding="utf-8")


def named(info: str, text: str) -> str | None:
    """The file that a block is, by ``name=`` behind its language or by its first line."""
    if match := re.search(r"\b(?:name|part)=(\S+)", info):
        return match[1]
    first = re.match(r"# (\S+\.(?:toml|py))\n", text)
    return first[1] if first else None


def why_not(page: str, text: str) -> str | None:
    """Why a block is not run, where it is not."""
    return next((why for (of, words), why in NOT_RUN.items() if of == page and text.startswith(words)), None)


def is_run(page: str, text: str) -> bool:
    """Whether a page has anything to run."""
    return any(
        info.split(" ")[0] in RUN_KINDS and not named(info, block) and not why_not(page, block)
        for info, block in FENCE.findall(text)
    )


# The program: one page of the site


def measured_campaign() -> Path | None:
    """The folder of the measured campaign on this machine, as the tests find it (tests/conftest.py)."""
    root = Path(os.environ.get("DAMPYR_DATA") or ROOT.parent / "shared" / "data").resolve()
    folder = root / "labcontrol-mr-damper"
    return folder if folder.is_dir() else None


def main(arguments: Sequence[str]) -> int:
    """Follow one page in a folder of its own, and leave what its blocks showed in OUT."""
    page, out = Path(arguments[0]).resolve(), Path(arguments[1]).resolve()
    out.mkdir(parents=True, exist_ok=True)
    import matplotlib

    matplotlib.use("agg")
    sys.path.append(str(ROOT))  # for the tools beside this one
    text = text_of(page)
    name = str(page.relative_to(ROOT))
    data = measured_campaign()
    faults: list[str] = []
    if needs_data(text) and data is None:
        shown: list[BlockResult | None] = [
            BlockResult(why_not="the measured campaign is not at hand") if info.split(" ")[0] in RUN_KINDS else None
            for info, _ in FENCE.findall(text)
        ]
    else:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place).resolve()
            lay_out(folder, text, data if needs_data(text) else None)
            os.chdir(folder)
            os.environ["DAMPYR_DATA"] = "data"
            sys.path.append("")
            desk = Desk(folder, data, out, strict=False)
            shown = list(follow(name, text, desk))
            os.chdir(ROOT)
            faults = desk.faults
    blocks = [None if each is None else asdict(each) for each in shown]
    (out / "blocks.json").write_text(json.dumps(blocks, ensure_ascii=False, indent=1), encoding="utf-8")
    print("\n".join(faults), file=sys.stderr)
    return int(bool(faults))


def text_of(page: Path) -> str:
    """The text of a page, or of a notebook as a page: its words and its code, and where to download it."""
    if page.suffix == ".md":
        return page.read_text(encoding="utf-8")
    cells = json.loads(page.read_text(encoding="utf-8"))["cells"]
    texts = [
        "".join(cell["source"]) if cell["cell_type"] == "markdown" else f"```python\n{''.join(cell['source'])}\n```"
        for cell in cells
    ]
    first, *others = texts
    return "\n\n".join([first, f"[Download the notebook]({page.name}).", *others]) + "\n"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
