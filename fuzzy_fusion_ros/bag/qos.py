"""The quality of service that a topic was offered with, as rosbag2 keeps it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from fuzzy_fusion_ros.parameters.errors import BagError

INFINITE_NS = 2**63 - 1

# Bags up to version 8 hold rmw's numbers instead of names.
_HISTORIES = ("system_default", "keep_last", "keep_all", "unknown")
_RELIABILITIES = ("system_default", "reliable", "best_effort", "unknown", "best_available")
_DURABILITIES = ("system_default", "transient_local", "volatile", "unknown", "best_available")
_LIVELINESSES = (
    "system_default",
    "automatic",
    "manual_by_node",
    "manual_by_topic",
    "unknown",
    "best_available",
)


@dataclass(frozen=True)
class QosProfile:
    """One offered profile; the policies by the names that rmw gives them.

    Attributes:
        history: ``keep_last`` or ``keep_all``.
        depth: Messages kept.
        reliability: ``reliable`` or ``best_effort``.
        durability: ``volatile`` or ``transient_local``.
        deadline_ns: ns; infinite if there is none, like the other durations.
        lifespan_ns: ns.
        liveliness: ``automatic`` or ``manual_by_topic``.
        liveliness_lease_ns: ns.
        avoid_ros_namespace_conventions: As in rmw.
    """

    history: str = "keep_last"
    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    deadline_ns: int = INFINITE_NS
    lifespan_ns: int = INFINITE_NS
    liveliness: str = "automatic"
    liveliness_lease_ns: int = INFINITE_NS
    avoid_ros_namespace_conventions: bool = False

    def to_rosbag2(self) -> dict[str, Any]:
        """Return the profile as metadata of version 9 holds it."""
        return {
            "history": self.history,
            "depth": self.depth,
            "reliability": self.reliability,
            "durability": self.durability,
            "deadline": _split(self.deadline_ns),
            "lifespan": _split(self.lifespan_ns),
            "liveliness": self.liveliness,
            "liveliness_lease_duration": _split(self.liveliness_lease_ns),
            "avoid_ros_namespace_conventions": self.avoid_ros_namespace_conventions,
        }


def qos_to_text(profiles: Iterable[QosProfile]) -> str:
    """Return profiles as the YAML text that an MCAP channel holds."""
    described = [profile.to_rosbag2() for profile in profiles]
    return yaml.safe_dump(described, sort_keys=False).strip() if described else ""


def qos_from_rosbag2(described: object) -> tuple[QosProfile, ...]:
    """Return the profiles in a bag, of any metadata version.

    Args:
        described: A list of mappings, or the YAML text of one.

    Raises:
        BagError: It is neither.
    """
    try:
        if isinstance(described, str):
            described = yaml.safe_load(described)
        profiles = described or ()
        if not isinstance(profiles, Iterable):
            raise TypeError(f"{type(profiles).__name__!r} object is not iterable")
        return tuple(_profile(each) for each in profiles)
    except (yaml.YAMLError, LookupError, TypeError, ValueError, AttributeError) as error:
        raise BagError(f"offered QoS profiles {described!r} are not rosbag2's: {error}") from error


def _profile(described: Mapping[str, Any]) -> QosProfile:
    return QosProfile(
        history=_named(described["history"], _HISTORIES),
        depth=int(described["depth"]),
        reliability=_named(described["reliability"], _RELIABILITIES),
        durability=_named(described["durability"], _DURABILITIES),
        deadline_ns=_join(described["deadline"]),
        lifespan_ns=_join(described["lifespan"]),
        liveliness=_named(described["liveliness"], _LIVELINESSES),
        liveliness_lease_ns=_join(described["liveliness_lease_duration"]),
        avoid_ros_namespace_conventions=bool(described["avoid_ros_namespace_conventions"]),
    )


def _named(policy: str | int, names: tuple[str, ...]) -> str:
    return names[policy] if isinstance(policy, int) else policy


def _split(duration_ns: int) -> dict[str, int]:
    seconds, nanoseconds = divmod(duration_ns, 1_000_000_000)
    return {"sec": seconds, "nsec": nanoseconds}


def _join(duration: Mapping[str, int]) -> int:
    return min(int(duration["sec"]) * 1_000_000_000 + int(duration["nsec"]), INFINITE_NS)
