"""Unmodelled effects: one file each, with what it does at its port in the drive.

Any set of them can be put into the emulated drive by the drive file (`effects: {name: {parameter:
value}}`), and the diagnosis lets all of them compete for the gap. What one is in a
rigid drive (`RIGID`) stands in its file, too.
"""
