"""The page of a result, found by its type."""

from __future__ import annotations

from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Any

from dampyr.errors import InputError
from dampyr.show.pages.html_page import write_html

PAGES = {
    "Fit": "fit_page",
    "Validated": "validate_page",
    "Accepted": "acceptance_page",
    "JudgedSpecimens": "judgement_page",
    "Response": "response_page",
    "Responses": "response_page",
    "EnsembleResult": "ensemble_page",
    "GroundMotion": "motion_page",
    "Plan": "plan_page",
    "HybridResult": "hybrid_page",
    "SpecimenHistories": "specimens_page",
    "ProtocolResult": "protocol_page",
    "CycleFigures": "cycles_page",
    "Arena": "arena_page",
    "ControlSearch": "search_page",
    "Posterior": "posterior_page",
}
"""The class of a result, and the module of its page, which is loaded when such a page is first written."""


def write_page(result: Any, path: str | Path, **choices: Any) -> Path:
    """Write the page of a result, one self-contained HTML file, and return its path.

    Parameters
    ----------
    result
        A fit, samples of its posterior, what `dampyr.identification.validate` or `accept` or `dampyr.campaigns.judge` or
        `judge_protocol` gives, a response or several, an ensemble, an arena, a search, a ground motion, a plan, a hybrid test,
        the histories of `dampyr.records.specimens` or what `dampyr.records.cycles` gives; or the text of a page that
        `dampyr.show.page` makes.
    path
        The file to write; its folder is made where it is not there.
    choices
        Of a fit ``sections``, which come after its first; of a ground motion ``dampings``, the damping ratios of its spectra,
        and ``periods`` of their table, s; of an ensemble its ``title``.

    Raises
    ------
    InputError
        for a result without a page, or without anything to show, such as an acceptance without a judgement.

    Examples
    --------
    >>> import dampyr as dp, tempfile
    >>> folder = tempfile.mkdtemp()
    >>> dp.show.write_page(dp.ground_motions.el_centro(), f"{folder}/motion.html").name
    'motion.html'
    """
    if isinstance(result, str):
        return write_html(path, result)
    names = [cls.__name__ for cls in type(result).__mro__ if cls.__name__ in PAGES]
    if not names:
        raise InputError(
            f"write_page: {type(result).__name__} has no page; give one of {', '.join(PAGES)}, or the text that page() makes"
        )
    html = import_module(f"dampyr.show.pages.{PAGES[names[0]]}").html
    offered = [name for name in list(signature(html).parameters)[1:] if name != "call"]
    for name in choices:
        if name not in offered:
            raise InputError(
                f"write_page(..., {name}=): the page of {names[0]} has no such choice; "
                + (f"it has {', '.join(offered)}" if offered else "leave it out")
            )
    return write_html(path, html(result, call=f"dampyr.show.write_page(result, {Path(path).name!r})", **choices))
