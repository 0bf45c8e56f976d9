r"""Counts of the source code: its size, its names, its circles, its constants, and the walks through two calls.

::

    python tools/measure.py                          # this checkout
    python tools/measure.py --root ../other --walks  # another one, with the walks
    python tools/measure.py --json

Nothing of the checkout is imported, except for the walks. The definitions, each with what it gives at commit b829dc7, from
which the review of the code counted (its numbers in brackets):

lines, files
    All ``*.py`` under ``src/dampyr``: 42,072 lines in 386 files [42,072, 386]. A code line holds code: it is not blank, no
    comment alone, and not of a docstring.
public functions and classes
    ``def`` and ``class`` at any level whose qualified name has no leading underscore at any level (methods count, special
    methods do not; functions inside of functions count by the same rule): 1,878 [1,900]. The names of modules play no part.
public module-level names
    Functions and classes at module level, and module-level assignments to a name (not to a tuple of names, no fields of
    classes), without a leading underscore, each name once per module: 2,120 [2,120].
functions
    Code lines of every function, the ``def`` line included, decorators and docstring not: median 6, 90th percentile 17,
    maximum 47 of 2,735 functions [6, 17, 47 of 2,735].
empty words
    NAME tokens that hold one of `EMPTY_WORDS` as an underscore segment, in any case, such as ``each`` and ``_one_of``; every
    occurrence counts, per 1,000 lines. They could stand anywhere, so a reader learns nothing from them; which of them are in
    place, only a reader can say. Expressions inside of f-strings count from Python 3.12 on, where they are tokens too, so
    compare numbers of one Python; these are of 3.11.
names of the faces
    What the ``__all__`` of the packages hold that `FACES` lists.
class names
    Names that more than one class of ``src`` has.
module names
    File names that occur more than once (``__init__`` and ``__main__`` apart): 35 [33].
import circles
    Groups of modules that import one another (strongly connected components): by what is imported when a module is loaded;
    with imports inside of functions as well; and with those under ``TYPE_CHECKING`` as well: 0, 5, 9 [0, 5, 9].
    ``from package import name`` leads to the module that defines the name, wherever the package takes it from; that a
    module loads the packages it lies in is not counted.
constants without a reason
    Module-level assignments of a number (or of arithmetic on numbers, or of a tuple, list or dictionary of them) that have
    no comment on the line, none in the line above and no docstring after them; comments for tools (``noqa``, ``fmt: skip``)
    give no reason: 178 of 382 [200 of 382].
modules with a test file
    Modules whose functions have five lines or more below their ``def`` lines, and how many of these have a file
    ``test_<name>.py`` in the same folder under ``tests/`` (without the leading underscore of a name); those without are listed.
walks
    A stop is a function of ours that the call enters, a return is going back into a file that was left. Counted so: the
    call is traced (``sys.setprofile``), and of the functions of ``src/dampyr`` that it enters each counts once, where it is
    first entered; generator expressions, comprehensions, lambdas, compiled and generated code do not count. In this
    sequence, functions of the same file that follow one another are one stop; a stop in a file that had a stop before is a
    return. So stops are files plus returns, as in all walks of the review. The calls run once before they are traced, so
    that imports, compilation and caches are done. The calls:

    - ``dampyr.identification.fit("dahl", records)`` with four synthetic records at two voltages: 97 stops, 73 returns;
    - the search in it, which is the outermost call out of the file of ``fit`` that is under way when ``progress`` is called
      first (where there is none, all of ``fit``): 40 stops, 30 returns, 67 functions [40, 32, 68];
    - ``write_fit_page`` of this fit: 60 stops, 31 returns. The page itself, without what it reads of a fit, are the
      functions in the packages `PAGE_PACKAGES` and in the modules at the top level: 43 stops, 22 returns, 86 functions
      [44, 25, 72].
"""

from __future__ import annotations

import argparse
import ast
import io
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import tokenize
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

