"""What the report says."""

import json

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, grid, random_triangles

import treelet


@pytest.fixture(scope="module")
def report():
    return treelet.build(*random_triangles(2000)).report


def test_as_dict_is_plain(report):
    plain = report.as_dict()
    again = json.loads(json.dumps(plain))
    assert set(plain) == {
        "recipe",
        "stages",
        "build_seconds",
        "faces",
        "references",
        "left_out_non_finite",
        "left_out_degenerate",
        "nodes",
        "leaves",
        "depth",
        "leaf_histogram",
        "bytes",
        "sah",
        "layout_sah",
        "layout_sah_at_build",
        "refits",
        "refit_seconds",
        "hidden",
        "held_bytes",
        "epo",
        "vertex_rounding",
    }
    assert again["leaf_histogram"] == {str(size): count for size, count in report.leaf_histogram.items()}
    assert again["stages"][0] == {"name": report.stages[0].name, "seconds": report.stages[0].seconds}
    assert all(
        again[name] == getattr(report, name) for name in plain if name not in ("leaf_histogram", "stages")
    )


def test_counts_fit_together(report):
    assert report.faces == report.references == 2000
    assert report.left_out_non_finite == report.left_out_degenerate == 0
    assert sum(report.leaf_histogram.values()) == report.leaves > report.nodes
    assert sum(size * count for size, count in report.leaf_histogram.items()) == report.references
    assert min(report.leaf_histogram) >= 1
    assert max(report.leaf_histogram) <= 8
    assert np.log2(report.leaves) / 3 <= report.depth <= report.nodes  # eight children a node
    assert report.bytes > 2000 * 36
    assert report.vertex_rounding == 0


def test_stages_are_the_build(report):
    names = [stage.name for stage in report.stages]
    assert names == [
        "create references",
        "compute Morton codes",
        "sort Morton codes",
        "emit hierarchy",
        "restructure treelets",
        "collapse to 8-wide",
        "plan bvh8",
        "write bvh8",
    ]
    assert all(stage.seconds >= 0 for stage in report.stages)
    assert 0 < sum(stage.seconds for stage in report.stages) <= report.build_seconds


def test_costs():
    vertices, faces = random_triangles(1000)
    fast, balanced = (treelet.build(vertices, faces, recipe).report for recipe in ("fast", "balanced"))
    assert 1 < balanced.sah < fast.sah
    assert 0 < balanced.epo < fast.epo
    assert fast.epo == fast.epo


def test_one_triangle():
    report = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES).report
    assert (report.nodes, report.leaves, report.depth, report.leaf_histogram) == (1, 1, 1, {1: 1})
    assert (report.sah, report.epo) == (1, 0)


def test_a_flat_mesh_has_costs_too():
    report = treelet.build(*grid(20)).report
    assert np.isfinite([report.sah, report.epo]).all()
    assert report.sah > 1


def test_a_mesh_in_one_point_costs_nothing():
    point = treelet.build(np.zeros((3, 3)), TRIANGLE_FACES).report
    assert (point.references, point.left_out_degenerate, point.sah, point.epo) == (0, 1, 0, 0)


def test_validation_is_a_stage_of_its_own(report):
    checked = treelet.build(*random_triangles(2000), validate=True).report
    assert (checked.sah, checked.nodes) == (report.sah, report.nodes)


def test_repr(report):
    text = repr(report)
    assert text.startswith(
        "Report(recipe='lbvh > treelet(size=7, rounds=2, gamma=14) > bvh8(leaf=8)', build_seconds="
    )
    assert "\n" not in text
