"""The loop of experiments: play a motion, diagnose its recording, plan the next, until decided."""
