"""Write every generated list of the documentation, and the pages that are generated whole.

::

    python tools/make_docs.py           # make docs: writes what has changed, and names it
    python tools/make_docs.py --check   # writes nothing; exit status 1 and the pages that are out of date

A generated list stands in a page between ``<!-- generated: NAME -->`` and ``<!-- end -->``, on lines of their own or in a line,
and NAME is one of `LISTS`. All of them are read from the registries, so that a new member is in every list without an edit.
"""

from __future__ import annotations

import argparse
import inspect
import re
import runpy
import sys
from collections.abc import Callable, Iterator
from dataclasses import MISSING, Field, fields
from importlib import import_module
from pathlib import Path
from textwrap import fill
from typing import Any, get_origin, get_type_hints

import citations
import click
import gallery
from page_notebook import notebook

import dampyr as dp
from dampyr import registry
from dampyr.cli import cli
from dampyr.cli._examples import examples_of
from dampyr.cli._options import OptionsCommand
from dampyr.config import origin, split
from dampyr.console import command_words
from dampyr.models import published
from dampyr.models.part import part
from dampyr.options import Option, Thresholds, options_of
from dampyr.phrases import listing
from dampyr.records.datasets import available_data_sets, data_set
from dampyr.structures.law_form import SHARED
from dampyr.structures.sensors import MEASURES
from dampyr.units import Quantity, for_people

CHECKOUT = Path(__file__).resolve().parents[1]
PROTOCOLS = "dampyr.campaigns.protocols"
PARTS, STEPS, LAWS = "dampyr.models.parts", "dampyr.campaigns.steps", "dampyr.structures.control"
RECORDS, MOTIONS = "dampyr.records.formats", "dampyr.ground_motions.formats"
EXPORTS, STUDIES, COMMANDS = "dampyr.export.kinds", "dampyr.studies", "dampyr.cli"
WHOLE_PAGES = {"docs/explanations/generated-kernel.md": "docs/explanations/make_generated_kernel.py"}
NOTEBOOKS = ("docs/tutorials/first-damper.md",)  # pages that are notebooks too
BIBLIOGRAPHY = "bibliography.md"  # beside the pages that docstrings are written into
COMMANDS_PAGE = "docs/reference/commands.md"
MARKS = re.compile(r"(<!-- generated: ([\w-]+) -->)(.*?)(<!-- end -->)", re.DOTALL)
LINE = 140  # characters of a line of prose
HELP_WIDTH = 140  # characters of a command's summary


def main() -> int:
    """Write the pages, or name those that are out of date."""
    parser = argparse.ArgumentParser(description="Generated lists and pages of the documentation.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit status 1 where a page is out of date")
    check = parser.parse_args().check
    changed = {path: text for path, text in pages() if path.read_text(encoding="utf-8") != text}
    for path, text in changed.items():
        if not check:
            path.write_text(text, encoding="utf-8")
        print(f"{path.relative_to(CHECKOUT)} {'is out of date: run make docs' if check else 'written'}")
    return int(check and bool(changed))


def pages() -> Iterator[tuple[Path, str]]:
    """Every page with a generated list, and every page that is generated whole, as it has to be."""
    for path in sorted((CHECKOUT / "docs").rglob("*.md")):
        text = path.read_text(encoding="utf-8")
        if MARKS.search(text):
            yield path, MARKS.sub(_filled, text)
    for page in NOTEBOOKS:
        yield (CHECKOUT / page).with_suffix(".ipynb"), notebook(CHECKOUT / page)
    for page, generator in WHOLE_PAGES.items():
        yield CHECKOUT / page, runpy.run_path(str(CHECKOUT / generator))["page"]()


def _filled(marks: re.Match[str]) -> str:
    opening, name, before, end = marks.groups()
    if name not in LISTS:
        raise SystemExit(f"there is no generated list {name!r}; choose from {', '.join(sorted(LISTS))}")
    text = LISTS[name]().strip("\n")
    return f"{opening}\n{text}\n{end}" if before.startswith("\n") else f"{opening}{text}{end}"


def in_line(package: str) -> str:
    """The names of the members, in a line."""
    return ", ".join(f"`{name}`" for name in registry.names(package))


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" if line[0] != "---" else f"|{'|'.join(line)}|" for line in lines)


