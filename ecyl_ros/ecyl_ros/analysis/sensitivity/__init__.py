"""How tracking figures change with parameters of a drive file (section 4.2 of the paper)."""
