"""Links between the pages lead somewhere: to a file that is there, and to a heading that it has."""

from __future__ import annotations

import itertools
import json
import re
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("docs/*.ipynb")])

ADDRESS = re.compile(r"https://[a-z0-9-]+(\.[a-z0-9-]+)+(/[\w.~%+/-]*)?(#[\w-]+)?", re.IGNORECASE)


def text_of(page: Path) -> str:
    """A page's Markdown; a notebook's cells of text."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".md":
        return text
    cells = [cell["source"] for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown"]
    return "\n\n".join("".join(source) for source in cells)


def links(page: Path) -> list[str]:
    """Targets of a page's links and pictures."""
    tokens = [child for token in MarkdownIt().enable("table").parse(text_of(page)) for child in token.children or ()]
    return [
        str(token.attrs.get("href") or token.attrs.get("src"))
        for token in tokens
        if token.type in ("link_open", "image")
    ]


def of_the_web(target: str) -> bool:
    return re.match(r"[a-z]+:", target) is not None


def anchors(page: Path) -> set[str]:
    """Of the headings, as renderers make them."""
    heads = re.findall(r"^#+ (.*)$", text_of(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_there_are_links():
    found = [target for page in PAGES for target in links(page)]
    assert sum(map(of_the_web, found)) > 5
    assert len(found) > 40


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path):
    for target in itertools.filterfalse(of_the_web, links(page)):
        path, _, heading = target.partition("#")
        there = (page.parent / path).resolve() if path else page
        assert there.exists(), target
        assert there.is_relative_to(ROOT), target
        assert not heading or heading in anchors(there), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_to_the_web_have_an_address(page: Path):
    """Whether anything answers there is not asked: tests need no network."""
    for target in filter(of_the_web, links(page)):
        assert ADDRESS.fullmatch(target), target
        assert not target.endswith("."), target
