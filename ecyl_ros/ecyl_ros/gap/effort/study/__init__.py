"""A sealed study of the diagnosis by effort: rigid drives of other equations, faults hidden."""
