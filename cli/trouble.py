"""A failure of commands whose exit code 1 is an answer."""

import click


class Trouble(click.ClickException):
    """What could not be read or computed, where 1 says something else, as for diff and cmp."""

    exit_code = 2
