"""``python -m geomhw``: the command-line program."""

from geomhw_cli.main import main

if __name__ == "__main__":
    main()