CHECKOUT = Path(__file__).resolve().parent.parent
PACKAGE = "dampyr"
EMPTY_WORDS = ("one", "each", "here", "there", "given", "made", "own", "words", "said", "found", "kept", "handed")
FACES = (
    "campaigns", "export", "ground_motions", "hybrid", "identification", "models", "planning", "records", "rig", "show",
    "structures",
)  # fmt: skip
PAGE_PACKAGES = ("show", "report", "figures")  # the last two up to 0.3.0
DIRECTIVE = re.compile(r"#\s*(fmt|type|ruff|mypy|pragma)\s*:|#\s*noqa")  # comments for tools give no reason
LAYOUT = {tokenize.NL, tokenize.NEWLINE, tokenize.COMMENT, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}

Function = ast.FunctionDef | ast.AsyncFunctionDef
Definition = Function | ast.ClassDef
NodeWithDocstring = Definition | ast.Module


@dataclass(frozen=True)
class Module:
    """One source file: its dotted name, its text, and what the parsers make of it."""

    path: Path
    name: str
    text: str
    tree: ast.Module
    tokens: list[tokenize.TokenInfo]

    @property
    def is_package(self) -> bool:
        """Whether it is an ``__init__.py``."""
        return self.path.name == "__init__.py"


def main() -> int:
    """Parse the command line and print; the exit status."""
    parser = argparse.ArgumentParser(description="Counts of the source code.")
    parser.add_argument("--root", type=Path, default=CHECKOUT, metavar="DIR", help="the checkout to measure")
    parser.add_argument("--json", action="store_true", help="for machines")
    parser.add_argument("--walks", action="store_true", help="trace the calls of fit and of its page as well")
    parser.add_argument("--trace-into", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    root = options.root.resolve()
    if options.trace_into:
        options.trace_into.write_text(json.dumps(traced_walks(root)), encoding="utf-8")
        return 0
    measures = measure(root)
    if options.walks:
        measures["walks"] = walks(root)
    print(json.dumps(measures, indent=1) if options.json else table(measures))
    return 0


def measure(root: Path) -> dict[str, Any]:
    """All counts that need no running code."""
    modules = list(read_modules(root / "src"))
    constants = [constant for module in modules for constant in numeric_constants(module)]
    lengths = sorted(length for module in modules for length in function_lengths(module))
    places = {"src": modules} | {name: list(read_modules(root / name)) for name in ("tests", "benchmarks")}
    return {
        "files": len(modules),
        "lines": sum(len(module.text.splitlines()) for module in modules),
        "code lines": sum(len(code_lines(module)) for module in modules),
        "public functions and classes": sum(public_definitions(module.tree) for module in modules),
        "public module-level names": sum(len(public_names(module.tree)) for module in modules),
        "functions": len(lengths),
        "code lines of a function": {
            "median": statistics.median(lengths),
            "p90": lengths[int(0.9 * len(lengths))],
            "max": lengths[-1],
        },
        "empty words in identifiers": {name: count_words(modules_there) for name, modules_there in places.items()},
        "names of the faces": sum(
            len(face(module)) for module in modules if module.name.removeprefix("dampyr.") in FACES
        ),
        "class names more than once": repeated_classes(modules),
        "module names more than once": repeated_names(modules),
        "import circles": import_circles(modules),
        "modules with a test file": tested_modules(modules, root / "tests"),
        "numeric constants": len(constants),
        "constants without a reason": [place for place, has_reason in constants if not has_reason],
    }


def read_modules(folder: Path) -> Iterator[Module]:
    """Every ``*.py`` under a folder."""
    for path in sorted(folder.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        parts = path.relative_to(folder).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
        yield Module(path, name, text, ast.parse(text), tokens)


def docstring_lines(tree: ast.AST) -> set[int]:
    """The lines of all docstrings below a node, and of strings that stand alone after an assignment."""
    lines: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return lines


def code_lines(module: Module) -> set[int]:
    """The numbers of the lines that hold code."""
    lines: set[int] = set()
    for token in module.tokens:
        if token.type not in LAYOUT:
            lines.update(range(token.start[0], token.end[0] + 1))
    return lines - docstring_lines(module.tree)


def function_lengths(module: Module) -> Iterator[int]:
    """The code lines of every function."""
    lines = code_lines(module)
    for node in ast.walk(module.tree):
        if isinstance(node, Function):
            yield sum(node.lineno <= line <= (node.end_lineno or node.lineno) for line in lines)


def public_definitions(node: ast.AST) -> int:
    """Functions and classes below a node whose qualified names have no leading underscore."""
    total = 0
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, Definition):
            total += public_definitions(child)
        elif not child.name.startswith("_"):
            total += 1 + public_definitions(child)
    return total


def public_names(tree: ast.Module) -> set[str]:
    """The names without leading underscore that a module defines at its top level."""
    names: set[str] = set()
    for node in tree.body:
        if isinstance(node, Definition):
            names.add(node.name)
        else:
            names.update(assigned_names(node))
    return {name for name in names if not name.startswith("_")}


def assigned_names(node: ast.stmt) -> list[str]:
    """The plain names that an assignment binds."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return [target.id for target in targets if isinstance(target, ast.Name)]


def count_words(modules: Sequence[Module]) -> dict[str, Any]:
    """How many NAME tokens hold each empty word, and how many hold one per 1,000 lines."""
    tokens = [set(t.string.lower().split("_")) for module in modules for t in module.tokens if t.type == tokenize.NAME]
    counts = Counter(word for token in tokens for word in token.intersection(EMPTY_WORDS))
    lines = sum(len(module.text.splitlines()) for module in modules)
    return {"per 1,000 lines": round(1000 * sum(counts.values()) / max(1, lines), 1), **counts}


def face(module: Module) -> list[str]:
    """The names in a package's ``__all__``, also where they are the keys of a dictionary above it."""
    assigned = {
        name: node.value for node in module.tree.body if isinstance(node, ast.Assign) for name in assigned_names(node)
    }
    names = assigned.get("__all__")
    if isinstance(names, ast.Call):  # list(_MODULES)
        names = assigned[ast.unparse(names.args[0])]
    entries = names.keys if isinstance(names, ast.Dict) else names.elts if isinstance(names, ast.List) else []
    return [entry.value for entry in entries if isinstance(entry, ast.Constant)]


def repeated_classes(modules: Sequence[Module]) -> dict[str, int]:
    """Class names that occur more than once, and how often."""
    counts = Counter(n.name for module in modules for n in ast.walk(module.tree) if isinstance(n, ast.ClassDef))
    return {name: count for name, count in sorted(counts.items()) if count > 1}


def repeated_names(modules: Sequence[Module]) -> dict[str, int]:
    """File names that occur more than once, and how often."""
    counts = Counter(module.path.stem for module in modules if not module.path.stem.startswith("__"))
    return {name: count for name, count in sorted(counts.items()) if count > 1}


def tested_modules(modules: Sequence[Module], tests: Path) -> dict[str, Any]:
    """How many modules with behaviour there are, how many have a test file of their name, and the others."""
    behaving = [module for module in modules if not module.path.stem.startswith("__") and body_lines(module) >= 5]
    folders = {module.name: tests.joinpath(*module.name.split(".")[1:-1]) for module in behaving}
    names = {module.name: f"test_{module.path.stem.lstrip('_')}.py" for module in behaving}
    without = [name for name, folder in folders.items() if not (folder / names[name]).is_file()]
    return {"of": len(behaving), "with": len(behaving) - len(without), "without": without}


def body_lines(module: Module) -> int:
    """Lines of all functions of a module below their ``def`` lines."""
    functions = (node for node in ast.walk(module.tree) if isinstance(node, Function))
    return sum((node.end_lineno or node.lineno) - node.lineno for node in functions)


def numeric_constants(module: Module) -> Iterator[tuple[str, bool]]:
    """Every numeric constant at module level as ``file:line NAME``, and whether a reason stands beside it."""
    commented = {
        token.start[0]
        for token in module.tokens
        if token.type == tokenize.COMMENT and not DIRECTIVE.match(token.string)
    }
    for node, following in zip(module.tree.body, [*module.tree.body[1:], None], strict=True):
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None or not is_numeric(node.value):
            continue
        names = ast.unparse(node).partition("=")[0].strip()
        lines = range(node.lineno - 1, (node.end_lineno or node.lineno) + 1)
        documented = (
            isinstance(following, ast.Expr)
            and isinstance(following.value, ast.Constant)
            and isinstance(following.value.value, str)
        )
        has_reason = documented or any(line in commented for line in lines)
        yield f"{module.name.replace('.', '/')}.py:{node.lineno} {names}", has_reason


def is_numeric(node: ast.expr) -> bool:
    """A number, arithmetic on numbers, or a tuple, list or dictionary of these."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float | complex) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp):
        return is_numeric(node.operand)
    if isinstance(node, ast.BinOp):
        return is_numeric(node.left) and is_numeric(node.right)
    if isinstance(node, ast.Dict):
        return bool(node.values) and all(map(is_numeric, node.values))
    return isinstance(node, ast.Tuple | ast.List) and bool(node.elts) and all(map(is_numeric, node.elts))


LOAD, FUNCTION, TYPING = "load", "function", "typing"  # when an import runs


def import_circles(modules: Sequence[Module]) -> dict[str, list[list[str]]]:
    """The circles at load; with imports inside of functions; with those for type checking as well."""
    by_name = {module.name: module for module in modules}
    edges: dict[str, set[tuple[str, str]]] = defaultdict(set)
    for module in modules:
        for when, target in imports(module, by_name):
            edges[when].add((module.name, target))
    load, function, typing = edges[LOAD], edges[LOAD] | edges[FUNCTION], edges[LOAD] | edges[FUNCTION] | edges[TYPING]
    return {
        "at load": circles(load),
        "with imports in functions": circles(function),
        "with TYPE_CHECKING": circles(typing),
    }


def imports(module: Module, by_name: dict[str, Module]) -> Iterator[tuple[str, str]]:
    """When and what of ours a module imports."""

    def visit(node: ast.AST, when: str) -> Iterator[tuple[str, str]]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import | ast.ImportFrom):
                yield from ((when, target) for target in targets(child, module, by_name) if target != module.name)
            elif isinstance(child, Function | ast.Lambda):
                yield from visit(child, TYPING if when == TYPING else FUNCTION)
            elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
                for statement in child.body:
                    yield from visit(ast.Module([statement], []), TYPING)
                for statement in child.orelse:
                    yield from visit(ast.Module([statement], []), when)
            else:
                yield from visit(child, when)

    yield from visit(module.tree, LOAD)


def targets(node: ast.Import | ast.ImportFrom, module: Module, by_name: dict[str, Module]) -> Iterator[str]:
    """The modules of ours that an import statement leads to."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name in by_name)
        return
    base = node.module or ""
    if node.level:
        package = module.name.split(".") if module.is_package else module.name.split(".")[:-1]
        base = ".".join([*package[: len(package) - node.level + 1], *([base] if base else [])])
    if base in by_name:
        yield from (defining_module(base, alias.name, by_name) for alias in node.names)


def defining_module(base: str, name: str, by_name: dict[str, Module], depth: int = 0) -> str:
    """The module that ``from base import name`` leads to, through packages that only pass the name on."""
    if f"{base}.{name}" in by_name and name not in public_names(by_name[base].tree):
        passed_on = passed_names(by_name[base], by_name)
        if name not in passed_on:
            return f"{base}.{name}"
    if depth < 5 and by_name[base].is_package and name not in public_names(by_name[base].tree):
        passed_on = passed_names(by_name[base], by_name)
        if name in passed_on:
            return defining_module(*passed_on[name], by_name, depth + 1)
    return base


def passed_names(module: Module, by_name: dict[str, Module]) -> dict[str, tuple[str, str]]:
    """Names that a package takes from modules of ours at its top level: name -> (module, name there)."""
    return {
        alias.asname or alias.name: (node.module, alias.name)
        for node in module.tree.body
        if isinstance(node, ast.ImportFrom) and not node.level and node.module in by_name
        for alias in node.names
    }


def circles(edges: set[tuple[str, str]]) -> list[list[str]]:
    """The strongly connected components of two modules or more (Tarjan 1972)."""
    successors: dict[str, list[str]] = defaultdict(list)
    for source, target in sorted(edges):
        successors[source].append(target)
    order: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    components: list[list[str]] = []

    def visit(name: str) -> None:
        order[name] = low[name] = len(order)
        stack.append(name)
        for target in successors[name]:
            if target not in order:
                visit(target)
                low[name] = min(low[name], low[target])
            elif target in stack:
                low[name] = min(low[name], order[target])
        if low[name] == order[name]:
            component = stack[stack.index(name) :]
            del stack[stack.index(name) :]
            if len(component) > 1:
                components.append(sorted(component))

    sys.setrecursionlimit(10_000)
    for name in list(successors):
        if name not in order:
            visit(name)
    return sorted(components)


@dataclass(frozen=True)
class Entry:
    """A function that a traced call entered: its file under ``src/dampyr``, its name, and how deep in the call."""

    file: str
    name: str
    depth: int
    code: CodeType


@dataclass(frozen=True)
class Trace:
    """The functions that a call entered, in order, and which of them were open when ``progress`` was called first."""

    entries: list[Entry]
    open_at_progress: list[int]

    def below(self, first: int) -> list[Entry]:
        """The entry ``first`` and all that it entered."""
        depth = self.entries[first].depth
        later = range(first + 1, len(self.entries))
        last = next((k for k in later if self.entries[k].depth <= depth), len(self.entries))
        return self.entries[first:last]


def walks(root: Path) -> dict[str, Any]:
    """The walks, traced in a process of their own with the sources of ``root``."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "walks.json"
        environment = os.environ | {"PYTHONPATH": str(root / "src"), "MPLBACKEND": "Agg"}
        command = [sys.executable, str(Path(__file__).resolve()), "--root", str(root), "--trace-into", str(out)]
        subprocess.run(command, env=environment, check=True)
        return dict(json.loads(out.read_text(encoding="utf-8")))


def traced_walks(root: Path) -> dict[str, Any]:
    """The walks; dampyr is imported from ``root``."""
    import dampyr as dp

    source = root / "src" / PACKAGE
    if not Path(dp.__file__).resolve().is_relative_to(source):
        raise SystemExit(f"{PACKAGE} was imported from {dp.__file__}, which is not in {root}")
    records = synthetic_records(dp)
    dp.identification.fit(records=records, model="dahl")
    fit_trace, fit = traced(
        source, lambda progress: dp.identification.fit(records=records, model="dahl", progress=progress)
    )
    faces = import_module("dampyr.show" if hasattr(dp, "show") else "dampyr.report")
    write_fit_page = (
        faces.write_fit_page if hasattr(faces, "write_fit_page") else faces.write_page
    )  # the first up to 0.3.0
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        write_fit_page(fit, page)
        page_trace, _ = traced(source, lambda progress: write_fit_page(fit, page))
    search = outermost_elsewhere(fit_trace)
    return {
        "fit": walk(fit_trace.entries),
        "search": {"from": f"{search[0].file} {search[0].name}"} | walk(search),
        "page": walk([entry for entry in page_trace.entries if is_of_page(entry.file)]),
        "page with all it reads": walk(page_trace.entries),
    }


def traced(source: Path, call: Any) -> tuple[Trace, Any]:
    """``call(progress)`` traced, and what it returned."""
    entries: list[Entry] = []
    open_entries: list[int] = []
    open_at_progress: list[int] = []

    def progress(*_: Any) -> None:
        if not open_at_progress:
            open_at_progress.extend(open_entries)

    def on_event(frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        if event not in ("call", "return") or not code.co_filename.startswith(str(source)):
            return
        if event == "return":
            open_entries.pop()
            return
        file = str(Path(code.co_filename).relative_to(source))
        entries.append(Entry(file, getattr(code, "co_qualname", code.co_name), len(open_entries), code))
        open_entries.append(len(entries) - 1)

    sys.setprofile(on_event)
    try:
        result = call(progress)
    finally:
        sys.setprofile(None)
    return Trace(entries, open_at_progress), result


def outermost_elsewhere(trace: Trace) -> list[Entry]:
    """The outermost call into another file than the first function's that was open at ``progress``, with all it entered."""
    home = trace.entries[0].file
    elsewhere = [k for k in trace.open_at_progress if trace.entries[k].file != home]
    return trace.below(elsewhere[0] if elsewhere else 0)


def is_of_page(file: str) -> bool:
    """Whether a file belongs to the page: of one of its packages, or at the top level."""
    parts = Path(file).parts
    return len(parts) == 1 or parts[0] in PAGE_PACKAGES


def walk(entries: Sequence[Entry]) -> dict[str, Any]:
    """Functions, files, stops and returns, and the stops themselves."""
    codes: set[CodeType] = set()
    visited: list[str] = []
    stops: list[str] = []
    returns = 0
    for entry in entries:
        if entry.code in codes or not entry.file.endswith(".py") or "<" in entry.code.co_name:
            continue
        codes.add(entry.code)
        if stops and stops[-1] == entry.file:
            continue
        stops.append(entry.file)
        if entry.file in visited:
            returns += 1
        else:
            visited.append(entry.file)
    return {"functions": len(codes), "files": len(visited), "stops": len(stops), "returns": returns, "path": stops}


def synthetic_records(dp: Any) -> list[Any]:
    """Four records of a viscous Dahl damper at two voltages, with noise, from a fixed seed."""
    import numpy as np

    rng = np.random.default_rng(1)
    records = []
    for voltage, amplitude, frequency in ((0.0, 8e-3, 1.0), (0.0, 6e-3, 1.2), (1.0, 8e-3, 1.0), (1.0, 6e-3, 1.2)):
        t = np.arange(1200) * 0.005
        x = amplitude * np.sin(2 * np.pi * frequency * t) * np.clip(t, 0.0, 1.0)
        v = np.gradient(x, t)
        w = np.zeros(t.size)
        for k in range(1, t.size):
            dx = x[k] - x[k - 1]
            w[k] = np.clip(w[k - 1] + 2000.0 * (dx - abs(dx) * w[k - 1]), -1.0, 1.0)
        force = 1000.0 * (1.0 + voltage) * v + 100.0 * (1.0 + 2.0 * voltage) * w + rng.normal(0.0, 2.0, t.size)
        name = f"{voltage:g} V, {frequency:g} Hz"
        records.append(dp.records.Record(time=t, displacement=x, velocity=v, force=force, voltage=voltage, name=name))
    return records


def table(measures: dict[str, Any]) -> str:
    """The counts as lines for people."""
    lines = []
    for name, value in measures.items():
        if name == "constants without a reason":
            lines.append(f"{name}: {len(value)} of {measures['numeric constants']}")
        elif name in ("class names more than once", "module names more than once"):
            lines.append(f"{name}: {len(value)} ({', '.join(f'{key} {count}' for key, count in value.items())})")
        elif name == "empty words in identifiers":
            for place, counts in value.items():
                words = ", ".join(f"{word} {counts.get(word, 0)}" for word in EMPTY_WORDS)
                lines.append(f"{name}, {place}, per 1,000 lines: {counts['per 1,000 lines']} ({words})")
        elif name == "modules with a test file":
            lines.append(f"{name}: {value['with']} of {value['of']} ({value['with'] / value['of']:.0%})")
        elif name == "import circles":
            for when, groups in value.items():
                text = "; ".join(" <-> ".join(group) for group in groups)
                lines.append(f"{name} {when}: {len(groups)}{f' ({text})' if text else ''}")
        elif name == "walks":
            for call, counts in value.items():
                numbers = ", ".join(f"{counts[key]} {key}" for key in ("stops", "returns", "files", "functions"))
                start = f" (from {counts['from']})" if "from" in counts else ""
                lines.append(f"walk of the {call}{start}: {numbers}")
        elif isinstance(value, dict):
            lines.append(f"{name}: {', '.join(f'{key} {count}' for key, count in value.items())}")
        else:
            lines.append(f"{name}: {value:,}")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
