#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Usage, in a colcon workspace, with ROS 2 sourced: src/fuzzy_fusion_ros/install.sh [COLCON OPTIONS]
# Installs what the package needs, and builds the workspace.
#
# The libraries for bags are only on PyPI, and Ubuntu 24.04 does not let pip install into its own
# Python. They go into a virtual environment next to src/ that sees the system's packages and that
# colcon ignores, as https://docs.ros.org/en/jazzy/How-To-Guides/Using-Python-Packages.html
# recommends. Programs are built with its interpreter, so it need not be activated.
set -euo pipefail

package=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
die() { echo "install.sh: $*" >&2; exit 2; }

[ -d src ] || die "there is no src/ in $PWD: run it in a colcon workspace"
python3 -c 'import rclpy' || die "python3 cannot import rclpy: source ROS 2 first, outside virtual environments"

rosdep install --from-paths "$package" --ignore-src -y
python3 -m venv --system-site-packages venv
touch venv/COLCON_IGNORE
compiler=()
if [ "${FUZZY_FUSION_COMPILE:-}" = 1 ]; then compiler=("mypy==2.4.1"); fi
# numpy as the system has it: the messages of ROS are compiled for it.
venv/bin/python -m pip install --quiet "mcap>=1.2,<2" "rosbags>=0.11.9,<0.12" "numpy<2" ${compiler[@]+"${compiler[@]}"}
# Only for speed, and no dependency: there are computers without it.
venv/bin/python -m pip install --quiet --only-binary=:all: numba "numpy<2" ||
  echo "install.sh: going on without numba: tune takes about 100 times as long" >&2
venv/bin/python "$(command -v colcon)" build "$@"
echo "install.sh: built; next: source install/setup.bash && fuzzy-fusion --help"
