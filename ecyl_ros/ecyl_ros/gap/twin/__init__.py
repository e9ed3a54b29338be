"""The twin: a drive file with what was found."""