def markdown(text: str) -> str:
    """A docstring as Markdown: displayed equations, mathematics in a line, code."""
    text = re.sub(r"^\.\. math:: (.*(?:\n[ ]+\S.*)*)", lambda m: "$$" + " ".join(m[1].split()) + "$$", text, flags=re.M)
    text = re.sub(r":math:`([^`]+)`", r"$\1$", text)
    text = re.sub(r":(?:class|func|mod):`~?([^`]+)`", r"`\1`", text)
    text = re.sub(r"``([^`]+)``", r"`\1`", text).replace("\\|v\\|", "|v|")
    return citations.linked(text, BIBLIOGRAPHY)


def about(module: Any) -> str:
    """The docstring of a module as Markdown."""
    return markdown(inspect.getdoc(module) or "")


def cell(text: str) -> str:
    """A text as a cell of a table."""
    return markdown(" ".join(text.split())).replace("|", "\\|")


# Models


def part_sections() -> str:
    """Each part: its docstring, its states and its parameters."""
    return "\n".join(map(part_section, registry.names(PARTS)))


def part_section(name: str) -> str:
    """The section of one part."""
    p = part(name)
    states = ", ".join(f"`{key}` in [{low:g}, {high:g}]" for key, (low, high) in p.states.items()) or "none"
    rows = [
        [f"`{key}`", q.unit or "1", q.range_in_words(), "yes" if q.linear else "no"] for key, q in p.parameters.items()
    ]
    parameters = table(["parameter", "unit", "allowed", "linear"], rows)
    picture = f"<!-- loops: {name} -->"  # the site has the picture here (tools/part_loops.py)
    return "\n".join([f"## `{name}`", "", picture, "", about(p.module), "", f"State: {states}.", "", parameters, ""])


def other_parts() -> str:
    """The parts that the page of the loops has not placed yet, with their pictures."""
    text = (CHECKOUT / "docs" / "how-to" / "which-model.md").read_text(encoding="utf-8")
    by_hand = MARKS.sub("", text)
    shown = {name for names in re.findall(r"<!-- loops: ([\w ]+) -->", by_hand) for name in names.split()}
    others = [name for name in registry.names(PARTS) if name not in shown]
    if not others:
        return ""
    return f"Further parts: {listing([f'`{name}`' for name in others])}.\n\n<!-- loops: {' '.join(others)} -->"


def set_table() -> str:
    """One row for each published set."""
    rows = []
    for name in published.available_sets():
        one = published.about(name)
        low, high = one.limits
        others = ", ".join(f"`{other}`" for other in one.differs) or "-"
        rows.append([f"[`{name}`](#{name})", one.claims, f"{low:g} to {high:g} {one.input}", others])
    return table(["set", "claims", "input", "differs from"], rows)


def set_sections() -> str:
    """Each published set with its numbers as printed."""
    return "\n".join(map(set_section, published.available_sets()))


def set_section(name: str) -> str:
    """The section of one published set."""
    one = published.about(name)
    items = [
        f"**Paper:** {one.paper}; {one.where}.",
        f"**Read:** {one.read}.",
        f"**Device:** {one.device}.",
        f"**Input:** {one.limits[0]:g} to {one.limits[1]:g} {one.input}: {one.limits_from}.",
        *(f"**Note:** {note}." for note in one.notes),
        *(f"**Differs:** `{other}` {what}." for other, what in one.differs.items()),
    ]
    lines = [fill(item, 118, subsequent_indent="  ", break_long_words=False, initial_indent="- ") for item in items]
    rows = [[f"`{letter}`", f"{number:.15g}", unit] for letter, (number, unit) in one.printed.items()]
    printed = table(["as printed", "number", "unit"], rows)
    return "\n".join([f"## `{name}`", "", markdown(one.description), "", *lines, "", printed, ""])


# Gallery


def gallery_list() -> str:
    """The scripts of the gallery by their titles, section by section."""
    lines = []
    for section, title in gallery.SECTIONS.items():
        listed = [entry for entry in gallery.entries() if entry.name.startswith(f"{section}/")]
        lines += [f"## {title}", "", *(f"- [{entry.words[0]}]({entry.name}.py)" for entry in listed), ""]
    return "\n".join(lines)


# Data sets


def dataset_table() -> str:
    """One row for each data set."""
    rows = []
    for name in available_data_sets():
        one = data_set(name)
        size = f"{one.size / 1e6:.2g} MB" if one.size >= 1e6 else f"{one.size / 1e3:.0f} kB" if one.size else "unknown"
        rows.append([f"[`{name}`](#{name})", one.kind, one.licence_in_words, str(one.count or "unknown"), size])
    return table(["data set", "of", "licence", "files", "size"], rows)


def dataset_sections() -> str:
    """Each data set in full."""
    return "\n".join(map(dataset_section, available_data_sets()))


