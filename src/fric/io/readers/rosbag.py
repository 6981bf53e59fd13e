"""ROS bags – ROS 2 as MCAP or SQLite, ROS 1 – through rosbags (the extra ``ros``).

Each number of a message is a column, named as in ``/joint_states.velocity[0]``, or by its joint where the message names
some; its time is the stamp in the message's header, or else when it was recorded. Messages give no units.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import import_module
from itertools import islice
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.input import foreign
from fric.io.readers.base import Column, ForeignTable, Format, RowBlock, library
from fric.io.readers.joined import Joined, SharedClock

FORMAT = Format("ROS bag", (".mcap", ".db3", ".bag"), "rosbags.highlevel", "ros")
MESSAGES = 16_384  # Messages a block
MOST_ELEMENTS = 64  # Elements of an array that are columns at most: an image is none
DEEP = 8  # Largest depth of nested messages
MOST_CHUNK = 256 << 20  # Bytes that a chunk unpacks to at most

Taken = Callable[[Any], float]


def recognises(path: Path, head: bytes) -> float:
    """MCAP and ROS 1 have signatures; SQLite is a bag by its name."""
    sqlite = head.startswith(b"SQLite format 3\0") and path.suffix.lower() == ".db3"
    return float(head.startswith((b"\x89MCAP", b"#ROSBAG")) or sqlite)


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a bag: one table of all its topics that hold numbers, on a common clock."""
    reader = library(FORMAT)
    from rosbags.typesys import Stores, get_typestore

    with _bounded(), reader.AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as bag:
        topics = [_Topic(path, bag, connection) for connection in bag.connections if connection.msgcount]
        if not (parts := [SharedClock(topic, 0, label=topic.name) for topic in topics if len(topic.columns) > 1]):
            raise FricError("holds no topic of numbers", hint="Record a topic such as /joint_states.")
        yield Joined(path, parts)


@contextmanager
def _bounded() -> Iterator[None]:
    """Let the library unpack a chunk up to `MOST_CHUNK`: bz2 makes a GiB of 800 bytes, and the library has no bound.
    What it unpacks with belongs to the whole process: it is put back.
    """
    import bz2

    ros_1: Any = import_module("rosbags.rosbag1.reader")
    mcap: Any = import_module("rosbags.rosbag2.storage_mcap")
    lz4: Any = import_module("lz4.frame")

    def bounded(make: Callable[[], Any]) -> Callable[..., bytes]:
        def unpack(data: bytes, *_: Any) -> bytes:
            found = b""
            while data:
                unpacker = make()
                found += unpacker.decompress(data, MOST_CHUNK - len(found) + 1)
                if len(found) > MOST_CHUNK:
                    raise FricError("unpacks to more than is read", hint="Record it unpacked.")
                if not unpacker.eof:
                    raise EOFError("a chunk is cut short")
                data = unpacker.unused_data or b""
            return found

        return unpack

    with ExitStack() as stack:
        for table, makers in (
            (ros_1.decompressors, {"bz2": bz2.BZ2Decompressor, "lz4": lz4.LZ4FrameDecompressor}),
            (mcap.DECOMPRESSORS, {"lz4": lz4.LZ4FrameDecompressor, "zstd": mcap.zstd.ZstdDecompressor}),
        ):
            stack.callback(table.update, dict(table))
            table.update({name: bounded(make) for name, make in makers.items()})
        if apsw := getattr(import_module("rosbags.rosbag2.storage_sqlite3"), "apsw", None):
            length, views = apsw.SQLITE_LIMIT_LENGTH, apsw.SQLITE_DBCONFIG_ENABLE_VIEW  # a view may have no end
            for hook in (lambda file: file.limit(length, MOST_CHUNK), lambda file: file.config(views, 0)):
                apsw.connection_hooks.append(hook)
                stack.callback(apsw.connection_hooks.remove, hook)
        yield


class _Topic(ForeignTable):
    """The numbers of the messages of a topic, with their time [s] as column 0."""

    def __init__(self, path: Path, bag: Any, connection: Any) -> None:
        self.path, self._bag, self._connection, self.name = path, bag, connection, connection.topic
        _, first = next(self._messages(), (0, None))
        if first is None:
            raise FricError(f"{self.name} has no messages", hint="Record the bag again.")
        self._stamped = hasattr(getattr(first, "header", None), "stamp")
        self._taken = dict(_numbers(first))
        super().__init__(path, [Column("time", "s"), *(Column(self.name + key) for key in self._taken)])

    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Read the bag message by message."""
        getters = [None, *self._taken.values()]
        taken = [getters[n] for n in wanted]
        row, messages = 0, self._messages()
        while True:  # messages are released one by one: thousands of them would slow garbage collection
            values = (
                take(message) if take else self._time(at, message)
                for at, message in islice(messages, MESSAGES) for take in taken
            )  # fmt: skip
            if not (columns := np.fromiter(values, "f8").reshape(-1, len(taken)).T).size:
                return
            yield RowBlock(row, [np.ascontiguousarray(column) for column in columns], 8 * columns.size)
            row += columns.shape[1]

    def _messages(self) -> Iterator[tuple[int, Any]]:
        with foreign(self.path, "Record the bag again."):
            for _, at, raw in self._bag.messages(connections=[self._connection]):
                yield at, self._bag.deserialize(raw, self._connection.msgtype)

    def _time(self, at: int, message: Any) -> float:
        stamp = message.header.stamp if self._stamped else None
        return stamp.sec + stamp.nanosec * 1e-9 if stamp and (stamp.sec or stamp.nanosec) else at * 1e-9


def _numbers(message: Any, name: str = "", depth: int = 0) -> Iterator[tuple[str, Taken]]:
    """Yield each number of a message: its name, and a function that reads it from another message of the type.

    name, depth: Of a message in another: its dotted name, which begins with a dot, and how deep it is.
    """
    joints = getattr(message, "name", None)
    for field in getattr(message, "__dataclass_fields__", {}):
        value = getattr(message, field)
        if field.startswith("__") or field in ("header", "layout"):
            continue
        inner = f"{name}.{field}"
        take = attrgetter(inner[1:])
        if isinstance(value, bool | int | float | np.generic):
            yield inner, take
        elif isinstance(value, np.ndarray | list) and len(value) <= MOST_ELEMENTS:
            labels = joints if isinstance(joints, list) and len(joints) == len(value) else range(len(value))
            for n, (label, element) in enumerate(zip(labels, value, strict=True)):
                if isinstance(element, int | float | np.generic):
                    yield f"{inner}[{label}]", partial(_element, take, n)
        elif depth < DEEP:
            yield from _numbers(value, inner, depth + 1)


def _element(field: Taken, n: int, message: Any) -> float:
    """Return an element; no number where a message holds fewer."""
    values: Any = field(message)
    return float(values[n]) if n < len(values) else np.nan
