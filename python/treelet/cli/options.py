"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

MeshArgument = Annotated[
    str,
    typer.Argument(
        metavar="MESH",
        help="Mesh file (ply, obj, stl, off, glb, npz) or name of a scene, see `treelet list`.",
    ),
]
MeshOrTreeArgument = Annotated[
    str,
    typer.Argument(
        metavar="MESH",
        help="Mesh file (ply, obj, stl, off, glb, npz), saved tree (treelet) or name of a scene.",
    ),
]
OptionalMeshArgument = Annotated[
    str | None,
    typer.Argument(metavar="MESH", help="Mesh file (ply, obj, stl, off, glb, npz) or name of a scene."),
]
TrianglesOption = Annotated[
    int | None,
    typer.Option("--triangles", metavar="N", help="About this many triangles; for embedded scenes."),
]
SeedOption = Annotated[
    int, typer.Option("--seed", metavar="N", min=0, help="Seed of scenes, rays and samples.")
]
ThreadsOption = Annotated[
    int, typer.Option("--threads", metavar="N", min=0, help="Threads, 0 for all cores.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON in place of the table.")]
RecipeOption = Annotated[
    str,
    typer.Option(
        "--recipe", "-r", metavar="TEXT", help="Preset, or steps such as 'lbvh > treelet(rounds=2) > bvh8'."
    ),
]
ViewOption = Annotated[
    str | None,
    typer.Option("--view", metavar="NAME", help="Name or number of one of the mesh's views, or 'automatic'."),
]
SizeOption = Annotated[str, typer.Option("--size", metavar="WxH", help="Pixels, width x height.")]
OutFolderOption = Annotated[Path, typer.Option("--out", metavar="FOLDER", help="Where files are written.")]
