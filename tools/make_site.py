"""Build the documentation as one site, without a network.

::

    python tools/make_site.py                   # make site: out/site/index.html
    python tools/make_site.py --out DIR         # elsewhere
    python tools/make_site.py --run 'how-to/*'  # runs these pages only; '' runs none

Sphinx reads a copy of the pages in OUT-source, so that no file of docs is written. In the copy

- the gallery has a page for each of its scripts, with the figure that it draws (tools/gallery.py), and each part its loops
  (tools/part_loops.py);
- below each block of commands or of Python stands what it printed, drew and wrote when the site was built
  (tools/page_runner.py), or why it was not run;
- the lists of links in index.md are the tables of contents;
- files outside of docs that a page links to come along: CHANGELOG.md and notebooks as pages, folders as lists, all others as
  downloads;
- each package of the public face has a page, from its docstrings.

A warning of sphinx fails the build.
"""

from __future__ import annotations

import argparse
import ast
import inspect
import itertools
import json
import os
import pkgutil
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import citations
import gallery
from page_runner import FENCE, PRINTED, RUN_KINDS, text_of
from sphinx.cmd.build import main as run_sphinx

from dampyr import registry
from dampyr.options import Options, Thresholds
from dampyr.shown import Shown

CHECKOUT = Path(__file__).resolve().parents[1]
DOCS = CHECKOUT / "docs"
FENCED = re.compile(r"(^```[^\n]*\n.*?^```$)", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(?<=\]\()([^)\s]+)(?=\))")
LISTED = re.compile(r"^- \[([^]]+)\]\(([^)\s]+)\)", re.MULTILINE)
LOOPS = "parts"  # the folder of the loops of the parts in RAN
RAN = "ran"  # the folder of what the blocks of the pages showed, in the source of the site
ALONE = ("errors", "units", "registry")  # modules of the public face that are no packages
FACE = (
    "records", "models", "models.published", "identification", "ground_motions", "structures", "campaigns", "planning",
    "hybrid", "rig", "show", "show.figures", "export", "studies", "console", *ALONE,
)  # fmt: skip


def main() -> int:
    """Copy the pages, add those of the packages, and run sphinx; its exit status."""
    parser = argparse.ArgumentParser(description="The documentation as one site, without a network.")
    parser.add_argument("--out", type=Path, default=CHECKOUT / "out" / "site", help="the folder of the site")
    parser.add_argument(
        "--run", default="*", metavar="GLOB", help="the pages that are run, such as 'how-to/*'; '' for none"
    )
    options = parser.parse_args()
    out = options.out.absolute()
    source = out.with_name(f"{out.name}-source")
    for folder in (source, out):
        shutil.rmtree(folder, ignore_errors=True)
    failed = run_pages(options.run, source / RAN)
    copy_pages(source)
    write_packages(source / "reference" / "python")
    status = run_sphinx(
        ["-W", "--keep-going", "-q", "-E", "-c", str(DOCS), "-d", f"{source}-trees", str(source), str(out)]
    )
    shutil.rmtree(f"{source}-trees", ignore_errors=True)
    if failed:
        print("\n".join(f"{page} stops:\n{why}" for page, why in failed.items()), file=sys.stderr)
        return 1
    if not status:
        print(f"{os.path.relpath(out)}/index.html")
    return status


# What the blocks of the pages show


def run_pages(pattern: str, folder: Path) -> dict[str, str]:
    """Follow the pages whose names match, each in a process of its own, several at once; those that stop, and why.

    ``folder`` then holds a folder for each page, with what its blocks showed.
    """
    pages = [
        page for page in sorted(DOCS.rglob("*")) if page.suffix in (".md", ".ipynb") and is_followed(page, pattern)
    ]
    pages.sort(key=lambda page: -len(text_of(page)))  # the long ones first, so that no process is alone at the end
    jobs = {str(page.relative_to(DOCS)): ["page_runner.py", str(page)] for page in pages}
    for place, tool in (("gallery/index.md", "gallery.py"), (LOOPS, "part_loops.py")):
        if fnmatch(place, pattern):
            jobs = {place.removesuffix("/index.md"): [tool], **jobs}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        done = list(pool.map(lambda place: run_tool([*jobs[place], str(folder / place)]), jobs))
    return {place: why for place, why in zip(jobs, done, strict=True) if why}


