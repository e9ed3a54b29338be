"""For all tests: genuine messages check their fields' types, as the stand-in's always do."""

import os

# Read by rosidl's modules when they are imported.
os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")
