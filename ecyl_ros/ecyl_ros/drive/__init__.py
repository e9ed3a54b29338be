"""The machine without ROS: motor, transmission, cascade, references, parameters and the engine."""
