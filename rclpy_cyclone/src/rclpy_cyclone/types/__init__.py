"""Message and service classes, their definitions, hashes and CDR codec."""