def dataset_section(name: str) -> str:
    """The section of one data set."""
    one = data_set(name)
    given = sum(bool(file.sha256) for file in one.contents)
    number = len(one.contents)
    sums = f"{given} of {number} in dampyr" if number else "none; dampyr does not know the files one by one"
    if number > given:
        sums += "; the others are recorded at the first fetch"
    got = (
        "by `dampyr datasets fetch`"
        if one.base_url
        else "from the page, then `--from FOLDER`"
        if number
        else "from the page"
    )
    items = [
        f"**Holds:** {one.holds}.",
        f"**Good for:** {one.good_for}.",
        f"**Specimen:** {one.specimen}.",
        f"**Format:** {one.format}.",
        f"**Licence:** {one.licence_in_words} ({one.licence_from}).",
        f"**Cite as:** {one.citation}.",
        f"**Page:** <{one.page}>" + (f", doi [{one.doi}](https://doi.org/{one.doi})." if one.doi else "."),
        f"**Got:** {got}. Checksums: {sums}.",
        *(f"**Note:** {note}." for note in one.notes),
    ]
    lines = [fill(item, 118, subsequent_indent="  ", break_long_words=False, initial_indent="- ") for item in items]
    return "\n".join([f"## `{name}`", "", f"{one.title}.", "", *lines, ""])


# Campaigns


def campaign_header() -> str:
    """The fields above the steps of a campaign."""
    from dampyr.campaigns.campaign import Header

    return field_table(Header)


def step_sections() -> str:
    """Each kind of step: its purpose, its path, and its fields."""
    from dampyr.campaigns.kinds import kind

    sections = [
        [f"## `{name}`", "", about(module), "", field_table(kind(name)), ""] for name, module in registry.members(STEPS)
    ]
    return "\n".join("\n".join(section) for section in sections)


def protocol_sections() -> str:
    """Each kind of protocol: its purpose and its fields."""
    from dampyr.campaigns.kinds import protocol_kind

    sections = [
        [f"## `{name}`", "", about(module), "", field_table(protocol_kind(name)), ""]
        for name, module in registry.members(PROTOCOLS)
    ]
    return "\n".join("\n".join(section) for section in sections)


def field_table(cls: Any) -> str:
    """The fields of a dataclass."""
    hints = get_type_hints(cls, include_extras=True)
    rows = [
        [f"`{f.name}`", unit_of(hints[f.name]), default_of(f, hints[f.name]), origin(hints[f.name])]
        for f in fields(cls)
    ]
    return table(["field", "unit", "default", "what"], rows)


def unit_of(hint: Any) -> str:
    """The SI unit, or what else a value is; of a list, of each entry."""
    plain, quantity = split(hint)
    words = {int: "whole number", str: "text", bool: "true or false", float: "1"}
    label = words[plain] if quantity is None or plain is int else quantity.unit or "1"
    label = label if label != "1" else "–"
    return f"list, {label}" if get_origin(plain) is tuple else label


def default_of(field: Field[Any], hint: Any) -> str:
    """The default as a person types it."""
    if field.default is MISSING:
        return "required"
    _, quantity = split(hint)
    if field.default is None:
        return "none"
    if isinstance(field.default, bool):
        return str(field.default).lower()
    if quantity is None or not quantity.unit:
        return f"{field.default}".removesuffix(".0") or "none"
    return typed(field.default, quantity)


def typed(value: Any, quantity: Quantity) -> str:
    """A value in the unit that people read."""
    unit, factor = ("s", 1.0) if quantity.unit == "s" else for_people(quantity.unit)
    if isinstance(value, tuple):
        return ", ".join(f"{each * factor:g} {unit}" for each in value)
    return f"{value * factor:g} {unit}"


# Control laws


def law_table() -> str:
    """One row for each control law: what it is, its equation, and its own settings."""
    rows = []
    for name, module in registry.members(LAWS):
        own = [field for field in fields(class_of(module)) if field.name not in SHARED]
        settings = ", ".join(f"`{field.name}`{setting(field.default)}" for field in own)
        label, _, words = registry.summary(module).partition(": ")
        equation = re.search(r"^\$\$(.*)\$\$$", about(module), flags=re.M)
        rows.append([f"`{name}`", words or label, f"${equation[1]}$" if equation else "", settings])
    return table(["law", "what", "input", "settings of its own"], rows)


def measures() -> str:
    """One row for each quantity that a law can measure."""
    return table(
        ["measure", "unit", "what"], [[f"`{name}`", m.unit.replace("^2", "²"), m.about] for name, m in MEASURES.items()]
    )


