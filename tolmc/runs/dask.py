"""Workers of an existing Dask cluster; importing this needs Dask."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import islice
from typing import Any

from dask.distributed import CancelledError, Client, Future, KilledWorker

from tolmc.errors import ClusterError

_CONNECT_SECONDS = 10
#: Calls that a worker has at hand: while one result waits to be collected it does the next.
_AHEAD = 3


class _Client(Client):
    """Dask's client, which does not close itself when it cannot start and then holds up the end of the process."""

    def start(self, **options: Any) -> None:
        with ExitStack() as undo:
            undo.callback(self.close)
            super().start(**options)
            undo.pop_all()


@dataclass(frozen=True)
class _Workers:
    """All workers of the cluster that ``client`` is connected to."""

    client: Client
    size: int

    def map(self, function: Callable, calls: Iterable[tuple]) -> Generator:
        tasks = (self.client.submit(function, *call, pure=False) for call in calls)
        waiting = deque(islice(tasks, _AHEAD * self.size))
        try:
            while waiting:
                result = _result(waiting[0])
                waiting.popleft()
                waiting.extend(islice(tasks, 1))
                yield result
        finally:
            self.client.cancel(list(waiting))


def _result(future: Future) -> Any:
    try:
        return future.result()
    except (KilledWorker, CancelledError) as error:
        raise ClusterError(f"the cluster gave a block up: {error}") from None


@contextmanager
def cluster_crew(address: str) -> Iterator[_Workers]:
    """All workers of the Dask cluster whose scheduler is at ``address``, such as "tcp://host:8786".

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
        yield _Workers(client, size)
