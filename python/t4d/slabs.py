"""Slabs one by one, of a mesh that is only described: a thread makes them while Python goes on."""

from __future__ import annotations

import atexit
import queue
import threading
import weakref
from typing import Iterator, Union

from t4d import _t4d
from t4d.errors import Failed


class SlabStream(Iterator[_t4d.Slab]):
    """Slabs of a producer, in time order. Its thread keeps one slab ready, and ends when the
    stream is no longer used or Python ends."""

    def __init__(self, producer: _t4d.Producer) -> None:
        # A put never waits, so that finalizers and exit handlers may put.
        self._made: queue.SimpleQueue[Union[_t4d.Slab, BaseException]] = queue.SimpleQueue()
        self._wanted: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self._ended = False
        producer.use()
        # The thread must not keep the stream alive.
        self._thread = threading.Thread(
            target=_make, args=(producer, self._made, self._wanted), name="t4d-slabs", daemon=True
        )
        self._thread.start()
        _waiting.add(self._wanted)

    def __del__(self) -> None:
        self._wanted.put(False)

    def __next__(self) -> _t4d.Slab:
        if self._ended:
            raise StopIteration
        if self._made.empty() and not self._thread.is_alive():
            raise Failed("the slabs are made in another process: this one is a fork of it")
        self._wanted.put(True)
        made = self._made.get()
        if isinstance(made, _t4d.Slab):
            return made
        self._ended = True
        raise made


def _make(
    producer: _t4d.Producer,
    made: queue.SimpleQueue[Union[_t4d.Slab, BaseException]],
    wanted: queue.SimpleQueue[bool],
) -> None:
    def put(slab: _t4d.Slab) -> None:
        if not wanted.get():
            raise SystemExit
        made.put(slab)

    try:
        producer.each(put)
        made.put(StopIteration())
    except BaseException as error:  # for the thread that takes the slabs
        made.put(error)


_waiting: weakref.WeakSet[queue.SimpleQueue[bool]] = weakref.WeakSet()


@atexit.register
def _end() -> None:
    """Ends the threads of streams, and the work of all other threads."""
    for wanted in list(_waiting):
        wanted.put(False)
    _t4d.end()
