"""Recordings: the contract's signals as arrays, and MCAP and CSV files in and out."""

from .signals import SIGNALS, Recording
from .topics import TOPICS, TopicSpec, renamed

__all__ = ["SIGNALS", "TOPICS", "Recording", "TopicSpec", "renamed"]
