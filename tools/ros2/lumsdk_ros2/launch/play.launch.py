"""A recording to topics.

ros2 launch lumsdk_ros2 play.launch.py file:=drive.mcap rate:=0.5 loop:=true rviz:=true"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def play(context):
    """Make the process, once the arguments are known."""
    def value(name):
        return LaunchConfiguration(name).perform(context)

    command = ["lumros2", value("file"), "--rate", value("rate")]
    command += ["--namespace", value("namespace")] if value("namespace") else []
    command += ["--loop"] if value("loop").lower() in ("true", "1") else []
    return [ExecuteProcess(cmd=command, output="screen", on_exit=Shutdown(reason="the recording has ended"))]


def generate_launch_description():
    """What launch asks for."""
    return LaunchDescription([
        DeclareLaunchArgument("file", description="an .mcap file of messages, as lumdump -o drive.mcap writes it"),
        DeclareLaunchArgument("rate", default_value="1", description="speed; 1 is as it was recorded"),
        DeclareLaunchArgument("loop", default_value="false", description="again and again"),
        DeclareLaunchArgument("namespace", default_value="", description="in front of the topics, such as front"),
        DeclareLaunchArgument("rviz", default_value="false", description="whether rviz2 is started, too"),
        OpaqueFunction(function=play),
        ExecuteProcess(cmd=["rviz2", "-d", PathJoinSubstitution([FindPackageShare("lumsdk_ros2"), "rviz", "luminar.rviz"])],
                       condition=IfCondition(LaunchConfiguration("rviz"))),
    ])
