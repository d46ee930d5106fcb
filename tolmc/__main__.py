"""``python -m tolmc`` is the command ``tolmc``."""

from tolmc.cli import main

if __name__ == "__main__":
    main(prog_name="tolmc")
