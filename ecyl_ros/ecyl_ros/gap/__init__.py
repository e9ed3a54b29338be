"""Diagnosis of the gap between a recording and its nominal model, and the study that checks it."""
