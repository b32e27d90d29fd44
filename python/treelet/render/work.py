"""Cutting a picture into chunks of pixels, for a few threads or one wave after the other."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import treelet

Progress = Callable[[int, int], None]  # (done, of)


def for_each_chunk(
    count: int, chunk: int, body: Callable[[range], None], progress: Progress | None = None
) -> None:
    """Call body(part) for ranges of [0, count) of at most `chunk`; bodies write to disjoint places.

    Threads help because numpy and the tracer both release the GIL. Chunk borders are constant, so the work
    and its rounding do not depend on the number of threads.
    """
    with ThreadPoolExecutor(max_workers=max(1, treelet.thread_count())) as pool:
        jobs = [pool.submit(body, part) for part in _parts(count, chunk)]
        try:
            for done, job in enumerate(jobs, start=1):
                job.result()
                if progress is not None:
                    progress(done, len(jobs))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def for_each_wave(
    count: int, chunk: int, body: Callable[[range], None], progress: Progress | None = None
) -> None:
    """As `for_each_chunk`, but here and in turn: a device is busy with one wave, and the current stream of
    array libraries belongs to a thread.
    """
    parts = _parts(count, chunk)
    for done, part in enumerate(parts, start=1):
        body(part)
        if progress is not None:
            progress(done, len(parts))


def _parts(count: int, chunk: int) -> list[range]:
    return [range(start, min(start + chunk, count)) for start in range(0, count, chunk)]
