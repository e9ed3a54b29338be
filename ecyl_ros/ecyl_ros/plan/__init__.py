"""Motions planned so that their recording tells what is still open."""
