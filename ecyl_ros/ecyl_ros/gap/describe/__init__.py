"""A cause that the library lacks: where it acts, what it depends on, by which law."""