def is_followed(page: Path, pattern: str) -> bool:
    """Whether a page is run: it matches, it is not another face of a page, and it has commands or Python."""
    if not fnmatch(str(page.relative_to(DOCS)), pattern) or (
        page.suffix == ".ipynb" and page.with_suffix(".md").exists()
    ):
        return False
    return any(info.split(" ")[0] in RUN_KINDS for info, _ in FENCE.findall(text_of(page)))


def run_tool(command: list[str]) -> str:
    """Run one of the tools in a process of its own; why it stops, or nothing."""
    tool, *arguments = command
    done = subprocess.run(
        [sys.executable, str(CHECKOUT / "tools" / tool), *arguments],
        capture_output=True, text=True, check=False, cwd=CHECKOUT,
    )  # fmt: skip
    return done.stderr[-3000:] or "no reason" if done.returncode else ""


def with_results(text: str, page: Path, source: Path) -> str:
    """A page with what each of its blocks showed below it; as it is where the page was not run."""
    folder = source / RAN / page.relative_to(source)
    for suffix in (".md", ".ipynb"):
        if (results := folder.with_suffix(suffix) / "blocks.json").is_file():
            break
    else:
        return text
    shown = json.loads(results.read_text(encoding="utf-8"))
    place = os.path.relpath(results.parent, page.parent)
    pieces, end, printed = [], 0, ""
    for block, result in zip(FENCE.finditer(text), shown, strict=True):
        code = (
            PRINTED.sub(r"\1", block[0]) if result and result["text"] else block[0]
        )  # what it says is printed is below it
        between = text[end : block.start()]
        end = block.end()
        if block[1] == "text" and not between.strip() and is_said(block[2], printed):
            continue  # the page's own excerpt of what is printed above
        pieces += [between, code]
        printed = result["text"] if result else ""
        if result:
            pieces += below(result, place)
    return "".join([*pieces, text[end:]])


def is_said(excerpt: str, printed: str) -> bool:
    """Whether every line of an excerpt is printed."""
    words = " ".join(printed.split())
    return bool(words) and all(" ".join(line.split()) in words for line in excerpt.splitlines())


def below(result: dict[str, Any], place: str) -> Iterator[str]:
    """What stands below a block: its text, its figures, its pages, or why there is nothing."""
    if result["why_not"]:
        yield f"\n\n```{{container}} not-run\nNot run when this page was made: {result['why_not']}.\n```\n"
    if result["text"]:
        fence = "`" * max(4, 1 + max(map(len, re.findall("`+", result["text"])), default=0))
        yield f"\n\n{fence}{{code-block}} text\n:class: printed\n\n{result['text']}\n{fence}\n"
    for file, words in result["figures"]:
        yield "\n\n" + picture(f"{place}/{file}", words).rstrip("\n") + "\n"
    for file in result["pages"]:
        yield f"\n\nThe page that it writes: [{file.partition('-')[2]}]({place}/{file})\n"


# The gallery and the loops of the parts


def write_gallery(source: Path) -> None:
    """A page for each script of the gallery, and its list as pictures."""
    drawn = source / RAN / "gallery"
    for entry in gallery.entries():
        page = source / "gallery" / f"{entry.name}.md"
        page.parent.mkdir(parents=True, exist_ok=True)
        title, words = entry.words
        file = drawn / f"{entry.name}.svg"
        above = picture(os.path.relpath(file, page.parent), words) if file.is_file() else ""
        page.write_text(f"# {title}\n\n{words}\n\n{above}```python\n{entry.code}```\n", encoding="utf-8")
    index = source / "gallery" / "index.md"
    text = index.read_text(encoding="utf-8").replace(".py)", ".md)")
    listed = "\n".join(["", *map(contents, re.split(r"^(?=## )", text, flags=re.MULTILINE))])
    if drawn.is_dir():

        def pictures(rows: re.Match[str]) -> str:
            names = [link.removesuffix(".md") for _, link in LISTED.findall(rows[0])]
            return thumbnails("gallery", names, index, source)

        text = re.sub(r"(?:^- .*\n)+", pictures, text, flags=re.MULTILINE)
    index.write_text(text + listed, encoding="utf-8")


