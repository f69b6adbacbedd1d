# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""The node with its parameters as arguments:
ros2 launch pcl_ssfr_ros2 registration.launch.py map_file:=/maps/site.pcd source:=/lidar/points anchor_frame:=odom"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

TOPICS = {"source": "points", "target": "target", "pose": "pose"}
# Name: default and type, as the node declares them.
PARAMETERS = {
    "map_file": ("", str),
    "target_frame": ("map", str),
    "anchor_frame": ("", str),
    "publish_transform": ("true", bool),
    "least_range": ("0.1", float),
    "threads": ("0", int),
    "time_limit": ("2.0", float),
    "min_confidence": ("0.7", float),
    "gravity_tolerance": ("0.0", float),
}


def generate_launch_description():
    arguments = [DeclareLaunchArgument(name, default_value=value) for name, value in TOPICS.items()]
    arguments += [DeclareLaunchArgument(name, default_value=value) for name, (value, _) in PARAMETERS.items()]
    node = Node(
        package="pcl_ssfr_ros2",
        executable="registration_node",
        output="screen",
        parameters=[{name: ParameterValue(LaunchConfiguration(name), value_type=kind) for name, (_, kind) in PARAMETERS.items()}],
        remappings=[(name, LaunchConfiguration(name)) for name in TOPICS],
    )
    return LaunchDescription([*arguments, node])
