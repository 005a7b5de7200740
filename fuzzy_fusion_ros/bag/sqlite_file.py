# SPDX-License-Identifier: Apache-2.0
"""Reads the messages of one sqlite3 file of rosbag2 in the order of their log times.

Instead of rosbags' reader because that leaves out what a killed recorder left in the write-ahead
log, and stops at the first damaged row (measured by test/bag/test_damage.py).
"""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fuzzy_fusion_ros.bag.block import Block, gathered
from fuzzy_fusion_ros.bag.metadata import MetadataError, qos_from_text
from fuzzy_fusion_ros.bag.topic import MOST_TOPICS, BagMessage, Definition, Topic
from fuzzy_fusion_ros.parameters.errors import BagError

# What sqlite3 raises on damaged files, and what wrong types in their rows lead to.
_DAMAGE = (sqlite3.Error, UnicodeDecodeError, LookupError, TypeError, ValueError, OverflowError)


class SqliteFile:
    """One sqlite3 file, of any version of rosbag2.

    Attributes:
        topics: What the file holds.
        start_ns: The earliest log time, ns; None without messages.
        end_ns: The latest log time, ns; None without messages.
    """

    def __init__(self, path: Path, note: Callable[[str], None]) -> None:
        """Open a file.

        Args:
            path: The file.
            note: Told of all that is not whole, now and while messages are read.

        Raises:
            BagError: It cannot be read or is no sqlite3 file of rosbag2.
        """
        self._note = note
        self.start_ns: int | None = None
        self.end_ns: int | None = None
        try:
            self._database = _connect(path)
        except _DAMAGE as error:
            raise BagError(f"{str(path)!r} is not a readable sqlite3 bag: {error}") from error
        try:
            self._require_plain_tables()
            definitions = self._definitions()
            rows = self._query(f"SELECT * FROM topics ORDER BY id LIMIT {MOST_TOPICS + 1}")
            if len(rows) > MOST_TOPICS:
                raise ValueError(f"it has more than {MOST_TOPICS} topics")
            topics = {row["id"]: self._topic(row, definitions) for row in rows}
        except (*_DAMAGE, BagError) as error:
            self._database.close()
            raise BagError(f"{str(path)!r} is not a readable sqlite3 bag: {error}") from error
        counts: Counter[int] | None = None
        try:
            ((self.start_ns, self.end_ns),) = self._query(
                "SELECT MIN(timestamp), MAX(timestamp) FROM messages "
                "WHERE typeof(timestamp) = 'integer'"
            )
            counts = Counter(
                dict(self._query("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id"))
            )
        except _DAMAGE as error:
            note(f"it is damaged ({error})")
        self._topics: dict[int, Topic] = {
            number: topic._replace(message_count=counts[number] if counts is not None else None)
            for number, topic in topics.items()
        }
        self.topics = list(self._topics.values())

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def messages(
        self, names: Collection[str] | None, start_ns: int, stop_ns: int
    ) -> Iterator[BagMessage]:
        """Yield messages in the order of their log times, equal ones in that of the file.

        Args:
            names: The topics; None for all.
            start_ns: Log times begin here, ns.
            stop_ns: Log times end before this, ns.

        Raises:
            BagError: The file was closed in between.
        """
        wanted = {
            number: (topic.name, topic.msgtype)
            for number, topic in self._topics.items()
            if names is None or topic.name in names
        }
        reached = start_ns
        try:
            for number, log_ns, data in self._database.execute(
                "SELECT topic_id, timestamp, data FROM messages "
                "WHERE timestamp >= ? AND timestamp < ? "
                f"AND topic_id IN ({','.join('?' * len(wanted))}) ORDER BY timestamp, id",
                (start_ns, stop_ns, *wanted),
            ):
                if not (isinstance(log_ns, int) and isinstance(data, bytes)):
                    self._note(f"a message after log time {reached} ns is damaged")
                    continue
                reached = log_ns
                name, msgtype = wanted[number]
                yield BagMessage(name, msgtype, log_ns, data)
        except sqlite3.ProgrammingError as error:
            raise BagError("a sqlite3 file was closed while it was being read") from error
        except _DAMAGE as error:
            self._note(f"messages from log time {reached} ns on are lost ({error})")

    def blocks(self, names: Collection[str] | None, start_ns: int, stop_ns: int) -> Iterator[Block]:
        """Yield the messages of :meth:`messages` side by side."""
        return gathered(self.messages(names, start_ns, stop_ns))

    def _query(self, statement: str) -> list[Any]:
        return self._database.execute(statement).fetchall()

    def _require_plain_tables(self) -> None:
        """Refuse views and generated columns: reading them would run what the file says.

        Raises:
            ValueError: There are some.
        """
        for name, kind, statement in self._query(
            "SELECT name, type, sql FROM sqlite_master "
            "WHERE lower(name) IN ('topics', 'messages', 'message_definitions')"
        ):
            hidden = self._database.execute(
                "SELECT 1 FROM pragma_table_xinfo(?) WHERE hidden <> 0", (name,)
            )
            if kind != "table" or "VIRTUAL" in statement.upper() or hidden.fetchone():
                raise ValueError(f"its {name} is not a plain table")

    def _definitions(self) -> dict[str, Definition]:
        """Return the definitions by type; bags of releases before Iron have none."""
        if not self._query("SELECT 1 FROM sqlite_master WHERE name = 'message_definitions'"):
            return {}
        columns = ("encoding", "encoded_message_definition", "type_description_hash")
        return {
            row["topic_type"]: Definition(*(str(row[each] or "") for each in columns))
            for row in self._query("SELECT * FROM message_definitions")
        }

    def _topic(self, row: Any, definitions: Mapping[str, Definition]) -> Topic:
        columns = row.keys()
        offered = row["offered_qos_profiles"] if "offered_qos_profiles" in columns else ""
        try:
            qos = qos_from_text(offered)
        except MetadataError as error:
            self._note(f"topic {row['name']}: {error}")
            qos = ()
        return Topic(
            str(row["name"]),
            str(row["type"]),
            definition=definitions.get(row["type"]),
            qos=qos,
            encoding=str(row["serialization_format"]),
        )


def _text(data: bytes) -> str:
    """Return a text of the database; bytes that are no UTF-8 are replaced."""
    return data.decode(errors="replace")


def _connect(path: Path) -> sqlite3.Connection:
    """Return a read-only connection; the write-ahead log is used where it can be."""
    place = f"file:{quote(str(path.resolve()))}"
    try:
        return _try_to_connect(f"{place}?mode=ro")
    except sqlite3.OperationalError:  # its log needs a file next to it that cannot be made
        return _try_to_connect(f"{place}?immutable=1")


def _try_to_connect(uri: str) -> sqlite3.Connection:
    database = sqlite3.connect(uri, uri=True)
    database.row_factory = sqlite3.Row
    database.text_factory = _text
    try:
        database.execute("SELECT 1 FROM sqlite_master").fetchall()
    except _DAMAGE:
        database.close()
        raise
    return database
