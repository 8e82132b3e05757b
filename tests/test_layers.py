"""Dependencies point down: no module imports one of a floor above its own, and modules import in no circle."""

import ast
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pytest

import flowabs_nodes

PACKAGE = "flowabs_nodes"

#: The floors of the house, the lowest first. The rooms of one line stand side by side.
FLOORS = (
    ("forks",),
    ("errors", "choices", "file_choices", "array_types", "file_hash", "stopping"),
    ("simd", "signals"),
    ("sampling",),
    ("color", "filters"),
    ("image", "array_kind", "encodings", "port_types"),
    ("io",),
    ("finishing", "comp", "looking"),
    ("nodes",),
    ("graph",),
    ("engine",),
    ("cli", "testing", "submit", "serve", "openfx", "one_call"),
    ("__main__", "reference"),
)
HEIGHT = {room: height for height, rooms in enumerate(FLOORS) for room in rooms}
SEPARATE = {"color", "filters"}  # neither may know the other


class Import(NamedTuple):
    """One module imports another. ``for_types``: only where ``TYPE_CHECKING`` is true."""

    importer: str
    imported: str
    place: str
    for_types: bool


def room(module: str) -> str:
    """Return the part of the package that a module belongs to: "filters" for ``flowabs_nodes.filters.flow.etf``."""
    return f"{module}.".split(".")[1]


def sources(package: Path) -> dict[str, Path]:
    """Return every file of a package by the name of its module."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = (package.name, *path.relative_to(package).with_suffix("").parts)
        found[".".join(parts).removesuffix(".__init__")] = path
    return found


def imports(files: dict[str, Path]) -> list[Import]:
    """Return each import of a module among ``files`` by another, also those inside functions."""
    return [
        Import(importer, imported, f"{path.relative_to(top(files))}:{node.lineno}", for_types)
        for importer, path in files.items()
        for node, for_types in statements(ast.parse(path.read_text(encoding="utf-8")))
        for imported in imported_modules(node, importer, path.name == "__init__.py", files)
        if imported != importer
    ]


def top(files: dict[str, Path]) -> Path:
    """Return the folder that the package is in."""
    return files[PACKAGE].parent.parent


def statements(node: ast.AST, for_types: bool = False) -> Iterator[tuple[ast.stmt, bool]]:
    """Yield every import statement below ``node``, and whether it stands under ``if TYPE_CHECKING``."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child, for_types
        elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            yield from statements(ast.Module(child.body, []), True)
            yield from statements(ast.Module(child.orelse, []), for_types)
        else:
            yield from statements(child, for_types)


def imported_modules(
    node: ast.Import | ast.ImportFrom, importer: str, is_package: bool, files: dict[str, Path]
) -> list[str]:
    """Return the modules among ``files`` that a statement imports; ``from a import b`` is a.b where a.b is a module."""
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    else:
        above = importer.split(".")[: -node.level + is_package or None] if node.level else []
        base = ".".join([*above, *filter(None, [node.module])])
        names = [f"{base}.{alias.name}" if f"{base}.{alias.name}" in files else base for alias in node.names]
    return sorted({name for name in names if name in files})


def wrong_directions(found: list[Import], package: str) -> list[str]:
    """Return a line for each import of a floor above, or of a room that must stay unknown."""
    wrong = []
    for each in found:
        # The top of the package only says what is where, and loads it when asked; below it counts for its version.
        if each.importer == package or each.imported == package:
            continue
        here, there = room(each.importer), room(each.imported)
        if HEIGHT[there] > HEIGHT[here]:
            why = f"{there} is a floor above {here}"
        elif here != there and {here, there} == SEPARATE:
            why = f"{here} and {there} must not know each other"
        else:
            continue
        wrong.append(f"{each.place}: {each.importer} imports {each.imported}: {why}")
    return wrong


def circles(found: list[Import]) -> list[str]:
    """Return a line for each circle of imports; imports for types do not count, nothing is loaded for them."""
    loads: dict[str, dict[str, str]] = {}
    for each in found:
        if not each.for_types:
            loads.setdefault(each.importer, {})[each.imported] = each.place
    lines: dict[frozenset[str], str] = {}
    for start in sorted(loads):
        way = way_back(loads, start)
        if way:
            steps = (f"{loads[a][b]}: {a} imports {b}" for a, b in pairwise(way))
            lines.setdefault(frozenset(way), "; ".join(steps))
    return list(lines.values())


