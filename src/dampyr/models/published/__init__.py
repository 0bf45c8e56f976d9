"""Published parameter sets: TOML files with the printed numbers, their units and their source.

`available_sets` lists the sets, `about` says where one comes from and what was read of it, and `damper` makes it::

    import dampyr as dp

    damper = dp.models.published.damper("spencer_1997")
    force = damper.force(t, x, voltage=1.5)
    print(dp.models.published.about("spencer_1997").differs)

A set whose paper was not read itself names the quotation that was. Sets that claim the same source and differ are all here,
and each names the others. The damper of Raminelli (2020) is `dampyr.studies.raminelli_2020.damper`.

A new set is a new file of this folder: `dampyr.models.published._about.About` lists its keys, and its ``model`` is one of
`dampyr.models.published._conversion`, which has the arithmetic to SI. A file whose sets share most numbers has what each has
of its own in tables ``sets``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from pathlib import Path

from dampyr.errors import InputError, MissingData, choose_from, did_you_mean
from dampyr.models.damper import Damper
from dampyr.models.published._about import About, read_sets

__all__ = ["about", "available_sets", "card_or_published", "damper"]


@lru_cache(maxsize=1)
def _sets() -> dict[str, About]:
    files = sorted(Path(__file__).parent.glob("*.toml"))
    return {name: about for file in files for name, about in read_sets(file).items()}


def available_sets() -> list[str]:
    """The names of all sets."""
    return sorted(_sets())


def about(name: str) -> About:
    """Where the set called ``name`` comes from; :class:`~dampyr.errors.InputError` lists the names if there is none."""
    if name not in _sets():
        raise InputError(f"{name!r} is not among the published sets; {choose_from(name, available_sets())}")
    return _sets()[name]


def damper(name: str) -> Damper:
    """The damper of the set called ``name``, in SI; :class:`~dampyr.errors.InputError` if there is none.

    Examples
    --------
    >>> import dampyr as dp
    >>> damper = dp.models.published.damper("spencer_1997")
    >>> str(damper.composition), damper.range
    ('modified_bouc_wen + offset + lag', (0.0, 2.25))
    """
    return about(name).damper()


MAX_FILES = 6  # of a folder that an error names


def card_or_published(
    name: str | Path, folder: str | Path | None = None, others: Mapping[str, Callable[[], Damper]] | None = None
) -> Damper:
    """The damper of a card, which a relative ``name`` has in ``folder``, or the published one of that name.

    A file of this name comes first. ``others`` are published dampers besides the sets of this package, by their names.
    :class:`~dampyr.errors.MissingData` where there is neither: it lists the names, and the cards that are there.
    """
    path = Path(folder or "") / name
    if path.is_file():
        return Damper.load(path)
    published = dict(others or {}) | {own: partial(damper, own) for own in available_sets()}
    if str(name) in published:
        return published[str(name)]()
    files = sorted(file.name for file in path.parent.glob("*.toml")) if path.parent.is_dir() else []
    more = f" and {len(files) - MAX_FILES} more" if len(files) > MAX_FILES else ""
    there = f"{', '.join(files[:MAX_FILES])}{more}" if files else "no .toml file"
    hint = did_you_mean(str(name), [*published, *files])
    raise MissingData(
        f"{path}: there is no such card, and no published damper of this name; {hint}in {path.parent} there is {there}, "
        f"published are {', '.join(sorted(published))}; `dampyr identify ... --save CARD` writes a card"
    )
