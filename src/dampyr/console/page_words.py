"""Messages for a page: what names options of a command or arguments of Python says where it is entered instead."""

from __future__ import annotations

import re

WORDS = tuple(
    (re.compile(pattern), words)
    for pattern, words in (
        (
            r"declare (which|another), --column \w+=NAME( --column \w+=NAME)* or columns=\{[^}]*\}",
            r"choose its column when it is uploaded",
        ),
        (r", by the full header or the number from 0", ""),
        (r", such as --column \S+( --dt \S+)?,? or columns=\{[^}]*\}( and dt=[\d.]+)?", ""),
        (r"give the sampling interval: --dt [\d.]+, dt=[\d.]+", "enter the sampling interval"),
        (r"declare it: --unit \S+ units=\{[^}]*\} or in reading\.toml", "enter it with the upload or in reading.toml"),
        (r"declare units=\{[^}]*\}", "enter it with the upload"),
        (r": --header 0, header=0", ""),
        (r"(declare which|name one), --variable NAME or variable=NAME", "enter the variable"),
        (r"say on which line the names stand, --header 7 or header=7", "enter the line of the names"),
        (
            r"(variables, )--column force=NAME, or --variable and --column force=NUMBER",
            r"\1or the variable, in the form",
        ),
        (r", or ask for it by name: mixed_origins=True \(--mixed-origins\)", ""),
        (r"pass allow_extrapolation=True", "allow extrapolation"),
        (r"give another --out", "choose another folder"),
        (
            r"was stopped by its operator; run it again to go on",
            "was stopped by its operator; Continue goes on with it",
        ),
        (r"declare it, such as (--motion-unit \w+, )?units='[^']*'( or units='[^']*')?", "write it in the header"),
        (r", such as (--dt [\d.]+ or )?dt=[\d.]+", " in the first column"),
        (r"declare it, --smoothed '([^']*)'", r'declare it in reading.toml: smoothed = "\1"'),
        (
            r"state a low-pass, --lowpass ([\d.e+-]+) \(Hz\), leaves",
            r"a low-pass of \1 Hz, stated in reading.toml, leaves",
        ),
        (r" \(dampyr run has --again for it\)", ""),
        (r"record it again with --again \S+, or", "record it again, or"),
        (r"`dampyr identify [^`]*` writes (a card|one)", r"the page Identify writes \1"),
    )
)


def in_page_words(sentence: str) -> str:
    """The sentence as it is read on a page."""
    for pattern, words in WORDS:
        sentence = pattern.sub(words, sentence)
    return sentence
