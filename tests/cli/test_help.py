"""`dampyr help` prints the pages that the messages name, from an installed package too."""

import ast
import json
import re
from pathlib import Path

from click.testing import CliRunner, Result

from dampyr.cli import cli
from dampyr.cli.help import list_pages

SOURCE = Path(__file__).resolve().parents[2] / "src" / "dampyr"


def run(*words: str) -> Result:
    return CliRunner().invoke(cli, ["help", *words], catch_exceptions=False)


def texts(path: Path) -> list[str]:
    """The string literals of a module, without its docstrings."""
    tree = ast.parse(path.read_text("utf-8"))
    statements = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    return [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in statements
    ]


def test_a_page_is_printed_as_it_is() -> None:
    page = list_pages()["card"]
    assert run("card").stdout == page.read_text("utf-8").rstrip() + "\n"
    assert run("card.md").stdout == run("card").stdout
    assert json.loads(run("card", "--json").stdout)["title"] == "The damper's card, schema 1"


def test_the_pages_are_listed_each_under_a_name_of_its_own() -> None:
    listed = json.loads(run("--json").stdout)
    assert len({row["topic"] for row in listed}) == len(listed) > 40
    assert {"ensembles", "explanations/ensembles", "card", "newcomer"} <= {row["topic"] for row in listed}
    assert "dampyr help TOPIC prints one" in run().stdout


def test_a_page_that_is_not_there_is_refused_with_those_that_may_be_meant() -> None:
    refused = run("crad")
    assert refused.exit_code == 2
    assert "no page is called 'crad'; did you mean card" in refused.stderr


def test_no_message_points_to_what_an_installed_package_lacks() -> None:
    pages = list_pages()
    for path in sorted(SOURCE.rglob("*.py")):
        for text in texts(path):
            assert not re.search(r"docs/[\w-]+/[\w-]+\.md", text), (path, text)
            assert set(re.findall(r"dampyr help ([a-z][a-z/-]+)", text)) <= pages.keys(), (path, text)
