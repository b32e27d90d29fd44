"""`treelet list`: scenes, recipes and views."""

from __future__ import annotations

from enum import Enum
from typing import Annotated, Any

import typer

from treelet.cli.options import JsonOption


class Topic(str, Enum):
    """What can be listed."""

    scenes = "scenes"
    recipes = "recipes"
    views = "views"


def list_(
    topic: Annotated[
        Topic | None, typer.Argument(help="What to list; scenes and recipes where nothing is said.")
    ] = None,
    mesh: Annotated[
        str | None, typer.Argument(metavar="MESH", help="Mesh file or scene whose views to list.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """List scenes, recipes, or the views of a mesh."""
    from treelet.cli.output import print_json

    if topic is Topic.views and mesh is None:
        raise ValueError("views belong to a mesh: name one, such as `treelet list views city`")
    if topic is not Topic.views and mesh is not None:
        raise ValueError(f"only views belong to a mesh: try `treelet list views {mesh}`")
    topics = [topic] if topic else [Topic.scenes, Topic.recipes]
    facts = {each.value: _gather(each, mesh) for each in topics}
    if json:
        print_json(facts)
        return
    for each in topics:
        _PRINTERS[each](facts[each.value])


def _gather(topic: Topic, mesh: str | None) -> Any:
    if topic is Topic.views:
        return _views(mesh or "")
    return _scenes() if topic is Topic.scenes else _recipes()


def _scenes() -> list[dict[str, str]]:
    from treelet import scenes

    embedded = [
        {"name": name, "kind": "embedded", "summary": scenes.describe(name)} for name in scenes.names()
    ]
    return embedded + [{"name": name, "kind": "external", "summary": ""} for name in _external_names()]


def _external_names() -> list[str]:
    """The external scenes that can be named; a note tells of the others."""
    from treelet import scenes
    from treelet.cli.output import note

    try:
        names = scenes.external_names()
    except ValueError as error:
        note(f"treelet: no external scenes: {error}")
        return []
    for name in names:
        if name in scenes.names():
            note(f"treelet: external scene {name!r} cannot be reached: the embedded one of that name wins")
    return [name for name in names if name not in scenes.names()]


def _recipes() -> dict[str, Any]:
    import treelet

    words = [
        {
            "name": word.name,
            "kind": str(word.kind),
            "summary": word.summary,
            "parameters": [
                {key: getattr(parameter, key) for key in ("name", "default", "minimum", "maximum", "summary")}
                for parameter in word.parameters
            ],
        }
        for word in treelet.recipe_words()
    ]
    return {"presets": dict(treelet.presets()), "words": words}


def _views(name: str) -> list[dict[str, Any]]:
    from treelet.cli.inputs import choose_view, load_subject

    mesh = load_subject(name)
    views = [*mesh.views, choose_view(mesh, "automatic")]
    return [
        {
            "name": view.name,
            "eye": _floats(view.eye),
            "look_at": _floats(view.look_at),
            "up": _floats(view.up),
            "fov_degrees": float(view.fov_degrees),
        }
        for view in views
    ]


def _floats(values) -> list[float]:
    return [float(value) for value in values]


def _print_scenes(scenes: list[dict[str, str]]) -> None:
    from treelet.cli.output import print_table

    print_table("Scenes", ["name", "kind", "what"], [list(scene.values()) for scene in scenes])


def _print_recipes(recipes: dict[str, Any]) -> None:
    from treelet.cli.output import print_table

    print_table("Presets", ["name", "recipe"], [list(item) for item in recipes["presets"].items()])
    rows = [[word["name"], word["kind"], word["summary"]] for word in recipes["words"]]
    print_table("Recipe words", ["word", "kind", "what"], rows)
    parameters = [
        [
            word["name"],
            each["name"],
            f"{each['default']:g}",
            f"{each['minimum']:g} to {each['maximum']:g}",
            each["summary"],
        ]
        for word in recipes["words"]
        for each in word["parameters"]
    ]
    if parameters:
        headings = ["word", "parameter", ("default", "right"), ("range", "right"), "what"]
        print_table("Parameters, written word(name=value, ...)", headings, parameters)


def _print_views(views: list[dict[str, Any]]) -> None:
    from treelet.cli.output import print_table
    from treelet.cli.text import coordinates

    rows = [
        [
            str(index),
            view["name"],
            *(coordinates(view[key]) for key in ("eye", "look_at", "up")),
            f"{view['fov_degrees']:g}",
        ]
        for index, view in enumerate(views)
    ]
    print_table("Views", [("", "right"), "name", "eye", "look at", "up", ("fov", "right")], rows)


_PRINTERS = {Topic.scenes: _print_scenes, Topic.recipes: _print_recipes, Topic.views: _print_views}
