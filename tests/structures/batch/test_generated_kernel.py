"""The page that prints a generated kernel is current."""

import re
import runpy
from pathlib import Path

DOCS = Path(__file__).resolve().parents[3] / "docs" / "explanations"


def test_the_page_of_the_generated_kernel_is_current() -> None:
    page = (DOCS / "generated-kernel.md").read_text(encoding="utf-8")
    made = runpy.run_path(str(DOCS / "make_generated_kernel.py"))["page"]()
    assert page == made, "run make docs"


def test_no_name_of_the_kernel_has_two_meanings() -> None:
    """What is an argument or a number of the kernel is assigned nowhere in its loops; ``last`` once was."""
    page = (DOCS / "generated-kernel.md").read_text(encoding="utf-8")
    kernel = page.partition("```text\n")[2].partition("```")[0]
    [arguments] = re.findall(r"def integrate_block\((.*)\):", kernel)
    assigned = set(re.findall(r"^ +(\w+) =", kernel, flags=re.MULTILINE))
    assert not assigned & set(arguments.split(", "))
    assert not assigned & {"zero", "one", "two", "half", "quarter", "tiny"}
