"""Rigid drives: one inertia, moved by one effort, perhaps by a loop; and followers, known less.

From the drive file (`machine`) to a model (`model`), its equation of motion (`plant`) and its
controller (`loop`), played along a measured motion (`driven`).
"""
