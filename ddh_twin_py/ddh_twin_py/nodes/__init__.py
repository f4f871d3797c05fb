"""ROS 2 nodes: declare parameters, turn messages into values, call the library, publish."""
