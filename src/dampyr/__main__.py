"""``python -m dampyr`` is the ``dampyr`` command."""

from dampyr.cli import main

if __name__ == "__main__":
    main()
