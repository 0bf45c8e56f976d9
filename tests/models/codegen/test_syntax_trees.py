"""Texts are parsed by several threads while garbage is collected, whose callbacks let other threads go on."""

import ast
import gc
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from dampyr.models.codegen.syntax_trees import expression_of, statements_of

TEXT = "\n".join(f"def f{k}(a, b):\n    return (a + b*{k}) * max(a, b) + g(a, b, {k})" for k in range(60))


@pytest.fixture
def threads_take_turns_within_a_tree() -> Iterator[None]:
    def let_others_go_on(phase: str, told: dict[str, int]) -> None:
        time.sleep(0)

    threshold = gc.get_threshold()
    gc.callbacks.append(let_others_go_on)
    gc.set_threshold(100)
    yield
    gc.callbacks.remove(let_others_go_on)
    gc.set_threshold(*threshold)


@pytest.mark.usefixtures("threads_take_turns_within_a_tree")
def test_threads_do_not_parse_within_each_other() -> None:
    with ThreadPoolExecutor(3) as pool:
        trees = list(pool.map(statements_of, [TEXT] * 24))
    assert {ast.dump(tree) for tree in trees} == {ast.dump(ast.parse(TEXT))}


def test_an_expression_has_a_tree_of_its_own() -> None:
    assert ast.unparse(expression_of("a*(b + c)")) == "a * (b + c)"
