"""Answers held against opened labels: figures, targets, tables, pictures."""
