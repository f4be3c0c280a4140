"""Installs the bridge as a package of ROS 2 (ament_python): `colcon build --packages-select ross_ros2`."""

from setuptools import setup

setup(
    name="ross_ros2",
    version="1.0.0",
    packages=["ross_ros2"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/ross_ros2"]),
        ("share/ross_ros2", ["package.xml"]),
    ],
    install_requires=["ross-payload[ground,stream]"],
    entry_points={"console_scripts": ["bridge = ross_ros2.node:main"]},
)
