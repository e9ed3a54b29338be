"""Reference generators: one kind per module, made from a SPEC by `spec.make_reference`."""
