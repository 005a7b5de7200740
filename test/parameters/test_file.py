# SPDX-License-Identifier: Apache-2.0
"""Parameter files: read as ROS reads them, written so that both take them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.file import applies, dump, load, owners, parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import descriptors, flatten, replace
from fuzzy_fusion_ros.parameters.writing import OutputError


def written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def of_fusion_node(path: Path, *lines: str) -> Path:
    body = "".join(f"    {line}\n" for line in lines)
    return written(path, f"fusion_node:\n  ros__parameters:\n{body}")


SCALARS: Mapping[str, object] = {
    "1": 1,
    "-1": -1,
    "+1": 1,
    "0x1F": 31,
    "-0x1f": -31,
    "010": 8,
    "08": 8.0,
    "1.5": 1.5,
    "1e5": 1e5,
    "1.": 1.0,
    ".5": 0.5,
    ".inf": float("inf"),
    "-.INF": float("-inf"),
    "y": True,
    "no": False,
    "On": True,
    "true": True,
    "1_000": "1_000",
    "'y'": "y",
    '"1.5"': "1.5",
    "text": "text",
    "[1, 2]": [1, 2],
    "[n, y]": [False, True],
    "": None,
}


@pytest.mark.parametrize("text", SCALARS)
def test_scalars_are_what_rcl_makes_of_them(tmp_path: Path, text: str) -> None:
    (value,) = load(of_fusion_node(tmp_path / "p.yaml", f"x: {text}")).values()
    assert (value, type(value)) == (SCALARS[text], type(SCALARS[text]))


def test_not_a_number_is_one(tmp_path: Path) -> None:
    value = load(of_fusion_node(tmp_path / "p.yaml", "x: .nan"))["x"]
    assert value != value


MATCHES = [
    ("fusion_node", "fusion_node", True),
    ("/fusion_node", "fusion_node", True),
    ("/ns/fusion_node", "fusion_node", True),
    ("/**", "fusion_node", True),
    ("/*", "fusion_node", True),
    ("/**/fusion_node", "fusion_node", True),
    ("other", "fusion_node", False),
    ("/", "fusion_node", False),
    ("/fusion_node", "/fusion_node", True),
    ("fusion_node", "/ns/fusion_node", False),
    ("/**/fusion_node", "/fusion_node", True),
    ("/**/fusion_node", "/a/b/fusion_node", True),
    ("/*/fusion_node", "/a/fusion_node", True),
    ("/*/fusion_node", "/a/b/fusion_node", False),
    ("/*/fusion_node", "/fusion_node", False),
    ("/a/**", "/a/b/fusion_node", True),
    ("/a/**", "/b/fusion_node", False),
]


@pytest.mark.parametrize(("owner", "node", "match"), MATCHES)
def test_wildcards_match_as_in_rcl(owner: str, node: str, match: bool) -> None:
    assert applies(owner, node) is match


def test_entries_nest_join_and_the_later_wins(tmp_path: Path) -> None:
    path = written(
        tmp_path / "p.yaml",
        """\
