"""`python -m treelet` is the command line program."""

from treelet.cli import main

if __name__ == "__main__":
    main()
