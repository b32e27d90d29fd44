"""`treelet info`: facts about a mesh, or about a tree in a file."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from treelet.cli.options import (
    JsonOption,
    MeshOrTreeArgument,
    RecipeOption,
    SeedOption,
    ThreadsOption,
    TrianglesOption,
)


def info(
    mesh: MeshOrTreeArgument,
    bvh: Annotated[bool, typer.Option("--bvh", help="Build a tree too, and print its statistics.")] = False,
    recipe: RecipeOption = "balanced",
    triangles: TrianglesOption = None,
    seed: SeedOption = 0,
    threads: ThreadsOption = 0,
    json: JsonOption = False,
) -> None:
    """Print what a mesh is like: size, bounds, flaws, open edges; or what is in a saved tree."""
    import treelet
    from treelet.cli.facts import gather_facts
    from treelet.cli.inputs import load_subject, use_threads
    from treelet.cli.output import print_json
    from treelet.cli.saved_tree import is_saved_tree, show_saved_tree
    from treelet.cli.tree_tables import print_leaf_histogram, print_statistics, tree_facts

    use_threads(threads)
    if is_saved_tree(mesh):
        show_saved_tree(mesh, json)
        return
    subject = load_subject(mesh, triangles, seed)
    facts = gather_facts(subject)
    tree = treelet.build(subject.vertices, subject.faces, recipe=recipe) if bvh else None
    if json:
        views = [view.name for view in subject.views]
        print_json(facts.as_dict() | {"views": views} | ({"bvh": tree_facts(tree)} if tree else {}))
        return
    print_facts(facts)
    if tree is not None:
        print_statistics(tree)
        print_leaf_histogram(tree)


def print_facts(facts: Any) -> None:
    """The facts as a table, flaws marked."""
    from treelet.cli.output import print_table
    from treelet.cli.text import coordinates, count

    extents = [high - low for low, high in zip(facts.low, facts.high, strict=True)]
    rows = [
        ["faces", count(facts.faces)],
        ["vertices", f"{count(facts.vertices)}, {count(facts.distinct_positions)} distinct"],
        ["bounds, low", coordinates(facts.low)],
        ["bounds, high", coordinates(facts.high)],
        ["extents", coordinates(extents)],
        ["faces not finite", _flaw(facts.non_finite_faces)],
        ["faces with two equal corners", _flaw(facts.degenerate_faces)],
        ["other faces without area", _flaw(facts.zero_area_faces)],
        ["duplicate faces", _flaw(facts.duplicate_faces)],
        ["edges of one face", count(facts.open_edges)],
        ["edges of two faces", count(facts.shared_edges)],
        ["edges of more faces", count(facts.crowded_edges)],
        ["closed", "yes" if facts.is_closed else "no"],
    ]
    print_table(facts.name, ["", ("", "right")], rows)


def _flaw(number: int) -> str | tuple[str, str]:
    from treelet.cli.text import count

    return (count(number), "yellow") if number else "0"
