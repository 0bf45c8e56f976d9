r"""What names of the code are for a reader: :math:`k_x` for kx, :math:`\rho` for rho as in formulas; laws in words."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η", "theta": "θ",
    "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ",
    "psi": "ψ", "omega": "ω",
}  # fmt: skip
# a Greek word or a letter, and an index of at most one sign; what is longer is a word
_SYMBOL = re.compile(rf"({'|'.join(sorted(GREEK, key=len, reverse=True))}|[A-Za-z])_?(\w?)")


def symbol(name: str) -> tuple[str, str] | None:
    """The letter of a parameter and its index: ("k", "x") of kx, ("ρ", "") of rho; None for a name that is a word."""
    match = _SYMBOL.fullmatch(name)
    return (GREEK.get(match[1], match[1]), match[2]) if match else None


def as_mathtext(name: str) -> str:
    """A parameter's name for matplotlib, such as ``dahl $k_x$`` for dahl.kx; the name itself where it is no symbol."""
    part, _, parameter = name.rpartition(".")
    letter_and_index = symbol(parameter)
    if letter_and_index is None:
        return name
    letter, index = letter_and_index
    shown = rf"${letter}_\mathit{{{index}}}$" if index else f"${letter}$"
    return f"{part.replace('_', ' ')} {shown}" if part else shown


def label_as_mathtext(label: str) -> str:
    """A label of a fitted number for matplotlib, such as ``dahl $k_x$ at 1.98 V`` for ``dahl.kx @ 1.98 V``."""
    name, at, rest = label.partition(" @ ")
    return f"{as_mathtext(name)} at {rest}" if at else as_mathtext(name)


def law_in_words(name: str) -> str:
    """A control law's name for a reader: bang-bang for bang_bang, clipped-optimal LQG, Lyapunov."""
    return name.replace("_lqg", " LQG").replace("_", "-").replace("lyapunov", "Lyapunov")


def with_law_words(text: str) -> str:
    """``text`` with the labels of laws in words, ``bang-bang 0 to 3 V`` for ``bang_bang 0 to 3 V``; other uses stay."""
    return _labels_of_laws().sub(lambda match: law_in_words(match[0]), text)


def in_law_words(figure: Any) -> Any:
    """A figure with the laws of all its texts in words."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        if (words := with_law_words(text.get_text())) != text.get_text():
            text.set_text(words)
    return figure


@lru_cache(maxsize=1)
def _labels_of_laws() -> re.Pattern[str]:
    from dampyr.structures import available_control_laws

    names = "|".join(sorted(available_control_laws(), key=len, reverse=True))
    return re.compile(rf"(?<![\w./-])(?:{names})(?= -?[\d.]+(?:e[+-]?\d+)? to )")
