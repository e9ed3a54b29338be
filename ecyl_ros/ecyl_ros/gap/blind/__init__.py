"""The check on withheld effects: sealed stand-ins for real drives, diagnosed, opened, scored."""
