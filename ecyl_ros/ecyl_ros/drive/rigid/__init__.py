"""Rigid drives: one inertia, moved by one effort, perhaps by a loop; and followers, known less.

From the drive file (`machine_file`, `effects_file`) to what it says (`machine`), to one model of
effort (`model`, `packed`), its equation of motion (`plant`) and its controller (`loop`), played
along a measured motion (`driven`).
"""