def setting(default: Any) -> str:
    """The default of a setting, where it is a number."""
    return f" = {default:g}" if isinstance(default, float) else ""


def class_of(module: Any) -> type:
    """The class that is called as its file."""
    wanted = module.__name__.rpartition(".")[2].replace("_", "")
    return next(c for name, c in vars(module).items() if isinstance(c, type) and name.lower() == wanted)


def sections_of(package: str) -> str:
    """Each member with its docstring."""
    return "\n".join(f"## `{name}`\n\n{about(module)}\n" for name, module in registry.members(package))


# Formats


def record_formats() -> str:
    """One row for each format of records."""
    rows = []
    for name, module in registry.members(RECORDS):
        written = "reads and writes" if hasattr(module, "write") else "reads"
        rows.append([f"`.{name}`", getattr(module, "TITLE", name.upper()), written, cell(registry.summary(module))])
    return table(["suffix", "format", "reads, writes", "what"], rows)


def record_suffixes() -> str:
    """The suffixes of records, in a line."""
    return ", ".join(f"`.{name}`" for name in registry.names(RECORDS))


def motion_formats() -> str:
    """One row for each format of ground motions."""
    rows = [
        [
            ", ".join(f"`{suffix}`" for suffix in module.SUFFIXES) or "any, by its content",
            cell(registry.summary(module)),
        ]
        for _, module in registry.members(MOTIONS)
    ]
    return table(["suffix", "what"], rows)


def motion_suffixes() -> str:
    """The suffixes of ground motions, in a line."""
    return ", ".join(f"`{suffix}`" for _, module in registry.members(MOTIONS) for suffix in module.SUFFIXES)


def export_kinds() -> str:
    """One row for each kind of export."""
    rows = [[f"`{name}`", cell(registry.summary(module))] for name, module in registry.members(EXPORTS)]
    return table(["`--to`", "what is written"], rows)


# Commands


def commands() -> Iterator[tuple[str, click.Command]]:
    """Every command, and those of its groups, by what is typed after ``dampyr``."""
    context = click.Context(cli)
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command is not None
        subcommands = getattr(command, "commands", {})
        yield from ((f"{name} {each}", sub) for each, sub in subcommands.items())
        if not isinstance(command, click.Group):
            yield name, command


def command_table() -> str:
    """One row for each command."""
    rows = [[f"`dampyr {name}`", cell(command.get_short_help_str(HELP_WIDTH))] for name, command in commands()]
    return table(["command", "what"], rows)


def command_places() -> str:
    """Where the console has each command, or why it has not."""
    rows = [
        [
            f"`dampyr {name}`",
            f"{page.capitalize()}{' and Commands' if page != 'commands' and not why else ''}" if page else "–",
            cell(why) or "–",
        ]
        for name, page, why in command_words.command_places()
    ]
    return table(["command", "page", "why not"], rows)


def command_sections() -> str:
    """Each command that has no section in the page of the commands yet: its help and its options."""
    page = MARKS.sub("", (CHECKOUT / COMMANDS_PAGE).read_text(encoding="utf-8"))
    headings = [line for line in page.splitlines() if line.startswith("## ")]
    return "\n".join(
        command_section(name, command)
        for name, command in commands()
        if not any(re.search(rf"`dampyr {re.escape(name)}[ `]", line) for line in headings)
    )


def command_section(name: str, command: click.Command) -> str:
    """The section of one command."""
    arguments = " ".join(
        p.make_metavar(click.Context(command)) for p in command.params if p.param_type_name == "argument"
    )
    options = [p for p in command.params if isinstance(p, click.Option) and "--json" not in p.opts and not p.hidden]
    rows = [[", ".join(f"`{spelled}`" for spelled in p.opts), cell(p.help or "")] for p in options]
    text = re.sub(r"(?<!\n)\n(?!\n)", " ", inspect.cleandoc(command.help or ""))
    parts = [f"## `{f'dampyr {name} {arguments}'.rstrip()}`", "", fill(text, 118), ""]
    return "\n".join([*parts, *([table(["option", "what"], rows), ""] if rows else [])])


def command_examples() -> str:
    """The examples of every command's help, in one block."""
    groups = [examples_of(command) for _, command in commands()]
    return "\n".join(["```sh", *dict.fromkeys(line for group in groups for line in group), "```"])


# Options


def options_commands() -> Iterator[tuple[str, OptionsCommand]]:
    """The commands with options of classes, by what is typed after ``dampyr``."""
    return ((name, command) for name, command in commands() if isinstance(command, OptionsCommand))


