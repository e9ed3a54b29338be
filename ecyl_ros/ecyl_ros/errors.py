"""The one exception that reaches a user as a line of text instead of a traceback."""

_LONGEST = 1000  # letters


class InputError(Exception):
    """Unusable input: a file, field, flag or parameter that the user can put right.

    The message is one line that names the file, the field and what was expected. Commands print
    it on stderr and exit with 2; nodes log it as fatal and end with 2.
    """

    def __init__(self, message: object = "") -> None:
        # Names out of damaged files hold anything: it stays one line, and drives no terminal.
        line = "".join(letter if letter.isprintable() else " " for letter in str(message))
        super().__init__(line if len(line) <= _LONGEST else f"{line[: _LONGEST - 3]}...")