def way_back(loads: dict[str, dict[str, str]], start: str) -> list[str]:
    """Return the shortest chain of imports from ``start`` to itself, both ends included; empty where there is none."""
    before: dict[str, str] = {}
    waiting = [start]
    for module in waiting:
        for imported in loads.get(module, {}):
            if imported == start:
                way = [start, module]
                while way[-1] != start:
                    way.append(before[way[-1]])
                return way[::-1]
            if imported not in before:
                before[imported] = module
                waiting.append(imported)
    return []


FILES = sources(Path(flowabs_nodes.__file__).parent)


@pytest.fixture(scope="module")
def found_imports() -> list[Import]:
    """Return every import of the package."""
    return imports(FILES)


def test_every_module_stands_on_a_floor():
    homeless = sorted({room(module) for module in FILES if module != PACKAGE} - HEIGHT.keys())
    assert not homeless, f"say in FLOORS how high these stand: {homeless}"


def test_dependencies_point_down(found_imports):
    wrong = wrong_directions(found_imports, PACKAGE)
    assert not wrong, "\n".join(wrong)


def test_nothing_imports_in_a_circle(found_imports):
    found = circles(found_imports)
    assert not found, "\n".join(found)


def test_nobody_takes_more_than_the_version_from_the_top_of_the_package():
    taken = []
    for path in FILES.values():
        for node, _ in statements(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module == PACKAGE:
                names = [each.name for each in node.names if f"{PACKAGE}.{each.name}" not in FILES]
                taken += [f"{path}:{node.lineno}: {name}" for name in names if name != "__version__"]
    assert not taken, "import these from their own modules:\n" + "\n".join(taken)


# ---------------------------------------------------------------------- the test itself finds what it looks for


def house(folder: Path, **modules: str) -> list[Import]:
    """Write a package of modules, named with __ for each dot, and return its imports."""
    for name, text in modules.items():
        path = folder.joinpath(PACKAGE, *name.split("__")).with_suffix(".py")
        path.parent.mkdir(parents=True, exist_ok=True)
        for each in path.parents:
            if each == folder:
                break
            (each / "__init__.py").touch()
        path.write_text(text, encoding="utf-8")
    return imports(sources(folder / PACKAGE))


def test_an_import_of_a_floor_above_is_named_with_its_place(tmp_path):
    up = "\ndef f():\n    from flowabs_nodes.engine.run import go\n"
    found = house(tmp_path, engine__run="def go(): pass", graph__load=up)
    (line,) = wrong_directions(found, PACKAGE)
    place = Path(PACKAGE, "graph", "load.py")
    imported = "flowabs_nodes.graph.load imports flowabs_nodes.engine.run"
    assert line == f"{place}:3: {imported}: engine is a floor above graph"


def test_an_import_for_types_counts_between_floors_but_makes_no_circle(tmp_path):
    head = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    "
    found = house(
        tmp_path,
        graph__a=f"{head}from flowabs_nodes.graph import b",
        graph__b="from . import a",
        io__read=f"{head}from flowabs_nodes.nodes.declare import Node",
        nodes__declare="Node = 1",
    )
    assert circles(found) == []
    (line,) = wrong_directions(found, PACKAGE)
    assert "flowabs_nodes.io.read imports flowabs_nodes.nodes.declare: nodes is a floor above io" in line


def test_colors_and_filters_do_not_know_each_other(tmp_path):
    found = house(
        tmp_path,
        color__codes="from flowabs_nodes.filters import blur",
        filters__blur="from ..color import codes",
    )
    assert len(wrong_directions(found, PACKAGE)) == 2
    (line,) = circles(found)
    assert "color.codes imports flowabs_nodes.filters.blur; " in line
    assert "filters.blur imports flowabs_nodes.color.codes" in line


def test_a_way_around_of_three_is_a_circle(tmp_path):
    (line,) = circles(house(tmp_path, io__a="from . import b", io__b="from . import c", io__c="from . import a"))
    assert line.count("imports") == 3
