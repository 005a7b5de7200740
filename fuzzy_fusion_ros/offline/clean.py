# SPDX-License-Identifier: Apache-2.0
"""Clean recordings as arrays: what :func:`read_recording` gives, without a step for each message.

Instead of the guards and the trigger because these take most of the time of reading, and in most
recordings they have nothing to do. Where they have or might have, this returns ``None``, and the
caller passes the messages through them one by one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.batch.arrays import Stamps
from fuzzy_fusion_ros.batch.series import NOWHERE, Series
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, timeout_for
from fuzzy_fusion_ros.messages.codec import ScalarCodec
from fuzzy_fusion_ros.messages.columns import ColumnReader, Columns
from fuzzy_fusion_ros.offline.tracks import Progress, Track
from fuzzy_fusion_ros.online.clocks import NOTICEABLE, offset_between
from fuzzy_fusion_ros.online.guard import DELAYS, Guard
from fuzzy_fusion_ros.online.lines import AsTheyAre, lines_for
from fuzzy_fusion_ros.parameters.fusion import Parameters

SENSORS = ("s1", "s2")


class Samples(NamedTuple):
    """The samples of a recording that count.

    Attributes:
        tracks: The samples by role.
        series: The steps of an estimator.
    """

    tracks: dict[str, Track]
    series: Series


def read_clean(
    bag: BagReader,
    topics: Mapping[str, str],
    codecs: Mapping[str, ScalarCodec],
    parameters: Parameters,
    start_s: float | None,
    end_s: float | None,
    progress: Progress,
) -> Samples | None:
    """Read the samples of a bag; return ``None`` if one of them needs a guard.

    Args:
        bag: The bag.
        topics: The topics by role; S1 and S2 are among them.
        codecs: What reads the messages of each role.
        parameters: Trigger, timeouts and tolerances.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
        progress: Passes blocks of messages on.
    """
    if not takes_arrays(parameters):
        return None
    roles: dict[str, list[str]] = {}
    for role in codecs:
        roles.setdefault(topics[role], []).append(role)
    readers = {topic: ColumnReader([codecs[r] for r in each]) for topic, each in roles.items()}
    places: dict[str, list[Stamps]] = {topics[role]: [NOWHERE] for role in SENSORS}
    seen = 0
    for block in progress(bag.blocks(list(readers), start_s, end_s)):
        for topic, reader in readers.items():
            which = block.which(topic)
            found = block.chosen(which)
            reader.add(found.data, found.at, found.sizes, found.log_ns)
            if topic in places:
                places[topic].append(which + seen)
        seen += block.at.size
    order = {role: np.concatenate(places[topics[role]]) for role in SENSORS}
    places.clear()
    tracks: dict[str, Track] = {}
    sensors: dict[str, Columns] = {}
    for topic, each in roles.items():
        columns = readers[topic].columns()
        for k, role in enumerate(each):
            own = columns._replace(values=columns.values[k], lacking=columns.lacking[k])
            if not is_settled(own, parameters.future_tolerance, Guard()):
                return None
            tracks[role] = Track(own.stamps_ns, own.values, own.received_ns)
            sensors[role] = own
    if not all(tracks[role].stamps_ns.size for role in SENSORS):
        return None
    if _clocks_differ(tracks["s1"], tracks["s2"]):
        return None
    guards = dict.fromkeys(SENSORS, Guard())
    series = series_of(sensors, order, guards, parameters)
    return None if series is None else Samples(tracks, series)


def takes_arrays(parameters: Parameters) -> bool:
    """Return whether samples make steps as they come: the trigger is S1, nothing wraps or adds up.

    Args:
        parameters: Of the fusion.
    """
    return parameters.trigger == "s1" and isinstance(lines_for(parameters), AsTheyAre)


def is_settled(columns: Columns, future_tolerance: float, guard: Guard) -> bool:
    """Return whether a guard would admit all samples of a sensor at once, each as it comes.

    Args:
        columns: The samples, ``values`` and ``lacking`` of shape (n,).
        future_tolerance: How far stamps may be ahead of the log, seconds.
        guard: The guard after the samples before them, of a timeline on which nothing is held.
    """
    stamps_ns = columns.stamps_ns
    if not stamps_ns.size:
        return True
    newest_ns = 0 if guard.newest_ns is None else guard.newest_ns
    return bool(
        stamps_ns[0] > newest_ns
        and (guard.left_ns is None or stamps_ns[-1] < guard.left_ns)
        and not columns.overflows.any()
        and not columns.lacking.any()
        and np.isfinite(columns.values).all()
        and (np.diff(stamps_ns) > 0).all()
        and ((stamps_ns - columns.received_ns) * 1e-9 <= future_tolerance).all()
    )


def series_of(
    columns: Mapping[str, Columns],
    places: Mapping[str, NDArray[np.int64]],
    guards: Mapping[str, Guard],
    parameters: Parameters,
) -> Series | None:
    """Return the steps of settled samples; ``None`` if S1 may be lost among them.

    Args:
        columns: The samples of both sensors, by role.
        places: Their places among all messages, rising, by role.
        guards: The guards after the samples before them, by role.
        parameters: Of the fusion.
    """
    s1, s2 = columns["s1"], columns["s2"]
    heard = np.searchsorted(places["s1"], places["s2"], side="right")
    before_ns = guards["s1"].newest_ns
    if before_ns is None and s2.stamps_ns.size:  # S1 is awaited from S2's first sample on
        before_ns = guards["s2"].first_ns or int(s2.stamps_ns[0])
    heard_ns = np.append(before_ns or 0, s1.stamps_ns)[heard]
    longest = timeout_for(parameters.s1.timeout, S1_TIMEOUT, 0.0)
    if ((s2.stamps_ns - heard_ns) * 1e-9 > longest).any():
        return None
    return Series(
        s1_ns=s1.stamps_ns,
        s1=s1.values,
        s2_ns=s2.stamps_ns,
        s2=s2.values,
        s2_known=np.searchsorted(places["s2"], places["s1"]).astype(np.int64),
        started_ns=int(s1.stamps_ns[0]) if s1.stamps_ns.size else 0,
    )


def _clocks_differ(s1: Track, s2: Track) -> bool:
    """Return whether there might be something to say about the sensors' clocks."""
    guards = Guard(), Guard()
    for guard, track in zip(guards, (s1, s2), strict=True):
        guard.delays_ns.extend((track.log_ns - track.stamps_ns)[-DELAYS:].tolist())
    offset = offset_between(*guards)
    return offset is not None and abs(offset) > NOTICEABLE
