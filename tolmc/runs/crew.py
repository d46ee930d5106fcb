"""Workers that do calls in parallel and hand the results back in order: threads here, or a Dask cluster.

Threads, because the kernels run without the interpreter lock and share one compilation, and because no array is then
copied between processes.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain, islice, starmap
from typing import Protocol

from tolmc.errors import ClusterError


class Crew(Protocol):
    """``size`` workers."""

    @property
    def size(self) -> int: ...

    def map(self, function: Callable, calls: Iterable[tuple]) -> Generator:
        """``function(*call)`` for every call, in the order of the calls, as they become ready.

        What is not collected is not computed, but for a few calls ahead.
        """


@dataclass(frozen=True)
class _Threads:
    size: int

    def map(self, function: Callable, calls: Iterable[tuple]) -> Generator:
        calls = iter(calls)
        first = list(islice(calls, 2))
        calls = chain(first, calls)
        if self.size == 1 or len(first) < 2:
            yield from starmap(function, calls)
            return
        import joblib  # takes longer to load than a small run's only call

        with joblib.parallel_config("threading"):
            parallel = joblib.Parallel(n_jobs=self.size, batch_size=1, return_as="generator")
            results = parallel(joblib.delayed(function)(*call) for call in calls)
        try:
            yield from chain(results)  # a chain has no close(), so only the one below reaches joblib
        finally:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # its remark on results that a stopped run leaves behind
                results.close()


@contextmanager
def crew(workers: int, cluster: str | None = None) -> Iterator[Crew]:
    """Threads, or all workers of the Dask cluster whose scheduler is at the address ``cluster``.

    ClusterError where Dask is missing or the cluster cannot be used, and from :meth:`Crew.map` where it gave up.
    """
    if cluster is None:
        yield _Threads(workers)
        return
    try:
        from tolmc.runs.dask import cluster_crew
    except ImportError:
        raise ClusterError('a cluster needs Dask: pip install "tolmc[cluster]".') from None
    with cluster_crew(cluster) as workers_there:
        yield workers_there
