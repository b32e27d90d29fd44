"""`python -m treelet.bench` is `treelet bench`."""

import sys

from treelet.cli import main

if __name__ == "__main__":
    main(["bench", *sys.argv[1:]])
