"""Where the gap lies: by signal, condition, frequency and block."""
