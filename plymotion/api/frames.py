"""Tables of pandas, which is optional."""

from types import ModuleType


def pandas() -> ModuleType:
    """Return the package pandas.

    Raises
    ------
    ImportError
        It is not installed; the message says how to install it.
    """
    try:
        import pandas as found
    except ImportError as error:
        raise ImportError(
            "to_pandas() needs pandas, which is not installed; expected "
            "pip install plymotion[pandas]"
        ) from error
    return found