def with_pictures(text: str, page: Path, source: Path) -> str:
    """A page with the pictures that it names; without those that were not drawn.

    ``<!-- loops: NAME -->`` is the picture of a part, ``<!-- loops: NAME NAME -->`` several as a row, each with its name, and
    ``<!-- gallery: NAME NAME -->`` entries of the gallery.
    """

    def drawn(mark: re.Match[str]) -> str:
        kind = mark[1]
        folder = source / RAN / (LOOPS if kind == "loops" else kind)
        names = [name for name in mark[2].split() if (folder / f"{name}.svg").is_file()]
        if not names:
            return ""
        if kind == "loops" and len(names) == 1 and page.stem == "models":
            return picture(
                os.path.relpath(source / RAN / LOOPS / f"{names[0]}.svg", page.parent), f"Loops of {names[0]}"
            )
        return thumbnails(kind, names, page, source)

    return re.sub(r"<!-- (loops|gallery): ([\w/ ]+) -->\n?", drawn, text)


def thumbnails(kind: str, names: Sequence[str], page: Path, source: Path) -> str:
    """Pictures of entries of the gallery or of parts in rows, each with its title, which leads to its page."""
    titles = {entry.name: entry.words[0] for entry in gallery.entries()}
    folder = source / RAN / (LOOPS if kind == "loops" else kind)
    pieces = []
    for name in names:
        target = f"reference/models.html#{name.replace('_', '-')}" if kind == "loops" else f"gallery/{name}.html"
        title = f"`{name}`" if kind == "loops" else titles[name]
        lead = f":target: {os.path.relpath(source, page.parent)}/{target}"
        place = os.path.relpath(folder / f"{name}.svg", page.parent)
        pieces.append(f"```{{figure}} {place}\n{lead}\n:alt: {titles.get(name, f'Loops of {name}')}\n\n{title}\n```\n")
    return "\n".join(["````{container} thumbnails", *pieces, "````", ""])


def picture(place: str, words: str) -> str:
    """A picture that was drawn for the site."""
    return f"```{{image}} {place}\n:alt: {words}\n:class: drawn\n```\n\n"


# Pages


def copy_pages(source: Path) -> None:
    """Every file of docs, with links that hold in the site, and the tables of contents."""
    shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("*.py", "_static", "__pycache__"), dirs_exist_ok=True)
    list_folder(source / "decisions", "Decisions", "What was decided, when it could have been decided otherwise.")
    for page in pages_in(source, ".md"):
        text = rewrite(page, DOCS / page.relative_to(source), source)
        page.write_text(with_pictures(with_results(text, page, source), page, source), encoding="utf-8")
    write_gallery(source)
    for notebook in pages_in(source, ".ipynb"):
        page = notebook.with_suffix(".md")
        if not page.exists():
            page.write_text(with_results(text_of(notebook), page, source), encoding="utf-8")
    index = source / "index.md"
    index.write_text(with_contents(index.read_text(encoding="utf-8")), encoding="utf-8")


def pages_in(source: Path, suffix: str) -> list[Path]:
    """The files of docs with this ending, in their copy."""
    return [page for page in sorted(source.rglob(f"*{suffix}")) if page.is_file() and source / RAN not in page.parents]


def rewrite(page: Path, original: Path, source: Path) -> str:
    """A page's text, its links to files outside of docs led to their copies in the site."""

    def lead(link: re.Match[str]) -> str:
        target, hash_mark, anchor = link[1].partition("#")
        if "://" in target or not target or target.startswith("mailto:"):
            return link[1]
        file = (original.parent / target).resolve()
        return os.path.relpath(placed(file, source), page.parent) + hash_mark + anchor

    parts = FENCED.split(page.read_text(encoding="utf-8"))
    return "".join(part if part.startswith("```") else LINK.sub(lead, part) for part in parts)


