"""Every field of every class of options is in call, terminal, equivalent command, request, form and reference page.

So is one that is declared in a copy of the tree."""

import inspect
import pkgutil
import shlex
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import click
import pytest

import dampyr as dp
from dampyr.cli import cli
from dampyr.cli._options import OptionsCommand
from dampyr.options import Option, Options, Thresholds, command_words, options_of

PACKAGES = ("identification", "structures", "campaigns", "planning", "hybrid", "records", "export")
ROOT = Path(__file__).parents[2]


def commands() -> Iterator[tuple[str, OptionsCommand]]:
    with cli.make_context("dampyr", []) as root:
        for name in cli.list_commands(root):
            member = cli.get_command(root, name)
            if isinstance(member, OptionsCommand):
                yield name, member


def classes() -> list[type[Options]]:
    """Every class of options that a package offers, but for its thresholds."""
    modules = [import_module(f"dampyr.{package}") for package in PACKAGES]
    offered = (getattr(module, name) for module in modules for name in module.__all__)
    return sorted(
        {
            each
            for each in offered
            if inspect.isclass(each) and issubclass(each, Options) and not issubclass(each, Thresholds)
        },
        key=str,
    )


def fields() -> list[tuple[type[Options], Option]]:
    return [(cls, option) for cls in classes() for option in options_of(cls)]


TEXTS = {
    "models": "dahl + spring", "add_ons": "spring", "laws": "constant", "units": "mm", "columns": "Load cell",
    "limits": "12mm", "smoothed": "0.1 periods, trailing", "repair": "gaps", "lowpass": "15 f", "cut": "events",
    "factors": "250 N", "offsets": "-12 N", "thousands": ",", "encoding": "cp1252", "delimiter": ";",
}  # fmt: skip


def another(option: Option) -> Any:
    """A value of an option that is not its usual one."""
    if option.kind is bool:
        return not option.default
    if option.several and option.choices:
        return tuple(option.choices)[:3] if tuple(option.choices)[:3] != option.default else tuple(option.choices)[:1]
    single: Any = TEXTS.get(option.name, "dahl.kx")
    if option.name == "force_sign":
        single = -1
    elif option.choices:
        single = next(choice for choice in option.choices if choice != option.default)
    elif option.kind in (int, float):
        low = option.quantity.low if option.quantity and option.quantity.low > -1e9 else 0.0
        single = max(int(low), option.default or 0) + 3 if option.kind is int else low + 0.3125
    named = {"force" if option.name in ("units", "columns", "factors", "offsets") else "dahl.kx": single}
    return named if option.pairs else (single,) if option.several else single


def only(option: Option) -> dict[str, Any]:
    return {option.name: another(option)}


IDS = [f"{cls.__name__}.{option.name}" for cls, option in fields()]


@pytest.mark.parametrize(("cls", "option"), fields(), ids=IDS)
def test_an_option_is_everywhere(cls: type[Options], option: Option) -> None:
    it_is_in_the_call(cls, option)
    it_is_in_the_terminal_and_in_the_equivalent_command(cls, option)
    it_is_in_the_request_and_the_form_of_the_console(cls, option)
    it_is_on_the_reference_page(cls, option)


def it_is_in_the_call(cls: type[Options], option: Option) -> None:
    """Its keyword argument is in the signature and in the docstring of every call that takes the class."""
    calls = [
        call for call in public_calls() if cls.__name__ in str(inspect.signature(call).parameters.get("options", ""))
    ]
    assert calls, f"no call takes {cls.__name__}"
    for call in calls:
        assert inspect.signature(call).parameters[option.name].default == option.default
        assert f"\n{option.name} : {option.values(si=True)}\n" in (call.__doc__ or "")


def test_a_default_is_allowed() -> None:
    """A value that nobody gave is not checked again; those of thresholds neither."""
    offered = (value for package in PACKAGES for value in vars(import_module(f"dampyr.{package}")).values())
    declared = {value for value in offered if inspect.isclass(value) and issubclass(value, Options)}
    assert {cls for cls in declared if issubclass(cls, Thresholds)}
    for option in (option for cls in declared for option in options_of(cls)):
        assert option.checked(option.default) == option.default, option.name


def public_calls() -> list[Any]:
    modules = [import_module(f"dampyr.{package}") for package in PACKAGES]
    return [each for m in modules for name in m.__all__ if inspect.isfunction(each := getattr(m, name))]


def it_is_in_the_terminal_and_in_the_equivalent_command(cls: type[Options], option: Option) -> None:
    """The words that the equivalent command has for a value are read as that value."""
    members = [command for _, command in commands() if cls in command.classes.values()]
    takers = [command for command in members if option in command.options_of(cls)]
    assert takers, f"no command takes {cls.__name__}.{option.name}"
    wanted = cls(**only(option))
    words = command_words(wanted)
    assert words[0] == option.flag
    for command in takers:
        arguments = ["x" for p in command.params if isinstance(p, click.Argument) and p.required]
        needed = [
            word for p in command.params if isinstance(p, click.Option) and p.required for word in (p.opts[0], "x")
        ]
        context = command.make_context("it", [*arguments, *needed, *shlex.split(shlex.join(words))])
        assert wanted in command.chosen(context.params).values()
        assert option.words.split(";")[0][:40] in " ".join(command.get_help(context).split())


def requests() -> dict[type[Options], Any]:
    """Class of options -> the class of the console's requests that hold them."""
    pytest.importorskip("fastapi")
    from dampyr.console.option_schemas import OptionsRequest

    console = import_module("dampyr.console")
    for module in pkgutil.iter_modules(console.__path__, "dampyr.console."):
        import_module(module.name)

    def below(cls: type) -> Iterator[type]:
        for each in cls.__subclasses__():
            yield each
            yield from below(each)

    return {each.OPTIONS: each for each in below(OptionsRequest) if "OPTIONS" in dir(each)}


