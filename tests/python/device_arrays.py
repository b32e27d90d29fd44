"""Arrays in device memory for tests, and trees over them."""

import numpy as np

import treelet
from treelet import cuda


def random_rays():
    """500 origins in and around the unit cube, and directions into it."""
    random = np.random.default_rng(5)
    origins = random.uniform(-1, 2, (500, 3)).astype(np.float32)
    return origins, (random.uniform(0, 1, (500, 3)) - origins).astype(np.float32)


def on_device(values, dtype=None):
    return cuda.copy_to_device(values, dtype)


def build(soup, recipe="lbvh > treelet > bvh2", **options):
    vertices, faces = soup
    return treelet.build(on_device(vertices), on_device(faces, "uint32"), recipe, **options)


class Foreign:
    """Another library's array, that may say something else of itself."""

    def __init__(self, array, **changes):
        self._array, self._changes = array, changes

    @property
    def __cuda_array_interface__(self):
        changed = self._array.__cuda_array_interface__ | self._changes
        return {key: value for key, value in changed.items() if value is not Ellipsis}
