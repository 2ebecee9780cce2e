"""``python -m floquet``: the command line without an installed script."""

from floquet.cli import main

if __name__ == "__main__":
    main()
