# SPDX-License-Identifier: Apache-2.0
"""Clean recordings as arrays: what :func:`read_recording` gives, without a step for each message.

Instead of the guards and the trigger because these take most of the time of reading, and in most
recordings they have nothing to do. Where they have, or might have, there is no answer here, and
the messages go through them one by one.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, timeout_for
from fuzzy_fusion_ros.messages.codec import ScalarCodec
from fuzzy_fusion_ros.messages.columns import ColumnReader, Columns
from fuzzy_fusion_ros.offline.tracks import Progress, Track
from fuzzy_fusion_ros.online.clocks import NOTICEABLE, offset_between
from fuzzy_fusion_ros.online.guard import DELAYS, Guard
from fuzzy_fusion_ros.online.lines import AsTheyAre, lines_for
from fuzzy_fusion_ros.parameters.fusion import Parameters

_SENSORS = ("s1", "s2")


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
        progress: Passes the messages on.
    """
    if parameters.trigger != "s1" or not isinstance(lines_for(parameters), AsTheyAre):
        return None
    roles: dict[str, list[str]] = {}
    for role in codecs:
        roles.setdefault(topics[role], []).append(role)
    readers = {topic: ColumnReader([codecs[r] for r in each]) for topic, each in roles.items()}
    sinks = {topic: (number, each.add) for number, (topic, each) in enumerate(readers.items())}
    order = array("B")
    for message in progress(bag.messages(list(readers), start_s, end_s)):
        number, add = sinks[message.topic]
        order.append(number)
        add(message.data, message.log_ns)
    tracks: dict[str, Track] = {}
    for topic, each in roles.items():
        columns = readers[topic].columns()
        for k, role in enumerate(each):
            if not _is_clean(columns, k, parameters.future_tolerance):
                return None
            if not columns.stamps_ns.size and role in _SENSORS:
                return None
            tracks[role] = Track(columns.stamps_ns, columns.values[k], columns.received_ns)
    if _clocks_differ(tracks["s1"], tracks["s2"]):
        return None
    numbers = np.frombuffer(order, np.uint8)
    places = {role: np.flatnonzero(numbers == sinks[topics[role]][0]) for role in _SENSORS}
    if _s1_may_be_lost(tracks, places, parameters):
        return None
    s1, s2 = tracks["s1"], tracks["s2"]
    return Samples(
        tracks,
        Series(
            s1_ns=s1.stamps_ns,
            s1=s1.values,
            s2_ns=s2.stamps_ns,
            s2=s2.values,
            s2_known=np.searchsorted(places["s2"], places["s1"]).astype(np.int64),
            s2_alone=np.array([], np.int64),
            started_ns=int(s1.stamps_ns[0]),
        ),
    )


def _is_clean(columns: Columns, k: int, future_tolerance: float) -> bool:
    """Return whether a guard would admit all samples at once."""
    stamps_ns = columns.stamps_ns
    return bool(
        (stamps_ns > 0).all()
        and not columns.overflows.any()
        and not columns.lacking[k].any()
        and np.isfinite(columns.values[k]).all()
        and (np.diff(stamps_ns) > 0).all()
        and ((stamps_ns - columns.received_ns) * 1e-9 <= future_tolerance).all()
    )


def _clocks_differ(s1: Track, s2: Track) -> bool:
    """Return whether there might be something to say about the sensors' clocks."""
    guards = Guard(), Guard()
    for guard, track in zip(guards, (s1, s2), strict=True):
        guard.delays_ns.extend((track.log_ns - track.stamps_ns)[-DELAYS:].tolist())
    offset = offset_between(*guards)
    return offset is not None and abs(offset) > NOTICEABLE


def _s1_may_be_lost(
    tracks: Mapping[str, Track], places: Mapping[str, NDArray[np.int64]], parameters: Parameters
) -> bool:
    """Return whether S2 comes later after S1, or S1's first sample, than the shortest timeout."""
    s1_ns, s2_ns = tracks["s1"].stamps_ns, tracks["s2"].stamps_ns
    heard = np.searchsorted(places["s1"], places["s2"], side="right")
    heard_ns = np.where(heard > 0, s1_ns[np.maximum(heard - 1, 0)], s2_ns[0])
    longest = timeout_for(parameters.s1.timeout, S1_TIMEOUT, 0.0)
    return bool(((s2_ns - heard_ns) * 1e-9 > longest).any())
