"""What a recording says about tracking: error figures, lag, spectrum and empirical modes."""
