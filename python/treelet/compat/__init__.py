"""Other libraries' interfaces to what treelet answers: change an import, keep the program."""
