"""`python -m footfix`."""

from footfix.cli import main

if __name__ == "__main__":  # spawned workers import this module again, and must not run it
    main()
