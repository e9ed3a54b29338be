"""The recorded run once more through the model, and what a recording shows beside it."""
