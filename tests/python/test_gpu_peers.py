"""The adapters of other tracers, with stand-ins for what they adapt: no GPU and none of them is needed."""

import sys
from types import ModuleType, SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

import treelet
from treelet.bench.gpu.cases import Case
from treelet.bench.gpu.peers import PEERS, mitsuba_optix, torch_bvh, warp_mesh

CASE = Case("sphere", 1000)


def module(name: str, **members) -> ModuleType:
    made = ModuleType(name)
    vars(made).update(members)
    return made


class FakeWarp(ModuleType):
    """Runs kernels thread by thread; a mesh is a tree of the CPU."""

    __version__ = "1.0"
    vec3, float32, int32, uint64, bool, inf = "vec3", "float32", "int32", "uint64", "bool", np.inf
    is_there = True

    def init(self):
        pass

    def is_cuda_available(self):
        return self.is_there

    def synchronize(self):
        pass

    def kernel(self, function):
        return function

    def array(self, data=None, dtype=None, device="cuda"):
        assert device == "cuda"
        return None if data is None else np.array(data)

    def empty(self, count, dtype, device):
        return np.zeros(count, {"bool": bool}.get(dtype, dtype)).view(WithNumpy)

    def Mesh(self, points, indices, bvh_constructor):  # noqa: N802
        assert bvh_constructor in warp_mesh.VARIANTS
        return SimpleNamespace(id=treelet.build(points, indices.reshape(-1, 3)))

    def launch(self, kernel, dim, inputs, outputs, device):
        for self.thread in range(dim):
            kernel(*inputs, *outputs)

    def tid(self):
        return self.thread

    def mesh_query_ray(self, tree, origin, direction, t_max):
        hit = tree.intersect(origin, direction, t_max=t_max)
        return SimpleNamespace(result=hit.face >= 0, t=hit.t, face=hit.face)

    def mesh_query_ray_anyhit(self, tree, origin, direction, t_max):
        return tree.occluded(origin, direction, t_max=t_max)


class WithNumpy(np.ndarray):
    def numpy(self):
        return np.asarray(self)


class FakeTensor(NamedTuple):
    values: np.ndarray

    def cuda(self):
        return self

    def cpu(self):
        return self

    def numpy(self):
        return self.values


class RayBVH:
    """As torchbvh's: triangles (F, 3, 3)."""

    def __init__(self, triangles, primitive_type):
        assert primitive_type == "triangle"
        corners = triangles.values.reshape(-1, 3)
        self.tree = treelet.build(corners, np.arange(len(corners)).reshape(-1, 3))

    def trace(self, origins, directions, *, t_min, t_max):
        hits = self.tree.intersect(origins.values, directions.values, t_min, t_max)
        return SimpleNamespace(t=FakeTensor(hits.t), primitive_indices=FakeTensor(hits.face.astype(np.int64)))


class Parameters(dict):
    def update(self):  # as mitsuba's, without arguments
        self["mesh"].tree = treelet.build(
            self["vertex_positions"].reshape(-1, 3), self["faces"].reshape(-1, 3)
        )


class Scene:
    def __init__(self, description):
        self.tree = description["mesh"].tree

    def ray_test(self, rays, coherent):
        return self.tree.occluded(rays.o, rays.d, t_max=rays.maxt)

    def ray_intersect_preliminary(self, rays, coherent):
        hits = self.tree.intersect(rays.o, rays.d, t_max=rays.maxt)
        return SimpleNamespace(t=hits.t, prim_index=hits.face.astype(np.uint32))


def as_columns(*axes):
    return np.stack(axes, axis=-1)


def fake_mitsuba() -> ModuleType:
    return module(
        "mitsuba",
        __version__="3.0",
        set_variant=lambda name: None,
        Mesh=lambda name, vertex_count, face_count: SimpleNamespace(tree=None),
        traverse=lambda mesh: Parameters(mesh=mesh),
        load_dict=Scene,
        Float=np.asarray,
        UInt32=np.asarray,
        Point3f=as_columns,
        Vector3f=as_columns,
        Ray3f=lambda o, d: SimpleNamespace(o=o, d=d, maxt=np.inf),
    )


@pytest.fixture
def stand_ins(monkeypatch):
    torch_cuda = SimpleNamespace(is_available=lambda: True, synchronize=lambda: None)
    fakes = {
        "warp": FakeWarp("warp"),
        "torch": module("torch", cuda=torch_cuda, from_numpy=FakeTensor),
        "torchbvh": module("torchbvh", __version__="0.3", RayBVH=RayBVH),
        "mitsuba": fake_mitsuba(),
        "drjit": module("drjit", eval=lambda *arrays: None, sync_thread=lambda: None),
    }
    for name, fake in fakes.items():
        monkeypatch.setitem(sys.modules, name, fake)
    monkeypatch.setattr(mitsuba_optix.ctypes, "CDLL", lambda name: None)
    return fakes


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.NAME)
def test_hits_come_through_the_adapter(peer, stand_ins):
    loaded = peer.load()
    assert loaded.version.startswith(peer.NAME)
    build = loaded.upload(CASE.mesh.vertices, CASE.mesh.faces)
    ray_sets = CASE.make_rays(16)
    assert {rays.kind for rays in ray_sets} == {"primary", "diffuse", "ambient_occlusion"}
    for variant in peer.VARIANTS:
        tree = build(variant)
        for rays in ray_sets:
            if rays.any_hit and peer is torch_bvh:
                with pytest.raises(NotImplementedError):
                    loaded.prepare(tree, rays)
                continue
            tracer = loaded.prepare(tree, rays)
            tracer()
            loaded.synchronize()
            expected = rays.trace(CASE.reference)
            if rays.any_hit:
                np.testing.assert_array_equal(tracer.answers(), expected)
                continue
            t, face = tracer.answers()
            np.testing.assert_array_equal(t, expected.t)
            np.testing.assert_array_equal(face, expected.face)


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.NAME)
def test_peers_that_are_not_installed_say_so(peer, monkeypatch):
    for name in ("warp", "torch", "drjit"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError):
        peer.load()


def test_peers_without_a_device_say_so(stand_ins, monkeypatch):
    def missing(name):
        raise OSError(f"{name}: cannot open shared object file")

    stand_ins["warp"].is_there = False
    stand_ins["torch"].cuda.is_available = lambda: False
    monkeypatch.setattr(mitsuba_optix.ctypes, "CDLL", missing)
    for peer, why in (
        (warp_mesh, "no CUDA device"),
        (torch_bvh, "no CUDA device"),
        (mitsuba_optix, "libnvoptix"),
    ):
        with pytest.raises(OSError, match=why):
            peer.load()
