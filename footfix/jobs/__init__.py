"""One job each, from the bytes of input files to the bytes of outputs; no file is read or written here."""
