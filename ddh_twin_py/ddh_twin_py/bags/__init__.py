"""Recordings on disk: bulk reading, recovery and writing of rosbag2 folders."""
