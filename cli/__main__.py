"""``python -m geomhw_cli``."""

from geomhw_cli.main import main

if __name__ == "__main__":
    main()
