"""The live page: what it shows, what it keeps, how it is served. Knows nothing of ROS."""
