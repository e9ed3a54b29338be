"""From a competition to what is named: intervals, what is no cause, confidence and verdict."""
