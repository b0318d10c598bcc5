"""The one error that jawenv raises for input from outside."""


class InputError(ValueError):
    """A value from outside (argument, file, action) is not usable.

    The message is one line that names the field, the value and what is allowed, so that command lines can
    print it as it stands.
    """
