"""Several recordings of one machine: one set of causes, one sheet."""
