"""Workers of an existing Dask cluster, through joblib's Dask backend."""

from __future__ import annotations

from concurrent.futures import Future
from contextlib import contextmanager

from joblib._dask import DaskDistributedBackend

from tolmc.errors import ClusterError
from tolmc.workers import Crew

_CONNECT_SECONDS = 10


class _Backend(DaskDistributedBackend):
    """Joblib's backend, which waits for ever for a task that Dask itself gave up (its workers died again and again)."""

    def submit(self, func, callback=None):
        future = super().submit(func, callback)
        future.add_done_callback(lambda done: callback(done) if done.exception() else None)
        return future

    def retrieve_result_callback(self, out):
        if isinstance(out, Future):
            raise ClusterError(f"the cluster gave a block up: {out.exception()}")
        return super().retrieve_result_callback(out)


@contextmanager
def cluster_crew(address: str):
    """All workers of the Dask cluster whose scheduler is at ``address``, such as "tcp://host:8786".

    Raises
    ------
    ClusterError
        When Dask is missing, or the cluster does not answer or has no workers.
    """
    try:
        from dask.distributed import Client
    except ImportError:
        raise ClusterError('a cluster needs Dask: pip install "tolmc[cluster]".') from None
    try:
        client = Client(address, timeout=_CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError(f"the Dask scheduler at {address!r} does not answer: {error}. Check the address.") from None
    with client:
        size = sum(client.ncores().values())
        if size == 0:
            raise ClusterError(f"the Dask cluster at {address!r} has no workers; start some with `dask worker`.")
        yield Crew(size, _Backend(client=client))