def placed(file: Path, source: Path) -> Path:
    """Where the site has a file or a folder of the checkout; it is put there where it is not yet."""
    if file.is_relative_to(DOCS):
        place = source / file.relative_to(DOCS)
        return place / "index.md" if file.is_dir() else place
    place = source / "files" / file.relative_to(CHECKOUT)
    if file.is_dir():
        if not place.exists():
            shutil.copytree(file, place, ignore=shutil.ignore_patterns("__pycache__"))
            list_folder(place, file.name.capitalize(), f"The files of the folder `{file.relative_to(CHECKOUT)}`.")
        return place / "index.md"
    place.parent.mkdir(parents=True, exist_ok=True)
    if file.suffix == ".md" and not place.exists():
        shutil.copy(file, place)
        place.write_text(rewrite(place, file, source), encoding="utf-8")
    elif not place.exists():
        shutil.copy(file, place)
    return place


def list_folder(folder: Path, title: str, words: str) -> None:
    """A page that lists what is in a folder, each file by its title."""
    files = sorted(file for file in folder.iterdir() if file.is_file())
    rows = [f"- [{title_of(file)}]({file.name})" for file in files]
    (folder / "index.md").write_text(with_contents("\n".join([f"# {title}", "", words, "", *rows, ""])), "utf-8")


