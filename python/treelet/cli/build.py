"""`treelet build`: build one tree and say where the time went."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from treelet.cli.options import (
    JsonOption,
    MeshArgument,
    RecipeOption,
    SeedOption,
    ThreadsOption,
    TrianglesOption,
)


def build(
    mesh: MeshArgument,
    recipe: RecipeOption = "balanced",
    triangles: TrianglesOption = None,
    validate: Annotated[bool, typer.Option("--validate", help="Check the tree after every stage.")] = False,
    save: Annotated[
        Path | None, typer.Option("--save", metavar="FILE", help="Write the tree there, as x.treelet.")
    ] = None,
    epo: Annotated[
        bool, typer.Option("--epo/--no-epo", help="Compute EPO, seconds for millions of triangles.")
    ] = True,
    seed: SeedOption = 0,
    threads: ThreadsOption = 0,
    json: JsonOption = False,
) -> None:
    """Build a tree over a mesh and print its stages and statistics."""
    import treelet
    from treelet import scenes
    from treelet.cli.inputs import use_threads
    from treelet.cli.output import print_json
    from treelet.cli.tree_tables import print_stages, print_statistics, tree_facts

    use_threads(threads)
    recipe = treelet.parse_recipe(recipe)
    subject = scenes.load(mesh, triangles=triangles, seed=seed)
    bvh = treelet.build(subject.vertices, subject.faces, recipe=recipe, validate=validate)
    if save is not None:
        bvh.save(save)
    if json:
        print_json({"mesh": subject.name, "threads": treelet.thread_count(), **tree_facts(bvh, epo)})
        return
    print_stages(subject.name, bvh)
    print_statistics(bvh, epo)
