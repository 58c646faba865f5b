"""A sensor to topics.

ros2 launch lumsdk_ros2 sensor.launch.py address:=10.42.0.37 namespace:=front rviz:=true"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackagePrefix, FindPackageShare

OVERRIDES = ("address", "rig", "sensor", "namespace", "frame_id", "preset", "record")


def generate_launch_description():
    """What launch asks for."""
    share = FindPackageShare("lumsdk_ros2")
    stream = PathJoinSubstitution([FindPackagePrefix("lumsdk_ros2"), "lib", "lumsdk_ros2", "lumsdk_stream"])
    return LaunchDescription([
        DeclareLaunchArgument("params", default_value=PathJoinSubstitution([share, "config", "sensor.yaml"]),
                              description="the parameters, as config/sensor.yaml has them"),
        DeclareLaunchArgument("rviz", default_value="false", description="whether rviz2 is started, too"),
        *(DeclareLaunchArgument(name, default_value="", description="instead of the parameter of this name")
          for name in OVERRIDES),
        ExecuteProcess(cmd=[stream, LaunchConfiguration("params"), *([f"{name}=", LaunchConfiguration(name)] for name in OVERRIDES)],
                       output="screen", on_exit=Shutdown(reason="the stream of the sensor has ended")),
        ExecuteProcess(cmd=["rviz2", "-d", PathJoinSubstitution([share, "rviz", "luminar.rviz"])],
                       condition=IfCondition(LaunchConfiguration("rviz"))),
    ])