def it_is_in_the_request_and_the_form_of_the_console(cls: type[Options], option: Option) -> None:
    from_console = requests()[cls]
    from dampyr.console.option_schemas import form_of, request_of

    made = request_of(cls)(**{name: list(v) if isinstance(v, tuple) else v for name, v in only(option).items()})
    assert made.options() == cls(**only(option))
    if option.name in from_console.LEFT_OUT:
        return
    described = from_console.model_json_schema()["properties"][option.name]["description"]
    assert described == f"{option.words}: {option.values(si=True)}."
    [control] = [control for control in form_of(cls) if control["name"] == option.name]
    assert control["words"] == option.words
    assert control["default"] == option.default


def it_is_on_the_reference_page(cls: type[Options], option: Option) -> None:
    page = (ROOT / "docs/reference/options.md").read_text("utf-8")
    [section] = [part for part in page.split("\n## ") if part.startswith(f"`{cls.__name__}`")]
    [row] = [line for line in section.splitlines() if line.startswith(f"| `{option.name}` ")]
    assert f"`{option.flag}" in row
    assert option.words in row


def test_wrong_values_are_sentences() -> None:
    """Each names the option, the value, what is allowed, and how to write it."""
    wrong: Mapping[str, Any] = {
        "loss": "cubes", "settling": "fast", "folds": 2.5, "bandwidth": "5 mm", "session_prior": 8, "nested": "yes",
        "predict": ("weather",), "fixed": {"dahl.kx": "many"}, "models": ("dahl + nothing",), "laws": 3,
    }  # fmt: skip
    for name, value in wrong.items():
        with pytest.raises(ValueError, match=r"\w") as caught:
            dp.identification.FitOptions(**{name: value})
        sentence = str(caught.value)
        assert name in sentence or "nothing" in sentence
        assert "\n" not in sentence
        assert ("0.1 is 10 %" in sentence) is (name == "session_prior")


def test_numbers_may_be_quantities() -> None:
    options = dp.identification.FitOptions(settling="500 ms", bandwidth="0.02 kHz", session_prior="5 %")
    assert (options.settling, options.bandwidth, options.session_prior) == (0.5, 20.0, 0.05)


def test_none_of_several_is_typed_and_read_again() -> None:
    """Without add-ons is another search than with those that are usual."""
    [add_ons] = [option for option in options_of(dp.identification.FitOptions) if option.name == "add_ons"]
    assert command_words(dp.identification.FitOptions(add_ons=())) == ["--add-on", "none"]
    assert add_ons.from_terminal(("none",)) == ()
    assert add_ons.from_terminal(()) == add_ons.default != ()


def test_a_flag_that_is_usually_set_is_refused_where_it_is_declared() -> None:
    @dataclass(frozen=True)
    class Doors(Options):
        open: Annotated[bool, "Whether they are open"] = True

    with pytest.raises(TypeError, match="open: a flag is False where it is not typed"):
        options_of(Doors)


def test_a_request_takes_quantities() -> None:
    pytest.importorskip("fastapi")
    from dampyr.console.option_schemas import request_of

    request = request_of(dp.identification.FitOptions)
    for typed, si in (("500 ms", 0.5), ("0.5", 0.5), (0.5, 0.5), ("5e-1 s", 0.5)):
        assert request(settling=typed).options().settling == si
    assert request(session_prior="5%").options().session_prior == 0.05
    for wrong in ("5 mm", "soon", "-1 s"):
        with pytest.raises(ValueError, match="settling"):
            request(settling=wrong)


def test_a_field_that_is_declared_once_is_everywhere(tmp_path: Path) -> None:
    """In a copy of the tree one line in a class is enough for call, terminal, request, form and reference page."""
    copy = tmp_path / "src"
    subprocess.run(["cp", "-r", str(ROOT / "src"), str(copy)], check=True)
    path = copy / "dampyr/identification/fits/fit_options.py"
    declared = '    patience: Annotated[float, Quantity("s", low=0), "How long one waits for a damper"] = 3.0\n\n    def check('
    text = path.read_text("utf-8")
    assert text.count("\n    def check(") == 1
    path.write_text(text.replace("\n    def check(", f"\n{declared}"), "utf-8")
    seen = subprocess.run(
        [sys.executable, "-c", SEEN], env={"PYTHONPATH": str(copy), "PATH": "/usr/bin"}, capture_output=True, text=True
    )
    assert seen.returncode == 0, seen.stderr


SEEN = """
import inspect, click
from dampyr.identification import FitOptions, fit, fit_specimens
from dampyr.cli import cli
from dampyr.console.identify_schemas import IdentifyRequest
from dampyr.console.option_schemas import form_of
from dampyr.console.equivalent_commands import identify_command
for call in (fit, fit_specimens):
    assert inspect.signature(call).parameters["patience"].default == 3.0
    assert "How long one waits" in call.__doc__
with cli.make_context("dampyr", []) as root:
    command = cli.get_command(root, "identify")
    assert "How long one waits" in command.get_help(click.Context(command, info_name="identify"))
assert IdentifyRequest.model_json_schema()["properties"]["patience"]["default"] == 3.0
assert any(control["name"] == "patience" for control in form_of(FitOptions))
assert "--patience 4" in identify_command(IdentifyRequest(records=["a"], model="dahl", patience=4.0))
"""
