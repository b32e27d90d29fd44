"""What a GPU's libraries get, and the streams it is ready in. Runs on a GPU, or on the emulated device."""

import contextlib
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from device_arrays import Foreign, build, on_device

import treelet
from treelet import _core, cuda

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")

PER_THREAD = 2  # a stream that is always there


def test_outputs_speak_dlpack(soup, rays):
    t = build(soup).intersect(*map(on_device, rays)).t
    assert t.__dlpack_device__() == (2, 0)  # CUDA
    for arguments in ({}, {"stream": -1}, {"max_version": (1, 0), "dl_device": (2, 0), "copy": False}):
        assert "dltensor" in repr(t.__dlpack__(**arguments))
    for arguments in ({"copy": True}, {"dl_device": (1, 0)}):
        with pytest.raises(BufferError, match="copy it with"):
            t.__dlpack__(**arguments)
    assert t.__cuda_array_interface__["shape"] == (500,)


@pytest.fixture
def waits(monkeypatch):
    """The streams that were waited for, in order."""
    streams = []
    monkeypatch.setattr(_core, "device_synchronize", lambda stream, device=-1: streams.append(stream))
    return streams


def test_dlpack_waits_unless_told_not_to(waits):
    array = cuda.copy_to_device(np.zeros(3, np.float32), stream=PER_THREAD)
    array.__dlpack__(stream=-1)
    assert waits == []
    array.__dlpack__(stream=None)
    array.__dlpack__(stream=1)
    assert waits == [PER_THREAD, PER_THREAD]


@pytest.mark.parametrize("dtype", ["float32", "float64", "int32", "uint32", "int64", "uint64", "bool"])
def test_copies_keep_their_values(dtype):
    values = np.arange(6).reshape(3, 2).T.astype(dtype)
    array = on_device(values)
    assert (array.shape, array.dtype, len(array)) == ((2, 3), np.dtype(dtype), 2)
    np.testing.assert_array_equal(array.numpy(), values)
    if dtype in ("float64", "uint64"):
        with pytest.raises(TypeError, match=r"copy it with \.numpy\(\)"):
            array.__dlpack__()
    else:
        assert "dltensor" in repr(array.__dlpack__())


@pytest.mark.parametrize("dtype", ["float16", "complex64", "int8", ">f4", "object", "U3"])
def test_other_dtypes_are_not_copied(dtype):
    with pytest.raises(TypeError, match="values must be of float32"):
        on_device(np.zeros(2).astype(dtype))


def test_single_values():
    array = on_device(3.0)
    assert (array.shape, array.numpy().shape, float(array.numpy())) == ((), (), 3.0)
    with pytest.raises(TypeError, match="no length"):
        len(array)
    with pytest.raises(TypeError, match=r"copy it with \.numpy\(\)"):
        np.asarray(array)


def test_what_another_stream_writes_is_waited_for(soup, rays, waits):
    bvh, (origins, directions) = build(soup), map(on_device, rays)
    assert waits == []
    bvh.occluded(origins, Foreign(directions, stream=PER_THREAD))
    bvh.occluded(origins, Foreign(directions, stream=None))
    bvh.occluded(origins, Foreign(directions, stream=1))
    assert waits == [PER_THREAD]
    bvh.occluded(Foreign(origins, stream=PER_THREAD), Foreign(directions, stream=PER_THREAD))
    assert waits == [PER_THREAD]
    bvh.occluded(origins, Foreign(directions, stream=None), stream=PER_THREAD)
    assert waits == [PER_THREAD, 0]
    treelet.build(on_device(soup[0]), Foreign(on_device(soup[1], "int32"), stream=PER_THREAD))
    assert waits == [PER_THREAD, 0, PER_THREAD]


class FakeTorch:
    """As much of torch as treelet calls, over arrays of treelet."""

    float32, int32, bool = "float32", "int32", "bool"

    class Tensor(Foreign):
        device = "cuda:0"

        def __init__(self, array):
            super().__init__(array, stream=...)
            self.recorded = []

        def data_ptr(self):
            return self.__cuda_array_interface__["data"][0]

        def record_stream(self, stream):
            self.recorded.append(stream.cuda_stream)

        def numpy(self):
            return self._array.numpy()

    Tensor.__module__ = "torch"

    def __init__(self):
        self.stream, self.made_in = 0, []
        self.cuda = SimpleNamespace(
            current_stream=lambda device: SimpleNamespace(cuda_stream=self.stream),
            ExternalStream=lambda address, device: SimpleNamespace(cuda_stream=address, device=device),
            stream=self.use,
        )

    @contextlib.contextmanager
    def use(self, stream):
        outer, self.stream = self.stream, stream.cuda_stream
        yield
        self.stream = outer

    def empty(self, shape, dtype, device):
        assert device == "cuda:0"
        self.made_in.append(self.stream)
        return self.Tensor(on_device(np.zeros(shape, dtype)))


class Parameter(FakeTorch.Tensor):
    """A subclass from elsewhere, as torch.nn.Parameter or a user's own."""


