# SPDX-License-Identifier: Apache-2.0
# docker build -t fuzzy_fusion_ros . && docker run --rm -it fuzzy_fusion_ros fuzzy-fusion --help
FROM ros:jazzy
RUN apt-get update && apt-get install -y --no-install-recommends python3-venv && rm -rf /var/lib/apt/lists/*
WORKDIR /ws
COPY . src/fuzzy_fusion_ros
RUN . /opt/ros/jazzy/setup.sh && apt-get update && rosdep update && src/fuzzy_fusion_ros/install.sh \
    && rm -rf /var/lib/apt/lists/*
ENTRYPOINT ["/bin/bash", "-c", ". /ws/install/setup.bash && exec \"$@\"", "--"]
CMD ["bash"]
