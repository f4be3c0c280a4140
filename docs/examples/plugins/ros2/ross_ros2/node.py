"""The node: `ros2 run ross_ros2 bridge --ros-args -p url:=udpin:127.0.0.1:14550`."""

from __future__ import annotations

import asyncio
import math
import threading
from concurrent.futures import CancelledError
from typing import Any

import rclpy
from control_msgs.action import PointHead
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rosidl_runtime_py.set_message import set_message_fields
from rosidl_runtime_py.utilities import get_message

from ross_payload.ground import connect
from ross_payload.ground.errors import GroundError
from ross_ros2.bridge import Bridge
from ross_ros2.conversions import Fields

FEEDBACK_S = 0.1


class RossNode(Node):  # type: ignore[misc]
    """Topics `bearings`, `heading`, `audio`, `audio_info` and `/diagnostics`; the action `turn`."""

    def __init__(self) -> None:
        super().__init__("ross")
        self.url = str(self.declare_parameter("url", "udpin:127.0.0.1:14550").value)
        self.listen = str(self.declare_parameter("listen_at", "").value)
        self.what = str(self.declare_parameter("what", "target").value)
        self.bridge: Bridge | None = None
        self.loop = asyncio.new_event_loop()
        self._topics: dict[str, Any] = {}
        beside = ReentrantCallbackGroup()  # a goal must be cancelled while it is carried out
        accept = lambda _: CancelResponse.ACCEPT  # noqa: E731
        ActionServer(self, PointHead, "turn", self._turn, cancel_callback=accept, callback_group=beside)

    def publish(self, topic: str, kind: str, fields: Fields) -> None:
        """Publish the fields of a message; a header gets the present time."""
        if topic not in self._topics:
            self._topics[topic] = self.create_publisher(get_message(kind), topic, 10)
        message = get_message(kind)()
        set_message_fields(message, fields)
        if hasattr(message, "header"):
            message.header.stamp = self.get_clock().now().to_msg()
        self._topics[topic].publish(message)

    async def serve(self) -> None:
        """Speak with the payload until cancelled."""
        async with connect(self.url) as payload, asyncio.TaskGroup() as tasks:
            self.bridge = Bridge(payload, self.publish)
            tasks.create_task(self.bridge.run())
            if self.listen:
                tasks.create_task(self.bridge.voice(self.listen, self.what))

    def _turn(self, goal: Any) -> Any:
        bridge, target = self.bridge, goal.request.target
        if bridge is None:
            goal.abort()
            return PointHead.Result()
        x, y = target.point.x, target.point.y
        turning = asyncio.run_coroutine_threadsafe(bridge.turn(target.header.frame_id, x, y), self.loop)
        stopped = False
        while not turning.done():
            if goal.is_cancel_requested and not stopped:
                stopped = True
                asyncio.run_coroutine_threadsafe(bridge.stop(), self.loop).result()
            elif (error := bridge.error_deg(x, y)) is not None:
                goal.publish_feedback(PointHead.Feedback(pointing_angle_error=math.radians(error)))
            threading.Event().wait(FEEDBACK_S)
        try:
            turning.result()
            goal.succeed()
        except (ValueError, GroundError, CancelledError) as error:
            self.get_logger().warning(f"turn: {error}")
            goal.canceled() if goal.is_cancel_requested else goal.abort()
        return PointHead.Result()


def main() -> None:
    """Run the node; the payload's client has a thread and a loop of its own."""
    rclpy.init()
    node = RossNode()
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    try:
        node.loop.run_until_complete(node.serve())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except GroundError as error:
        node.get_logger().error(str(error))
    finally:
        rclpy.try_shutdown()
