"""The check on withheld labels: sealed stand-ins for real drives, diagnosed, opened, scored."""
