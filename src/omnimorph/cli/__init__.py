"""The command line, ``omnimorph``: one short file a command.

`main` reads the arguments and turns what went wrong into one line and an exit code. A command is
a module with a summary, its arguments, and ``answer(options) -> Answer``; `console` prints the
answer, and `folder` sees to it that what is written is whole or not there. Nothing heavy is
imported before a command needs it.
"""

from __future__ import annotations
