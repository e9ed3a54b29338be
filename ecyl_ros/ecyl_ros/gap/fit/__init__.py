"""Parameters of effects and constants of the sheet, found by replaying a recording."""
