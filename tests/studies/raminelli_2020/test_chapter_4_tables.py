"""Tables of Raminelli (2020): 4.1 from the printed rows, the others with the rows that have a file."""

from dataclasses import replace

import pytest
from tests.studies.raminelli_2020.artefact_values import one

from dampyr.studies._compared_value import PrintedNumber
from dampyr.studies.raminelli_2020 import PUBLISHED
from dampyr.studies.raminelli_2020.campaign_records import PublishedCampaign
from dampyr.studies.raminelli_2020.chapter_4_tables import table_4_1, tables


class TestTable41:
    def test_kx_and_kw_follow_and_rho_is_nine_rows(self) -> None:
        part = table_4_1(PUBLISHED)
        for name in ("kx", "kw"):
            assert one(part, "Table 4.1", f"mean of {name}").verdict == "agrees"
            assert one(part, "Table 4.1", f"s.d. of {name}").verdict == "agrees"
        mean, spread = one(part, "Table 4.1", "mean of ρ"), one(part, "Table 4.1", "s.d. of ρ")
        assert (mean.ours, spread.ours) == (pytest.approx(42.53746), pytest.approx(11.785218))
        assert "without row 10" in mean.reason
        assert "row 10 counted as 0" in spread.reason

    def test_another_printed_mean_changes_the_verdict(self) -> None:
        right = dict(PUBLISHED.table_4_1) | {"rho": (PrintedNumber("42.5375"), PrintedNumber("11.7852"))}
        assert one(table_4_1(replace(PUBLISHED, table_4_1=right)), "Table 4.1", "mean of ρ").verdict == "agrees"
        wrong = dict(PUBLISHED.table_4_1) | {"rho": (PrintedNumber("41.0000"), PrintedNumber("11.7852"))}
        value = one(table_4_1(replace(PUBLISHED, table_4_1=wrong)), "Table 4.1", "mean of ρ")
        assert "leaving out any one" in value.reason

    def test_another_row_changes_the_mean(self) -> None:
        rows = tuple(replace(r, kx=0.9) if (r.table, r.row) == ("4.2", 1) else r for r in PUBLISHED.rows)
        assert one(table_4_1(replace(PUBLISHED, rows=rows)), "Table 4.1", "mean of kx").verdict == "differs"


def test_what_has_no_file_is_not_guessed(one_file: PublishedCampaign) -> None:
    first, *others = tables(PUBLISHED, one_file)
    assert one(first, "Table 4.2", "row 5: frequency").verdict == "agrees"
    assert one(first, "Table 4.2", "row 6: frequency").ours is None
    assert {value.ours for part in others for value in part.compared if value.quantity.startswith("row")} == {None}
