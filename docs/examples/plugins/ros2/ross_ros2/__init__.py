"""A RoSS payload on ROS 2."""
