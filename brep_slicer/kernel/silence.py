"""OCCT's chatter, switched off while it works for us.

In: a block of code. Out: the same, without lines on the terminal; the host's printers are put back afterwards.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from OCP.Message import Message


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Take OCCT's message printers away for the length of a `with` block."""
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    for printer in printers:
        messenger.RemovePrinter(printer)
    try:
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)
