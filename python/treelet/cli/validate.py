"""`treelet validate`: is the mesh sound, is the tree, are the hits right?"""

from __future__ import annotations

from typing import Annotated, Any

import typer

from treelet.cli.errors import CHECK_FAILED
from treelet.cli.options import (
    JsonOption,
    MeshOrTreeArgument,
    RecipeOption,
    SeedOption,
    ThreadsOption,
    TrianglesOption,
)

_SHOWN_VIOLATIONS = 10
_TESTS_AT_ONCE = 50_000_000  # rays by triangles, half a second or so: then Ctrl-C is heard


def validate(
    mesh: MeshOrTreeArgument,
    recipe: RecipeOption = "balanced",
    rays: Annotated[
        int, typer.Option("--rays", metavar="N", min=0, help="Rays checked against all triangles.")
    ] = 256,
    strict: Annotated[
        bool, typer.Option("--strict", help="Fail too where faces of the mesh are left out.")
    ] = False,
    triangles: TrianglesOption = None,
    seed: SeedOption = 0,
    threads: ThreadsOption = 0,
    json: JsonOption = False,
) -> None:
    """Check a mesh, its tree after every build stage, sample rays against brute force; or a saved tree."""
    import treelet
    from treelet.cli.facts import gather_facts
    from treelet.cli.inputs import load_subject, use_threads
    from treelet.cli.output import print_json
    from treelet.cli.saved_tree import check_saved_tree, is_saved_tree

    use_threads(threads)
    if is_saved_tree(mesh):
        if not check_saved_tree(mesh, json):
            raise typer.Exit(CHECK_FAILED)
        return
    recipe = treelet.parse_recipe(recipe)
    subject = load_subject(mesh, triangles, seed)
    facts = gather_facts(subject)
    bvh, violations = _build_checked(subject, recipe)
    wrong = _wrong_rays(subject, bvh, rays, seed)
    left_out = bvh.report.left_out_non_finite + bvh.report.left_out_degenerate
    passed = not violations and not wrong and not (strict and left_out)
    if json:
        print_json(
            {
                "passed": passed,
                "mesh": facts.as_dict(),
                "recipe": bvh.report.recipe,
                "left_out": int(left_out),
                "violations": violations,
                "rays": rays,
                "wrong_rays": wrong,
            }
        )
    else:
        _print_verdict(facts, violations, rays, wrong, left_out, strict)
    if not passed:
        raise typer.Exit(CHECK_FAILED)


def _build_checked(subject: Any, recipe: str) -> tuple[Any, list[str]]:
    """The tree, and what is wrong with it or with a stage on the way to it."""
    import treelet

    try:
        bvh, violations = treelet.build(subject.vertices, subject.faces, recipe=recipe, validate=True), []
    except RuntimeError as violation:
        bvh, violations = treelet.build(subject.vertices, subject.faces, recipe=recipe), [str(violation)]
    violations += bvh.validate(subject.vertices, subject.faces)
    if bvh.report.references == 0 and bvh.report.faces > 0:
        violations.append(f"nothing to trace: all {bvh.report.faces} faces were left out of the tree")
    return bvh, violations


def _wrong_rays(subject: Any, bvh: Any, count: int, seed: int) -> list[dict[str, Any]]:
    """Origin, direction and both answers of each ray for which tree and brute force differ in t or face."""
    import numpy as np

    from treelet.cli.sample_rays import sample_rays

    bounds = np.asarray(bvh.bounds, dtype=np.float64)
    if count == 0 or not np.isfinite(bounds).all():
        return []
    origins, directions = sample_rays(subject, bounds, count, seed)
    hits = bvh.intersect(origins, directions)
    expected_t, expected_face = _brute_force(subject, origins, directions)
    return [
        {
            "origin": origins[row].tolist(),
            "direction": directions[row].tolist(),
            "face": int(hits.face[row]),
            "t": _finite_or_none(hits.t[row]),
            "expected_face": int(expected_face[row]),
            "expected_t": _finite_or_none(expected_t[row]),
        }
        for row in np.flatnonzero((hits.face != expected_face) | (hits.t != expected_t))
    ]


def _brute_force(subject: Any, origins: Any, directions: Any) -> tuple[Any, Any]:
    """t and face of each ray, found without the tree, so many rays at a time that Ctrl-C need not wait."""
    import numpy as np

    import treelet
    from treelet.cli.output import progress_bar

    step = max(1, _TESTS_AT_ONCE // max(1, len(subject.faces)))
    found = []
    with progress_bar("brute force", len(origins)) as bar:
        for start in range(0, len(origins), step):
            rays = slice(start, start + step)
            found.append(
                treelet.intersect_brute_force(
                    subject.vertices, subject.faces, origins[rays], directions[rays]
                )
            )
            bar.at(min(start + step, len(origins)), len(origins))
    return np.concatenate([hits.t for hits in found]), np.concatenate([hits.face for hits in found])


def _finite_or_none(value) -> float | None:
    return float(value) if abs(value) < float("inf") else None


def _print_verdict(
    facts: Any, violations: list[str], rays: int, wrong: list, left_out: int, strict: bool
) -> None:
    from treelet.cli.info import print_facts
    from treelet.cli.output import console
    from treelet.cli.text import count

    print_facts(facts)
    out = console()
    out.print(_mark(not left_out, not strict), f"faces left out of the tree: {count(left_out)}")
    out.print(_mark(not violations), f"violations in the tree: {count(len(violations))}")
    for violation in violations[:_SHOWN_VIOLATIONS]:
        out.print(f"    {violation}", markup=False)
    if len(violations) > _SHOWN_VIOLATIONS:
        out.print(f"    and {count(len(violations) - _SHOWN_VIOLATIONS)} more, see --json")
    out.print(_mark(not wrong), f"rays that differ from brute force: {count(len(wrong))} of {count(rays)}")
    for ray in wrong[:_SHOWN_VIOLATIONS]:
        out.print(f"    {ray}", markup=False)


def _mark(is_clean: bool, is_tolerated: bool = False) -> str:
    if is_clean:
        return "[green]ok     [/green]"
    return "[yellow]note   [/yellow]" if is_tolerated else "[red]FAILED [/red]"
