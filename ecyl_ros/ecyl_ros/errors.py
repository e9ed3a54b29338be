"""The one exception that reaches a user as a line of text instead of a traceback."""


class InputError(Exception):
    """Unusable input: a file, field, flag or parameter that the user can put right.

    The message is one line that names the file, the field and what was expected. Commands print
    it on stderr and exit with 2; nodes log it as fatal and end with 2.
    """
