"""Workers of an existing Dask cluster, through joblib's Dask backend; importing this needs Dask."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager

from dask.distributed import Client
from joblib._dask import DaskDistributedBackend

from tolmc.errors import ClusterError

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


class _Client(Client):
    """Dask's client, which does not close itself when it cannot start and then holds up the end of the process."""

    def start(self, **options):
        with ExitStack() as undo:
            undo.callback(self.close)
            super().start(**options)
            undo.pop_all()


@contextmanager
def cluster_backend(address: str) -> Iterator[tuple[int, DaskDistributedBackend]]:
    """Number and joblib backend of all workers of the Dask cluster whose scheduler is at ``address``, such as "tcp://host:8786".

    Raises
    ------
    ClusterError
        When ``address`` is none, or the cluster does not answer or has no workers.
    """
    try:
        client = _Client(address, timeout=_CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:  # no answer; no address; a protocol that is not set up
        raise ClusterError(
            f"the Dask scheduler at {address!r} cannot be reached: {error}. Give its address, such as tcp://host:8786."
        ) from None
    with client:
        size = sum(client.ncores().values())
        if size == 0:
            raise ClusterError(f"the Dask cluster at {address!r} has no workers; start some with `dask worker`.")
        yield size, _Backend(client=client)
