"""The kinds of repair by name, and the option that names some of them."""

from __future__ import annotations

from dampyr.errors import InputError

REPAIR_KINDS = ("false samples", "gaps", "force drift", "position drift")
GAPS = REPAIR_KINDS[1]
NONE = "none"


def as_repairs(text: object) -> tuple[str, ...]:
    """The kinds that ``text`` names, in their order, "none" being no kind; else an :class:`~dampyr.errors.InputError`.

    A dash is a blank, as shells like it: ``false-samples,gaps``.
    """
    words = [word.strip().replace("-", " ") for word in text.split(",")] if isinstance(text, str) else []
    if words == [NONE]:
        return ()
    unknown = [word for word in words if word not in REPAIR_KINDS]
    if not words or unknown:
        raise InputError(
            f"repair = {text!r} is not known; choose from {', '.join(REPAIR_KINDS)}, several with commas between them, or "
            f"{NONE}, which undoes those that an .h5 file holds"
        )
    return tuple(kind for kind in REPAIR_KINDS if kind in words)