/**:
  ros__parameters:
    gate.tolerance: 1.0
    use_sim_time: true
robot:
  fusion_node:
    ros__parameters:
      gate:
        tolerance: 2.0
      s1: {field: point.y}
  other_node:
    ros__parameters: {a: 1}
""",
    )
    assert owners(path) == ["/**", "/robot/fusion_node", "/robot/other_node"]
    values = {"gate.tolerance": 2.0, "use_sim_time": True, "s1.field": "point.y"}
    assert load(path) == values
    assert load(path, "/robot/fusion_node") == values
    assert load(path, "/fusion_node") == {"gate.tolerance": 1.0, "use_sim_time": True}
    wanted = replace(Parameters(), {"gate.tolerance": 2.0, "s1.field": "point.y"})
    assert parameters_from(path) == wanted


REFUSED = {
    "of another node": (
        "other:\n  ros__parameters: {a: 1}\n",
        "it has no entry for fusion_node, only",
    ),
    "empty": ("", "expected node names with ros__parameters: below them"),
    "a list": ("- 1\n", "expected node names with ros__parameters: below them"),
    "no YAML": ("a: [1\n", "is not valid YAML: while parsing"),
    "no ros__parameters": (
        "fusion_node:\n  rate: 3\n",
        "line 2: expected ros__parameters: between the node's name and 'rate'",
    ),
    "bare": ("rate: 3.0\n", "line 1: expected ros__parameters: between the node's name and 'rate'"),
    "unknown": (
        "/**:\n  ros__parameters: {gate.tolerence: 1.0}\n",
        "parameter gate.tolerence: unknown; did you mean gate.tolerance?",
    ),
    "out of range": (
        "/**:\n  ros__parameters: {predictor.samples: 1}\n",
        "parameter predictor.samples: got 1, expected an integer from 3 to 200",
    ),
    "of the wrong type": (
        "/**:\n  ros__parameters: {gate.tolerance: wide}\n",
        "parameter gate.tolerance: got 'wide', expected a number",
    ),
    "a word turned into a switch": (
        "/**:\n  ros__parameters: {s1.field: y}\n",
        "parameter s1.field: got True, expected a string: quote words like 'y' and 'on'",
    ),
    "a name turned into a switch": (
        "/**:\n  ros__parameters: {channels: [x, y, z]}\n",
        "line 2: channels: got ['x', True, 'z'], expected strings: quote words like 'y' and 'on'",
    ),
    "nothing but a name turned into a switch": (
        "/**:\n  ros__parameters: {channels: [y]}\n",
        "parameter channels: got [True], expected a list of strings: quote words like 'y' and 'on'",
    ),
    "a value for a group": (
        "/**:\n  ros__parameters: {gate: 3.0}\n",
        "parameter gate: expected parameters below it, such as gate.tolerance",
    ),
    "a value for a channel": (
        "/**:\n  ros__parameters: {channels: [x], x: 3}\n",
        "parameter x: expected parameters below it, such as x.s1.field",
    ),
    "a channel's own of what belongs to the node": (
        "/**:\n  ros__parameters: {channels: [x], x: {trigger: pair}}\n",
        "parameter x.trigger: trigger belongs to the node, not to a channel: write it as trigger",
    ),
    "a channel that is not listed": (
        "/**:\n  ros__parameters: {channels: [x], z: {trigger: pair}}\n",
        "parameter z.trigger: there is no channel 'z' in channels, which has: x; add it there",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_used_is_refused_in_one_line(tmp_path: Path, name: str) -> None:
    text, problem = REFUSED[name]
    path = written(tmp_path / "p.yaml", text)
    with pytest.raises(ParameterError) as refusal:
        parameters_from(path)
    assert str(refusal.value).startswith(f"parameter file '{path}': {problem}")
    assert "\n" not in str(refusal.value)


def test_a_file_that_cannot_be_read_or_written_is_said(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "missing" / "p.yaml"):
        with pytest.raises(ParameterError, match="cannot be read: "):
            load(path)
    with pytest.raises(OutputError, match="cannot be written: "):
        dump(Parameters(), tmp_path)


def test_bytes_that_are_no_text_are_no_yaml(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ParameterError, match="is not valid YAML: "):
        load(path)


def channels(data: st.DataObject) -> dict[str, object]:
    """No channels, or two, and some values of their own."""
    names = data.draw(st.sampled_from([(), ("roll", "pitch_2")]))
    own = {"gate.tolerance": st.floats(0.0, 1e9), "s1.field": st.sampled_from(["a.x", "a.y"])}
    chosen = [
        (name, each) for name in names for each in data.draw(st.sets(st.sampled_from(list(own))))
    ]
    return {"channels": names, **{f"{n}.{each}": data.draw(own[each]) for n, each in chosen}}


def sound(data: st.DataObject) -> Parameters:
    """Any parameters at all, combinations aside."""
    values: dict[str, object] = {}
    for name, descriptor, default in descriptors(Parameters):
        if name.endswith((".small", ".large", ".scale")) or descriptor.choices:
            continue
        if name == "channels":
            values |= channels(data)
            continue
        values[name] = data.draw(
            {
                float: st.floats(descriptor.low, descriptor.high),
                bool: st.booleans(),
                str: st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Zl", "Zp"])),
            }[descriptor.kind]
            if descriptor.kind is not int
            else st.integers(int(descriptor.low), int(descriptor.high))
        )
        assert type(default) is descriptor.kind
    return replace(Parameters(), values)


@given(data=st.data())
def test_what_is_written_is_read_back(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    parameters = sound(data)
    path = tmp_path_factory.mktemp("files") / "p.yaml"
    dump(parameters, path, ["fitted", "", "to a recording"])
    assert flatten(parameters_from(path)) == flatten(parameters)
    assert path.read_text(encoding="utf-8").startswith("# fitted\n#\n# to a recording\n/**:")
    assert load(path, "/robot/of_another_name") == load(path)


def test_a_group_of_another_node_is_written_for_that_node(tmp_path: Path) -> None:
    @dataclasses.dataclass(frozen=True)
    class Own(Parameters):
        """Parameters of another node."""

    dump(Own(), tmp_path / "p.yaml", node_name="other_node")
    assert owners(tmp_path / "p.yaml") == ["/**/other_node"]