def option_classes() -> list[type]:
    """Every class of options that a command takes, in the order of their names."""
    return sorted(
        {cls for _, command in options_commands() for cls in command.classes.values()}, key=lambda c: c.__name__
    )


def option_sections() -> str:
    """Each class of options: who takes it, and its options."""
    return "\n".join(map(option_section, option_classes()))


def threshold_sections() -> str:
    """Each class of judgements, and its fields."""
    packages = [import_module(f"dampyr.{name}") for name in sorted(dp._PACKAGES)]
    offered = [getattr(package, name) for package in packages for name in getattr(package, "__all__", ())]
    classes = [cls for cls in offered if inspect.isclass(cls) and issubclass(cls, Thresholds)]
    return "\n".join(map(threshold_section, classes))


def threshold_section(cls: type) -> str:
    """The section of one class of judgements."""
    rows = [[f"`{o.name}`", f"{o.default:g}", cell(o.values(si=True)), cell(meaning(o))] for o in options_of(cls)]
    summary = fill((inspect.getdoc(cls) or "").partition("\n\n")[0].replace("``", "`"), 118)
    return "\n".join([f"## `{cls.__name__}`", "", summary, "", table(["field", "default", "value", "what"], rows), ""])


def option_section(cls: type) -> str:
    """The section of one class."""
    package = import_module(".".join(cls.__module__.split(".")[:2]))
    functions = {name: getattr(package, name) for name in package.__all__ if inspect.isfunction(getattr(package, name))}
    calls = [
        f"`{package.__name__}.{name}`"
        for name, call in functions.items()
        if cls.__name__ in str(inspect.signature(call).parameters.get("options", ""))
    ]
    typed = [f"`dampyr {name}`" for name, command in options_commands() if cls in command.classes.values()]
    rows = [
        [
            f"`{o.name}`",
            f"`{o.flag}`",
            cell(o.values()),
            f"`{o.default_text}`" if o.default_text else "",
            cell(meaning(o)),
        ]
        for o in options_of(cls)
    ]
    taken = fill(f"Taken by {listing(calls)} and {listing(typed)}.", 118)
    return "\n".join(
        [f"## `{cls.__name__}`", "", taken, "", table(["argument", "option", "value", "default", "what"], rows), ""]
    )


def meaning(option: Option) -> str:
    """What an option is, and what each of its choices means."""
    meanings = [f"{name}: {words}" for name, words in (option.choices or {}).items() if words != name]
    return f"{option.words}. {'; '.join(meanings)}" if meanings else option.words


def option_names(command: str) -> Callable[[], str]:
    """The options of a command that come from classes, each class with its section."""

    def names() -> str:
        member = dict(options_commands())[command]
        flags = {
            cls: ", ".join(f"`{option.flag}`" for option in member.options_of(cls)) for cls in member.classes.values()
        }
        listed_by_class = "; ".join(
            f"{listed} ([{cls.__name__}](options.md#{cls.__name__.lower()}))" for cls, listed in flags.items()
        )
        return fill(f"{listed_by_class}.", width=LINE, break_long_words=False, break_on_hyphens=False)

    return names


LISTS: dict[str, Callable[[], str]] = {
    "parts": lambda: in_line(PARTS),
    "part-sections": part_sections,
    "gallery": gallery_list,
    "other-parts": other_parts,
    "set-table": set_table,
    "set-sections": set_sections,
    "steps": lambda: in_line(STEPS),
    "dataset-table": dataset_table,
    "dataset-sections": dataset_sections,
    "campaign-header": campaign_header,
    "step-sections": step_sections,
    "protocol-sections": protocol_sections,
    "control-laws": lambda: in_line(LAWS),
    "law-table": law_table,
    "measures": measures,
    "law-sections": lambda: sections_of(LAWS),
    "record-suffixes": record_suffixes,
    "record-formats": record_formats,
    "motion-suffixes": motion_suffixes,
    "motion-formats": motion_formats,
    "export-names": lambda: in_line(EXPORTS),
    "export-kinds": export_kinds,
    "studies": lambda: in_line(STUDIES),
    "study-sections": lambda: sections_of(STUDIES),
    "commands": lambda: ", ".join(f"`{name.replace('_', '-')}`" for name in registry.names(COMMANDS)),
    "command-table": command_table,
    "command-places": command_places,
    "command-examples": command_examples,
    "command-sections": command_sections,
    "option-sections": option_sections,
    "threshold-sections": threshold_sections,
    **{f"options-of-{name.replace(' ', '-')}": option_names(name) for name, _ in options_commands()},
    "bibliography": citations.sections,
}


if __name__ == "__main__":
    sys.exit(main())
