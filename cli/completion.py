"""``geomhw completion``: completion by the Tab key in shells."""

import os
from pathlib import Path
from typing import Any

import click

from geomhw.options import ShellName
from geomhw_cli.options import Choice, Command, OptionGroup, flag

INSTALL = OptionGroup(
    "Output", flag("--install", "Write it to the user's folder for the shell, and say how to use it.")
)


@click.command(
    cls=Command,
    groups=(INSTALL,),
    params=[click.Argument(["shell"], type=Choice(ShellName)), *INSTALL.options],
)
@click.pass_context
def completion(context: click.Context, shell: str, install: bool) -> None:
    """Print the script that completes commands, options and their values by the Tab key in a shell.

    \b
    --install writes it to, under XDG_DATA_HOME (~/.local/share) or XDG_CONFIG_HOME (~/.config):
      bash: bash-completion/completions/geomhw   zsh: zsh/site-functions/_geomhw
      fish: fish/completions/geomhw.fish

    \b
    Examples:
      geomhw completion bash
      geomhw completion fish --install
    """
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    program: Any = context.find_root()
    script = kind(program.command, {}, "geomhw", "_GEOMHW_COMPLETE").source()
    if not install:
        click.echo(script)
        return
    from geomhw.io import replacing

    target = _target(shell)
    target.parent.mkdir(parents=True, exist_ok=True)
    with replacing([target]) as (temporary,):
        temporary.write_text(script + "\n", encoding="utf-8")
    click.echo(f"wrote {target}")
    if shell == "zsh":
        click.echo(f"add to ~/.zshrc, before compinit: fpath+=({target.parent})")
    else:
        click.echo("new shells use it" + (", if bash-completion is installed" if shell == "bash" else ""))


def _target(shell: str) -> Path:
    """The file that a shell reads for this program, in the user's folders."""
    home = Path.home()
    data = Path(os.environ.get("XDG_DATA_HOME") or home / ".local" / "share")
    config = Path(os.environ.get("XDG_CONFIG_HOME") or home / ".config")
    return {
        "bash": data / "bash-completion" / "completions" / "geomhw",
        "zsh": data / "zsh" / "site-functions" / "_geomhw",
        "fish": config / "fish" / "completions" / "geomhw.fish",
    }[shell]
