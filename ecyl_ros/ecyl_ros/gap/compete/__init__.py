"""Which effects close the gap: their starts, their sets, and what it takes to earn a place."""