@pytest.mark.parametrize("kind", [FakeTorch.Tensor, Parameter])
def test_torch_gets_tensors_made_in_the_stream_that_writes_them(soup, rays, monkeypatch, kind):
    torch = FakeTorch()
    monkeypatch.setitem(sys.modules, "torch", torch)
    bvh, expected = build(soup), treelet.build(*soup).intersect(*rays)
    for current, stream in ((0, None), (PER_THREAD, None), (0, PER_THREAD), (PER_THREAD, 0)):
        origins, directions = (kind(on_device(part)) for part in rays)
        torch.stream, torch.made_in = current, []
        hits = bvh.intersect(origins, directions, stream=stream)
        used = current if stream is None else stream
        assert all(type(values) is FakeTorch.Tensor for values in hits)
        assert torch.made_in == [used] * 4
        assert origins.recorded == directions.recorded == ([used] if used != current else [])
        cuda.synchronize(used)
        np.testing.assert_array_equal(hits.t.numpy(), expected.t)


class FakeCupy:
    """As much of cupy as treelet calls, over arrays of treelet."""

    class ndarray(Foreign):  # noqa: N801
        device = contextlib.nullcontext()

        @property
        def data(self):
            return SimpleNamespace(ptr=self.__cuda_array_interface__["data"][0])

        def numpy(self):
            return self._array.numpy()

    ndarray.__module__ = "cupy"

    def __init__(self):
        self.stream, self.made_in = 0, []
        self.cuda = SimpleNamespace(
            Device=contextlib.nullcontext,
            get_current_stream=lambda: SimpleNamespace(ptr=self.stream),
            ExternalStream=self.use,
        )

    @contextlib.contextmanager
    def use(self, address):
        outer, self.stream = self.stream, address
        yield
        self.stream = outer

    def empty(self, shape, dtype):
        self.made_in.append(self.stream)
        return self.ndarray(on_device(np.zeros(shape, dtype)))


def test_cupy_gets_arrays_made_in_the_stream_that_writes_them(soup, rays, monkeypatch):
    cupy = FakeCupy()
    monkeypatch.setitem(sys.modules, "cupy", cupy)
    bvh, expected = build(soup), treelet.build(*soup).occluded(*rays)
    for current, stream in ((0, None), (PER_THREAD, None), (0, PER_THREAD)):
        origins, directions = (FakeCupy.ndarray(on_device(part)) for part in rays)
        cupy.stream, cupy.made_in = current, []
        occluded = bvh.occluded(origins, directions, stream=stream)
        used = current if stream is None else stream
        assert type(occluded) is FakeCupy.ndarray
        assert cupy.made_in == [used]
        cuda.synchronize(used)
        np.testing.assert_array_equal(occluded.numpy(), expected)


class JaxArray(Foreign):
    """jax's arrays come from jaxlib, and know no streams."""

    def block_until_ready(self):
        self.is_ready = True


JaxArray.__module__ = "jaxlib._jax"


def test_jax_is_waited_for_and_waits(soup, rays, monkeypatch, waits):
    dlpack = SimpleNamespace(from_dlpack=lambda array: ("jax", array))
    monkeypatch.setitem(sys.modules, "jax", SimpleNamespace(dlpack=dlpack))
    vertices = JaxArray(on_device(soup[0]), stream=None)
    bvh = treelet.build(vertices, on_device(soup[1], "int32"), "lbvh > bvh2", updatable=True)
    assert vertices.is_ready
    assert len(waits) == 1
    bvh.refit(vertices)
    bvh.rebuild(vertices)
    assert len(waits) == 3
    library, occluded = bvh.occluded(*(JaxArray(on_device(part), stream=None) for part in rays))
    assert len(waits) == 4
    assert library == "jax"
    np.testing.assert_array_equal(occluded.numpy(), treelet.build(*soup).occluded(*rays))


class Stream:
    def __init__(self, address):
        self.address = address

    def __cuda_stream__(self):
        return (0, self.address)


def test_any_stream_object(soup):
    bvh = build(soup)
    origin, direction = on_device(np.zeros((1, 3), np.float32)), on_device(np.ones((1, 3), np.float32))
    expected = bvh.intersect(origin, direction).t.numpy()
    streams = (0, 1, PER_THREAD, np.int64(1), Stream(0), Stream(PER_THREAD), SimpleNamespace(ptr=0))
    for stream in (*streams, SimpleNamespace(cuda_stream=1)):
        t = bvh.intersect(origin, cuda.copy_to_device(direction.numpy(), stream=stream), stream=stream).t
        cuda.synchronize(stream)
        np.testing.assert_array_equal(t.numpy(), expected)
        on_stream = build(soup, stream=stream)
        assert on_stream.to("cpu", stream=stream).validate() == []


@pytest.mark.parametrize("stream", ["fast", 1.0, True, Stream("fast"), SimpleNamespace(ptr=None)], ids=str)
def test_what_is_no_stream(soup, stream):
    for call in (cuda.synchronize, lambda stream: build(soup, stream=stream)):
        with pytest.raises(TypeError, match="stream must be an address or a stream object"):
            call(stream)


@pytest.mark.parametrize("stream", [-1, 2**64])
def test_what_is_no_address_of_a_stream(stream):
    with pytest.raises(ValueError, match="stream must be an address, not"):
        cuda.synchronize(stream)
    with pytest.raises(ValueError, match="stream must be an address, not"):
        cuda.copy_to_device([1.0], stream=stream)
