"""How small a fault a recording would have shown, and which faults it cannot tell apart."""