def title_of(file: Path) -> str:
    """The heading of a page, with its number in front where it has one; of a script its name and first line."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".md":
        number = re.match(r"\d+", file.name)
        heading = text.partition("\n")[0].removeprefix("# ")
        return heading if number is None or heading.startswith(number[0].lstrip("0")) else f"{number[0]}: {heading}"
    if file.suffix == ".py":
        return f"{file.name}: {(ast.get_docstring(ast.parse(text)) or '').partition(chr(10))[0]}"
    return f"{file.name}: {text.partition(chr(10))[0].removeprefix('# ')}"


def with_contents(text: str) -> str:
    """A page with a hidden table of contents of the pages that each of its sections lists."""
    parts = re.split(r"^(?=## )", text, flags=re.MULTILINE)
    return "\n".join([text, *(contents(part) for part in parts)])


def contents(section: str) -> str:
    """The table of contents of what a section lists, under its heading; of files that are no pages none."""
    heading = re.match(r"## (.*)", section)
    # Of a notebook that has no page beside it, one is made.
    pages = [(title, re.sub(r"\.ipynb$", ".md", link)) for title, link in LISTED.findall(section)]
    lines = [f"{title} <{link.removesuffix('.md')}>" for title, link in pages if link.endswith(".md")]
    if heading and heading[1] == "Reference":
        lines.insert(1, "Python <reference/python/index>")
    if not lines:
        return ""
    return "\n".join(
        ["```{toctree}", ":hidden:", *([f":caption: {heading[1]}"] if heading else []), "", *lines, "```", ""]
    )


# Packages


def write_packages(folder: Path) -> None:
    """A page for each package of the public face, and one that lists them."""
    folder.mkdir(parents=True)
    names = pages_of_packages()
    for name in names:
        (folder / f"{name}.rst").write_text(package_page(name), encoding="utf-8")
    rows = [f"- :doc:`{name} <{name}>`: {registry.summary(import_module(name))}." for name in names]
    head = ["Python", "======", "", "Every public name of every package, from its docstring.", ""]
    tree = ["", ".. toctree::", "   :hidden:", "", *(f"   {name} <{name}>" for name in names), ""]
    (folder / "index.rst").write_text("\n".join([*head, *rows, *tree]), encoding="utf-8")


def pages_of_packages() -> list[str]:
    """The packages that have a page, and each study."""
    return [f"dampyr.{name}" for name in (*FACE, *(f"studies.{name}" for name in registry.names("dampyr.studies")))]


def package_page(module_name: str) -> str:
    """The page of one package: its docstring, a table of its names, and each of them."""
    module = import_module(module_name)
    lines = [module_name, "=" * len(module_name), "", f".. automodule:: {module_name}", "   :no-members:", ""]
    for owner, names in members(module):
        if owner is not module:
            lines += [
                owner.__name__,
                "-" * len(owner.__name__),
                "",
                f".. automodule:: {owner.__name__}",
                "   :no-members:",
                "",
            ]
        lines += [f".. currentmodule:: {owner.__name__}", ""]
        called = [name for name in names if callable(getattr(owner, name))]
        if len(called) > 1:
            lines += [".. autosummary::", "   :nosignatures:", "", *(f"   {name}" for name in called), ""]
        for name in names:
            lines += described(owner, name)
    if results := results_of(module):
        lines += ["What they return", "----------------", "", "Results, each in the module that makes it.", ""]
        for result in results:
            lines += [
                f".. currentmodule:: {result.__module__}",
                "",
                *described(import_module(result.__module__), result.__name__),
            ]
    return "\n".join(lines)


def results_of(package: ModuleType) -> list[type]:
    """What the calls of a package return and nobody makes by hand: they show themselves, but are not in its ``__all__``."""
    if not hasattr(package, "__path__") or not hasattr(package, "__all__"):
        return []
    other_pages = tuple(f"{name}." for name in pages_of_packages() if name.startswith(f"{package.__name__}."))
    names = [module.name for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")]
    modules = [import_module(name) for name in names if not name.startswith(other_pages)]
    classes = {
        value
        for module in modules
        for name, value in vars(module).items()
        if inspect.isclass(value)
        and issubclass(value, Shown)
        and value.__module__ == module.__name__
        and name[0] != "_"
    }
    return sorted((cls for cls in classes if cls.__name__ not in package.__all__), key=lambda cls: cls.__name__)


def members(module: ModuleType) -> list[tuple[ModuleType, list[str]]]:
    """The public names of a package, by the module that they are taken from.

    They are in its ``__all__``. Without one they are what the module defines itself, and where that is nothing either, as in
    ``dampyr.show.figures``, what each of its modules defines.
    """
    if hasattr(module, "__all__"):
        return [(module, list(module.__all__))]
    if own := defined(module):
        return [(module, own)]
    if module.__name__ == "dampyr.studies":  # each study has a page of its own
        return []
    parts = [member for _, member in registry.members(module.__name__)]
    return [(part, defined(part)) for part in parts if defined(part)]


def defined(module: ModuleType) -> list[str]:
    """The functions and classes that a module defines, in the order of its text, without those that begin with ``_``."""
    own = [
        name
        for name, value in vars(module).items()
        if not name.startswith("_")
        and (inspect.isfunction(value) or inspect.isclass(value))
        and value.__module__ == module.__name__
    ]
    return sorted(own, key=lambda name: inspect.getsourcelines(vars(module)[name])[1])


def described(owner: ModuleType, name: str) -> list[str]:
    """The directive that documents one name."""
    value: Any = getattr(owner, name)
    if inspect.isclass(value) and issubclass(value, Options):  # its fields are on the page of all of them
        page = "thresholds" if issubclass(value, Thresholds) else "options"
        words = f"   The fields, each with its unit and range: :doc:`{page} <../{page}>`."
        return [f".. autoclass:: {name}(**{page})", "   :no-members:", "", words, ""]
    if inspect.isclass(value):
        call = "()" if getattr(value, "_is_protocol", False) else ""  # nobody calls a protocol
        if any("Annotated[" in str(hint) for hint in vars(value).get("__annotations__", {}).values()):
            call = "(**fields)"  # listed below with their words; an annotation with a quantity is no text for people
        return [f".. autoclass:: {name}{call}", "   :members:", ""]
    if callable(value):
        return [f".. autofunction:: {name}", ""]
    if inspect.ismodule(value):  # it has a page of its own
        return [f":doc:`{value.__name__}`: {registry.summary(value)}.", ""]
    words = citations.linked_in_rst(words_below(owner, name), citations.FROM_A_PACKAGE)
    return [f".. py:data:: {name}", "", *(f"   {line}" for line in words.splitlines()), ""]


def words_below(owner: ModuleType, name: str) -> str:
    """The text below the assignment of a constant, in the module that makes it."""
    tree = ast.parse(Path(inspect.getsourcefile(owner) or "").read_text(encoding="utf-8"))
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module and name in [each.name for each in node.names]:
            return words_below(import_module(node.module), name)
    for node, below in itertools.pairwise(tree.body):
        named = isinstance(node, ast.Assign) and name in [getattr(target, "id", "") for target in node.targets]
        words = below.value if isinstance(below, ast.Expr) else None
        if named and isinstance(words, ast.Constant) and isinstance(words.value, str):
            return inspect.cleandoc(words.value)
    raise SystemExit(f"{owner.__name__}.{name} has no words below it that say what it is, which the site would show")


if __name__ == "__main__":
    sys.exit(main())
