"""Race treelet's CPU path against Embree on a list of scenes, one JSON-lines file a scene.

python bench/peers/run.py --harness build/release/bench/peers/treelet_peers --out out/peers city kitchen

Scenes are names or files as the command treelet takes them; without any, all embedded ones and those of
TREELET_SCENES. The lines are those of `treelet bench`, with more in their details (docs/benchmarks.md).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from make_scene import make_scene_file

from treelet import scenes
from treelet.bench import Measurement, write_measurements
from treelet.bench.arguments import whole_number

TABLES = Path(__file__).parents[2] / "tools" / "peers_table.py"


def main(words: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = _parse(words)
    names = options.scenes or scenes.names() + scenes.external_names()
    for name in names:
        triangles = options.triangles if name in scenes.names() else None
        mesh = scenes.load(name, triangles)
        print(f"{mesh.name}: {len(mesh.faces):,} triangles", flush=True)
        path = write_measurements(options.out / f"{mesh.name}.jsonl", race(mesh, options))
        print(f"  {path}\n", flush=True)
    subprocess.run([sys.executable, TABLES, options.out])


def race(mesh, options: argparse.Namespace) -> list[Measurement]:
    """The harness's measurements of one mesh."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene"
        make_scene_file(file, mesh, options.width, options.height)
        answer = subprocess.run(
            [options.harness.absolute(), file, *_harness_arguments(options)],
            stdout=subprocess.PIPE,
            stderr=None if options.verbose else subprocess.PIPE,
            text=True,
        )
    if answer.returncode != 0:
        sys.exit(answer.stderr or f"{options.harness} ended with {answer.returncode}")
    return list(read_answer(answer.stdout, mesh.name, len(mesh.faces)))


def read_answer(text: str, scene: str, faces: int) -> Iterator[Measurement]:
    """Measurements out of the lines that the harness prints."""
    for line in text.splitlines():
        yield Measurement(scene=scene, faces=faces, **json.loads(line))


def _harness_arguments(options: argparse.Namespace) -> list[str]:
    arguments = [f"--builds={options.builds}", f"--repeats={options.repeats}"]
    arguments += [f"--contender={text}" for text in options.contender]
    return arguments + ([f"--threads={options.threads}"] if options.threads else [])


def _parse(words: Sequence[str] | None) -> argparse.Namespace:
    count = whole_number(1)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--harness", type=Path, required=True, help="the program treelet_peers")
    parser.add_argument("--out", type=Path, default=Path("out/peers"), help="folder for the results")
    parser.add_argument(
        "--contender",
        action="append",
        default=[],
        metavar="TEXT",
        help="a recipe, embree:low, medium or high with +robust or +compact, or embree-tree:low, medium or "
        "high with +budget=N or +block=N; may be repeated",
    )
    parser.add_argument("--triangles", type=count, default=200_000, help="of embedded scenes")
    parser.add_argument("--width", type=count, default=1024, help="of the picture whose rays are traced")
    parser.add_argument("--height", type=count, default=640)
    parser.add_argument("--builds", type=count, default=5)
    parser.add_argument("--repeats", type=count, default=7)
    parser.add_argument("--threads", type=count, help="all by default")
    parser.add_argument("--verbose", action="store_true", help="show what is being measured")
    options = parser.parse_args(words)
    if not os.access(options.harness, os.X_OK) or options.harness.is_dir():
        parser.error(
            f"--harness {options.harness} is no program: build the target treelet_peers with "
            "-DTREELET_BUILD_PEERS=ON, or run `make bench-peers`"
        )
    return options


if __name__ == "__main__":
    main()
