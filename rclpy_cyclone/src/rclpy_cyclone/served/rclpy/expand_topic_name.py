"""Expansion of topic names."""

from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name
from rclpy.validate_topic_name import validate_topic_name
from rclpy_cyclone import remapping


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the full name of a topic.

    :param topic_name: relative, private or full name.
    :param node_name: name of the node it is for.
    :param node_namespace: namespace of that node.
    :raises ValueError: if a name is not text.
    """
    validate_topic_name(topic_name)
    validate_node_name(node_name)
    validate_namespace(node_namespace)
    return remapping.expand(topic_name, node_name, node_namespace)
