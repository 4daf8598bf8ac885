"""The one error that is the user's to mend: the command prints it as a single line and exits with 2."""


class InputError(ValueError):
    """Bad input, said as *who: what was given (with unit), what is allowed*.

    Raise it where the input is read or a parameter is set; let it pass through everything else.
    """
