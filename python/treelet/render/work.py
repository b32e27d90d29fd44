"""Cutting a picture into chunks of pixels and running them on a few threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import treelet

Array = np.ndarray
Progress = Callable[[int, int], None]  # (done, of)


def for_each_chunk(
    count: int, chunk: int, body: Callable[[Array], None], progress: Progress | None = None
) -> None:
    """Call body(indices) for ranges of [0, count) of at most `chunk`; bodies write to disjoint places.

    Threads help because numpy and the tracer both release the GIL. Chunk borders are constant, so the work
    and its rounding do not depend on the number of threads.
    """
    starts = range(0, count, chunk)
    with ThreadPoolExecutor(max_workers=max(1, treelet.thread_count())) as pool:
        jobs = [pool.submit(body, np.arange(start, min(start + chunk, count))) for start in starts]
        try:
            for done, job in enumerate(jobs, start=1):
                job.result()
                if progress is not None:
                    progress(done, len(jobs))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
