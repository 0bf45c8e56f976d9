"""Options of a command that are declared in a class of options (`dampyr.options`).

::

    @click.command(cls=OptionsCommand, options={"options": "dampyr.identification:FitOptions"})
    @click.argument("paths", nargs=-1)
    def command(paths: tuple[Path, ...], options: FitOptions) -> None:

They are made when the command is parsed or its help is asked for: ``dampyr --help`` lists the commands without loading the
packages that declare their options.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

import click

from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.options import Option


class OptionsCommand(click.Command):
    """A command with the options of classes: argument of the function -> where its class is, as ``package:class``.

    What is typed comes as one object of each class; the names in ``leave_out`` are given in another way. In the help they
    stand after the ``first`` options that the function declares.
    """

    def __init__(
        self, *rest: Any, options: Mapping[str, str], leave_out: tuple[str, ...] = (), first: int = 0, **settings: Any
    ) -> None:
        self._params: list[click.Parameter] = []
        self._places, self._left_out, self._first, self._is_complete = dict(options), leave_out, first, False
        super().__init__(*rest, **settings)

    @property
    def params(self) -> list[click.Parameter]:
        """Those that the function declares, and between its arguments and its options those of the classes."""
        if not self._is_complete:
            self._is_complete = True
            arguments = [p for p in self._params if isinstance(p, click.Argument)]
            others = [p for p in self._params if not isinstance(p, click.Argument)]
            of_classes = [click_option(option) for cls in self.classes.values() for option in self.options_of(cls)]
            self._params = [*arguments, *others[: self._first], *of_classes, *others[self._first :]]
        return self._params

    @params.setter
    def params(self, declared: list[click.Parameter]) -> None:
        self._params = declared

    @cached_property
    def classes(self) -> dict[str, type]:
        """Argument of the function -> the class of its options."""
        places = {argument: place.split(":") for argument, place in self._places.items()}
        return {argument: getattr(import_module(package), name) for argument, (package, name) in places.items()}

    def options_of(self, cls: type) -> list[Option]:
        """The options of one class that are typed."""
        from dampyr.options import options_of

        return [option for option in options_of(cls) if option.name not in self._left_out]

    def chosen(self, typed: Mapping[str, Any]) -> dict[str, Any]:
        """The object of options for each argument, of what click read."""
        return {
            argument: cls(**{option.name: option.from_terminal(typed[option.name]) for option in self.options_of(cls)})
            for argument, cls in self.classes.items()
        }

    def invoke(self, context: click.Context) -> Any:
        """Call the function, with one object for what was typed of each class."""
        names = {option.name for cls in self.classes.values() for option in self.options_of(cls)}
        others = {name: value for name, value in context.params.items() if name not in names}
        context.params = others | self.chosen(context.params)
        return super().invoke(context)


def refuse_typed(names: Collection[str], why: str) -> None:
    """Refuse the first parameter of the running command among ``names`` that was typed; ``why`` follows its name."""
    context = click.get_current_context()
    for parameter in context.command.params:
        source = context.get_parameter_source(str(parameter.name))
        if parameter.name in names and source is not click.core.ParameterSource.DEFAULT:
            name = parameter.opts[0] if isinstance(parameter, click.Option) else parameter.human_readable_name
            raise InputError(f"{name} {why}")


def click_option(option: Option) -> click.Option:
    """The option as click has it: its text is read by `Option.from_terminal`."""
    name, help_text = option.name, f"{option.words}."
    if option.kind is bool:
        return click.Option([option.flag, name], is_flag=True, help=help_text)
    several = option.several or option.pairs
    if option.default_text and not option.adds:
        help_text += f"  [default: {option.default_text}]"
    return click.Option([option.flag, name], multiple=several, metavar=option.metavar, help=help_text)
