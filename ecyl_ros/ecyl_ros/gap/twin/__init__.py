"""The closer twin: a drive file with what was found."""
