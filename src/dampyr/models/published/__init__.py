"""Published parameter sets, one file each: the printed numbers, their units, and the arithmetic to SI.

`names` lists the sets, `about` says where one comes from and what was read of it, and `damper` makes it::

    import dampyr as dp

    damper = dp.models.published.damper("spencer_1997")
    force = damper.force(t, x, voltage=1.5)
    print(dp.models.published.about("spencer_1997").differs)

A set whose paper was not read itself says whose quotation was. Sets that claim the same source and differ are all here,
and each names the others. The damper of Raminelli (2020) is `dampyr.studies.raminelli_2020.damper`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dampyr import registry

if TYPE_CHECKING:
    from dampyr.models.damper import Damper
    from dampyr.models.published._about import About

__all__ = ["about", "damper", "names"]


def names() -> list[str]:
    """The names of all sets."""
    return registry.names(__name__)


def about(name: str) -> About:
    """Where the set called ``name`` comes from; :class:`~dampyr.errors.InputError` with the known names if there is none."""
    result: About = registry.member(__name__, name).ABOUT
    return result


def damper(name: str) -> Damper:
    """The damper of the set called ``name``, in SI; :class:`~dampyr.errors.InputError` if there is none.

    A set whose loops bulge the wrong way is made with a :class:`~dampyr.errors.DampyrWarning`.
    """
    made: Damper = registry.member(__name__, name).damper()
    return made
