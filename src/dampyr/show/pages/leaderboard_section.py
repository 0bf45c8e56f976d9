"""Section of a fit's page: the leaderboard that its model was chosen by."""

from __future__ import annotations

from dampyr.identification import Leaderboard
from dampyr.phrases import sentence
from dampyr.show.figures.leaderboard import leaderboard_figure
from dampyr.show.identification.leaderboard import choice_in_words, finalists, screened, screened_errors
from dampyr.show.pages.blocks import FigureBlock, Section, Text


def leaderboard_section(board: Leaderboard) -> Section:
    """The finalists, and every model bare and at its best."""
    return Section(
        "Which model predicts best",
        [
            Text(" ".join(map(sentence, choice_in_words(board)))),
            finalists(board),
            FigureBlock(
                leaderboard_figure(*screened_errors(board)),
                "Every model on a few short records: bare, and with the add-ons that improved it.",
            ),
            screened(board),
        ],
    )
