"""``python -m geomhw_cli``: the command-line program."""

from geomhw_cli.main import main

if __name__ == "__main__":
    main()
