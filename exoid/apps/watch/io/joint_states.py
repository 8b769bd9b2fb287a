"""`sensor_msgs/JointState` messages as they come, from a topic of ROS 2: `exoid watch leg.toml ros2:/joint_states`.

Each message is read as one line of a log with the columns that a bag has, `topic/joint/position` and `.../effort`, so
that names, `--map` and `--units` mean the same for both. rclpy comes with ROS 2, not with pip.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from exoid.ground.errors import ExoidError

WAIT = 0.2
"""s after which nothing is said where no message has come."""
DEPTH = 1000
"""Messages that wait while a change is looked into, which takes seconds."""
FIELDS = ("position", "velocity", "effort")


def joint_state_line(message: Any, topic: str) -> str:
    """Return a message as one line of JSON: its stamp in s as `t`, and what it says of each joint.

    A field that is empty, as the message's definition allows, is left out.
    """
    stamp = message.header.stamp
    line: dict[str, float] = {"t": stamp.sec + 1e-9 * stamp.nanosec}
    for field in FIELDS:
        values = getattr(message, field)
        if len(values) == len(message.name):
            line |= {f"{topic}/{name}/{field}": float(x) for name, x in zip(message.name, values, strict=True)}
    return json.dumps(line) + "\n"  # NaN as such, which is a sample that is passed over and named


def heard(topic: str) -> Iterator[str]:
    """Yield the messages of a topic as lines, "" now and then while none comes; until ROS shuts down.

    ExoidError where rclpy is not there.
    """
    try:
        import rclpy
        from rclpy.qos import qos_profile_sensor_data
        from sensor_msgs.msg import JointState
    except ImportError as error:
        remedy = "source its setup.bash, and install exoid where its Python is; or record a bag and watch that"
        raise ExoidError(f"ROS 2 is not there ({error})", where=f"ros2:{topic}", remedy=remedy) from error
    waiting: list[str] = []
    plain = topic.strip("/")
    rclpy.init()
    try:
        node = rclpy.create_node("exoid_watch")
        quality = qos_profile_sensor_data
        quality.depth = DEPTH
        node.create_subscription(JointState, topic, lambda one: waiting.append(joint_state_line(one, plain)), quality)
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=WAIT)
            found, waiting[:] = "".join(waiting), []
            yield found
    finally:
        rclpy.try_shutdown()
