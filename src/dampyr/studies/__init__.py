"""Published studies run again, the published value beside ours, and the demonstration of the whole chain."""

from types import ModuleType

from dampyr import catalogue


def __getattr__(name: str) -> ModuleType:
    if not name.startswith("_") and name in catalogue.names(__name__):
        return catalogue.member(__name__, name)
    raise AttributeError(f"module {__name__!r} has no study {name!r}; there are {', '.join(catalogue.names(__name__))}")
