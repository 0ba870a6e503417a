"""One job each: from the bytes of files to the bytes of all that comes of them, and no file touched."""
