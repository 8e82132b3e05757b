"""Links of README.md and of the pages below docs lead somewhere, and README names every graph there is."""

from __future__ import annotations

import re
from pathlib import Path

from flowabs_nodes.graph.shipped import shipped
from tests.docs.blocks import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
_LINK = re.compile(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]+))?\)")


def anchors(page: Path) -> set[str]:
    """Return the names by which GitHub knows the headings of a page, and those that it gives itself."""
    text = page.read_text(encoding="utf-8")
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    named = re.findall(r'<a (?:id|name)="([^"]+)"', text)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings} | set(named)


def test_every_link_leads_to_a_file_and_a_heading():
    lost = []
    for page in PAGES:
        for file, anchor in _LINK.findall(page.read_text(encoding="utf-8")):
            there = page.parent / file if file else page
            of_code = anchor.startswith("L") and there.suffix == ".py"  # a line of code, which another test holds
            if not there.exists() or (anchor and not of_code and anchor not in anchors(there)):
                lost.append(f"{page.relative_to(ROOT)}: {file}#{anchor}")
    assert lost == []


def test_the_readme_names_every_graph():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    graphs = {name for name in shipped() if not name.startswith("fig")}
    assert {name for name in graphs if f"`{name}`" not in text.partition("## The graphs")[2]} == set()
